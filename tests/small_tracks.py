"""A few strokes of known shape over a few frames, for the tests of the writers."""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction

import numpy as np

from videovec.clip import Timeline
from videovec.stroke_life import StrokeLife
from videovec.strokes import Strokes
from videovec.tracks import StrokeTracks

Floats = np.typing.NDArray[np.float64]

SIZE = 96

WAVE = np.array([[10, 50], [30, 10], [45, 90], [60, 50], [70, 24], [80, 30], [86, 40.0]])
ROUND = np.array([[48, 20], [62, 20], [62, 40], [48, 40], [34, 40], [34, 20], [48, 20.0]])


def tracks_of(lives: list[StrokeLife], exposures: tuple[int, ...] = (1, 2)) -> StrokeTracks:
    shown = np.repeat(np.arange(len(exposures)), exposures)
    timeline = Timeline(
        shown,
        tuple(Fraction(k, 12) for k in range(len(shown))),
        Fraction(len(shown), 12),
        np.arange(1, len(shown) + 1),
    )
    strokes = Strokes.concatenate([life.as_strokes() for life in lives])
    rows = strokes.row_count
    return StrokeTracks("test", (SIZE, SIZE), np.ones(3), timeline, strokes, (), np.zeros(rows), np.ones(rows))


def life(stroke: int, points: Floats, half_width: list[float], **changes: object) -> StrokeLife:
    """A stroke that moves down by 4 px from its first drawing to its second."""
    plain = StrokeLife(
        id=stroke,
        first=0,
        points=np.stack([points, points + np.array([0, 4])]),
        half_width=np.tile(np.asarray(half_width, float), (2, 1)),
        opacity=np.ones(2),
        visible=np.tile([0.0, 1.0], (2, 1)),
        color=np.zeros(3),
        layer=stroke,
        is_closed=False,
    )
    return replace(plain, **changes)  # type: ignore[arg-type]
