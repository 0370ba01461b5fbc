"""The CPU back end: drawings in parallel, each by one thread with scratch memory of its own.

A drawing takes three passes: coverage of its pairs, chunk by chunk (`numba_kernels.evaluate`); compositing, pixel by
pixel; gradients, chunk by chunk (`numba_kernels.accumulate`). What passes hand on lives as long as the drawing's turn.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from torch import Tensor

from videovec.compiling import compiled
from videovec.render.numba_kernels import PARTIALS, accumulate, evaluate
from videovec.render.pairs import PairList
from videovec.render.scene import Scene

__all__ = ["Arrays", "arrays_of", "cover", "gather", "match_drawings", "most_pairs"]

Array = NDArray[Any]


class Arrays(NamedTuple):
    """A scene and its pair list as arrays, the form that compiled code takes; meanings as in `Scene` and `PairList`."""

    control: Array
    half_width: Array
    interval: Array
    opacity: Array
    color: Array
    segment: Array
    bounds: Array
    drawing_chunks: Array
    chunk_pairs: Array
    x: Array
    y: Array
    t: Array
    active: Array
    start: Array
    order: Array
    order_row: Array
    drawing_pixels: Array


def arrays_of(scene: Scene, pairs: PairList) -> Arrays:
    """View a scene on the CPU and its pair list as arrays, without a copy."""
    real = scene.control.dtype

    def floats(value: Tensor) -> Array:
        return value.detach().to(real).contiguous().numpy()

    return Arrays(
        control=floats(scene.control),
        half_width=floats(scene.half_width),
        interval=floats(scene.interval),
        opacity=floats(scene.opacity),
        color=floats(scene.color),
        segment=pairs.chunks.segment.numpy(),
        bounds=floats(pairs.chunks.bounds),
        drawing_chunks=pairs.chunks.drawing_chunks.numpy(),
        chunk_pairs=pairs.chunk_pairs.numpy(),
        x=pairs.x.numpy(),
        y=pairs.y.numpy(),
        t=pairs.t.numpy(),
        active=pairs.active.numpy(),
        start=pairs.start.numpy(),
        order=pairs.order.numpy(),
        order_row=pairs.order_row.numpy(),
        drawing_pixels=pairs.drawing_pixels.numpy(),
    )


@compiled(inline=True)
def _visible(a: Arrays, chunk: int) -> tuple[tuple[Any, Any], bool, bool]:
    """First and last visible t of a chunk, and whether those are ends of the visible interval."""
    g = a.segment[chunk]
    ends = max(a.bounds[chunk, 0], a.interval[g, 0]), min(a.bounds[chunk, 1], a.interval[g, 1])
    return ends, a.interval[g, 0] >= a.bounds[chunk, 0], a.interval[g, 1] <= a.bounds[chunk, 1]


@compiled(inline=True)
def _fields(a: Arrays, scratch: Array, i: int, j: int, first: int) -> tuple[Array, ...]:
    """t, coverage and partials of pairs i .. j, as contiguous arrays: strided ones would not be vectorised."""
    m, n = i - first, j - first
    c, ux, uy, vx, vy, h = scratch[0], scratch[1], scratch[2], scratch[3], scratch[4], scratch[5]
    return a.t[i:j], c[m:n], ux[m:n], uy[m:n], vx[m:n], vy[m:n], h[m:n]


@compiled()
def cover(a: Arrays, scale: float, drawing: int, scratch: Array) -> None:
    """First pass: coverage [1] and partials [2:] of every pair of a drawing."""
    first = a.chunk_pairs[a.drawing_chunks[drawing]]
    for chunk in range(a.drawing_chunks[drawing], a.drawing_chunks[drawing + 1]):
        i, j = a.chunk_pairs[chunk], a.chunk_pairs[chunk + 1]
        ends, _, _ = _visible(a, chunk)
        if not ends[1] > ends[0]:
            scratch[:, i - first : j - first] = 0
            continue
        g, out = a.segment[chunk], _fields(a, scratch, i, j, first)
        evaluate(a.control[g], a.half_width[g], ends, scale, (a.x[i:j], a.y[i:j]), out)


@compiled()
def gather(a: Arrays, drawing: int, scratch: Array, weight: Array, grads: tuple[Array, Array, Array]) -> None:
    """Third pass: gradients of control points, half-widths and visible intervals."""
    first = a.chunk_pairs[a.drawing_chunks[drawing]]
    grad_control, grad_half_width, grad_interval = grads
    for chunk in range(a.drawing_chunks[drawing], a.drawing_chunks[drawing + 1]):
        i, j = a.chunk_pairs[chunk], a.chunk_pairs[chunk + 1]
        ends, is_first, is_last = _visible(a, chunk)
        if not ends[1] > ends[0]:
            continue
        g, out, w = a.segment[chunk], _fields(a, scratch, i, j, first), weight[i - first : j - first]
        accumulate(w, out, grad_control[g], grad_half_width[g])
        if is_first:
            grad_interval[g, 0] += _end_gradient(a.control[g], a.half_width[g], ends[0], w, out)
        if is_last:
            grad_interval[g, 1] += _end_gradient(a.control[g], a.half_width[g], ends[1], w, out)


@compiled()
def _end_gradient(p: Array, h: Array, end: float, weight: Array, out: tuple[Array, ...]) -> float:
    """Derivative by the t of a visible end: pairs whose nearest point it is move and widen with it."""
    ts, _, uxs, uys, vxs, vys, hs = out
    s, t = 1 - end, end
    ux = uy = vx = vy = dh = 0.0
    for i in range(len(ts)):
        if ts[i] == end:
            ux += weight[i] * uxs[i]
            uy += weight[i] * uys[i]
            vx += weight[i] * vxs[i]
            vy += weight[i] * vys[i]
            dh += weight[i] * hs[i]
    velocity = 3 * (s * s * (p[1] - p[0]) + 2 * s * t * (p[2] - p[1]) + t * t * (p[3] - p[2]))
    acceleration = 6 * (s * (p[2] - 2 * p[1] + p[0]) + t * (p[3] - 2 * p[2] + p[1]))
    moved = ux * velocity[0] + uy * velocity[1] + vx * acceleration[0] + vy * acceleration[1]
    return float(moved + dh * (h[1] - h[0]))


@compiled()
def most_pairs(start: Array, begin: int, end: int) -> int:
    """Most pairs on one pixel."""
    most = 0
    for a in range(begin, end):
        most = max(most, start[a + 1] - start[a])
    return most


@compiled()
def _match(
    a: Arrays, drawing: int, fields: tuple[Array, Array], target: Array, extra: Array, grad_opacity: Array, value: Array
) -> float:
    """Second pass of the fit: union of the rows, squared residual, derivative by each pair's coverage."""
    real = a.control.dtype.type
    coverage, weight = fields
    first = a.chunk_pairs[a.drawing_chunks[drawing]]
    begin, end = a.drawing_pixels[drawing], a.drawing_pixels[drawing + 1]
    most = most_pairs(a.start, begin, end)
    best, best_row = np.empty(most, np.int64), np.empty(most, np.int32)
    clear, one = np.empty(most + 1, a.control.dtype), real(1)
    clear[0] = one
    total, full = 0.0, real(1 / 255)
    for pixel in range(begin, end):
        at, stop = a.start[pixel], a.start[pixel + 1]
        wanted = real(target[a.active[pixel]]) * full
        added = extra[pixel] if len(extra) > 0 else real(0)
        if stop - at == 1:  # most pixels have one pair
            row, win = a.order_row[at], a.order[at] - first
            opacity, covered = a.opacity[row], coverage[win]
            value[pixel] = opacity * covered
            residual = value[pixel] - wanted
            total += residual * residual
            slope = residual + residual + added
            weight[win] = slope * opacity
            grad_opacity[row] += slope * covered
            continue
        rows = 0
        while at < stop:
            row, win = a.order_row[at], a.order[at] - first
            weight[win] = 0
            at += 1
            while at < stop and a.order_row[at] == row:
                i = a.order[at] - first
                weight[i] = 0
                if coverage[i] > coverage[win]:
                    win = i
                at += 1
            best[rows], best_row[rows] = win, row
            clear[rows + 1] = clear[rows] * (one - a.opacity[row] * coverage[win])
            rows += 1
        value[pixel] = one - clear[rows]
        residual = value[pixel] - wanted
        total += residual * residual
        slope = residual + residual + added
        for n in range(rows - 1, -1, -1):
            row, win = best_row[n], best[n]
            through = slope * clear[n]
            weight[win] = through * a.opacity[row]
            grad_opacity[row] += through * coverage[win]
            slope *= one - a.opacity[row] * coverage[win]
    return total


