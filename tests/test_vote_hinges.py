"""Hinges: a limb that swings about a body which keeps its direction is a stroke of its own."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray
from test_vote import distance, straight

from videovec.curves import arc_length
from videovec.stroke_life import StrokeLife
from videovec.strokes import Strokes
from videovec.vote.hinges import cut_at_hinges

Floats = NDArray[np.float64]

ANGLES = np.radians([0.0, 5.0, 15.0, 25.0, 15.0, 0.0])
BODY = [(60.0, 160.0), (60.0, 100.0)]


def after(point: tuple[float, float], length: float, angle: float) -> tuple[float, float]:
    return (point[0] + length * float(np.cos(angle)), point[1] + length * float(np.sin(angle)))


def living(drawings: list[Floats], *, is_closed: bool = False) -> Strokes:
    count = len(drawings)
    life = StrokeLife(
        id=3,
        first=0,
        points=np.stack(drawings),
        half_width=np.full((count, (len(drawings[0]) + 2) // 3), 1.5),
        opacity=np.ones(count),
        visible=np.tile([0.0, 1.0], (count, 1)),
        color=np.zeros(3),
        layer=0,
        is_closed=is_closed,
    )
    return life.as_strokes()


def cut(strokes: Strokes) -> Strokes:
    made, confidence = cut_at_hinges(strokes, np.ones(strokes.row_count), 200)
    assert len(confidence) == made.row_count
    return made


def arm(angle: float) -> Floats:
    """A body and an arm in one line."""
    return straight(*BODY, after(BODY[1], 70.0, angle))


def test_an_arm_that_swings_about_a_body_is_a_stroke_of_its_own() -> None:
    strokes = cut(living([arm(angle) for angle in ANGLES]))
    assert len(strokes) == 2
    assert strokes.ids.tolist() == [3, 4]
    for d, angle in enumerate(ANGLES):
        limb, body = (strokes.points_of(strokes.row(s, d)) for s in (0, 1))
        assert distance(limb, straight(BODY[1], after(BODY[1], 70.0, angle))) < 4.0
        assert distance(body, straight(*BODY)) < 4.0


def test_a_swing_of_the_whole_and_small_swings_are_none() -> None:
    turns = [np.array([[np.cos(a), np.sin(a)], [-np.sin(a), np.cos(a)]]) for a in ANGLES]
    assert len(cut(living([arm(0.0) @ turn for turn in turns]))) == 1
    assert len(cut(living([arm(0.3 * angle) for angle in ANGLES]))) == 1


def test_what_is_skewed_as_a_whole_keeps_its_corners() -> None:
    corners = np.array([(60, 40), (120, 40), (120, 160), (60, 160), (60, 40)], float)
    skews = [np.array([[1.0, 0.0], [np.tan(angle), 1.0]]) for angle in ANGLES]
    assert len(cut(living([straight(*map(tuple, corners @ skew)) for skew in skews], is_closed=True))) == 1


def test_an_elbow_between_two_parts_that_swing_is_no_hinge() -> None:
    def limb(angle: float) -> Floats:
        elbow = after((20.0, 100.0), 60.0, angle)
        return straight((20.0, 100.0), elbow, after(elbow, 60.0, -2.0 * angle))

    assert len(cut(living([limb(angle) for angle in ANGLES]))) == 1


def test_a_tail_that_bends_is_one_stroke() -> None:
    def tail(bend: float) -> Floats:
        heading = bend * np.linspace(0.0, 3.0, 40)
        places = np.cumsum(4.0 * np.stack([np.cos(heading), np.sin(heading)], axis=1), axis=0)
        return straight(*((20.0 + x, 100.0 + y) for x, y in places.tolist()))

    assert len(cut(living([tail(angle) for angle in ANGLES]))) == 1


@pytest.mark.parametrize("is_seen", [True, False])
def test_a_ring_is_cut_at_two_hinges_and_its_seam_is_whole(is_seen: bool) -> None:
    def figure(angle: float) -> Floats:
        tip = after((90.0, 60.0), 60.0, -angle)
        return straight((60.0, 160.0), (90.0, 160.0), (90.0, 72.0), tip, (90.0, 60.0), (60.0, 60.0), (60.0, 160.0))

    strokes = living([figure(angle) for angle in ANGLES], is_closed=True)
    if not is_seen:
        strokes = replace(strokes, visible=np.tile([0.0, 0.5], (len(ANGLES), 1)))
    made = cut(strokes)
    assert len(made) == (2 if is_seen else 1)
    assert bool(made.is_closed.any()) is not is_seen
    for d, angle in enumerate(ANGLES):
        lengths = [arc_length(made.points_of(made.row(s, d))) for s in range(len(made))]
        assert sum(lengths) == pytest.approx(arc_length(figure(angle)), rel=1e-3)


def test_a_card_that_is_foreshortened_keeps_its_corners() -> None:
    def card(angle: float) -> Floats:
        x, away = 60 * np.cos(4.0 * angle), 18 * np.sin(4.0 * angle)
        return straight((60, 40), (60 + x, 40 - away), (60 + x, 160 + away), (60, 160), (60, 40))

    assert len(cut(living([card(angle) for angle in np.radians(np.linspace(0, 20, 6))], is_closed=True))) == 1
