"""Hinges: places of a stroke at which a part that keeps its direction meets one that turns; it is two strokes.

An arm that is drawn in one go with the trunk on the first drawing swings about the shoulder later on. What bends, what
swings on both sides of an elbow, and what changes by one affine map as a whole stays in one piece.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from videovec.curves import arc_length, evaluate, parameter_at, segments_of
from videovec.life_edits import cut_at, join_ends
from videovec.propagate.affine import affine_change
from videovec.stroke_life import StrokeLife
from videovec.strokes import Strokes

__all__ = ["cut_at_hinges"]

Floats = NDArray[np.float64]
Complexes = NDArray[np.complex128]

_STILL = 2.0
"""Degrees by which the part on one side of a hinge may turn."""
_TURNS, _ALONE = 12.0, 20.0
"""Degrees by which the part on its other side must turn; and if it is the stroke's only hinge."""
_RIGID = 0.1
"""Share of that by which the near half of a side may turn otherwise than its far half: what bends has no hinge."""
_LENGTH = 0.4
"""Share by which the length of either side may change: an edge that is foreshortened has no hinge at its corner."""
_SKIP, _REACH = 1.0, 3.0
"""Widths from the hinge from which on its sides are looked at, and over how many."""
_PART = 0.05
"""Length that is looked at on either side at least, as a share of the page's long edge."""
_STEP = 0.5
"""Widths between places that are tried."""
_FEWEST = 5
"""Drawings on which a stroke must be seen whole."""
_LEFT = 0.3
"""Share of the largest motion of a stroke of several hinges that must be no affine map of it, such as a skew."""
_SPREAD = 0.5
"""Spread of a stroke in a direction up to which its change of size there is not believed. px"""
_TOUCHING = 1.0
"""Gap over which the ends of a ring are one joint again. px"""


@dataclass(frozen=True, slots=True, eq=False)
class _Swing:
    """Samples of a stroke on T drawings on which it is seen whole.

    Args:
        points: Where they are. [T, n, 2] px
        place: Where they lie on the stroke, as segment plus parameter. [n]
        step: Distance of neighbours on the first of the drawings. px
        is_closed: Whether the last is a neighbour of the first.
    """

    points: Floats
    place: Floats
    step: float
    is_closed: bool


def cut_at_hinges(strokes: Strokes, confidence: Floats, long_edge: int) -> tuple[Strokes, Floats]:
    """Cut strokes where a part that keeps its direction meets one that turns.

    Args:
        strokes: S strokes over D drawings.
        confidence: Of every row. [R]
        long_edge: Of the page. px

    Returns:
        The strokes, of which the longest part of each keeps its identity, and the confidence of their rows.
    """
    free = int(strokes.ids.max(initial=0)) + 1
    has_gaps = (strokes.parent > 0) | np.isin(strokes.ids, strokes.parent)  # one cut would have to be that of its parts
    lives: list[tuple[StrokeLife, Floats]] = []
    for s in range(len(strokes)):
        sure = confidence[slice(*strokes.layout.stroke_rows[s : s + 2].tolist())]
        places = [] if has_gaps[s] else _hinges(strokes, s, _PART * long_edge)
        parts = sorted(_cut(StrokeLife.of(strokes, s), places), key=lambda part: -arc_length(part.points[0]))
        lives.append((parts[0], sure))
        lives += [(replace(part, id=free + k), sure) for k, part in enumerate(parts[1:])]
        free += len(parts) - 1
    if len(lives) == len(strokes):
        return strokes, confidence
    lives.sort(key=lambda entry: entry[0].id)
    return Strokes.concatenate([life.as_strokes() for life, _ in lives]), np.concatenate([sure for _, sure in lives])


def _cut(life: StrokeLife, places: list[float]) -> list[StrokeLife]:
    """The parts of a stroke between some places; a ring has one part for each."""
    was_closed, parts = life.is_closed, []
    for place in reversed(places):
        life, tail = cut_at(life, place, life.id)
        parts.append(tail)
    if was_closed and parts:
        return [join_ends(parts[0], life, _TOUCHING), *parts[1:]]
    return [life, *parts]


