"""The normal equations of a fit on the CPU: how the squared residual falls and bends with the unknowns of each segment.

Pixels are least-squares equations. With J the derivative of a pixel's value by the unknowns, the residual's square has
the gradient 2 r J and, as Gauss and Newton have it, the second derivative 2 J J'. A pixel's value hangs on one segment
of each row that covers it; what the equations leave out is the coupling between rows.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from videovec.compiling import compiled
from videovec.render.numba_backend import (
    Arrays,
    cover,
    most_pairs,
    room_for_stacks,
    scratch_of,
    see_through,
    slopes_of,
    winners,
)

__all__ = ["UNKNOWNS", "normal_drawings"]

Array = NDArray[Any]

UNKNOWNS = 10
"""Of a segment, in this order: x, y and half-width of its first joint; x, y of both handles; its last joint."""


@compiled()
def normal_drawings(
    a: Arrays, drawings: tuple[int, int], scale: float, target: Array, out: tuple[Array, Array, Array]
) -> None:
    """Set up the equations of some drawings.

    Args:
        a: Scene and pairs.
        drawings: First drawing and the one after the last.
        scale: Side of the kernel. px
        target: Ink coverage of all pixels, 255 is full. uint8 [D * H * W]
        out: Sum of squared residuals of each drawing's active pixels [D]; gradient [G, UNKNOWNS] and second derivative
            [G, UNKNOWNS, UNKNOWNS] by each segment's unknowns, zeros before.
    """
    loss, gradient, matrix = out
    most = most_pairs(a, drawings)
    room, winner, row_of = np.empty((2, most), a.control.dtype), np.empty(most, np.uint32), np.empty(most, np.int32)
    for drawing in range(drawings[0], drawings[1]):
        first, last = a.chunk_pairs[a.drawing_chunks[drawing]], a.chunk_pairs[a.drawing_chunks[drawing + 1]]
        sway, residual = room[0, : last - first], room[1, : last - first]
        cover(a, scale, drawing, sway)
        count = winners(a, drawing, sway, winner, row_of)
        plain = _plain_residuals(a, drawing, target, (winner[:count], row_of[:count]), sway, residual)
        loss[drawing] = plain + _residuals(a, drawing, target, sway, residual)
        place, scratch = scratch_of(a, drawing)
        rows = np.empty((UNKNOWNS, scratch.shape[1]), a.control.dtype)
        for chunk in range(a.drawing_chunks[drawing], a.drawing_chunks[drawing + 1]):
            i, j, g = a.chunk_pairs[chunk] - first, a.chunk_pairs[chunk + 1] - first, a.segment[chunk]
            count, pairs, partials = slopes_of(a, scale, chunk, sway[i:j], place, scratch)
            for n in range(count):
                place[n] += i
            if count > 0:
                _add(pairs, partials, (residual, place[:count]), rows, (gradient[g], matrix[g]))


@compiled()
def _plain_residuals(
    a: Arrays, drawing: int, target: Array, seen: tuple[Array, Array], sway: Array, residual: Array
) -> float:
    """`_residuals` of pixels with one row, whose pairs and rows `winners` has found."""
    real, (winner, row_of) = a.control.dtype.type, seen
    begin = a.drawing_pixels[drawing]
    active = a.active[begin : begin + len(winner)]
    one, full, zero = real(1), real(1 / 255), real(0)
    total, of_row, last, opacity = 0.0, zero, np.int32(-1), one
    for n in range(len(winner)):
        pair, row = winner[n], row_of[n]
        if row != last:
            total += of_row
            last, of_row, opacity = row, zero, a.opacity[row]
        covered = sway[pair]
        error = opacity * covered - real(target[np.uint64(active[n])]) * full
        of_row += error * error
        residual[pair] = error
        sway[pair] = opacity if (covered > zero) & (covered < one) else zero
    return float(total + of_row)


@compiled()
def _residuals(a: Arrays, drawing: int, target: Array, sway: Array, residual: Array) -> float:
    """Composite where rows may lie above each other.

    The coverage of each pair gives way to the derivative of its pixel's value by it.

    Args:
        a: Scene and pairs.
        drawing: Which one.
        target: As of `normal_drawings`.
        sway: Coverage of each pair; gives way to the derivatives. [n]
        residual: Receives that of the pixel of each pair that has one. [n]

    Returns:
        Sum of squared residuals.
    """
    real = a.control.dtype.type
    first, begin, end = a.chunk_pairs[a.drawing_chunks[drawing]], a.plain[drawing, 1], a.drawing_pixels[drawing + 1]
    room = room_for_stacks(a, begin, end)
    winner, row_of, covered, clear = room
    one, full = real(1), real(1 / 255)
    total = 0.0
    for pixel in range(begin, end):
        rows = see_through(a, pixel, first, sway, room)
        error = one - clear[rows] - real(target[a.active[pixel]]) * full
        total += error * error
        for at in range(a.start[pixel], a.start[pixel + 1]):
            sway[a.order[at] - first] = 0
        above = one
        for n in range(rows - 1, -1, -1):
            opacity = a.opacity[row_of[n]]
            if (covered[n] > 0) & (covered[n] < one):  # else it is flat
                sway[winner[n]], residual[winner[n]] = clear[n] * above * opacity, error
            above *= one - opacity * covered[n]
    return total


@compiled(fastmath=True)
def _add(
    pairs: tuple[Array, Array], partials: tuple[Array, ...], residuals: tuple[Array, Array], rows: Array, out: Any
) -> None:
    """Add the equations of some pairs of one chunk to those of its segment; the matrix's upper triangle."""
    (ts, ws), (uxs, uys, vxs, vys, hs), (residual, place), (gradient, matrix) = pairs, partials, residuals, out
    real = ws.dtype.type
    one, two, three = real(1), real(2), real(3)
    x0, y0, h0, x1, y1 = rows[0], rows[1], rows[2], rows[3], rows[4]
    x2, y2, x3, y3, h1 = rows[5], rows[6], rows[7], rows[8], rows[9]
    for i in range(len(ts)):
        t, w = ts[i], ws[i]
        s = one - t
        b0, b1, b2, b3 = s * s * s, three * s * s * t, three * s * t * t, t * t * t
        d0, d1, d2, d3 = -three * s * s, three * s * (s - t - t), three * t * (s + s - t), three * t * t
        ux, uy, vx, vy, h = w * uxs[i], w * uys[i], w * vxs[i], w * vys[i], w * hs[i]
        x0[i], y0[i], h0[i] = b0 * ux + d0 * vx, b0 * uy + d0 * vy, s * h
        x1[i], y1[i] = b1 * ux + d1 * vx, b1 * uy + d1 * vy
        x2[i], y2[i] = b2 * ux + d2 * vx, b2 * uy + d2 * vy
        x3[i], y3[i], h1[i] = b3 * ux + d3 * vx, b3 * uy + d3 * vy, t * h
    for m in range(len(rows)):
        one_row, total = rows[m], real(0)
        for n in range(len(place)):
            total += one_row[n] * residual[place[n]]
        gradient[m] += two * total
        for k in range(m, len(rows)):
            other_row, total = rows[k], real(0)
            for i in range(len(ts)):
                total += one_row[i] * other_row[i]
            matrix[m, k] += two * total
