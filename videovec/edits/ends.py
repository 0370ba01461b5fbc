"""Move the ends of strokes to where their ink ends: farther than a pixel the optimiser sees nothing of it.

Beyond the end of a thin line the kernel reaches a fraction of a pixel. Where no pixel's centre lies within it, nothing
pulls the end out, and where another stroke's ink surrounds it, nothing pulls it back: ends are sought instead.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from videovec.curves import split
from videovec.edits.layers import Layer, Page, layers_of
from videovec.edits.shapes import Shape, shapes_of, strokes_of
from videovec.settings import EditSettings
from videovec.strokes import Strokes

__all__ = ["COARSE", "FINE", "move_ends"]

Floats = NDArray[np.float64]

COARSE = (1.5, 0.7)
"""Steps by which ends are moved out and in, one after the other, where a fit follows that moves them by less. px"""
FINE = (*COARSE, 0.35, 0.15)
"""The same where none follows. px"""

_AGAIN = 2  # times that an end is moved by one of them
_STRETCH = 0.6  # of its length by which a last segment may be made longer or shorter at a time
_AROUND = 1.5  # px around an end's cap in which the drawing must be wrong for it to be moved
_GAIN = 0.1  # prices of a control point that a move must gain


def move_ends(strokes: Strokes, page: Page, settings: EditSettings, steps: Sequence[float]) -> Strokes:
    """Move ends along their lines, out and in, wherever that lowers the error.

    Args:
        strokes: Strokes of one drawing.
        page: They drawn, against the ink; changed as they change.
        settings: The price of a control point.
        steps: `COARSE` or `FINE`. px

    Returns:
        The same strokes, some longer or shorter.
    """
    shapes, layers = shapes_of(strokes), layers_of(strokes, page.size)
    least = _GAIN * settings.price
    for step in steps:
        live = [i for i, shape in enumerate(shapes) if not shape.is_closed]
        for _ in range(_AGAIN):
            live = _improve(shapes, layers, live, step, page, least)
    return strokes_of(shapes)


def _improve(
    shapes: list[Shape], layers: list[Layer], live: list[int], step: float, page: Page, least: float
) -> list[int]:
    """Move ends of some strokes by one step where that gains enough, in place; which strokes were changed."""
    wrong = [(i, at_end) for i in live for at_end in (True, False) if _wrong(shapes[i], at_end, page) > least]
    tried = _moved(shapes, wrong, step)
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


def _moved(shapes: list[Shape], ends: list[tuple[int, bool]], step: float) -> list[tuple[int, Shape]]:
    """Strokes that are longer or shorter at an end by some px, along its last cubic, and which; none too short for it.

    Args:
        shapes: All strokes.
        ends: Which of them, and whether it is the last point's end.
        step: By how much. px
    """
    if not ends:
        return []
    outward = np.stack([shapes[i].points[-4:] if at_end else shapes[i].points[3::-1] for i, at_end in ends])
    speed = 3.0 * np.linalg.norm(outward[:, 3] - outward[:, 2], axis=1)
    moved = []
    can_move = (speed > 1e-6) & (step <= _STRETCH * speed)
    length = np.array([step, -step]) / np.maximum(speed, 1e-6)[:, None]
    grown, _ = split(outward[:, None], 1.0 + length)  # [E, 2, 4, 2]
    for n in np.flatnonzero(can_move).tolist():
        i, at_end = ends[n]
        for cubic in grown[n]:
            points = shapes[i].points.copy()
            if at_end:
                points[-4:] = cubic
            else:
                points[:4] = cubic[::-1]
            moved.append((i, replace(shapes[i], points=points)))
    return moved
