"""Strokes that were taken for hidden, though all of their ink is where they are."""

from __future__ import annotations

from dataclasses import replace

import cv2
import numpy as np
from numpy.typing import NDArray

from videovec.curves import arc_length, sample_by_arc
from videovec.ink import Ink
from videovec.strokes import Strokes

__all__ = ["unhide"]

_SPACING = 2.0
"""Distance between the places that are looked at. px"""
_INKED = 0.9
"""Share of them that must be ink."""
_COVERAGE = 0.4
"""Coverage of ink, as a share of what the stroke's seen drawings show."""


def unhide(strokes: Strokes, ink: Ink) -> Strokes:
    """Show hidden strokes that lie on ink from end to end.

    Where two lines touch, one of them claims the ink of both and the other counts as hidden for a drawing or two. A
    stroke behind something else does not lie on ink: it is where its surroundings carried it.

    Args:
        strokes: Strokes over D drawings, some of them hidden in some.
        ink: The ink of these drawings.

    Returns:
        The same strokes, with fewer of them hidden.
    """
    is_hidden = strokes.visible[:, 1] <= strokes.visible[:, 0]
    visible = strokes.visible.copy()
    layout = strokes.layout
    for stroke in np.unique(layout.row_stroke[is_hidden]).tolist():
        rows = np.arange(layout.stroke_rows[stroke], layout.stroke_rows[stroke + 1])
        values = {row: _along(strokes, row, ink) for row in rows.tolist()}
        seen = [values[row] for row in rows.tolist() if not is_hidden[row]]
        if not seen:
            continue
        least = _COVERAGE * float(np.median(np.concatenate(seen)))
        for row in rows[is_hidden[rows]].tolist():
            if least > 0 and np.mean(values[row] >= least) >= _INKED:
                visible[row] = (0.0, 1.0)
    return replace(strokes, visible=visible)


def _along(strokes: Strokes, row: int, ink: Ink) -> NDArray[np.float32]:
    """Coverage along the centre line of a row. [M]"""
    points = strokes.points_of(row)
    places = sample_by_arc(points, max(2, round(arc_length(points) / _SPACING))).astype(np.float32) - 0.5
    image = ink.coverage[strokes.layout.row_drawing[row]]
    # OpenCV maps at most 32,767 places at once
    values = [
        cv2.remap(image, part[:, :1], part[:, 1:], cv2.INTER_LINEAR, borderMode=cv2.BORDER_CONSTANT)
        for part in np.array_split(places, len(places) // 30000 + 1)
    ]
    return np.concatenate(values).ravel().astype(np.float32)
