"""What each stroke of a drawing covers, apart from the others: what it would cost to be without it."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
import torch
from numpy.typing import NDArray

from videovec.parameters import Parameters
from videovec.render import list_pairs
from videovec.render.numba_backend import arrays_of, cover
from videovec.strokes import Strokes

__all__ = ["Layer", "Page", "layers_of"]

Floats = NDArray[np.float64]
Ints = NDArray[np.intp]

_FULL = 1.0 - 1e-6  # coverage that can still be divided out
_MARGIN = 0.1  # px beyond the kernel's reach, for rounding
_ROUNDS = 2  # Newton updates of the nearest points of a fresh pair list


@dataclass(frozen=True, slots=True, eq=False)
class Layer:
    """The coverage of one stroke.

    Args:
        pixels: Pixels within its reach, as y * W + x, ascending. int [M]
        coverage: Coverage there, its opacity included. [M]
    """

    pixels: Ints
    coverage: Floats

    @property
    def mass(self) -> float:
        """Ink of the stroke alone. px²"""
        return float(self.coverage.sum())


def layers_of(strokes: Strokes, size: tuple[int, int]) -> list[Layer]:
    """Cover a page by each of some strokes alone, with the kernel of the last phase.

    Args:
        strokes: S strokes of drawing 0.
        size: H and W. px

    Returns:
        One layer for each stroke.
    """
    if not len(strokes):
        return []
    order = np.argsort(strokes.layer, kind="stable")
    parameters = Parameters.of(strokes)
    with torch.no_grad():
        scene = parameters.scene((1, *size), parameters.intervals())
        pairs = list_pairs(scene, 1.0, margin=_MARGIN)
    arrays = arrays_of(scene, pairs)
    covered = np.empty(len(pairs), arrays.control.dtype)
    for _ in range(_ROUNDS):
        cover(arrays, 1.0, 0, covered)
    pixel = np.repeat(arrays.active, np.diff(arrays.start))
    stroke = order[arrays.order_row]
    value = covered[arrays.order].astype(np.float64) * strokes.opacity[stroke]
    by_stroke = np.lexsort([pixel, stroke])
    pixel, stroke, value = pixel[by_stroke], stroke[by_stroke], value[by_stroke]
    first = np.flatnonzero(np.diff(stroke * np.intp(size[0] * size[1]) + pixel, prepend=-1))
    if not len(first):
        return [Layer(np.zeros(0, np.intp), np.zeros(0)) for _ in range(len(strokes))]
    value = np.minimum(np.maximum.reduceat(value, first), _FULL)
    pixel, stroke = pixel[first], stroke[first]
    starts = np.searchsorted(stroke, np.arange(len(strokes) + 1))
    return [Layer(pixel[a:b], value[a:b]) for a, b in pairwise(starts)]


class Page:
    """The union of layers against the ink, as layers come and go.

    Args:
        seen: Ink coverage. uint8 [H, W]
        layers: What is drawn at first.
    """

    def __init__(self, seen: NDArray[np.uint8], layers: list[Layer]) -> None:
        self.seen = seen.ravel() / 255.0
        self.clear = np.ones(self.seen.size)
        self._marked = np.zeros(self.seen.size, bool)
        self.size = (seen.shape[0], seen.shape[1])
        for layer in layers:
            self.add(layer)

    @property
    def drawn(self) -> Floats:
        """Coverage of the union. [H, W]"""
        return (1.0 - self.clear).reshape(self.size)

    @property
    def residual(self) -> Floats:
        """Seen less drawn coverage. [H, W]"""
        return self.seen.reshape(self.size) - self.drawn

    def residual_in(self, rows: slice, columns: slice) -> Floats:
        """Seen less drawn coverage in a part of the page."""
        seen, clear = (values.reshape(self.size)[rows, columns] for values in (self.seen, self.clear))
        return np.asarray(seen - 1.0 + clear)

    def add(self, layer: Layer) -> None:
        """Draw a layer."""
        self.clear[layer.pixels] *= 1.0 - layer.coverage

    def remove(self, layer: Layer) -> None:
        """Take a layer away again."""
        self.clear[layer.pixels] /= 1.0 - layer.coverage

    def loss_at(self, pixels: Ints) -> float:
        """Sum of squared coverage errors over some pixels."""
        return float(np.square(self.seen[pixels] - 1.0 + self.clear[pixels]).sum())

    def rise(self, old: list[Layer], new: list[Layer]) -> float:
        """By how much the loss would rise if some layers took the place of others."""
        pixels = self._union([*old, *new])
        before = self.loss_at(pixels)
        self.exchange(old, new)
        after = self.loss_at(pixels)
        self.exchange(new, old)
        return after - before

    def _union(self, layers: list[Layer]) -> Ints:
        """The pixels of some layers, each once."""
        parts = []
        for layer in layers:
            parts.append(layer.pixels[~self._marked[layer.pixels]])
            self._marked[parts[-1]] = True
        pixels = np.concatenate(parts)
        self._marked[pixels] = False
        return pixels

    def exchange(self, old: list[Layer], new: list[Layer]) -> None:
        """Draw some layers in the place of others."""
        for layer in old:
            self.remove(layer)
        for layer in new:
            self.add(layer)
