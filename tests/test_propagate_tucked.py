"""Strokes with a hidden end: what was never seen of them does not come out by sliding."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from numpy.typing import NDArray

from videovec.curves import sample_by_arc, sub_curve
from videovec.propagate.record import Life, Row
from videovec.propagate.tucked import hold_tucked

Floats = NDArray[np.float64]

HIDDEN = 0.8
"""Arc fraction at which the arm goes under the line."""
COUNT = 12


def _bent(drawing: int) -> Floats:
    """An arm of about 100 px whose bend differs from drawing to drawing. [7, 2] px"""
    t = np.linspace(0.0, 1.0, 7)
    return np.stack([20.0 + 100.0 * t, 60.0 + (10.0 + drawing) * np.sin(2.0 * t)], axis=1)


def _pulled_in(points: Floats, share: float) -> Floats:
    """The same curve with its last part, up to a share of its length, cut off."""
    return sub_curve(points, np.ones((len(points) - 1) // 3 + 1), 0.0, share)[0]


def _life(identity: int, rows: dict[int, Row]) -> Life:
    return Life(identity, False, identity, np.zeros(3), rows, home=0)


def _row(points: Floats, visible: tuple[float, float] = (0.0, 1.0)) -> Row:
    return Row(points, np.full((len(points) - 1) // 3 + 1, 1.5), 1.0, visible, 1.0)


def _wall(x: float) -> Row:
    return _row(np.stack([np.full(4, x), np.linspace(10.0, 120.0, 4)], axis=1))


def _scene(end: Callable[[int], float], wall: Callable[[int], float]) -> tuple[list[Life], list[Floats]]:
    """An arm of which less is kept on later drawings, behind a wall, and the whole arms.

    Args:
        end: Up to which share of its length the arm is kept on a drawing.
        wall: At which share of its length it goes under the wall.
    """
    whole = [_bent(d) for d in range(COUNT)]
    arms, walls = {}, {}
    for d, points in enumerate(whole):
        arms[d] = _row(_pulled_in(points, end(d)), (0.0, min(1.0, wall(d) / end(d))))
        walls[d] = _wall(float(sample_by_arc(points, 1001)[round(1000 * wall(d))][0]))
    return [_life(1, arms), _life(2, walls)], whole


def test_an_end_that_slid_up_to_the_line_that_hides_it_goes_back_under_it() -> None:
    lives, whole = _scene(lambda d: 1.0 - 0.012 * d, lambda _: HIDDEN)
    assert lives[0].rows[COUNT - 1].visible[1] > HIDDEN + 0.1
    hold_tucked(lives)
    for d, row in lives[0].rows.items():
        assert row.visible == pytest.approx((0.0, HIDDEN), abs=0.01)
        places = sample_by_arc(row.points, 101)[:81]
        assert np.linalg.norm(places - sample_by_arc(whole[d], 101)[:81], axis=1).max() < 1.0
        assert np.linalg.norm(row.points[-1] - whole[d][-1]) < 4.0


@pytest.mark.parametrize("pace", [0.02, 0.04])
def test_an_end_that_comes_out_from_under_a_line_stays_out(pace: float) -> None:
    lives, _ = _scene(lambda _: 1.0, lambda d: min(1.0, HIDDEN + pace * d))
    before = {d: row.visible for d, row in lives[0].rows.items()}
    wall = lives[1]
    for d in range(COUNT):
        if before[d][1] >= 1.0:  # the wall has gone on
            wall.rows[d] = _wall(150.0 + 3.0 * d)
    hold_tucked(lives)
    assert {d: row.visible for d, row in lives[0].rows.items()} == before


def test_strokes_that_were_seen_whole_are_left_alone() -> None:
    lives, _ = _scene(lambda _: 1.0, lambda _: HIDDEN)
    lives[0].rows[0] = _row(_bent(0))
    before = [row.points.copy() for row in lives[0].rows.values()]
    hold_tucked(lives)
    assert all(np.array_equal(a, row.points) for a, row in zip(before, lives[0].rows.values(), strict=True))
