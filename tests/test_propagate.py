from __future__ import annotations

from collections.abc import Callable
from functools import partial

import cv2
import numpy as np
import pytest
from numpy.typing import NDArray

from videovec.curves import evaluate, segments_of
from videovec.errors import FitError
from videovec.events import EventKind
from videovec.initialise import initialise
from videovec.ink import Ink
from videovec.propagate import Propagated, propagate
from videovec.settings import InitialiseSettings, PropagateSettings
from videovec.strokes import Strokes

Floats = NDArray[np.float64]

SIZE = 160
WIDTH = 3.0
FAST = PropagateSettings(refine_steps=18)
trace: Callable[[Ink, int], Strokes] = partial(initialise, settings=InitialiseSettings())


def line(*ends: float) -> Floats:
    a, b = np.array(ends[:2]), np.array(ends[2:])
    return np.asarray(a + (b - a) * np.linspace(0, 1, 4)[:, None])


def arc(x: float, y: float, radius: float, start: float, stop: float) -> Floats:
    """A circular arc of at most a quarter, as the usual cubic."""
    a, b = np.radians([start, stop])
    k = 4 / 3 * np.tan((b - a) / 4)
    p, q = np.array([np.cos(a), np.sin(a)]), np.array([np.cos(b), np.sin(b)])
    points = np.stack([p, p + k * np.array([-p[1], p[0]]), q - k * np.array([-q[1], q[0]]), q])
    return np.asarray(radius * points + (x, y))


FIGURE = [arc(70, 60, 30, 200, 280), arc(70, 60, 30, 300, 380), line(70, 75, 70, 125), line(70, 95, 110, 80)]


def turned(curves: list[Floats], angle: float, shift: tuple[float, float]) -> list[Floats]:
    cos, sin = np.cos(np.radians(angle)), np.sin(np.radians(angle))
    middle = np.array([75.0, 85.0])
    return [(c - middle) @ np.array([[cos, sin], [-sin, cos]]) + middle + shift for c in curves]


def draw(curves: list[Floats], cover: tuple[int, int, int, int] | None = None) -> NDArray[np.uint8]:
    """Coverage by supersampling, with a rectangle x0, y0, x1, y1 of bare paper on top."""
    scale = 4
    image = np.zeros((SIZE * scale, SIZE * scale), np.uint8)
    for points in curves:
        dense = evaluate(segments_of(points)[:, None], np.linspace(0, 1, 40)).reshape(-1, 2)
        at = np.round((dense * scale - 0.5) * 16).astype(np.int32)
        cv2.polylines(image, [at], False, 255, round(WIDTH * scale), cv2.LINE_AA, 4)
    if cover:
        x0, y0, x1, y1 = (scale * v for v in cover)
        image[y0:y1, x0:x1] = 0
    return np.asarray(cv2.resize(image, (SIZE, SIZE), interpolation=cv2.INTER_AREA), np.uint8)


def ink_of(drawings: list[NDArray[np.uint8]]) -> Ink:
    coverage = np.stack(drawings)
    return Ink(coverage, np.zeros_like(coverage), np.zeros((1, 3)), np.ones(3), 0.0)


