"""Drawings that are far apart: new lines are not where they were one drawing ago."""

from __future__ import annotations

import numpy as np
from test_propagate import FIGURE, draw, ink_of, line, run, strokes_of, turned

from samples.scene import polygon
from videovec.settings import PropagateSettings


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


def test_a_bend_that_only_the_refinement_reaches_is_seen() -> None:
    rail = line(20, 140, 140, 140)
    flat, bent = (polygon([(15, y), (40, y), (67, y), (75, y - high), (83, y), (110, y), (140, y)])
                  for y, high in ((60, 0), (74, 8)))  # fmt: skip
    drawings = [draw([rail, curve]) for curve in (flat, bent, bent)]
    result = run(ink_of(drawings), strokes_of([rail, flat]), PropagateSettings()).strokes
    assert len(result) == 2
    assert (result.visible == (0.0, 1.0)).all()
