"""The CPU back end: drawings in parallel, each by one thread with scratch memory of its own.

A drawing takes three passes: coverage of its pairs, chunk by chunk; compositing, pixel by pixel, where the loss's slope
by each coverage takes the coverage's place; gradients, chunk by chunk, from those pairs that have a slope. A pair in
the list's margin, or well inside its line, costs its coverage alone.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from torch import Tensor

from videovec.compiling import compiled
from videovec.render.numba_kernels import PARTIALS, accumulate, at_parameter, cover_pairs, cubic_of, differentiate
from videovec.render.pairs import PairList
from videovec.render.scene import Scene

__all__ = [
    "Arrays",
    "arrays_of",
    "cover",
    "gather",
    "most_on_pixel",
    "most_pairs",
    "room_for_stacks",
    "scratch_of",
    "see_through",
    "slopes_of",
    "stack",
    "winners",
]

Array = NDArray[Any]

LANES = 8
"""Pairs that are differentiated at once: what is left over would be done one by one, at as much cost."""


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
    plain: Array


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
        plain=pairs.plain.numpy(),
    )


@compiled(inline=True)
def _visible(a: Arrays, chunk: int) -> tuple[tuple[Any, Any], bool, bool]:
    """First and last visible t of a chunk, and whether those are ends of the visible interval."""
    g = a.segment[chunk]
    ends = max(a.bounds[chunk, 0], a.interval[g, 0]), min(a.bounds[chunk, 1], a.interval[g, 1])
    return ends, a.interval[g, 0] >= a.bounds[chunk, 0], a.interval[g, 1] <= a.bounds[chunk, 1]


@compiled()
def most_pairs(a: Arrays, drawings: tuple[int, int]) -> int:
    """Most pairs of one drawing."""
    most = 0
    for drawing in range(drawings[0], drawings[1]):
        most = max(most, a.chunk_pairs[a.drawing_chunks[drawing + 1]] - a.chunk_pairs[a.drawing_chunks[drawing]])
    return most


@compiled()
def most_on_pixel(a: Arrays, begin: int, end: int) -> int:
    """Most pairs on one of some active pixels."""
    most = 0
    for pixel in range(begin, end):
        most = max(most, a.start[pixel + 1] - a.start[pixel])
    return most


@compiled()
def cover(a: Arrays, scale: float, drawing: int, coverage: Array) -> None:
    """First pass: coverage of every pair of a drawing."""
    first = a.chunk_pairs[a.drawing_chunks[drawing]]
    for chunk in range(a.drawing_chunks[drawing], a.drawing_chunks[drawing + 1]):
        i, j = a.chunk_pairs[chunk], a.chunk_pairs[chunk + 1]
        g, covered = a.segment[chunk], coverage[i - first : j - first]
        visible, _, _ = _visible(a, chunk)
        if visible[1] > visible[0]:
            cover_pairs((a.control[g], a.half_width[g]), visible, scale, (a.x[i:j], a.y[i:j]), (a.t[i:j], covered))
        else:
            covered[:] = 0


@compiled()
def gather(a: Arrays, scale: float, drawing: int, weight: Array, grads: tuple[Array, Array, Array]) -> None:
    """Third pass: gradients of control points, half-widths and visible intervals, from the pairs that have a weight."""
    first, (place, scratch) = a.chunk_pairs[a.drawing_chunks[drawing]], scratch_of(a, drawing)
    grad_control, grad_half_width, grad_interval = grads
    for chunk in range(a.drawing_chunks[drawing], a.drawing_chunks[drawing + 1]):
        i, j, g = a.chunk_pairs[chunk], a.chunk_pairs[chunk + 1], a.segment[chunk]
        count, (t, w), partials = slopes_of(a, scale, chunk, weight[i - first : j - first], place, scratch)
        if count == 0:
            continue
        accumulate(t, w, partials, grad_control[g], grad_half_width[g])
        visible, is_first, is_last = _visible(a, chunk)
        curve = a.control[g], a.half_width[g]
        if is_first:
            grad_interval[g, 0] += _end_gradient(curve, visible[0], (t, w), partials)
        if is_last:
            grad_interval[g, 1] += _end_gradient(curve, visible[1], (t, w), partials)


@compiled()
def scratch_of(a: Arrays, drawing: int) -> tuple[Array, Array]:
    """Room for what `slopes_of` writes about any chunk of a drawing."""
    most = 0
    for chunk in range(a.drawing_chunks[drawing], a.drawing_chunks[drawing + 1]):
        most = max(most, a.chunk_pairs[chunk + 1] - a.chunk_pairs[chunk])
    return np.empty(most, np.int64), np.zeros((PARTIALS + 4, most + LANES), a.control.dtype)


@compiled()
def slopes_of(
    a: Arrays, scale: float, chunk: int, weight: Array, place: Array, scratch: Array
) -> tuple[int, tuple[Array, Array], tuple[Array, ...]]:
    """The partials of those pairs of a chunk that have a weight.

    Args:
        a: Scene and pairs.
        scale: Side of the kernel. px
        chunk: Which one.
        weight: Of each of its pairs.
        place: Receives where the pairs with a weight are among the chunk's.
        scratch: Where the results lie.

    Returns:
        How many there are; t and weight, and partials, of these and of pairs without weight that fill up the lanes.
    """
    visible, _, _ = _visible(a, chunk)
    count = _weighty(weight, place) if visible[1] > visible[0] else 0
    full = (count + LANES - 1) // LANES * LANES
    x, y, t, w = scratch[0, :full], scratch[1, :full], scratch[2, :full], scratch[3, :full]
    partials = _rows_of(scratch, full)
    if count > 0:
        for n in range(count):
            at = a.chunk_pairs[chunk] + place[n]
            x[n], y[n], t[n], w[n] = a.x[at], a.y[at], a.t[at], weight[place[n]]
        x[count:], y[count:], t[count:], w[count:] = x[0], y[0], t[0], 0
        g = a.segment[chunk]
        differentiate((a.control[g], a.half_width[g]), visible, scale, (x, y, t), partials)
    return count, (t, w), partials


@compiled()
def _weighty(weight: Array, place: Array) -> int:
    """Write where weights are not zero; how many there are."""
    count = 0
    for i in range(len(weight)):
        place[count] = i
        count += weight[i] != 0
    return count


@compiled(inline=True)
def _rows_of(scratch: Array, count: int) -> tuple[Array, ...]:
    """The partials, as contiguous arrays: strided ones would not be vectorised."""
    ux, uy, vx, vy, h = scratch[4], scratch[5], scratch[6], scratch[7], scratch[8]
    return ux[:count], uy[:count], vx[:count], vy[:count], h[:count]


@compiled()
def _end_gradient(
    curve: tuple[Array, Array], end: float, pairs: tuple[Array, Array], partials: tuple[Array, ...]
) -> float:
    """Derivative by the t of a visible end: pairs whose nearest point it is move and widen with it."""
    (p, h), (ts, weight), (uxs, uys, vxs, vys, hs) = curve, pairs, partials
    ux = uy = vx = vy = dh = 0.0
    for i in range(len(ts)):
        if ts[i] == end:
            ux += weight[i] * uxs[i]
            uy += weight[i] * uys[i]
            vx += weight[i] * vxs[i]
            vy += weight[i] * vys[i]
            dh += weight[i] * hs[i]
    _, _, speed_x, speed_y, bend_x, bend_y = at_parameter(cubic_of(p), 0.0, 0.0, end)
    return float(ux * speed_x + uy * speed_y + vx * bend_x + vy * bend_y + dh * (h[1] - h[0]))


@compiled(inline=True)
def stack(a: Arrays, pixel: int, first: int, coverage: Array, winner: Array, row_of: Array) -> int:
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
def room_for_stacks(a: Arrays, begin: int, end: int) -> tuple[Array, Array, Array, Array]:
    """Room for what `see_through` writes about any of some active pixels."""
    most, real = most_on_pixel(a, begin, end), a.control.dtype
    clear = np.empty(most + 1, real)
    clear[0] = 1
    return np.empty(most, np.int64), np.empty(most, np.int32), np.empty(most, real), clear


@compiled(inline=True)
def see_through(a: Arrays, pixel: int, first: int, coverage: Array, room: tuple[Array, Array, Array, Array]) -> int:
    """`stack`, and of each row its coverage and how clear the pixel is below it, after the last one in all."""
    winner, row_of, covered, clear = room
    rows = stack(a, pixel, first, coverage, winner, row_of)
    for n in range(rows):
        covered[n] = coverage[winner[n]]
        clear[n + 1] = clear[n] * (a.control.dtype.type(1) - a.opacity[row_of[n]] * covered[n])
    return rows


@compiled()
def winners(a: Arrays, drawing: int, coverage: Array, winner: Array, row_of: Array) -> int:
    """Of each pixel of one row: the pair that covers most, and the row; the other pair's coverage becomes zero.

    Nearly all pixels are such, so that indices here are unsigned: signed ones would be wrapped around, at a cost.

    Args:
        a: Scene and pairs.
        drawing: Which one.
        coverage: Of each of its pairs. [n]
        winner: Receives the pairs. uint32
        row_of: Receives the rows. int32

    Returns:
        How many pixels there are.
    """
    first, begin = a.chunk_pairs[a.drawing_chunks[drawing]], a.drawing_pixels[drawing]
    lone, count = a.plain[drawing, 0] - begin, a.plain[drawing, 1] - begin
    at = a.start[begin]
    order, rows = a.order[at : at + 2 * count - lone], a.order_row[at : at + 2 * count - lone]
    for n in range(lone):
        winner[n], row_of[n] = order[n] - first, rows[n]
    for n in range(lone, count):
        i = 2 * n - lone
        one, two = np.uint32(order[i] - first), np.uint32(order[i + 1] - first)
        is_second = coverage[two] > coverage[one]
        winner[n], row_of[n] = two if is_second else one, rows[i]
        coverage[one if is_second else two] = 0
    return int(count)
