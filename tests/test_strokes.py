import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from videovec.errors import FitError
from videovec.strokes import Layout, Strokes


def random_strokes(segments: list[int], lives: list[tuple[int, int]], seed: int = 0) -> Strokes:
    """Strokes whose every number is told from every other."""
    rng = np.random.default_rng(seed)
    first, last = np.array(lives).T
    layout = Layout(np.array(segments), first, last)
    rows = len(layout.row_stroke)
    return Strokes(
        ids=np.arange(len(segments)) + 5,
        layout=layout,
        is_closed=np.zeros(len(segments), bool),
        layer=rng.permutation(len(segments)),
        color=rng.uniform(size=(len(segments), 3)),
        points=rng.uniform(size=(int(layout.row_points[-1]), 2)),
        half_width=rng.uniform(size=int(layout.row_joints[-1])),
        opacity=rng.uniform(size=rows),
        visible=np.tile([0.0, 1.0], (rows, 1)),
    )


LIVES = st.lists(
    st.tuples(st.integers(1, 4), st.integers(0, 5), st.integers(0, 4)).map(lambda x: (x[0], (x[1], x[1] + x[2]))),
    min_size=1,
    max_size=6,
)


def same_row(a: Strokes, row_a: int, b: Strokes, row_b: int) -> bool:
    return (
        np.array_equal(a.points_of(row_a), b.points_of(row_b))
        and np.array_equal(a.half_width_of(row_a), b.half_width_of(row_b))
        and a.opacity[row_a] == b.opacity[row_b]
    )


def test_neighbouring_segments_share_their_joint() -> None:
    strokes = random_strokes([3, 1], [(0, 1), (1, 1)])
    segments = strokes.segments()
    assert segments.shape == (7, 4, 2)
    for before, after in ((0, 1), (1, 2), (3, 4), (4, 5)):
        np.testing.assert_array_equal(segments[before, 3], segments[after, 0])
    np.testing.assert_array_equal(strokes.layout.segment_row, [0, 0, 0, 1, 1, 1, 2])


@given(LIVES)
def test_every_row_finds_its_stroke_and_drawing(spec: list[tuple[int, tuple[int, int]]]) -> None:
    strokes = random_strokes([n for n, _ in spec], [life for _, life in spec])
    layout = strokes.layout
    for stroke, (segments, (first, last)) in enumerate(spec):
        for drawing in range(first, last + 1):
            row = strokes.row(stroke, drawing)
            assert layout.row_stroke[row] == stroke
            assert layout.row_drawing[row] == drawing
            assert len(strokes.points_of(row)) == 3 * segments + 1


@given(LIVES, st.integers(0, 9))
def test_a_drawing_alone_has_the_rows_of_the_strokes_alive(
    spec: list[tuple[int, tuple[int, int]]], drawing: int
) -> None:
    strokes = random_strokes([n for n, _ in spec], [life for _, life in spec])
    alone = strokes.at_drawing(drawing)
    alive = [k for k, (_, (first, last)) in enumerate(spec) if first <= drawing <= last]
    assert alone.ids.tolist() == strokes.ids[alive].tolist()
    for k, stroke in enumerate(alive):
        assert same_row(alone, k, strokes, strokes.row(stroke, drawing))


@given(LIVES, st.integers(0, 9), st.integers(0, 5))
def test_what_is_taken_from_a_window_can_be_put_back(
    spec: list[tuple[int, tuple[int, int]]], first: int, more: int
) -> None:
    strokes = random_strokes([n for n, _ in spec], [life for _, life in spec])
    part = strokes.within(first, first + more)
    assert all(part.layout.first >= first)
    assert all(part.layout.last <= first + more)
    empty = random_strokes([n for n, _ in spec], [life for _, life in spec], seed=1)
    filled = empty.with_rows_of(part)
    for row, (stroke, drawing) in enumerate(
        zip(strokes.layout.row_stroke.tolist(), strokes.layout.row_drawing.tolist(), strict=True)
    ):
        inside = first <= drawing <= first + more
        assert same_row(filled, row, strokes if inside else empty, row), (stroke, drawing)


def test_selected_strokes_come_in_the_order_asked_for() -> None:
    strokes = random_strokes([1, 2, 3], [(0, 2), (1, 1), (0, 0)])
    chosen = strokes.select([2, 0])
    assert chosen.ids.tolist() == [7, 5]
    np.testing.assert_array_equal(chosen.points, np.concatenate([strokes.points[-10:], strokes.points[:12]]))


def test_identities_are_unique() -> None:
    strokes = random_strokes([1], [(0, 0)])
    with pytest.raises(FitError, match="unique"):
        Strokes.concatenate([strokes, strokes])


def test_shapes_that_do_not_agree_are_refused() -> None:
    layout = Layout(np.array([1]), np.array([0]), np.array([0]))
    with pytest.raises(FitError, match=r"strokes.points must be \(4, 2\), got \(3, 2\)"):
        Strokes(
            np.array([1]),
            layout,
            np.array([False]),
            np.array([0]),
            np.zeros((1, 3)),
            np.zeros((3, 2)),
            np.ones(2),
            np.ones(1),
            np.array([[0.0, 1.0]]),
        )


def test_a_stroke_has_no_row_outside_its_life() -> None:
    with pytest.raises(FitError, match=r"lives in drawings 1..2, asked for 0"):
        random_strokes([1], [(1, 2)]).row(0, 0)
