"""How opaque strokes are on every drawing, read from ink that fades."""

from __future__ import annotations

from dataclasses import replace

import cv2
import numpy as np
from numpy.typing import NDArray

from videovec.curves import arc_length, sample_by_arc
from videovec.ink import Ink
from videovec.strokes import Strokes

__all__ = ["measure_opacity"]

_OPAQUE = 0.96
"""Opacity from which on a stroke is opaque."""
_LEAST = 0.02
"""Opacity of a stroke of which nothing is left, but that it is there."""
_WIDE = 1.5
"""Half-width from which on the middle of a line shows all that there is of its ink. px"""
_PLACES = 2.0
"""Distance between the places at which a stroke's opacity is measured. px"""


def measure_opacity(strokes: Strokes, ink: Ink) -> Strokes:
    """Strokes with the opacity that each of their drawings shows.

    Args:
        strokes: S strokes over D drawings.
        ink: The drawings; where nothing fades, the strokes stay as they are.
    """
    if ink.seen is None:
        return strokes
    opacity = strokes.opacity.copy()
    for row in np.flatnonzero(strokes.visible[:, 1] > strokes.visible[:, 0]).tolist():
        drawing = int(strokes.layout.row_drawing[row])
        opacity[row] = _opacity(strokes, row, ink.seen[drawing], ink.coverage[drawing])
    return replace(strokes, opacity=opacity)


def _opacity(strokes: Strokes, row: int, seen: NDArray[np.uint8], solid: NDArray[np.uint8]) -> float:
    """Median share along the centre line; of a thin line, against what its ink would show there."""
    points = strokes.points_of(row)
    dense = sample_by_arc(points, max(5, round(arc_length(points) / _PLACES)))
    u = np.linspace(0.0, 1.0, len(dense))
    begin, end = strokes.visible[row]
    places = dense[(u >= begin) & (u <= end)] if end > begin else dense
    at = (places if len(places) else dense).astype(np.float32) - 0.5
    values = [
        float(np.median(cv2.remap(image, at[:, :1], at[:, 1:], cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)))
        for image in (seen, solid)
    ]
    wide = float(strokes.half_width_of(row).mean()) >= _WIDE
    share = values[0] / 255.0 if wide else values[0] / max(values[1], 1.0)
    return 1.0 if share >= _OPAQUE else max(share, _LEAST)
