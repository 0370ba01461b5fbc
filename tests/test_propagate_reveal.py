"""Strokes behind others: what is seen of them is the ink that no other explains, and hidden parts find theirs again."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray
from test_propagate import SIZE, draw, ink_of, line, strokes_of
from test_propagate_front import LYING, POST, nodes_of

from videovec.propagate.placing import emerging
from videovec.propagate.record import Life, open_lives
from videovec.propagate.reveal import reveal
from videovec.propagate.support import Inks, Support
from videovec.propagate.target import make_target

Floats = NDArray[np.float64]

HALF_WIDTH = np.array([1.5, 1.5])


def lives_of(curve: Floats, seen: tuple[float, float], covers: bool = True) -> tuple[Life, Life]:
    """A stroke and the post that may have hidden others; what is seen of the stroke is said to be this much."""
    stroke, post = open_lives(strokes_of([curve, POST]))
    stroke.rows[0] = replace(stroke.rows[0], visible=seen)
    return stroke, replace(post, covers=covers)


@pytest.mark.parametrize("said", [(0.0, 0.2), (0.3, 0.9), (0.0, 0.0), (0.0, 1.0)])
@pytest.mark.parametrize("until", [100.0, 70.0])
def test_a_stroke_is_seen_to_the_middle_of_what_covers_it_or_to_the_end_of_its_ink(
    said: tuple[float, float], until: float
) -> None:
    stroke, post = lives_of(LYING, said)
    stroke.rows[1] = replace(stroke.rows[0], visible=(0.0, 1.0))
    drawing = draw([line(20, 80, until, 80), POST])
    reveal([stroke, post], ink_of([drawing]))
    begin, end = stroke.rows[0].visible
    assert begin == pytest.approx(0.0, abs=0.02)
    assert end == pytest.approx((until - 20) / 120, abs=0.025)


def test_what_lies_on_ink_of_others_alone_is_not_seen() -> None:
    beside = line(100.5, 40, 100.5, 120)
    stroke, post = lives_of(beside, (0.0, 0.5))
    stroke.rows[1] = replace(stroke.rows[0], visible=(0.0, 1.0))
    reveal([stroke, post], ink_of([draw([POST])]))
    assert stroke.rows[0].parts == ()


def test_without_a_stroke_that_hides_others_nothing_is_measured_again() -> None:
    stroke, post = lives_of(LYING, (0.0, 0.2), covers=False)
    reveal([stroke, post], ink_of([draw([LYING, POST])]))
    assert stroke.rows[0].visible == (0.0, 0.2)


@pytest.mark.parametrize(
    ("ink", "is_found"),
    [(line(20, 86, 140, 86), True), (line(20, 104, 140, 104), False), (line(60, 70, 60, 95), False)],
)
def test_a_hidden_stroke_is_looked_for_in_ink_around_it_that_goes_its_way(ink: Floats, is_found: bool) -> None:
    nodes, positions = nodes_of([LYING, POST])
    shown = nodes.stroke == 1
    support = Support(shown, shown, ((), ((0.0, 1.0),)), np.array([0.0, 1.0]), shown)
    inks = Inks(target := make_target(draw([ink, POST]), SIZE), target, np.array([False, True]))
    found = emerging(nodes, positions, HALF_WIDTH, support, inks)
    if not is_found:
        assert found is None
    else:
        assert found is not None
        assert found.follows()[nodes.stroke == 0].mean() > 0.8


def test_nothing_is_looked_for_where_all_ink_has_strokes() -> None:
    nodes, positions = nodes_of([LYING, POST])
    shown = nodes.stroke == 1
    support = Support(shown, shown, ((), ((0.0, 1.0),)), np.array([0.0, 1.0]), shown)
    target = make_target(draw([POST]), SIZE)
    assert emerging(nodes, positions, HALF_WIDTH, support, Inks(target, target, np.array([False, True]))) is None
