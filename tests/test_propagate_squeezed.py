"""Closed strokes that shut onto a line and open again stay one stroke; what is hidden in part is not squeezed."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from numpy.typing import NDArray
from test_propagate import arc, draw, ink_of, line, run, strokes_of

from samples.scene import polygon
from videovec.curves import sample_by_arc
from videovec.propagate import Propagated
from videovec.propagate.squeezed import is_narrow, opened
from videovec.strokes import Strokes

Floats = NDArray[np.float64]

NOSE, BROW = line(80, 70, 84, 110), line(36, 30, 66, 36)
ANGLES = np.linspace(0, 2 * np.pi, 24, endpoint=False)


def eye(x: float, y: float, wide: float, high: float, turn: float = 0.0) -> Floats:
    """An ellipse of control points, turned by an angle in degrees. [13, 2]"""
    curve = np.concatenate([arc(0, 0, 1, k, k + 90)[k > 0 :] for k in (0, 90, 180, 270)])
    cos, sin = np.cos(np.radians(turn)), np.sin(np.radians(turn))
    return np.asarray((curve * (wide, high)) @ np.array([[cos, sin], [-sin, cos]]) + (x, y))


def given(curves: list[Floats], closed: int) -> Strokes:
    """Strokes of the first drawing, of which the first ones are closed."""
    strokes = strokes_of(curves)
    return replace(strokes, is_closed=np.arange(len(curves)) < closed)


def gaps(result: Propagated, identity: int, drawing: int, curve: Floats) -> tuple[float, float]:
    """How far a true stroke is at most from what is seen of a found one, and that from it. px"""
    row = result.strokes.row(identity - 1, drawing)
    places, (begin, end) = sample_by_arc(result.strokes.points_of(row), 401), result.strokes.visible[row]
    seen = places[round(400 * begin) : round(400 * end) + 1]
    apart = np.linalg.norm(sample_by_arc(curve, 200)[:, None] - seen, axis=2)
    return float(apart.min(1).max()), float(apart.min(0).max())


@pytest.mark.parametrize(
    ("shares", "turn"), [((1.0, 0.4, 0.0, 0.5, 1.0), 0.0), ((1.0, 0.0, 0.0, 1.0), 25.0), ((1.0, 0.0, 0.3, 0.8), 0.0)]
)
def test_an_eye_that_blinks_is_one_stroke_that_is_seen_whole(shares: tuple[float, ...], turn: float) -> None:
    eyes = [eye(50 + d, 60, 11, max(0.3, 14 * share), turn) for d, share in enumerate(shares)]
    result = run(ink_of([draw([curve, NOSE, BROW]) for curve in eyes]), given([eyes[0], NOSE, BROW], 1))
    assert len(result.strokes) == 3
    assert result.events == ()
    for drawing, curve in enumerate(eyes):
        assert max(gaps(result, 1, drawing, curve)) < 1.6


def test_a_door_that_shuts_along_its_long_side_keeps_its_corners() -> None:
    def door(share: float) -> Floats:
        x, y = 24 * max(share, 0.02), 36.0
        corners = np.array([(-x, -y), (x, -y), (x, y), (-x, y), (-x, -y)]) + 70
        return np.concatenate([line(*a, *b)[k > 0 :] for k, (a, b) in enumerate(pairwise(corners))])

    doors = [door(share) for share in (1.0, 0.6, 0.0, 0.4, 1.0)]
    sill = line(20, 130, 140, 132)
    result = run(ink_of([draw([curve, sill]) for curve in doors]), given([doors[0], sill], 1))
    assert len(result.strokes) == 2
    assert max(gaps(result, 1, 4, doors[4])) < 1.6
    joints = result.strokes.points_of(result.strokes.row(0, 4))[::3]
    assert np.linalg.norm(joints - doors[0][::3], axis=1).max() < 4.0


def test_a_ring_of_which_a_card_hides_half_is_not_squeezed() -> None:
    ring = eye(60, 60, 16, 16)
    drawings = [draw([ring, NOSE]), draw([ring, NOSE], cover=(40, 62, 76, 80)), draw([ring, NOSE])]
    result = run(ink_of(drawings), given([ring, NOSE], 1))
    half = result.strokes.points_of(result.strokes.row(0, 1))
    assert np.ptp(half[:, 1]) > 28
    assert max(gaps(result, 1, 2, ring)) < 1.0


def test_the_open_shape_turns_and_moves_with_a_shape_that_is_squeezed() -> None:
    ring = np.stack([20 * np.cos(ANGLES), 30 * np.sin(ANGLES)], axis=1)
    turn = np.array([[np.cos(0.3), np.sin(0.3)], [-np.sin(0.3), np.cos(0.3)]])
    for share in (0.5, 0.02):
        np.testing.assert_allclose(opened(ring, (ring * (share, 1)) @ turn + (7, 3)), ring @ turn + (7, 3), atol=1e-9)
    still_open = (ring * (0.9, 1)) @ turn
    assert opened(ring, still_open) is still_open


def test_a_stick_is_not_squeezed() -> None:
    """A closed outline ten times as long as wide; five times as wide it could shut."""
    ends = np.array([(-40.0, -4.0), (40.0, -4.0), (40.0, 4.0), (-40.0, 4.0), (-40.0, -4.0)])
    stick = sample_by_arc(polygon(ends + 100.0), 120)[:-1]
    assert is_narrow(stick)
    assert not is_narrow(stick * [1.0, 5.0])
