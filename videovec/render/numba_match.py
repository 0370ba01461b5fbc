"""The step of a fit on the CPU: union of the rows, squared residual against the ink, gradients, in one go."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from videovec.compiling import compiled
from videovec.render.numba_backend import Arrays, cover, gather, most_on_pixel, most_pairs, stack

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
    scratch = np.empty(most_pairs(a, drawings), a.control.dtype)
    for drawing in range(drawings[0], drawings[1]):
        first, last = a.chunk_pairs[a.drawing_chunks[drawing]], a.chunk_pairs[a.drawing_chunks[drawing + 1]]
        pairs = scratch[: last - first]
        cover(a, scale, drawing, pairs)
        plain = _match_plain(a, drawing, pairs, (target, extra), grad_opacity, value)
        loss[drawing] = plain + _match_stacks(a, drawing, pairs, (target, extra), grad_opacity, value)
        gather(a, scale, drawing, pairs, (grad_control, grad_half_width, grad_interval))


@compiled()
def _match_plain(
    a: Arrays, drawing: int, pairs: Array, wanted: tuple[Array, Array], grad_opacity: Array, value: Array
) -> float:
    """Second pass where a pixel has one row, of one or two pairs: nearly everywhere, and always the same to do.

    Args:
        a: Scene and pairs.
        drawing: Which one.
        pairs: Coverage of each pair; gives way to the derivative of the loss by it. [n]
        wanted: As ``target`` and ``extra`` of `match_drawings`.
        grad_opacity: Gradient of the rows' opacity, added to. [R]
        value: Of each active pixel, written. [A]

    Returns:
        Sum of squared residuals.
    """
    real, (target, extra) = a.control.dtype.type, wanted
    first, lone = a.chunk_pairs[a.drawing_chunks[drawing]], a.plain[drawing, 0]
    one, full, zero = real(1), real(1 / 255), real(0)
    has_extra = len(extra) > 0
    total, last, grad = 0.0, -1, zero
    for pixel in range(a.drawing_pixels[drawing], a.plain[drawing, 1]):
        at = a.start[pixel]
        row, win = a.order_row[at], a.order[at] - first
        if pixel >= lone:
            other = a.order[at + 1] - first
            is_second = pairs[other] > pairs[win]
            win, other = (other, win) if is_second else (win, other)
            pairs[other] = zero
        opacity, covered = a.opacity[row], pairs[win]
        drawn = opacity * covered
        residual = drawn - real(target[a.active[pixel]]) * full
        total += residual * residual
        slope = residual + residual + (extra[pixel] if has_extra else zero)
        value[pixel] = drawn
        pairs[win] = slope * opacity if (covered > zero) & (covered < one) else zero
        if row != last:
            if last >= 0:
                grad_opacity[last] += grad
            last, grad = row, zero
        grad += slope * covered
    if last >= 0:
        grad_opacity[last] += grad
    return total


@compiled()
def _match_stacks(
    a: Arrays, drawing: int, pairs: Array, wanted: tuple[Array, Array], grad_opacity: Array, value: Array
) -> float:
    """`_match_plain` for the other pixels, where rows may lie above each other."""
    real, (target, extra) = a.control.dtype.type, wanted
    first, begin, end = a.chunk_pairs[a.drawing_chunks[drawing]], a.plain[drawing, 1], a.drawing_pixels[drawing + 1]
    most = most_on_pixel(a, begin, end)
    winner, row_of = np.empty(most, np.int64), np.empty(most, np.int32)
    covered, clear = np.empty(most, a.control.dtype), np.empty(most + 1, a.control.dtype)
    clear[0], one, full = real(1), real(1), real(1 / 255)
    total = 0.0
    for pixel in range(begin, end):
        rows = stack(a, pixel, first, pairs, winner, row_of)
        for n in range(rows):
            covered[n] = pairs[winner[n]]
            clear[n + 1] = clear[n] * (one - a.opacity[row_of[n]] * covered[n])
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