@compiled()
def match_drawings(
    a: Arrays, drawings: tuple[int, int], scale: float, target: Array, extra: Array, out: tuple[Array, ...]
) -> None:
    """Forward, squared residual at active pixels and backward, in one go for each drawing.

    Args:
        a: Scene and pairs.
        drawings: First drawing and the one after the last.
        scale: Side of the kernel. px
        target: Ink coverage of all pixels, 255 is full. uint8 [D * H * W]
        extra: Derivative of other losses by each active pixel's value, or empty. [A]
        out: Sum of squared residuals of each drawing's active pixels [D], value of each active pixel [A]; gradients of
            control, half-width, interval and opacity, zeros before. All are written.
    """
    loss, value, grad_control, grad_half_width, grad_interval, grad_opacity = out
    for drawing in range(drawings[0], drawings[1]):
        first, last = a.chunk_pairs[a.drawing_chunks[drawing]], a.chunk_pairs[a.drawing_chunks[drawing + 1]]
        scratch = np.empty((PARTIALS + 1, last - first), a.control.dtype)
        weight = np.empty(last - first, a.control.dtype)
        cover(a, scale, drawing, scratch)
        loss[drawing] = _match(a, drawing, (scratch[0], weight), target, extra, grad_opacity, value)
        gather(a, drawing, scratch, weight, (grad_control, grad_half_width, grad_interval))
