"""Move the ends of strokes to where their ink ends: farther than a pixel the optimiser sees nothing of it.

Beyond the end of a thin line the kernel reaches a fraction of a pixel. Where no pixel's centre lies within it, nothing
pulls the end out, and where another stroke's ink surrounds it, nothing pulls it back: ends are sought instead.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from videovec.curves import reverse, segments_of, split
from videovec.edits.layers import Layer, Page, layers_of
from videovec.edits.shapes import Shape, shapes_of, strokes_of
from videovec.settings import EditSettings
from videovec.strokes import Strokes

__all__ = ["move_ends"]

Floats = NDArray[np.float64]

_STEPS = (1.5, 0.7, 0.35, 0.15)  # px by which ends are moved out and in, one after the other
_AGAIN = 2  # times that an end is moved by one of them
_STRETCH = 0.6  # of its length by which a last segment may be made longer or shorter at a time
_AROUND = 1.5  # px around an end's cap in which the drawing must be wrong for it to be moved
_GAIN = 0.1  # prices of a control point that a move must gain
_REACHES = tuple((is_last, sign) for is_last in (True, False) for sign in (1.0, -1.0))


def move_ends(strokes: Strokes, page: Page, settings: EditSettings) -> Strokes:
    """Move ends along their lines, out and in, wherever that lowers the error.

    Args:
        strokes: Strokes of one drawing.
        page: They drawn, against the ink; changed as they change.
        settings: The price of a control point.

    Returns:
        The same strokes, some longer or shorter.
    """
    shapes, layers = shapes_of(strokes), layers_of(strokes, page.size)
    least = _GAIN * settings.price
    for step in _STEPS:
        live = [i for i, shape in enumerate(shapes) if not shape.is_closed]
        for _ in range(_AGAIN):
            live = _improve(shapes, layers, live, step, page, least)
    return strokes_of(shapes)


def _improve(
    shapes: list[Shape], layers: list[Layer], live: list[int], step: float, page: Page, least: float
) -> list[int]:
    """Move ends of some strokes by one step where that gains enough, in place; which strokes were changed."""
    tried = [
        (i, moved)
        for i in live
        for is_last, sign in _REACHES
        if _wrong(shapes[i], is_last, page) > least and (moved := _moved(shapes[i], is_last, sign * step)) is not None
    ]
    trials = strokes_of([replace(moved, id=n + 1) for n, (_, moved) in enumerate(tried)])
    best: dict[int, tuple[float, Shape, Layer]] = {}
    for (i, moved), layer in zip(tried, layers_of(trials, page.size), strict=True):
        rise = page.rise([layers[i]], [layer])
        if rise < -least and (i not in best or rise < best[i][0]):
            best[i] = rise, moved, layer
    changed = []
    for i, (_, moved, layer) in sorted(best.items(), key=lambda found: found[1][0]):
        if page.rise([layers[i]], [layer]) < -least:  # no other stroke has taken the ink since
            page.exchange([layers[i]], [layer])
            shapes[i], layers[i] = moved, layer
            changed.append(i)
    return changed


def _wrong(shape: Shape, is_last: bool, page: Page) -> float:
    """Sum of squared errors around an end."""
    at = -1 if is_last else 0
    reach = float(shape.half_width[at]) + _AROUND
    low = np.maximum(shape.points[at] - reach, 0.0).astype(int)
    high = np.maximum(shape.points[at] + reach + 1.0, 0.0).astype(int)
    return float(np.square(page.residual_in(slice(low[1], high[1]), slice(low[0], high[0]))).sum())


def _moved(shape: Shape, is_last: bool, length: float) -> Shape | None:
    """A stroke that is longer at one end by some px, along its last cubic; None where that is too short."""
    points, widths = (shape.points, shape.half_width) if is_last else reverse(shape.points, shape.half_width)
    last = segments_of(points)[-1]
    speed = 3.0 * float(np.linalg.norm(last[3] - last[2]))
    if speed <= 1e-6 or abs(length) > _STRETCH * speed:
        return None
    grown, _ = split(last, 1.0 + length / speed)
    points = np.concatenate([points[:-4], grown])
    if not is_last:
        points, widths = reverse(points, widths)
    return replace(shape, points=points, half_width=widths)