def strokes_of(curves: list[Floats], drawing: int = 0) -> Strokes:
    widths = [np.full((len(c) - 1) // 3 + 1, WIDTH / 2) for c in curves]
    return Strokes.from_curves(curves, widths, drawing=drawing)


def run(ink: Ink, strokes: Strokes, settings: PropagateSettings = FAST) -> Propagated:
    result = propagate(ink, strokes, settings, trace)
    assert np.isfinite(result.strokes.points).all()
    assert result.confidence.shape == (result.strokes.row_count,)
    assert ((result.strokes.visible >= 0) & (result.strokes.visible <= 1)).all()
    return result


def kinds(result: Propagated, kind: EventKind) -> list[int]:
    return [event.drawing for event in result.events if event.kind == kind]


def worst(result: Propagated, true: list[list[Floats]]) -> float:
    """Mean distance of control points from the truth on the worst drawing; strokes 0 .. are the true ones in order."""
    errors = []
    for drawing, curves in enumerate(true):
        points = [result.strokes.points_of(result.strokes.row(s, drawing)) for s in range(len(curves))]
        errors.append(float(np.linalg.norm(np.concatenate(points) - np.concatenate(curves), axis=1).mean()))
    return max(errors)


@pytest.mark.parametrize("seed", [0, 3])
def test_strokes_follow_a_figure_that_turns_and_moves(seed: int) -> None:
    true = [turned(FIGURE, 12.0 * t, (3.0 * t, 2.0 * t)) for t in range(6)]
    result = run(ink_of([draw(curves) for curves in true]), strokes_of(true[seed], seed))
    assert len(result.strokes) == len(FIGURE)
    assert result.events == ()
    assert worst(result, true) < 1.0


def test_the_measure_of_the_tests_sees_strokes_that_stay_behind() -> None:
    true = [turned(FIGURE, 12.0 * t, (3.0 * t, 2.0 * t)) for t in range(3)]
    still = ink_of([draw(true[0])] * 3)
    assert worst(run(still, strokes_of(true[0])), true) > 3.0


def test_a_figure_that_turns_far_between_two_drawings_is_found_by_search() -> None:
    true = [FIGURE, turned(FIGURE, 130.0, (10.0, -5.0))]
    assert worst(run(ink_of([draw(c) for c in true]), strokes_of(FIGURE)), true) < 1.5


def test_parts_that_turn_apart_are_found_one_by_one() -> None:
    one, two = [FIGURE[0], line(70, 40, 125, 60)], [line(20, 130, 60, 145), line(30, 145, 50, 120)]
    cos, sin = np.cos(np.radians(45)), np.sin(np.radians(45))
    turn = np.array([[cos, sin], [-sin, cos]])
    moved = [(c - (70, 50)) @ turn + (75, 55) for c in one] + [(c - (40, 135)) @ turn.T + (45, 130) for c in two]
    true = [one + two, moved]
    result = run(ink_of([draw(c) for c in true]), strokes_of(true[0]))
    assert worst(result, true) < 1.5


def test_ink_that_appears_is_one_stroke_from_its_first_drawing() -> None:
    extra = line(20, 140, 140, 140)
    drawings = [draw(FIGURE)] * 3 + [draw([*FIGURE, extra])] * 3
    result = run(ink_of(drawings), strokes_of(FIGURE))
    assert len(result.strokes) == len(FIGURE) + 1
    assert kinds(result, EventKind.BIRTH) == [3]
    assert (result.strokes.layout.first[-1], result.strokes.layout.last[-1]) == (3, 5)
    ends = result.strokes.points_of(result.strokes.row(len(FIGURE), 4))[[0, -1]]
    assert np.abs(ends[np.argsort(ends[:, 0])] - extra[[0, -1]]).max() < 3.0


def test_a_stroke_whose_ink_vanishes_dies_and_no_other_does() -> None:
    drawings = [draw(FIGURE)] * 3 + [draw(FIGURE[:3])] * 4
    result = run(ink_of(drawings), strokes_of(FIGURE))
    assert kinds(result, EventKind.DEATH) == [3]
    np.testing.assert_array_equal(result.strokes.layout.last, [6, 6, 6, 2])


def test_a_stroke_that_comes_back_within_memory_keeps_its_identity() -> None:
    drawings = [draw(FIGURE)] * 2 + [draw(FIGURE[:3])] * 2 + [draw(FIGURE)] * 2
    result = run(ink_of(drawings), strokes_of(FIGURE))
    assert len(result.strokes) == len(FIGURE)
    rows = [result.strokes.row(3, t) for t in range(6)]
    seen = result.strokes.visible[rows, 1] > result.strokes.visible[rows, 0]
    np.testing.assert_array_equal(seen, [True, True, False, False, True, True])
    assert kinds(result, EventKind.OCCLUSION) == [2]
    assert kinds(result, EventKind.REAPPEARANCE) == [4]


def test_a_stroke_that_comes_back_after_memory_is_another() -> None:
    drawings = [draw(FIGURE)] * 2 + [draw(FIGURE[:3])] * 4 + [draw(FIGURE)] * 2
    result = run(ink_of(drawings), strokes_of(FIGURE), PropagateSettings(refine_steps=0, memory=2))
    assert len(result.strokes) == len(FIGURE) + 1
    assert kinds(result, EventKind.DEATH) == [2]
    assert kinds(result, EventKind.BIRTH) == [6]


def test_a_half_hidden_stroke_keeps_its_shape_and_shows_the_rest() -> None:
    long = [line(20, 140, 140, 140), *FIGURE]
    drawings = [draw(long)] + [draw(long, cover=(x, 130, SIZE, 150)) for x in (110, 90, 80)] + [draw(long)]
    result = run(ink_of(drawings), strokes_of(long))
    assert len(result.strokes) == len(long)
    seen = [20 + 120 * result.strokes.visible[result.strokes.row(0, t), 1] for t in range(5)]
    np.testing.assert_allclose(seen, [140, 110, 90, 80, 140], atol=5.0)
    assert worst(result, [long] * 5) < 1.5


def test_a_line_that_is_being_drawn_is_one_stroke_whose_visible_part_grows() -> None:
    grown = [[*FIGURE, line(20, 140, 20 + 24 * t, 140)] if t else FIGURE for t in range(7)]
    grown[6] = grown[5]
    result = run(ink_of([draw(c) for c in grown]), strokes_of(FIGURE))
    assert len(result.strokes) == len(FIGURE) + 1
    s = len(FIGURE)
    assert result.strokes.layout.first[s] == 1
    rows = [result.strokes.row(s, t) for t in range(1, 7)]
    share = np.diff(result.strokes.visible[rows], axis=1)[:, 0]
    np.testing.assert_allclose(share, [0.2, 0.4, 0.6, 0.8, 1.0, 1.0], atol=0.06)


def test_ink_that_is_never_twice_in_one_place_is_one_stroke() -> None:
    still = [line(30, 40, 30, 120), line(30, 40, 60, 70)]
    fast = [line(84 + 16 * t, 10, 84 + 16 * t, 150) for t in range(5)]
    result = run(ink_of([draw(still), *(draw([*still, bar]) for bar in fast)]), strokes_of(still))
    assert len(result.strokes) == len(still) + 1
    assert kinds(result, EventKind.BIRTH) == [1]
    for t, bar in enumerate(fast, start=1):
        across = result.strokes.points_of(result.strokes.row(len(still), t))[:, 0]
        np.testing.assert_allclose(across, bar[0, 0], atol=1.5)


def test_an_end_under_another_line_stays_hidden_where_the_two_cross() -> None:
    under = [line(20, 60, 20 + 90, 60), line(90, 20, 90, 110)]
    moved = [[c + np.array([4.0, 2.0]) * t for c in under] for t in range(4)]
    drawings = [draw(curves, cover=(round(curves[1][0, 0]) + 2, 0, SIZE, SIZE)) for curves in moved]
    begun = strokes_of(under)
    begun.visible[0] = 0.0, 70 / 90
    result = run(ink_of(drawings), begun)
    seen = [90 * result.strokes.visible[result.strokes.row(0, t), 1] for t in range(4)]
    np.testing.assert_allclose(seen, 70, atol=3.0)


def test_a_cut_ends_all_lives_and_begins_others() -> None:
    other = [arc(x, y, 18, a, a + 85) for x in (30, 80, 130) for y in (30, 80, 130) for a in (0, 95, 190)]
    result = run(ink_of([draw(FIGURE)] * 2 + [draw(other)] * 2), strokes_of(FIGURE))
    assert kinds(result, EventKind.CUT) == [2]
    first, last = result.strokes.layout.first, result.strokes.layout.last
    assert set(zip(first.tolist(), last.tolist(), strict=True)) == {(0, 1), (2, 3)}


def test_an_empty_drawing_in_the_middle_hides_all_strokes() -> None:
    blank = np.zeros((SIZE, SIZE), np.uint8)
    result = run(ink_of([draw(FIGURE), blank, draw(FIGURE)]), strokes_of(FIGURE))
    assert len(result.strokes) == len(FIGURE)
    hidden = result.strokes.visible[result.strokes.rows_at(1)]
    assert (hidden[:, 1] <= hidden[:, 0]).all()


def test_a_stroke_that_leaves_the_page_dies() -> None:
    true = [[*FIGURE[:2], FIGURE[2] + (45.0 * t, 0)] for t in range(4)]
    result = run(ink_of([draw(c) for c in true]), strokes_of(true[0]))
    assert result.strokes.layout.last[2] < 3
    assert (result.strokes.layout.last[:2] == 3).all()


def test_without_strokes_the_first_drawing_is_traced() -> None:
    result = run(ink_of([draw(FIGURE)] * 2), Strokes.empty())
    assert len(result.strokes) > 0
    assert (result.strokes.layout.last == 1).all()


@pytest.mark.parametrize("shape", [(1, 1), (2, 2), (2, 40), (5, 3)])
def test_tiny_pages_work(shape: tuple[int, int]) -> None:
    coverage = np.full((3, *shape), 255, np.uint8)
    ink = Ink(coverage, np.zeros_like(coverage), np.zeros((1, 3)), np.ones(3), 0.0)
    run(ink, strokes_of([line(0.5, 0.5, shape[1] - 0.5, shape[0] - 0.5), np.full((4, 2), 0.5)]))


def test_a_single_drawing_stays_as_it_is() -> None:
    strokes = strokes_of(FIGURE)
    result = run(ink_of([draw(FIGURE)]), strokes)
    np.testing.assert_array_equal(result.strokes.points, strokes.points)


def test_nothing_at_all_gives_nothing() -> None:
    result = run(ink_of([np.zeros((SIZE, SIZE), np.uint8)] * 3), Strokes.empty())
    assert len(result.strokes) == 0


def test_strokes_of_several_drawings_are_refused() -> None:
    two = Strokes.concatenate(
        [strokes_of(FIGURE[:1]), Strokes.from_curves(FIGURE[1:2], [np.ones(2)], drawing=1, first_id=9)]
    )
    with pytest.raises(FitError, match="one drawing"):
        propagate(ink_of([draw(FIGURE)] * 2), two, FAST, trace)
