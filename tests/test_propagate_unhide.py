from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from test_propagate import draw, ink_of, line, strokes_of

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
