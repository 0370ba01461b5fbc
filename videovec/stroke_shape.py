"""One stroke as it stands on one drawing."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from videovec.curves import arc_length, evaluate, parameter_at, segment_lengths, segments_of, split, sub_curve, width_at
from videovec.strokes import Strokes

__all__ = ["StrokeShape", "hex_colour", "shape_of_row"]

Floats = NDArray[np.float64]

_SAMPLES = 33  # places on a segment among which its nearest point is first looked for


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

    def positions(self, u: Floats) -> Floats:
        """Points at arc fractions. [M] -> [M, 2] px"""
        segment, t = parameter_at(self.points, u)
        return evaluate(segments_of(self.points)[segment], t)

    def half_width_at(self, u: float) -> float:
        """Half-width at an arc fraction. px"""
        segment, t = parameter_at(self.points, np.array([u]))
        return float(width_at(self.half_width, segment, t)[0])

    def nearest(self, at: Floats) -> tuple[float, float]:
        """The visible point that is nearest to a place.

        Args:
            at: x and y. [2] px

        Returns:
            Its arc fraction, and its distance from the place. px
        """
        part = self.visible_part()
        control = segments_of(part.points)
        t = np.linspace(0.0, 1.0, _SAMPLES)
        distance = np.linalg.norm(evaluate(control[:, None], t) - at, axis=-1)  # [n, M]
        start, end = self.visible
        best = (np.inf, 0.0)
        for k in np.argsort(distance.min(1))[:3]:  # neighbours of the nearest sample may hold the nearest point
            place = _closest_parameter(control[k], at, float(t[distance[k].argmin()]))
            reach = float(np.linalg.norm(evaluate(control[k], place) - at))
            best = min(best, (reach, _fraction_at(part.points, int(k), place)))
        return start + best[1] * (end - start), best[0]

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


def _closest_parameter(control: Floats, at: Floats, guess: float) -> float:
    """Parameter of a cubic's nearest point to a place, around a guess, by thirds of a shrinking bracket."""
    low, high = max(guess - 1 / (_SAMPLES - 1), 0.0), min(guess + 1 / (_SAMPLES - 1), 1.0)
    while high - low > 1e-9:
        inner = np.array([low + (high - low) / 3, high - (high - low) / 3])
        distance = np.linalg.norm(evaluate(control, inner) - at, axis=-1)
        low, high = (low, float(inner[1])) if distance[0] <= distance[1] else (float(inner[0]), high)
    return (low + high) / 2


def _fraction_at(points: Floats, segment: int, t: float) -> float:
    """Arc fraction of a parameter; that of the parameter itself where the stroke has no length."""
    lengths = segment_lengths(points)
    if lengths.sum() == 0:
        return (segment + t) / len(lengths)
    before = arc_length(split(points[3 * segment : 3 * segment + 4], t)[0])
    return float((lengths[:segment].sum() + before) / lengths.sum())


def hex_colour(color: Floats) -> str:
    """A colour as web formats write it: [3] in [0, 1] -> ``#rrggbb``."""
    red, green, blue = np.rint(255 * np.clip(color, 0, 1)).astype(int).tolist()
    return f"#{red:02x}{green:02x}{blue:02x}"
