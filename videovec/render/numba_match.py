"""The step of a fit on the CPU: union of the rows, squared residual against the ink, gradients, in one go."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from videovec.compiling import compiled
from videovec.render.numba_backend import Arrays, cover, gather, most_pairs, room_for_stacks, see_through, winners

__all__ = ["match_drawings"]

Array = NDArray[Any]


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
    most = most_pairs(a, drawings)
    scratch, winner, row_of = np.empty(most, a.control.dtype), np.empty(most, np.uint32), np.empty(most, np.int32)
    for drawing in range(drawings[0], drawings[1]):
        first, last = a.chunk_pairs[a.drawing_chunks[drawing]], a.chunk_pairs[a.drawing_chunks[drawing + 1]]
        pairs, wanted = scratch[: last - first], (target, extra)
        cover(a, scale, drawing, pairs)
        count = winners(a, drawing, pairs, winner, row_of)
        plain = _match_plain(a, drawing, pairs, (winner[:count], row_of[:count]), wanted, (grad_opacity, value))
        loss[drawing] = plain + _match_stacks(a, drawing, pairs, wanted, grad_opacity, value)
        gather(a, scale, drawing, pairs, (grad_control, grad_half_width, grad_interval))


@compiled()
def _match_plain(
    a: Arrays,
    drawing: int,
    pairs: Array,
    seen: tuple[Array, Array],
    wanted: tuple[Array, Array],
    out: tuple[Array, Array],
) -> float:
    """Second pass where a pixel has one row, of one or two pairs: nearly everywhere, and always the same to do.

    Args:
        a: Scene and pairs.
        drawing: Which one.
        pairs: Coverage of each pair; gives way to the derivative of the loss by it. [n]
        seen: Pair and row of each pixel, from `winners`.
        wanted: As ``target`` and ``extra`` of `match_drawings`.
        out: Gradient of the rows' opacity, added to [R]; value of each active pixel, written [A].

    Returns:
        Sum of squared residuals.
    """
    real, (target, extra), (winner, row_of), (grad_opacity, value) = a.control.dtype.type, wanted, seen, out
    begin = a.drawing_pixels[drawing]
    one, full, zero = real(1), real(1 / 255), real(0)
    active, value = a.active[begin : begin + len(winner)], value[begin : begin + len(winner)]
    has_extra = len(extra) > 0
    total, of_row, last, grad, opacity = 0.0, zero, np.int32(-1), zero, one
    for n in range(len(winner)):
        pair, row = winner[n], row_of[n]
        if row != last:
            if last >= 0:
                grad_opacity[last] += grad
            total += of_row
            last, grad, of_row, opacity = row, zero, zero, a.opacity[row]
        covered = pairs[pair]
        drawn = opacity * covered
        residual = drawn - real(target[np.uint64(active[n])]) * full
        of_row += residual * residual
        slope = residual + residual + (extra[begin + n] if has_extra else zero)
        value[n] = drawn
        pairs[pair] = slope * opacity if (covered > zero) & (covered < one) else zero
        grad += slope * covered
    if last >= 0:
        grad_opacity[last] += grad
    return float(total + of_row)


@compiled()
def _match_stacks(
    a: Arrays, drawing: int, pairs: Array, wanted: tuple[Array, Array], grad_opacity: Array, value: Array
) -> float:
    """`_match_plain` for the other pixels, where rows may lie above each other."""
    real, (target, extra) = a.control.dtype.type, wanted
    first, begin, end = a.chunk_pairs[a.drawing_chunks[drawing]], a.plain[drawing, 1], a.drawing_pixels[drawing + 1]
    room = room_for_stacks(a, begin, end)
    winner, row_of, covered, clear = room
    one, full = real(1), real(1 / 255)
    total = 0.0
    for pixel in range(begin, end):
        rows = see_through(a, pixel, first, pairs, room)
        value[pixel] = one - clear[rows]
        residual = value[pixel] - real(target[a.active[pixel]]) * full
        total += residual * residual
        slope = residual + residual + (extra[pixel] if len(extra) > 0 else real(0))
        for at in range(a.start[pixel], a.start[pixel + 1]):
            pairs[a.order[at] - first] = 0
        for n in range(rows - 1, -1, -1):
            opacity, through = a.opacity[row_of[n]], slope * clear[n]
            if (covered[n] > 0) & (covered[n] < one):  # else it is flat
                pairs[winner[n]] = through * opacity
            grad_opacity[row_of[n]] += through * covered[n]
            slope *= one - opacity * covered[n]
    return total
