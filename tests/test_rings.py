"""Closed lines that share stretches of ink are traced whole; rasters by supersampling, truth as it was drawn."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
from numpy.typing import NDArray
from test_initialise import circle, distance, ink, paint, straight

from videovec.curves import arc_length
from videovec.initialise import initialise
from videovec.settings import InitialiseSettings
from videovec.strokes import Strokes

Floats = NDArray[np.float64]
SETTINGS = InitialiseSettings()


def pill(x: float, y: float, length: float, radius: float) -> Floats:
    """A closed stroke: two straight sides of a length, the upper one from (x, y), and two half circles."""
    left, right = circle(x, y + radius, radius), circle(x + length, y + radius, radius)
    caps = np.concatenate([right[9:], right[1:4]]), left[3:10]
    sides = [straight(tuple(a[-1]), tuple(b[0])) for a, b in (caps, caps[::-1])]
    return np.concatenate([caps[0], sides[0][1:], caps[1][1:], sides[1][1:]])


def traced(curves: list[Floats], width: float, side: int) -> Strokes:
    return initialise(ink(paint(curves, width, (side, side))), 0, SETTINGS)


def assert_found(strokes: Strokes, truth: list[Floats], within: float) -> None:
    """Exactly the true strokes, each closed and near its own."""
    assert len(strokes) == len(truth)
    assert strokes.is_closed.all()
    for curve in truth:
        nearest = min(range(len(strokes)), key=lambda s: distance(strokes.points_of(s), curve))
        assert distance(strokes.points_of(nearest), curve) < within
        assert arc_length(strokes.points_of(nearest)) == pytest.approx(arc_length(curve), rel=0.03)


@pytest.mark.parametrize("width", [3.0, 6.0])
def test_pills_that_share_their_sides_are_traced_whole(width: float) -> None:
    stack = [pill(40, 20, 80, 15), pill(55, 50, 80, 15), pill(45, 80, 80, 15)]
    assert_found(traced(stack, width, 180), stack, 0.15 * width)


def test_a_circle_that_touches_a_line_of_pills_from_within_is_whole() -> None:
    drawn = [pill(30, 30, 90, 14), circle(110, 30 + 45, 45), pill(50, 58, 90, 14)]
    assert_found(traced(drawn, 5.0, 200), drawn, 1.0)


def test_two_rings_that_touch_and_cross_stay_two() -> None:
    drawn = [circle(60, 80, 40), circle(100, 80, 40)]
    assert_found(traced(drawn, 4.0, 170), drawn, 0.6)


def test_a_line_that_runs_into_a_ring_still_ends_there() -> None:
    strokes = traced([circle(90, 90, 40), straight((10, 90), (50, 90)), straight((90, 50), (90, 10))], 4.0, 170)
    assert sorted(strokes.is_closed.tolist()) == [False, False, True]


def test_a_square_is_no_ring_and_its_neighbour_shares_nothing() -> None:
    corners = [(20.0, 20.0), (80.0, 20.0), (80.0, 80.0), (20.0, 80.0), (20.0, 20.0)]
    sides = [straight(start, stop) for start, stop in pairwise(corners)]
    square = np.concatenate([sides[0], *(side[1:] for side in sides[1:])])
    strokes = traced([square, square + np.array([60.0, 0.0])], 4.0, 160)
    drawn = sum(arc_length(strokes.points_of(s)) for s in range(len(strokes)))
    assert drawn == pytest.approx(7 * 60, rel=0.03)  # the common side once
