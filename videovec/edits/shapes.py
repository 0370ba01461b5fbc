"""A drawing's strokes one by one, the form in which edits cut, join and drop them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from videovec.strokes import Layout, Strokes

__all__ = ["Shape", "shapes_of", "strokes_of"]

Floats = NDArray[np.float64]


@dataclass(frozen=True, slots=True, eq=False)
class Shape:
    """One stroke of one drawing.

    Args:
        id: Its identity.
        points: Control points. [3n+1, 2] px
        half_width: Half-width at joints. [n+1] px
        color: Ink, sRGB in [0, 1]. [3]
        is_closed: Whether it ends where it begins.
        layer: Compositing order.
        opacity: Plateau coverage.
    """

    id: int
    points: Floats
    half_width: Floats
    color: Floats
    is_closed: bool
    layer: int
    opacity: float


def shapes_of(strokes: Strokes) -> list[Shape]:
    """The strokes of one drawing, one by one."""
    return [
        Shape(
            id=int(strokes.ids[s]),
            points=strokes.points_of(s),
            half_width=strokes.half_width_of(s),
            color=strokes.color[s],
            is_closed=bool(strokes.is_closed[s]),
            layer=int(strokes.layer[s]),
            opacity=float(strokes.opacity[s]),
        )
        for s in range(len(strokes))
    ]


def strokes_of(shapes: list[Shape]) -> Strokes:
    """Fully visible strokes of drawing 0."""
    if not shapes:
        return Strokes.empty()
    at = np.zeros(len(shapes), np.intp)
    return Strokes(
        ids=np.array([shape.id for shape in shapes], np.intp),
        layout=Layout(np.array([len(shape.half_width) - 1 for shape in shapes], np.intp), at, at),
        is_closed=np.array([shape.is_closed for shape in shapes]),
        layer=np.array([shape.layer for shape in shapes], np.intp),
        color=np.stack([shape.color for shape in shapes]),
        points=np.concatenate([shape.points for shape in shapes]),
        half_width=np.concatenate([shape.half_width for shape in shapes]),
        opacity=np.array([shape.opacity for shape in shapes]),
        visible=np.tile([0.0, 1.0], (len(shapes), 1)),
    )