def _hinges(strokes: Strokes, stroke: int, shortest: float) -> list[float]:
    """Places of the hinges of a stroke, in their order; ``shortest`` is the least length of a side. px"""
    width = 2.0 * float(strokes.half_width_of(int(strokes.layout.stroke_rows[stroke])).mean())
    swing = _swing(strokes, stroke, _STEP * width)
    if swing is None:
        return []
    skip, reach = (round(length / swing.step) for length in (_SKIP * width, max(_REACH * width, shortest)))
    count = swing.points.shape[1]
    if count <= 2 * (skip + reach):
        return []
    found: dict[int, float] = {}
    for k in range(count) if swing.is_closed else range(skip + reach, count - skip - reach):
        side = np.array([skip, skip + reach // 2, skip + reach])
        before, after = (_changes(swing.points[:, (k + sign * side) % count]) for sign in (-1, 1))
        turn = max(_swing_at(before, after), _swing_at(after, before))
        if turn > 0:
            found[k] = turn
    places = [float(swing.place[k]) for k in _middles(sorted(found), reach) if swing.place[k] > 0]
    if len(places) == 1:  # any motion of two straight parts is an affine map
        return places if not swing.is_closed and max(found.values()) >= _ALONE else []
    return places if places and _is_jointed(swing.points) else []


def _swing(strokes: Strokes, stroke: int, step: float) -> _Swing | None:
    """The stroke at equal steps of the first drawing on which it is seen whole; nothing if it seldom is."""
    begin, end = strokes.layout.stroke_rows[stroke : stroke + 2].tolist()
    rows = [row for row in range(begin, end) if strokes.visible[row, 1] - strokes.visible[row, 0] > 0.99]
    if len(rows) < _FEWEST:
        return None
    first = strokes.points_of(rows[0])
    steps = max(2, round(arc_length(first) / step))
    segment, t = parameter_at(first, np.linspace(0.0, 1.0, steps + 1))
    if strokes.is_closed[stroke]:
        segment, t = segment[:-1], t[:-1]
    points = np.stack([evaluate(segments_of(strokes.points_of(row))[segment], t) for row in rows])
    return _Swing(points, segment + t, arc_length(first) / steps, bool(strokes.is_closed[stroke]))


def _is_jointed(points: Floats) -> bool:
    """Whether a stroke moves otherwise than by affine maps of the whole."""
    rest = points[0] - points[0].mean(axis=0)
    moved = points - points.mean(axis=1, keepdims=True) - rest
    far = moved[int(np.square(moved).sum(axis=(1, 2)).argmax())]
    left = far - rest @ affine_change(rest, far, _SPREAD)
    return bool(np.square(left).sum() >= _LEFT**2 * np.square(far).sum())


def _changes(places: Floats) -> Complexes:
    """How the near and the far half of a side have changed since the first drawing, in length and turn. [T, 2]"""
    halves = np.diff(places, axis=1) @ np.array([1.0, 1.0j])
    first = np.where(np.abs(halves[0]) > 0, halves[0], 1.0)
    return np.asarray(halves / first)


def _swing_at(still: Complexes, turning: Complexes) -> float:
    """By how many degrees one side turns while the other does not and both stay straight; 0 if they do otherwise."""
    both = np.stack([still, turning])
    if np.abs(both).max() > 1.0 + _LENGTH or np.abs(both).min() < 1.0 / (1.0 + _LENGTH):
        return 0.0
    degrees = np.degrees(np.angle(both))
    rests, swings = (float(np.ptp(side, axis=0).max()) for side in degrees)
    bends = float(np.abs(degrees[..., 0] - degrees[..., 1]).max())
    return swings if rests <= _STILL and swings >= _TURNS and bends <= _RIGID * swings else 0.0


def _middles(places: list[int], apart: int) -> list[int]:
    """The middle of each run of places."""
    if not places:
        return []
    runs = np.split(np.array(places, np.intp), np.flatnonzero(np.diff(places) > max(1, apart // 2)) + 1)
    return [int(run[len(run) // 2]) for run in runs]
