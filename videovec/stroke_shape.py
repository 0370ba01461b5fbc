"""One stroke as it stands on one drawing."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from videovec.curves import segment_lengths, sub_curve
from videovec.strokes import Strokes

__all__ = ["StrokeShape", "shape_of_row"]

Floats = NDArray[np.float64]


@dataclass(frozen=True, slots=True, eq=False)
class StrokeShape:
    """A stroke on one drawing.

    Args:
        id: Its identity.
        points: Control points of its n segments. [3n+1, 2] px
        half_width: Centre line to edge at the joints. [n+1] px
        color: Ink, sRGB in [0, 1]. [3]
        opacity: Plateau coverage, in [0, 1].
        visible: The part of the arc that is seen, as arc fractions.
        is_closed: Whether it ends where it begins.
    """

    id: int
    points: Floats
    half_width: Floats
    color: Floats
    opacity: float
    visible: tuple[float, float] = (0.0, 1.0)
    is_closed: bool = False

    @property
    def is_visible(self) -> bool:
        """Whether any of it is seen."""
        return self.visible[0] < self.visible[1] and self.opacity > 0

    @property
    def is_whole(self) -> bool:
        """Whether all of it is seen."""
        return self.visible[0] <= 0 and self.visible[1] >= 1

    @property
    def mean_half_width(self) -> float:
        """Half-width, averaged over the arc. px"""
        lengths = segment_lengths(self.points)
        middles = (self.half_width[:-1] + self.half_width[1:]) / 2
        return float(np.average(middles, weights=lengths) if lengths.sum() > 0 else middles.mean())

    def visible_part(self) -> StrokeShape:
        """The part that is seen, as a stroke of its own; a part of a closed stroke is open."""
        if self.is_whole:
            return self
        points, half_width = sub_curve(self.points, self.half_width, *self.visible)
        return replace(self, points=points, half_width=half_width, visible=(0.0, 1.0), is_closed=False)


def shape_of_row(strokes: Strokes, row: int) -> StrokeShape:
    """A row of strokes, on its own."""
    stroke = int(strokes.layout.row_stroke[row])
    return StrokeShape(
        id=int(strokes.ids[stroke]),
        points=strokes.points_of(row),
        half_width=strokes.half_width_of(row),
        color=strokes.color[stroke],
        opacity=float(strokes.opacity[row]),
        visible=(float(strokes.visible[row, 0]), float(strokes.visible[row, 1])),
        is_closed=bool(strokes.is_closed[stroke]),
    )
