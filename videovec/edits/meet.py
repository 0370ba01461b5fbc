"""Ends under another line's ink go to the middle of that line, where lines meet.

The fit sees next to nothing of an end that other ink covers: it stays where the tracing left it, short of the middle by
half the covering line's half-width or so.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from videovec.curves import evaluate, split
from videovec.edits.bodies import Bodies
from videovec.edits.layers import Page, layers_of
from videovec.edits.shapes import Shape, shapes_of, strokes_of
from videovec.settings import EditSettings
from videovec.strokes import Strokes

__all__ = ["EARLY", "LATE", "meet"]

Floats = NDArray[np.float64]

EARLY = 30.0
"""Prices of a control point that an end's move may cost where a fit follows, which wins most of that back."""
LATE = 5.0
"""The same where none follows."""

_SPACING = 0.25  # px between the points of a middle line
_STEP = 0.1  # px between the places that are tried for an end
_ON = 0.15  # px from one of the points within which a place lies on the line
_REACH = 0.5  # px farther than its half-width that an end may lie from a middle
_STRETCH = 0.6  # of its length by which a last segment may be made longer or shorter


def meet(strokes: Strokes, page: Page, settings: EditSettings, cost: float) -> Strokes:
    """Move covered ends, along their own lines, to the middle of the line that covers them.

    Args:
        strokes: Strokes of one drawing.
        page: They drawn, against the ink; changed as they change.
        settings: The price of a control point.
        cost: `EARLY` or `LATE`.

    Returns:
        The same strokes, some longer or shorter.
    """
    shapes = shapes_of(strokes)
    if len(shapes) < 2:
        return strokes
    layers, bodies = layers_of(strokes, page.size), Bodies.of(shapes, _SPACING)
    for at_end in (True, False):
        moves = list(_moves(shapes, at_end, bodies))
        trials = layers_of(strokes_of([replace(moved, id=n + 1) for n, (_, moved) in enumerate(moves)]), page.size)
        for (i, moved), layer in zip(moves, trials, strict=True):
            if page.rise([layers[i]], [layer]) <= cost * settings.price:
                page.exchange([layers[i]], [layer])
                shapes[i], layers[i] = moved, layer
    return strokes_of(shapes)


def _moves(shapes: list[Shape], at_end: bool, bodies: Bodies) -> Iterator[tuple[int, Shape]]:
    """Strokes with that end on the middle of a line that covers it, and which strokes they are."""
    middle, half_width = np.asarray(bodies.tree.data), np.array([shape.half_width.mean() for shape in shapes])
    farthest = _REACH + float(half_width.max())
    for i, shape in enumerate(shapes):
        outward = shape.points[-4:] if at_end else shape.points[3::-1]
        near = np.array(bodies.tree.query_ball_point(outward[3], farthest), np.intp)
        owner = bodies.owner[near]
        reach = _REACH + half_width[owner]
        is_over = (owner != i) & (np.linalg.norm(middle[near] - outward[3], axis=1) <= reach)
        if is_over.any() and not shape.is_closed:
            cubic = _led_to(outward, middle[near[is_over]], 2.0 * float(reach[is_over].max()))
            if cubic is not None:
                points = shape.points.copy()
                points[slice(-4, None) if at_end else slice(3, None, -1)] = cubic
                yield i, replace(shape, points=points)


def _led_to(outward: Floats, middle: Floats, farthest: float) -> Floats | None:
    """A last cubic made longer or shorter so that it ends on a line; None where the line is not on its way.

    Args:
        outward: The cubic, which ends where the stroke does. [4, 2] px
        middle: Points of the line. [P, 2] px
        farthest: By how much its length may change. px
    """
    speed = 3.0 * float(np.linalg.norm(outward[3] - outward[2]))
    if speed < 1e-6:
        return None
    most = min(farthest, _STRETCH * speed)
    step = np.arange(-most, most, _STEP)
    apart = np.linalg.norm(evaluate(outward, 1.0 + step / speed)[:, None] - middle, axis=-1).min(axis=1)
    on = np.flatnonzero(apart <= _ON)
    if not len(on):
        return None
    best = on[np.argmin(np.abs(step[on]) + apart[on])]
    return split(outward, 1.0 + step[best] / speed)[0]
