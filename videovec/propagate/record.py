"""The book of lives: what every stroke was on every drawing, until it is bound into `Strokes`."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from videovec.curves import arc_length, sample_by_arc
from videovec.stroke_life import StrokeLife
from videovec.strokes import Layout, Strokes

__all__ = ["STEP", "Interval", "Life", "Row", "bind", "open_lives", "within"]

Floats = NDArray[np.float64]
Bools = NDArray[np.bool_]

Interval = tuple[float, float]
"""A part of a stroke's arc, as arc fractions."""

STEP = 0.5
"""Distance of the places that are looked at along a stroke. px"""


@dataclass(frozen=True, slots=True, eq=False)
class Row:
    """A stroke on one drawing.

    Args:
        points: Control points. [3n+1, 2] px
        half_width: Half-width at the joints. [n+1] px
        opacity: Plateau coverage.
        visible: The part of the arc that is seen, as arc fractions; equal ends are none.
        confidence: How well the ink supports it, in [0, 1].
        gaps: Parts within it that are not seen, in their order.
    """

    points: Floats
    half_width: Floats
    opacity: float
    visible: Interval
    confidence: float
    gaps: tuple[Interval, ...] = ()

    @property
    def parts(self) -> tuple[Interval, ...]:
        """The parts that are seen, in their order."""
        cuts = [self.visible[0], *(u for gap in self.gaps for u in gap), self.visible[1]]
        return tuple(zip(cuts[::2], cuts[1::2], strict=True)) if cuts[-1] > cuts[0] else ()

    @property
    def seen(self) -> float:
        """Share of the arc that is seen."""
        return sum(end - begin for begin, end in self.parts)

    def along(self) -> Floats:
        """Places all along it, evenly `STEP` apart. [M, 2] px"""
        return sample_by_arc(self.points, max(3, round(arc_length(self.points) / STEP) + 1))

    def showing(self, parts: Sequence[Interval]) -> Row:
        """The same with other parts seen."""
        cuts = [u for part in parts for u in part]
        visible = (cuts[0], cuts[-1]) if cuts else (0.0, 0.0)
        return replace(self, visible=visible, gaps=tuple(zip(cuts[1:-1:2], cuts[2::2], strict=False)))


def within(parts: Sequence[Interval], count: int) -> Bools:
    """Which of some places, evenly along a stroke, lie in parts of it. bool [M]"""
    u = np.linspace(0.0, 1.0, count)
    return np.asarray(np.any([(u >= begin) & (u <= end) for begin, end in parts] or [np.zeros(count, bool)], axis=0))


@dataclass(slots=True, eq=False)
class Life:
    """One identity while it is being followed.

    Args:
        id: Identity, from 1.
        is_closed: Whether the stroke ends where it begins.
        layer: Compositing order.
        color: Ink. [3]
        rows: What it was, by drawing.
        parent: Identity of the stroke whose part beyond a gap it is, else 0.
        covers: Whether it has hidden another stroke.
        home: The drawing on which it was given or traced.
    """

    id: int
    is_closed: bool
    layer: int
    color: Floats
    rows: dict[int, Row] = field(default_factory=dict)
    parent: int = 0
    covers: bool = False
    home: int = 0

    @property
    def first(self) -> int:
        """First drawing."""
        return min(self.rows)

    @property
    def last(self) -> int:
        """Last drawing."""
        return max(self.rows)

    @property
    def most_seen(self) -> Interval:
        """The longest part of the arc that was ever seen."""
        return max((row.visible for row in self.rows.values()), key=lambda visible: visible[1] - visible[0])

    @property
    def has_gaps(self) -> bool:
        """Whether it has a gap on any drawing."""
        return any(row.gaps for row in self.rows.values())

    def whole(self) -> StrokeLife:
        """The same as arrays; gaps are left out."""
        rows = [self.rows[drawing] for drawing in sorted(self.rows)]
        return StrokeLife(
            id=self.id,
            first=self.first,
            points=np.stack([row.points for row in rows]),
            half_width=np.stack([row.half_width for row in rows]),
            opacity=np.array([row.opacity for row in rows]),
            visible=np.array([row.visible for row in rows]),
            color=self.color,
            layer=self.layer,
            is_closed=self.is_closed,
        )

    def becoming(self, whole: StrokeLife, others: Sequence[Life]) -> Life:
        """This identity with the rows of arrays, each as sure as the surest of some lives is on its drawing."""
        rows = {}
        for k, visible in enumerate(whole.visible.tolist()):
            sure = [life.rows[whole.first + k].confidence for life in others if whole.first + k in life.rows]
            rows[whole.first + k] = Row(
                whole.points[k], whole.half_width[k], float(whole.opacity[k]), tuple(visible), max(sure, default=0.0)
            )
        return replace(self, rows=rows)


def open_lives(strokes: Strokes) -> list[Life]:
    """A life for every stroke, with all its rows."""
    lives = []
    for s in range(len(strokes)):
        life = Life(int(strokes.ids[s]), bool(strokes.is_closed[s]), int(strokes.layer[s]), strokes.color[s])
        life.home = int(strokes.layout.first[s])
        for drawing in range(int(strokes.layout.first[s]), int(strokes.layout.last[s]) + 1):
            row = strokes.row(s, drawing)
            visible = (float(strokes.visible[row, 0]), float(strokes.visible[row, 1]))
            life.rows[drawing] = Row(
                strokes.points_of(row), strokes.half_width_of(row), float(strokes.opacity[row]), visible, 1.0
            )
        lives.append(life)
    return lives


def bind(lives: list[Life]) -> tuple[Strokes, Floats]:
    """All lives as strokes, in their order, and the confidence of every row.

    Args:
        lives: Lives without gaps in them or between their drawings; those without rows are left out.

    Returns:
        The strokes and [R].
    """
    lives = [life for life in lives if life.rows]
    if not lives:
        return Strokes.empty(), np.zeros(0)
    rows = [life.rows[d] for life in lives for d in range(life.first, life.last + 1)]
    strokes = Strokes(
        ids=np.array([life.id for life in lives], np.intp),
        layout=Layout(
            np.array([(len(life.rows[life.first].points) - 1) // 3 for life in lives], np.intp),
            np.array([life.first for life in lives], np.intp),
            np.array([life.last for life in lives], np.intp),
        ),
        is_closed=np.array([life.is_closed for life in lives], bool),
        layer=np.array([life.layer for life in lives], np.intp),
        color=np.stack([life.color for life in lives]),
        points=np.concatenate([row.points for row in rows]),
        half_width=np.concatenate([row.half_width for row in rows]),
        opacity=np.array([row.opacity for row in rows]),
        visible=np.array([row.visible for row in rows], float),
        parent=np.array([life.parent for life in lives], np.intp),
    )
    return strokes, np.array([row.confidence for row in rows])
