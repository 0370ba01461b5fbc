"""Colour and coverage of the active pixels on the CPU, as one differentiable operation."""

from __future__ import annotations

from typing import Any

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor

from videovec.compiling import compiled
from videovec.render.numba_backend import Arrays, arrays_of, cover, gather, most_pairs
from videovec.render.numba_kernels import PARTIALS
from videovec.render.pairs import PairList
from videovec.render.scene import Scene
from videovec.threads import over_ranges

__all__ = ["composite_pairs"]

Array = NDArray[Any]


def composite_pairs(scene: Scene, pairs: PairList, scale: float) -> tuple[Tensor, Tensor]:
    """Composite the rows on every active pixel; see `videovec.render.composite`."""
    leaves = (scene.control, scene.half_width, scene.interval, scene.opacity, scene.color)
    color, coverage = _Composite.apply(scene, pairs, scale, *leaves)  # type: ignore[no-untyped-call]
    return color, coverage


class _Composite(torch.autograd.Function):
    @staticmethod
    def forward(ctx: Any, scene: Scene, pairs: PairList, scale: float, *leaves: Tensor) -> tuple[Tensor, Tensor]:
        arrays, drawings = arrays_of(scene, pairs), scene.size[0]
        color = torch.zeros(len(pairs.active), scene.color.shape[1], dtype=scene.control.dtype)
        coverage = torch.zeros(len(pairs.active), dtype=scene.control.dtype)
        over_ranges(lambda part: _forward(arrays, part, scale, color.numpy(), coverage.numpy()), drawings)
        ctx.arrays, ctx.scale, ctx.drawings = arrays, scale, drawings
        return color, coverage

    @staticmethod
    def backward(ctx: Any, *grads: Tensor) -> Any:
        arrays, real = ctx.arrays, ctx.arrays.control.dtype
        by_color, by_coverage = (np.ascontiguousarray(grad.numpy(), real) for grad in grads)
        leaves = (arrays.control, arrays.half_width, arrays.interval, arrays.opacity, arrays.color)
        out = tuple(np.zeros_like(leaf) for leaf in leaves)
        over_ranges(lambda part: _backward(arrays, part, ctx.scale, (by_color, by_coverage), out), ctx.drawings)
        return None, None, None, *(torch.from_numpy(grad) for grad in out)


@compiled(inline=True)
def _stack(a: Arrays, pixel: int, first: int, coverage: Array, winner: Array, row_of: Array) -> int:
    """The rows on a pixel, lowest first, and of each the pair that covers most; how many there are."""
    rows, at, stop = 0, a.start[pixel], a.start[pixel + 1]
    while at < stop:
        row, best = a.order_row[at], a.order[at] - first
        at += 1
        while at < stop and a.order_row[at] == row:
            i = a.order[at] - first
            if coverage[i] > coverage[best]:
                best = i
            at += 1
        winner[rows], row_of[rows] = best, row
        rows += 1
    return rows


@compiled()
def _forward(a: Arrays, drawings: tuple[int, int], scale: float, color: Array, coverage: Array) -> None:
    """Composite some drawings into ``color`` [A, C] and ``coverage`` [A]."""
    real = a.control.dtype.type
    for drawing in range(drawings[0], drawings[1]):
        first, last = a.chunk_pairs[a.drawing_chunks[drawing]], a.chunk_pairs[a.drawing_chunks[drawing + 1]]
        begin, end = a.drawing_pixels[drawing], a.drawing_pixels[drawing + 1]
        scratch = np.empty((PARTIALS + 1, last - first), a.control.dtype)
        cover(a, scale, drawing, scratch)
        most = most_pairs(a.start, begin, end)
        winner, row_of = np.empty(most, np.int64), np.empty(most, np.int32)
        for pixel in range(begin, end):
            clear = real(1)
            for n in range(_stack(a, pixel, first, scratch[0], winner, row_of)):
                alpha = a.opacity[row_of[n]] * scratch[0, winner[n]]
                clear *= real(1) - alpha
                for c in range(color.shape[1]):
                    color[pixel, c] += alpha * (a.color[row_of[n], c] - color[pixel, c])
            coverage[pixel] = real(1) - clear


@compiled()
def _backward(
    a: Arrays, drawings: tuple[int, int], scale: float, grads: tuple[Array, Array], out: tuple[Array, ...]
) -> None:
    """Gradients of control, half-width, interval, opacity and colour of some drawings, added to ``out``."""
    real = a.control.dtype.type
    by_color, by_coverage = grads
    for drawing in range(drawings[0], drawings[1]):
        first, last = a.chunk_pairs[a.drawing_chunks[drawing]], a.chunk_pairs[a.drawing_chunks[drawing + 1]]
        begin, end = a.drawing_pixels[drawing], a.drawing_pixels[drawing + 1]
        scratch = np.empty((PARTIALS + 1, last - first), a.control.dtype)
        weight = np.zeros(last - first, a.control.dtype)
        cover(a, scale, drawing, scratch)
        most = most_pairs(a.start, begin, end)
        winner, row_of = np.empty(most, np.int64), np.empty(most, np.int32)
        under, clear = np.empty((most, by_color.shape[1]), a.control.dtype), np.empty(most, a.control.dtype)
        for pixel in range(begin, end):
            rows = _stack(a, pixel, first, scratch[0], winner, row_of)
            _pile(a, scratch[0], (winner, row_of), rows, under, clear)
            slope, slope_clear = by_color[pixel].copy(), -by_coverage[pixel]
            for n in range(rows - 1, -1, -1):
                row, covered = row_of[n], scratch[0, winner[n]]
                alpha = a.opacity[row] * covered
                by_alpha = -slope_clear * clear[n]
                for c in range(len(slope)):
                    by_alpha += slope[c] * (a.color[row, c] - under[n, c])
                    out[4][row, c] += slope[c] * alpha
                    slope[c] *= real(1) - alpha
                slope_clear *= real(1) - alpha
                weight[winner[n]] = by_alpha * a.opacity[row]
                out[3][row] += by_alpha * covered
        gather(a, drawing, scratch, weight, (out[0], out[1], out[2]))


@compiled()
def _pile(a: Arrays, coverage: Array, rows: tuple[Array, Array], count: int, under: Array, clear: Array) -> None:
    """Colour [n, C] and transmittance [n] below each row of a pixel."""
    winner, row_of = rows
    under[0, :], clear[0] = 0, 1
    for n in range(count - 1):
        row = row_of[n]
        alpha = a.opacity[row] * coverage[winner[n]]
        clear[n + 1] = clear[n] * (a.control.dtype.type(1) - alpha)
        for c in range(under.shape[1]):
            under[n + 1, c] = under[n, c] + alpha * (a.color[row, c] - under[n, c])
