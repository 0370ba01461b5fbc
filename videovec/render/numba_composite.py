"""Colour and coverage of the active pixels on the CPU, as one differentiable operation."""

from __future__ import annotations

from typing import Any

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor

from videovec.compiling import compiled
from videovec.render.numba_backend import Arrays, arrays_of, cover, gather, most_on_pixel, stack
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
        covered = np.empty(len(pairs), arrays.control.dtype)
        out = color.numpy(), coverage.numpy()
        over_ranges(lambda part: _forward(arrays, part, scale, covered, out), drawings)
        ctx.arrays, ctx.scale, ctx.drawings, ctx.covered = arrays, scale, drawings, covered
        return color, coverage

    @staticmethod
    def backward(ctx: Any, *grads: Tensor) -> Any:
        arrays, real = ctx.arrays, ctx.arrays.control.dtype
        by_color, by_coverage = (np.ascontiguousarray(grad.numpy(), real) for grad in grads)
        leaves = (arrays.control, arrays.half_width, arrays.interval, arrays.opacity, arrays.color)
        out = tuple(np.zeros_like(leaf) for leaf in leaves)
        given = by_color, by_coverage, ctx.covered
        over_ranges(lambda part: _backward(arrays, part, ctx.scale, given, out), ctx.drawings)
        return None, None, None, *(torch.from_numpy(grad) for grad in out)


@compiled()
def _forward(a: Arrays, drawings: tuple[int, int], scale: float, covered: Array, out: tuple[Array, Array]) -> None:
    """Coverage of the pairs of some drawings [N], composited into colour [A, C] and coverage [A] of pixels."""
    color, coverage = out
    real = a.control.dtype.type
    for drawing in range(drawings[0], drawings[1]):
        first, last = a.chunk_pairs[a.drawing_chunks[drawing]], a.chunk_pairs[a.drawing_chunks[drawing + 1]]
        begin, end = a.drawing_pixels[drawing], a.drawing_pixels[drawing + 1]
        pairs = covered[first:last]
        cover(a, scale, drawing, pairs)
        most = most_on_pixel(a, begin, end)
        winner, row_of = np.empty(most, np.int64), np.empty(most, np.int32)
        for pixel in range(begin, end):
            clear = real(1)
            for n in range(stack(a, pixel, first, pairs, winner, row_of)):
                alpha = a.opacity[row_of[n]] * pairs[winner[n]]
                clear *= real(1) - alpha
                for c in range(color.shape[1]):
                    color[pixel, c] += alpha * (a.color[row_of[n], c] - color[pixel, c])
            coverage[pixel] = real(1) - clear


@compiled()
def _backward(
    a: Arrays, drawings: tuple[int, int], scale: float, given: tuple[Array, Array, Array], out: tuple[Array, ...]
) -> None:
    """Gradients of control, half-width, interval, opacity and colour of some drawings, added to ``out``."""
    real = a.control.dtype.type
    by_color, by_coverage, covered = given
    for drawing in range(drawings[0], drawings[1]):
        first, last = a.chunk_pairs[a.drawing_chunks[drawing]], a.chunk_pairs[a.drawing_chunks[drawing + 1]]
        begin, end = a.drawing_pixels[drawing], a.drawing_pixels[drawing + 1]
        pairs, weight = covered[first:last], np.zeros(last - first, a.control.dtype)
        most = most_on_pixel(a, begin, end)
        winner, row_of = np.empty(most, np.int64), np.empty(most, np.int32)
        under, clear = np.empty((most, by_color.shape[1]), a.control.dtype), np.empty(most, a.control.dtype)
        for pixel in range(begin, end):
            rows = stack(a, pixel, first, pairs, winner, row_of)
            _pile(a, pairs, (winner, row_of), rows, under, clear)
            slope, slope_clear = by_color[pixel].copy(), -by_coverage[pixel]
            for n in range(rows - 1, -1, -1):
                row, here = row_of[n], pairs[winner[n]]
                alpha = a.opacity[row] * here
                by_alpha = -slope_clear * clear[n]
                for c in range(len(slope)):
                    by_alpha += slope[c] * (a.color[row, c] - under[n, c])
                    out[4][row, c] += slope[c] * alpha
                    slope[c] *= real(1) - alpha
                slope_clear *= real(1) - alpha
                if (here > 0) & (here < 1):  # else it is flat
                    weight[winner[n]] = by_alpha * a.opacity[row]
                out[3][row] += by_alpha * here
        gather(a, scale, drawing, weight, (out[0], out[1], out[2]))


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
