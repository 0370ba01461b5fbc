import numpy as np
from numpy.typing import NDArray

from videovec.curves import sample_by_arc
from videovec.link import link
from videovec.strokes import Strokes

LINE = np.array([[0, 0], [10, 0], [20, 0], [30, 0]], float)
ARCH = np.array([[0, 40], [5, 20], [10, 20], [15, 20], [20, 20], [25, 20], [30, 40]], float)


def drawing(curves: list[NDArray[np.float64]], at: int) -> Strokes:
    return Strokes.from_curves(curves, [np.ones((len(c) - 1) // 3 + 1) for c in curves], drawing=at)


def test_strokes_that_stay_near_keep_one_identity_in_whatever_order_they_are_listed() -> None:
    linked = link([drawing([LINE, ARCH], 0), drawing([ARCH + 1, LINE + 1], 1)], search_range=5.0)
    assert len(linked) == 2
    assert linked.layout.last.tolist() == [1, 1]
    np.testing.assert_allclose(linked.points_of(linked.row(0, 1)), LINE + 1)


def test_strokes_out_of_range_are_other_strokes() -> None:
    linked = link([drawing([LINE], 0), drawing([LINE + 100], 1)], search_range=5.0)
    assert linked.layout.first.tolist() == [0, 1]
    assert linked.layout.last.tolist() == [0, 1]


def test_a_reversed_stroke_is_turned_round() -> None:
    linked = link([drawing([ARCH], 0), drawing([ARCH[::-1]], 1)], search_range=5.0)
    np.testing.assert_allclose(linked.points_of(1), ARCH)


def test_more_segments_do_not_change_the_curve() -> None:
    linked = link([drawing([LINE], 0), drawing([np.array([[0, 0.5], [7, 0], [8, 0], [10, 0], *LINE[1:]])], 1)], 5.0)
    assert linked.layout.segments.tolist() == [2]
    np.testing.assert_allclose(sample_by_arc(linked.points_of(0), 31), sample_by_arc(LINE, 31), atol=1e-9)


def test_empty_drawings_end_and_begin_lives() -> None:
    linked = link([drawing([LINE], 0), drawing([], 1), drawing([LINE], 2)], search_range=5.0)
    assert linked.layout.first.tolist() == [0, 2]
