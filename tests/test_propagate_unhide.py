from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from test_propagate import WIDTH, draw, ink_of, line, run, strokes_of

from samples.scene import ellipse
from videovec.curves import arc_length
from videovec.propagate.unhide import unhide
from videovec.strokes import Layout, Strokes


def hidden_in_the_middle() -> Strokes:
    """A still stroke over three drawings that counts as hidden in the second."""
    one = strokes_of([line(20, 80, 120, 80)])
    return Strokes(
        ids=one.ids,
        layout=Layout(np.array([1]), np.array([0]), np.array([2])),
        is_closed=one.is_closed,
        layer=one.layer,
        color=one.color,
        points=np.tile(one.points, (3, 1)),
        half_width=np.tile(one.half_width, 3),
        opacity=np.ones(3),
        visible=np.array([[0.0, 1.0], [0.0, 0.0], [0.0, 1.0]]),
    )


@pytest.mark.parametrize(
    ("ends", "is_seen"),
    [((20, 80, 120, 80), True), ((10, 80, 140, 80), True), ((20, 80, 90, 80), False), ((70, 20, 70, 140), False)],
)
def test_only_a_stroke_that_lies_on_ink_from_end_to_end_is_seen_again(ends: tuple[float, ...], is_seen: bool) -> None:
    own, other = draw([line(20, 80, 120, 80)]), draw([line(*ends)])
    strokes = unhide(hidden_in_the_middle(), ink_of([own, other, own]))
    assert bool(strokes.visible[1, 1] > strokes.visible[1, 0]) is is_seen
    np.testing.assert_array_equal(strokes.visible[[0, 2]], [[0, 1], [0, 1]])


def test_a_stroke_that_is_never_seen_stays_hidden() -> None:
    strokes = replace(hidden_in_the_middle(), visible=np.zeros((3, 2)))
    drawing = draw([line(20, 80, 120, 80)])
    assert not unhide(strokes, ink_of([drawing] * 3)).visible.any()


@pytest.mark.parametrize("speed", [1.5, 3.0])
def test_a_short_stroke_that_a_line_moves_away_from_stays_seen(speed: float) -> None:
    drawings = []
    for d in range(9):
        x = 55 + speed * d
        drawings.append([line(30, 20, 30, 80), ellipse((45, 50), (5, 5)), line(50, 50, 55, 50), line(x, 20, x, 80)])
    widths = [np.full((len(curve) + 2) // 3, WIDTH / 2) for curve in drawings[0]]
    first = Strokes.from_curves(drawings[0], widths, is_closed=[False, True, False, False])
    strokes = run(ink_of([draw(curves) for curves in drawings]), first).strokes
    short = int(np.flatnonzero(strokes.ids == 3)[0])
    rows = [strokes.row(short, d) for d in range(9)]
    assert (strokes.visible[rows, 1] > strokes.visible[rows, 0]).all()
    assert max(arc_length(strokes.points_of(row)) for row in rows) < 10  # it does not go along with the line
