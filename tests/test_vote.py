from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from videovec.curves import evaluate, segments_of
from videovec.ink import Ink
from videovec.propagate import Propagated
from videovec.stroke_life import StrokeLife
from videovec.strokes import Strokes
from videovec.vote import vote

Floats = NDArray[np.float64]

DRAWINGS = 5
INK = Ink(
    np.zeros((DRAWINGS, 8, 8), np.uint8), np.zeros((DRAWINGS, 8, 8), np.uint8), np.zeros((1, 3)), np.ones(3), noise=0.0
)


def straight(*corners: tuple[float, float]) -> Floats:
    knots = np.array(corners, float)
    parts = [a + (b - a) * np.array([[1], [2], [3]]) / 3 for a, b in pairwise(knots)]
    return np.concatenate([knots[:1], *parts])


def moved(points: Floats, drawing: int) -> Floats:
    angle = 0.1 * drawing
    turn = np.array([[np.cos(angle), np.sin(angle)], [-np.sin(angle), np.cos(angle)]])
    return np.asarray(points @ turn + (2.0 * drawing, drawing))


def living(curves: list[Floats], drawings: int = DRAWINGS) -> Strokes:
    """Strokes that turn and move together."""
    lives = [
        StrokeLife(
            id=k + 1,
            first=0,
            points=np.stack([moved(curve, d) for d in range(drawings)]),
            half_width=np.full((drawings, (len(curve) + 2) // 3), 1.5),
            opacity=np.ones(drawings),
            visible=np.tile([0.0, 1.0], (drawings, 1)),
            color=np.zeros(3),
            layer=k,
            is_closed=False,
        )
        for k, curve in enumerate(curves)
    ]
    return Strokes.concatenate([life.as_strokes() for life in lives])


def carried(strokes: Strokes) -> Propagated:
    return Propagated(strokes, (), np.linspace(0.5, 1.0, strokes.row_count))


def tracing(curves_of: Callable[[int], list[Floats]]) -> Callable[[Ink, int], Strokes]:
    """A tracer that finds known curves on one drawing after the other, as `vote` asks for all of them in order."""
    order = iter(range(DRAWINGS))

    def trace(ink: Ink, drawing: int) -> Strokes:
        now = next(order)
        curves = [moved(curve, now) for curve in curves_of(now)]
        return Strokes.from_curves(curves, [np.full((len(c) + 2) // 3, 1.5) for c in curves])

    return trace


TRUE = [straight((10, 50), (50, 50), (90, 50)), straight((50, 50), (55, 90))]
WRONG = [straight((10, 50), (50, 50), (55, 90)), straight((50, 50), (90, 50))]


def distance(found: Floats, curve: Floats) -> float:
    """Largest distance of a found curve from a true one, and the other way round. px"""
    t = np.linspace(0, 1, 60)
    a, b = (evaluate(segments_of(p)[:, None], t[None]).reshape(-1, 2) for p in (found, curve))
    gaps = np.linalg.norm(a[:, None] - b, axis=2)
    return float(max(gaps.min(0).max(), gaps.min(1).max()))


def test_a_majority_of_the_drawings_cuts_and_joins_strokes_on_all_of_them() -> None:
    voted = vote(INK, carried(living(WRONG)), 0, tracing(lambda drawing: WRONG if drawing < 2 else TRUE))
    assert sorted(voted.strokes.ids.tolist()) == [1, 2]
    assert voted.strokes.layout.first.tolist() == [0, 0]
    assert voted.strokes.layout.last.tolist() == [4, 4]
    for drawing in range(DRAWINGS):
        found = [voted.strokes.points_of(voted.strokes.row(s, drawing)) for s in range(2)]
        for curve in TRUE:
            assert min(distance(points, moved(curve, drawing)) for points in found) < 0.8


def test_the_joined_stroke_is_no_surer_than_its_parts() -> None:
    voted = vote(INK, carried(living(WRONG)), 0, tracing(lambda _: TRUE))
    assert voted.confidence.shape == (voted.strokes.row_count,)
    assert np.all((voted.confidence >= 0.5) & (voted.confidence <= 1.0))


def test_a_minority_changes_nothing() -> None:
    before = carried(living(WRONG))
    assert vote(INK, before, 0, tracing(lambda drawing: WRONG if drawing < 3 else TRUE)) is before


def test_lines_that_come_apart_are_two_strokes() -> None:
    """On the first drawing two lines meet end to end; on the others there is a gap."""
    joined = [straight((10, 50), (50, 50), (90, 50)), straight((50, 50), (52, 90))]
    parted = [straight((10, 50), (50, 50)), straight((50, 50), (90, 50)), straight((50, 50), (52, 90))]
    voted = vote(INK, carried(living(joined)), 0, tracing(lambda drawing: parted if drawing else joined))
    assert len(voted.strokes) == 3
    lengths = sorted(float(np.ptp(voted.strokes.points_of(voted.strokes.row(s, 0))[:, 0])) for s in range(3))
    np.testing.assert_allclose(lengths, [2, 40, 40], atol=1.5)


def test_strokes_of_another_life_and_closed_ones_stay_as_they_are() -> None:
    strokes = living([*WRONG, straight((20, 20), (30, 30), (20, 30), (20, 20)), straight((60, 10), (80, 10))])
    closed = replace(strokes, is_closed=np.array([False, False, True, False]))
    short = closed.with_lives(np.zeros(4, np.intp), np.array([4, 4, 4, 2]))
    voted = vote(INK, carried(short), 0, tracing(lambda _: [*TRUE, straight((60, 10), (80, 10))])).strokes
    assert len(voted) == 4
    for identity in (3, 4):
        a, b = int(np.flatnonzero(voted.ids == identity)[0]), identity - 1
        assert voted.layout.last[a] == short.layout.last[b]
        np.testing.assert_array_equal(voted.points_of(voted.row(a, 1)), short.points_of(short.row(b, 1)))


def test_a_clip_of_two_drawings_has_no_majority() -> None:
    before = carried(living(WRONG, drawings=2))
    assert vote(INK, before, 0, tracing(lambda _: TRUE)) is before
