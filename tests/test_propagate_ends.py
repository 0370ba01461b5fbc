"""Where what is seen of a stroke ends, and where its hidden part is, on drawings whose answers are known."""

from __future__ import annotations

import numpy as np
import pytest
from test_propagate import arc, draw, line, turned

from videovec.propagate.ends import find_ends
from videovec.propagate.nodes import Nodes, basis_of, gather
from videovec.propagate.predict import predict_hidden
from videovec.propagate.record import Life, Row
from videovec.propagate.support import Support
from videovec.propagate.target import make_target

Floats = np.typing.NDArray[np.float64]

WHOLE = line(20, 80, 140, 80)
POST = line(100, 20, 100, 140)


def nodes_of(curves: list[Floats]) -> tuple[Nodes, Floats]:
    nodes = gather([basis_of(curve, 4.0, False) for curve in curves])
    return nodes, np.asarray(nodes.weights @ np.concatenate(curves))


def seen_runs(nodes: Nodes, until: list[float]) -> list[list[tuple[int, int]]]:
    """For each stroke the run of nodes up to an arc fraction."""
    return [[(0, int(np.flatnonzero(basis.u <= end)[-1]))] for basis, end in zip(nodes.bases, until, strict=True)]


@pytest.mark.parametrize("end", [56.0, 91.0, 123.0])
def test_what_is_seen_ends_where_the_ink_does(end: float) -> None:
    nodes, positions = nodes_of([WHOLE])
    target = make_target(draw([line(20, 80, end, 80)]), 160)
    runs = seen_runs(nodes, [(end - 20) / 120])
    ((part,),) = find_ends(nodes, positions, np.array([1.5]), (runs, np.array([[0.0, 1.0]])), target)
    assert part[0] == 0.0
    assert 20 + 120 * part[1] == pytest.approx(end, abs=2.0)


def test_a_stroke_that_goes_under_a_line_ends_in_its_middle() -> None:
    nodes, positions = nodes_of([WHOLE, POST])
    target = make_target(draw([line(20, 80, 100, 80), POST]), 160)
    runs = seen_runs(nodes, [80 / 120, 1.0])
    parts = find_ends(nodes, positions, np.array([1.5, 1.5]), (runs, np.tile([0.0, 1.0], (2, 1))), target)
    assert 20 + 120 * parts[0][0][1] == pytest.approx(100.0, abs=1.0)
    assert parts[1] == ((0.0, 1.0),)


def test_a_stroke_on_ink_from_end_to_end_is_seen_whole_and_one_without_not_at_all() -> None:
    nodes, positions = nodes_of([WHOLE, line(20, 120, 140, 120)])
    target = make_target(draw([WHOLE]), 160)
    runs = [seen_runs(nodes, [1.0, 1.0])[0], []]
    parts = find_ends(nodes, positions, np.array([1.5, 1.5]), (runs, np.tile([0.0, 1.0], (2, 1))), target)
    assert parts == [((0.0, 1.0),), ()]


def followed(curves: list[Floats], moved: list[Floats], is_seen: list[bool]) -> tuple[Floats, Floats, Nodes]:
    """Goal and stiffness of a step in which strokes move from one drawing to the next, some of them then hidden."""
    lives = [
        Life(s + 1, False, s, np.zeros(3), {0: Row(curve, np.full(2, 1.5), 1.0, (0.0, 1.0), 1.0)})
        for s, curve in enumerate(curves)
    ]
    nodes, positions = nodes_of(curves)
    shown = np.array(is_seen)[nodes.stroke]
    now = np.where(shown[:, None], nodes.weights @ np.concatenate(moved), positions)
    visible = tuple(((0.0, 1.0),) if seen else () for seen in is_seen)
    support = Support(shown, shown, visible, shown.astype(float), shown)
    hold = predict_hidden(lives, nodes, now, support, (0, 1, 1.0), np.zeros(len(lives), bool))
    return hold.goal, hold.stiffness, nodes


FIGURE = [line(40, 60, 110, 60), line(40, 60, 40, 120), line(110, 60, 110, 120), line(50, 80, 100, 110)]


def test_a_hidden_stroke_turns_and_moves_with_what_it_moved_with_before() -> None:
    moved = turned(FIGURE, 8.0, (5.0, -3.0))
    goal, stiffness, nodes = followed(FIGURE, moved, [True, True, True, False])
    own = nodes.stroke == 3
    np.testing.assert_allclose(goal[own], (nodes.weights @ np.concatenate(moved))[own], atol=1e-6)
    assert (stiffness[own] > 0).all()
    assert not stiffness[~own].any()


def test_where_nothing_is_seen_or_the_leap_is_large_nothing_is_expected() -> None:
    assert not followed(FIGURE, FIGURE, [False] * 4)[1].any()
    far = turned(FIGURE, 0.0, (30.0, 0.0))
    assert not followed(FIGURE, far, [True, True, True, False])[1].any()


def test_strokes_that_are_seen_whole_are_left_to_the_ink() -> None:
    assert not followed(FIGURE, turned(FIGURE, 5.0, (0.0, 0.0)), [True] * 4)[1].any()


def test_what_little_is_seen_of_a_stroke_neither_turns_nor_shrinks_the_rest() -> None:
    curve = np.concatenate([arc(80, 80, 40, k, k + 90)[k > 0 :] for k in (0, 90, 180)])
    nodes, positions = nodes_of([curve])
    cap = nodes.u < 0.25
    middle = positions[cap].mean(axis=0)
    slid = turned([positions], 6.0, (0.0, 0.0))[0]
    slid = slid + middle - slid[cap].mean(axis=0)
    now = np.where(cap[:, None], middle + 0.92 * (slid - middle), positions)
    life = Life(1, False, 0, np.zeros(3), {0: Row(curve, np.full(4, 1.5), 1.0, (0.0, 1.0), 1.0)})
    support = Support(cap, cap, (((0.0, 0.25),),), np.array([0.25]), cap)
    hold = predict_hidden([life], nodes, now, support, (0, 1, 1.0), np.zeros(1, bool))
    assert (hold.stiffness[~cap] > 0).all()
    assert np.linalg.norm(hold.goal - positions, axis=1)[~cap].mean() < 4.0
