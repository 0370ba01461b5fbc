"""Strokes over drawings: the type that every stage after initialisation takes and gives.

Ragged in strokes and in time, without padding. A stroke has one *row* for each drawing of its life, drawings
``first .. last`` without a gap (a stroke that is hidden for a while keeps its rows, with an empty visible interval).
Rows are sorted by stroke, then drawing; the control points of a row lie together, as do its joints.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike, NDArray

from videovec.errors import FitError

__all__ = ["Layout", "Strokes"]

Floats = NDArray[np.float64]
Ints = NDArray[np.intp]


def _starts(counts: Ints) -> Ints:
    """Where each of several runs begins, and where the last one ends."""
    return np.concatenate([[0], np.cumsum(counts)]).astype(np.intp)


@dataclass(frozen=True, eq=False)
class Layout:
    """Where things lie: S strokes, R rows (stroke, drawing), P control points, J joints, G segments.

    A stroke of n segments has 3n+1 control points and n+1 joints in each of its rows; a closed one repeats its first
    control point as its last.

    Args:
        segments: Number of segments of each stroke, at least one. int [S]
        first: First drawing of each stroke's life. int [S]
        last: Last drawing of each stroke's life, inclusive. int [S]
    """

    segments: Ints
    first: Ints
    last: Ints

    @cached_property
    def stroke_rows(self) -> Ints:
        """Row at which each stroke begins, then R. int [S+1]"""
        return _starts(self.last - self.first + 1)

    @cached_property
    def row_stroke(self) -> Ints:
        """Stroke of each row. int [R]"""
        return np.repeat(np.arange(len(self.segments)), self.last - self.first + 1)

    @cached_property
    def row_drawing(self) -> Ints:
        """Drawing of each row. int [R]"""
        stroke = self.row_stroke
        return self.first[stroke] + np.arange(len(stroke)) - self.stroke_rows[stroke]

    @cached_property
    def row_points(self) -> Ints:
        """Control point at which each row begins, then P. int [R+1]"""
        return _starts(3 * self.segments[self.row_stroke] + 1)

    @cached_property
    def row_joints(self) -> Ints:
        """Joint at which each row begins, then J. int [R+1]"""
        return _starts(self.segments[self.row_stroke] + 1)

    @cached_property
    def row_segments(self) -> Ints:
        """Segment at which each row begins, then G. int [R+1]"""
        return _starts(self.segments[self.row_stroke])

    @cached_property
    def segment_row(self) -> Ints:
        """Row of each segment. int [G]"""
        return np.repeat(np.arange(len(self.row_stroke)), self.segments[self.row_stroke])

    @cached_property
    def segment_points(self) -> Ints:
        """The four control points of each segment. int [G, 4]"""
        row = self.segment_row
        k = np.arange(len(row)) - self.row_segments[row]
        return (self.row_points[row] + 3 * k)[:, None] + np.arange(4)

    @cached_property
    def segment_joints(self) -> Ints:
        """The two joints of each segment. int [G, 2]"""
        row = self.segment_row
        k = np.arange(len(row)) - self.row_segments[row]
        return (self.row_joints[row] + k)[:, None] + np.arange(2)

    @cached_property
    def point_row(self) -> Ints:
        """Row of each control point. int [P]"""
        return np.repeat(np.arange(len(self.row_stroke)), np.diff(self.row_points))

    @cached_property
    def joint_row(self) -> Ints:
        """Row of each joint. int [J]"""
        return np.repeat(np.arange(len(self.row_stroke)), np.diff(self.row_joints))


@dataclass(frozen=True, slots=True, eq=False)
class Strokes:
    """S strokes with one identity and one topology each, over the drawings of their lives.

    Args:
        ids: Identity of each stroke, unique, from 1. int [S]
        layout: Segments and life of each stroke.
        is_closed: Whether each stroke ends where it begins. bool [S]
        layer: Compositing order; the higher lies above. int [S]
        color: Ink, sRGB in [0, 1]. [S, 3]
        points: Control points, row by row. [P, 2] px
        half_width: Centre line to edge at every joint, row by row; linear in t between joints. [J] px
        opacity: Plateau coverage. [R] in [0, 1]
        visible: The part of the arc that is seen, as arc fractions; (0, 1) is all, equal ends are none. [R, 2]
        parent: For a stroke that is the part of another beyond a gap in it, that other's identity, else 0. It has the
            other's control points and lives within its life. int [S]

    Raises:
        FitError: The shapes do not agree.
    """

    ids: Ints
    layout: Layout
    is_closed: NDArray[np.bool_]
    layer: Ints
    color: Floats
    points: Floats
    half_width: Floats
    opacity: Floats
    visible: Floats
    parent: Ints = field(default_factory=lambda: np.zeros(0, np.intp))

    def __post_init__(self) -> None:
        if not len(self.parent):  # whoever does not tell knows of no gaps
            object.__setattr__(self, "parent", np.zeros(len(self.ids), np.intp))
        count, rows = len(self.layout.segments), len(self.layout.row_stroke)
        expected = {
            "ids": (count,),
            "is_closed": (count,),
            "layer": (count,),
            "color": (count, 3),
            "points": (int(self.layout.row_points[-1]), 2),
            "half_width": (int(self.layout.row_joints[-1]),),
            "opacity": (rows,),
            "visible": (rows, 2),
            "parent": (count,),
        }
        for name, shape in expected.items():
            if getattr(self, name).shape != shape:
                raise FitError(f"strokes.{name} must be {shape}, got {getattr(self, name).shape}")

    def __len__(self) -> int:
        """S."""
        return len(self.ids)

    @property
    def row_count(self) -> int:
        """R, the number of (stroke, drawing) pairs."""
        return len(self.layout.row_stroke)

    def row(self, stroke: int, drawing: int) -> int:
        """The row of a stroke (its position, not its id) at a drawing of its life."""
        first, last = int(self.layout.first[stroke]), int(self.layout.last[stroke])
        if not first <= drawing <= last:
            raise FitError(f"stroke {stroke} lives in drawings {first}..{last}, asked for {drawing}")
        return int(self.layout.stroke_rows[stroke]) + drawing - first

    def points_of(self, row: int) -> Floats:
        """Control points of a row. [3n+1, 2] px"""
        return self.points[self.layout.row_points[row] : self.layout.row_points[row + 1]]

    def half_width_of(self, row: int) -> Floats:
        """Half-width at the joints of a row. [n+1] px"""
        return self.half_width[self.layout.row_joints[row] : self.layout.row_joints[row + 1]]

    def segments(self) -> Floats:
        """Control points of every segment, row by row. [G, 4, 2] px"""
        return self.points[self.layout.segment_points]

    def rows_at(self, drawing: int) -> Ints:
        """Rows of all strokes alive at a drawing, in layer order. int [R_d]"""
        rows = np.flatnonzero(self.layout.row_drawing == drawing)
        return rows[np.argsort(self.layer[self.layout.row_stroke[rows]], kind="stable")]

    def select(self, which: ArrayLike) -> Strokes:
        """Some of the strokes, by position or mask, in the order given."""
        strokes = np.arange(len(self))[np.asarray(which)]
        rows = _ranges(self.layout.stroke_rows, strokes)
        return Strokes(
            ids=self.ids[strokes],
            layout=Layout(self.layout.segments[strokes], self.layout.first[strokes], self.layout.last[strokes]),
            is_closed=self.is_closed[strokes],
            layer=self.layer[strokes],
            color=self.color[strokes],
            parent=self.parent[strokes],
            **self._of_rows(rows),
        )

    def at_drawing(self, drawing: int, as_drawing: int | None = None) -> Strokes:
        """The strokes alive at one drawing, as strokes of that drawing alone (or renumbered ``as_drawing``)."""
        rows = np.sort(np.flatnonzero(self.layout.row_drawing == drawing))
        strokes = self.layout.row_stroke[rows]
        at = np.full(len(strokes), drawing if as_drawing is None else as_drawing, dtype=np.intp)
        return Strokes(
            ids=self.ids[strokes],
            layout=Layout(self.layout.segments[strokes], at, at),
            is_closed=self.is_closed[strokes],
            layer=self.layer[strokes],
            color=self.color[strokes],
            parent=self.parent[strokes],
            **self._of_rows(rows),
        )

    def with_lives(self, first: Ints, last: Ints) -> Strokes:
        """The same strokes with lives cut short to first .. last, which must lie inside their present ones."""
        if np.any(first < self.layout.first) or np.any(last > self.layout.last) or np.any(first > last):
            raise FitError("a life can only be cut short, and to no less than one drawing")
        before = np.repeat(first, self.layout.last - self.layout.first + 1)
        after = np.repeat(last, self.layout.last - self.layout.first + 1)
        rows = np.flatnonzero((self.layout.row_drawing >= before) & (self.layout.row_drawing <= after))
        return Strokes(
            ids=self.ids,
            layout=Layout(self.layout.segments, first, last),
            is_closed=self.is_closed,
            layer=self.layer,
            color=self.color,
            parent=self.parent,
            **self._of_rows(rows),
        )

    def within(self, first: int, last: int) -> Strokes:
        """The strokes alive in drawings ``first .. last``, with lives cut to them."""
        alive = (self.layout.first <= last) & (self.layout.last >= first)
        part = self.select(alive)
        return part.with_lives(np.maximum(part.layout.first, first), np.minimum(part.layout.last, last))

    def shifted(self, drawings: int) -> Strokes:
        """The same strokes that many drawings later."""
        layout = self.layout
        return replace(self, layout=Layout(layout.segments, layout.first + drawings, layout.last + drawings))

    def with_rows_of(self, part: Strokes) -> Strokes:
        """The same strokes with the rows of ``part``, whose strokes are some of these over parts of their lives."""
        order = np.argsort(self.ids)
        stroke = order[np.searchsorted(self.ids, part.ids, sorter=order)]
        here = part.layout.row_stroke
        rows = (
            self.layout.stroke_rows[stroke][here] + part.layout.row_drawing - self.layout.first[stroke][here]
        ).astype(np.intp)
        points, half_width, opacity, visible = (
            x.copy() for x in (self.points, self.half_width, self.opacity, self.visible)
        )
        points[_ranges(self.layout.row_points, rows)] = part.points
        half_width[_ranges(self.layout.row_joints, rows)] = part.half_width
        opacity[rows], visible[rows] = part.opacity, part.visible
        return replace(self, points=points, half_width=half_width, opacity=opacity, visible=visible)

    def _of_rows(self, rows: Ints) -> dict[str, Floats]:
        return {
            "points": self.points[_ranges(self.layout.row_points, rows)],
            "half_width": self.half_width[_ranges(self.layout.row_joints, rows)],
            "opacity": self.opacity[rows],
            "visible": self.visible[rows],
        }

    @staticmethod
    def concatenate(parts: list[Strokes]) -> Strokes:
        """Strokes of several parts, one after the other; ids must not clash."""
        if not parts:
            return Strokes.empty()
        layouts = [part.layout for part in parts]
        merged = Strokes(
            layout=Layout(
                *(np.concatenate([getattr(x, name) for x in layouts]) for name in ("segments", "first", "last"))
            ),
            **{
                name: np.concatenate([getattr(part, name) for part in parts])
                for name in (
                    *("ids", "is_closed", "layer", "color", "parent"),
                    *("points", "half_width", "opacity", "visible"),
                )
            },
        )
        if len(np.unique(merged.ids)) != len(merged):
            raise FitError("stroke ids must be unique")
        return merged

    @staticmethod
    def empty() -> Strokes:
        """No strokes."""
        return Strokes.from_curves([], [])

    @staticmethod
    def from_curves(
        curves: list[Floats],
        half_widths: list[Floats],
        *,
        is_closed: ArrayLike | None = None,
        color: ArrayLike = (0.0, 0.0, 0.0),
        drawing: int = 0,
        first_id: int = 1,
    ) -> Strokes:
        """Strokes of one drawing, one for each curve.

        Args:
            curves: Control points of each stroke. [3n+1, 2] px
            half_widths: Half-width at the joints of each stroke. [n+1] px
            is_closed: Whether each stroke is closed; none is unless told. bool [S]
            color: One ink for all, or one each. [3] or [S, 3]
            drawing: The drawing that they belong to.
            first_id: Identity of the first; the others follow.

        Returns:
            Opaque, fully visible strokes, layered in their order.
        """
        count = len(curves)
        at = np.full(count, drawing, dtype=np.intp)
        return Strokes(
            ids=np.arange(first_id, first_id + count),
            layout=Layout(np.array([(len(c) - 1) // 3 for c in curves], dtype=np.intp), at, at),
            is_closed=np.zeros(count, bool) if is_closed is None else np.asarray(is_closed, bool),
            layer=np.arange(count),
            color=np.broadcast_to(np.asarray(color, float), (count, 3)).copy(),
            points=np.concatenate([np.zeros((0, 2)), *(np.asarray(c, float) for c in curves)]),
            half_width=np.concatenate([np.zeros(0), *(np.asarray(w, float) for w in half_widths)]),
            opacity=np.ones(count),
            visible=np.tile([0.0, 1.0], (count, 1)),
        )


def _ranges(starts: Ints, which: Ints) -> Ints:
    """All indices of the runs ``which``, run after run."""
    counts = starts[which + 1] - starts[which]
    offsets = np.repeat(starts[which] - _starts(counts)[:-1], counts)
    return (offsets + np.arange(len(offsets))).astype(np.intp)
