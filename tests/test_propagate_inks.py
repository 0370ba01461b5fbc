from __future__ import annotations

from dataclasses import replace
from functools import partial

import numpy as np
from numpy.typing import NDArray
from test_propagate import FAST, FIGURE, arc, draw, ink_of, kinds, line, strokes_of, turned

from videovec.events import EventKind
from videovec.initialise import initialise
from videovec.ink import Ink
from videovec.propagate import propagate
from videovec.settings import InitialiseSettings
from videovec.strokes import Strokes

RED, BLUE = np.array([0.9, 0.1, 0.1]), np.array([0.1, 0.1, 0.9])


def two_inks(red: list[NDArray[np.uint8]], blue: list[NDArray[np.uint8]]) -> Ink:
    """Red ink above blue ink."""
    over, under = np.stack(red), np.stack(blue)
    label = np.where(over > 0, 0, 1).astype(np.uint8)
    return Ink(np.maximum(over, under), label, np.stack([RED, BLUE]), np.ones(3), 0.0)


def painted(strokes: Strokes, colors: list[NDArray[np.float64]]) -> Strokes:
    return replace(strokes, color=np.stack(colors))


def test_equal_shapes_of_two_inks_that_pass_each_other_keep_their_colours_and_order() -> None:
    shift = [-20.0, -7.0, 7.0, 20.0]
    red = [turned(FIGURE[2:], 0, (x, 0)) for x in shift]
    blue = [turned(FIGURE[2:], 0, (-x, 0)) for x in shift]
    ink = two_inks([draw(c) for c in red], [draw(c) for c in blue])
    first = painted(strokes_of([blue[0][0], red[0][0], blue[0][1], red[0][1]]), [BLUE, RED, BLUE, RED])
    carried = propagate(ink, first, FAST, partial(initialise, settings=InitialiseSettings()))
    assert carried.strokes.ids.tolist()[:4] == [1, 2, 3, 4]
    assert len(carried.confidence) == carried.strokes.row_count
    for stroke, truth in enumerate([blue, red, blue, red]):
        found = carried.strokes.points_of(carried.strokes.row(stroke, 3))
        assert np.abs(found - truth[3][stroke // 2]).max() < 5.0, stroke  # a swap is 40 px off


def test_an_ink_that_comes_late_is_traced_when_it_comes() -> None:
    red = [draw(FIGURE[2:])] * 4
    blue = [draw([])] * 2 + [draw(FIGURE[:2])] * 2
    first = painted(strokes_of(FIGURE[2:]), [RED, RED])
    carried = propagate(two_inks(red, blue), first, FAST, partial(initialise, settings=InitialiseSettings()))
    lives = carried.strokes.layout.first, carried.strokes.layout.last
    assert [list(map(int, life)) for life in lives] == [[0, 0, 2, 2], [3, 3, 3, 3]]
    np.testing.assert_allclose(carried.strokes.color[2:], [BLUE, BLUE])


SHAPES = [arc(x, y, 18, a, a + 85) for x in (30, 80, 130) for y in (30, 80, 130) for a in (0, 95, 190)]


def test_one_ink_that_changes_altogether_is_no_cut_though_it_would_be_one_alone() -> None:
    frame = [line(14, 5, 146, 5), line(14, 155, 146, 155), line(5, 14, 5, 146), line(155, 14, 155, 146)]
    red = [draw(FIGURE)] * 2 + [draw(SHAPES)] * 2
    trace = partial(initialise, settings=InitialiseSettings())
    assert kinds(propagate(ink_of(red), strokes_of(FIGURE), FAST, trace), EventKind.CUT) == [2]
    first = painted(strokes_of([*frame, *FIGURE]), [BLUE] * 4 + [RED] * 4)
    together = propagate(two_inks(red, [draw(frame)] * 4), first, FAST, trace)
    assert not kinds(together, EventKind.CUT)
    assert together.strokes.layout.last[:4].tolist() == [3, 3, 3, 3]


def test_where_the_larger_part_of_all_ink_changes_altogether_there_is_a_cut() -> None:
    red = [draw([line(10, 150, 60, 150)])] * 2 + [draw([arc(130, 20, 12, 0, 80)])] * 2
    first = painted(strokes_of([*FIGURE, line(10, 150, 60, 150)]), [BLUE] * 4 + [RED])
    blue = [draw(FIGURE)] * 2 + [draw(SHAPES)] * 2
    both = propagate(two_inks(red, blue), first, FAST, partial(initialise, settings=InitialiseSettings()))
    assert kinds(both, EventKind.CUT) == [2]
    assert both.strokes.layout.last[:5].tolist() == [1, 1, 1, 1, 1]
