"""Drawings that are far apart: new lines are not where they were one drawing ago."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray
from test_propagate import FIGURE, draw, ink_of, line, run, strokes_of, turned

from samples.scene import polygon
from videovec.settings import PropagateSettings

Floats = NDArray[np.float64]


def test_a_short_new_line_is_one_stroke_where_all_moves_far() -> None:
    moved = [turned(FIGURE, 0, (22.0 * (t - 1), 0.0)) for t in range(4)]
    new = [line(20 + 22 * t, 125, 22 + 22 * t, 140) for t in range(4)]
    drawings = [draw([*moved[t], *[new[t]] * (t in (1, 2))]) for t in range(4)]
    result = run(ink_of(drawings), strokes_of(moved[0])).strokes
    assert len(result) == 5
    found = int(np.flatnonzero(result.layout.first > 0)[0])
    assert result.layout.first[found] == 1
    for drawing in (1, 2):
        ends = result.points_of(result.row(found, drawing))[[0, -1]]
        assert np.abs(ends[np.argsort(ends[:, 1])] - new[drawing][[0, -1]]).max() < 2.0


@pytest.mark.parametrize(("down", "high", "half"), [(14.0, 7.0, 10.0), (20.0, 8.0, 8.0)])
def test_a_bend_that_only_the_refinement_reaches_is_seen(down: float, high: float, half: float) -> None:
    """Two lines move down together, and one of them gets a bend on the way."""
    before, after = (
        [line(20, 130 + y, 140, 130 + y), bent_line(60 + y, bend, half)] for y, bend in ((0.0, 0.0), (down, high))
    )
    drawings = [draw(curves) for curves in (before, after, after)]
    result = run(ink_of(drawings), strokes_of(before), PropagateSettings()).strokes
    assert len(result) == 2
    assert (result.visible == (0.0, 1.0)).all()


def bent_line(y: float, high: float, half: float) -> Floats:
    """A level line with a bend of a height and half a width in its middle. [N, 2]"""
    return polygon([(15, y), (40, y), (75 - half, y), (75, y - high), (75 + half, y), (110, y), (140, y)])
