"""Edges that pass before others: who they are, what they pass over, and that limbs beside them are not drawn along."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray
from test_propagate import SIZE, arc, draw, ink_of, line, run, strokes_of

from videovec.curves import sample_by_arc
from videovec.propagate.front import behind, covering, ends_missing, passed_over, without
from videovec.propagate.nodes import Nodes, basis_of, gather
from videovec.propagate.placing import find
from videovec.propagate.registration import source_of
from videovec.propagate.target import make_target
from videovec.strokes import Strokes

Floats = NDArray[np.float64]

POST = line(100, 20, 100, 140)
LYING = line(20, 80, 140, 80)
FIGURE = [line(58, 40, 66, 112), line(92, 36, 86, 112), arc(76, 38, 14, 200, 290), line(10, 128, 150, 132)]
BAR = 34.0


def nodes_of(curves: list[Floats], is_closed: bool = False) -> tuple[Nodes, Floats]:
    nodes = gather([basis_of(curve, 4.0, is_closed) for curve in curves])
    return nodes, np.asarray(nodes.weights @ np.concatenate(curves))


@pytest.mark.parametrize(
    ("post", "seen_until", "covers"),
    [(POST, 100.0, True), (POST, 140.0, False), (POST, 70.0, False), (line(100, 81, 100, 140), 100.0, False)],
)
def test_a_line_hides_another_that_ends_within_it(post: Floats, seen_until: float, covers: bool) -> None:
    nodes, positions = nodes_of([LYING, post])
    shown = (nodes.stroke == 1) | (positions[:, 0] <= seen_until)
    missing = ends_missing(nodes, positions, shown, np.array([[0.0, 1.0], [0.0, 1.0]]))
    assert covering(nodes, positions, np.array([1.5, 1.5]), shown, missing).tolist() == [False, covers]


def test_what_was_never_seen_is_not_missing() -> None:
    nodes, positions = nodes_of([LYING, POST])
    shown = (nodes.stroke == 1) | (positions[:, 0] <= 100)
    assert ends_missing(nodes, positions, shown, np.array([[0.0, 0.66], [0.0, 1.0]])) == [[], []]


def test_an_edge_passes_over_what_changes_sides_and_two_edges_pass_over_it_twice() -> None:
    nodes, positions = nodes_of([LYING, POST, POST - (8.0, 0.0)])
    moved = positions - np.where(nodes.stroke == 0, 0.0, 40.0)[:, None] * (1.0, 0.0)
    x = positions[:, 0]
    alone = passed_over(nodes, (positions, positions), moved, np.array([False, True, False]))
    assert (alone == ((nodes.stroke == 0) & (x > 60) & (x < 100)) | (alone & (nodes.stroke == 2))).all()
    both = passed_over(nodes, (positions, positions), moved, np.array([False, True, True]))
    assert (both == ((nodes.stroke == 0) & (((x > 52) & (x < 60)) | ((x > 92) & (x < 100))))).all()


def test_a_ring_passes_over_what_comes_to_lie_inside() -> None:
    quarters = [arc(120, 80, 16, a, a + 90) for a in (0, 90, 180, 270)]
    ring = np.concatenate([quarters[0], *(quarter[1:] for quarter in quarters[1:])])
    nodes = gather([basis_of(LYING, 4.0, False), basis_of(ring, 4.0, True)])
    positions = np.asarray(nodes.weights @ np.concatenate([LYING, ring]))
    moved = positions - np.where(nodes.stroke == 1, 50.0, 0.0)[:, None] * (1.0, 0.0)
    passed = passed_over(nodes, (positions, positions), moved, np.array([False, True]))
    x = positions[:, 0]
    is_inside = (np.abs(x - 70) < 16) | (np.abs(x - 120) < 16)  # in it before, or in it now
    assert (passed[nodes.stroke == 0] == is_inside[nodes.stroke == 0]).all()


def test_the_ink_of_an_edge_is_nobody_elses_but_what_crosses_it_stays() -> None:
    target = make_target(draw([LYING, POST]), SIZE)
    nodes, positions = nodes_of([LYING, POST])
    left = without(target, nodes, positions, np.array([1.5, 1.5]), np.array([False, True]))
    assert (np.abs(left.points[:, 1] - 80) < 4).all()
    assert np.ptp(left.points[:, 0]) > 110
    assert without(target, nodes, positions, np.array([1.5, 1.5]), np.array([False, False])) is target


def test_edges_are_held_and_pull_nobody() -> None:
    nodes, positions = nodes_of([LYING, POST])
    source = source_of(nodes, positions, make_target(draw([LYING, POST]), SIZE))
    held = behind(source, positions + 5.0, np.array([False, True]), positions[:, 0] > 120)
    own = np.repeat(np.arange(len(nodes)), np.diff(source.indptr))
    assert not held.across[nodes.stroke[own] != nodes.stroke[source.index]].any()
    assert ((held.hold > 0) == (nodes.stroke == 1)).all()
    assert (held.weight == ((nodes.stroke == 0) & (positions[:, 0] <= 120))).all()


def behind_a_bar(left: float) -> NDArray[np.uint8]:
    """A still figure behind a bar of bare paper between two upright edges."""
    low, high = (int(np.clip(round(x), 0, SIZE)) for x in (left, left + BAR))
    edges = [line(x, -10, x, SIZE + 10) for x in (left, left + BAR) if -4 < x < SIZE + 4]
    figure = draw(FIGURE, (low, 0, high, SIZE))
    return np.maximum(figure, draw(edges)) if edges else figure


@pytest.fixture(scope="module")
def passed() -> Strokes:
    """The figure, while the bar passes it from left to right."""
    drawings = [behind_a_bar(-44.0 + 15 * d) for d in range(14)]
    return run(ink_of(drawings), strokes_of(FIGURE)).strokes


@pytest.mark.parametrize("stroke", range(4))
def test_limbs_that_run_almost_along_the_edge_that_covers_them_stay_where_they_are(
    passed: Strokes, stroke: int
) -> None:
    true = sample_by_arc(FIGURE[stroke], 41)
    for drawing in range(14):
        now = sample_by_arc(passed.points_of(passed.row(stroke, drawing)), 41)
        assert np.linalg.norm(now - true, axis=1).mean() < 3.0
    assert np.ptp(passed.visible[passed.row(stroke, 13)]) > 0.9


@pytest.mark.parametrize("stroke", range(3))
def test_nothing_is_seen_of_what_lies_under_the_bar(passed: Strokes, stroke: int) -> None:
    for drawing in range(14):
        left = -44.0 + 15 * drawing
        x = sample_by_arc(FIGURE[stroke], 401)[:, 0]
        is_seen = (x < left) | (x > left + BAR)
        begin, end = passed.visible[passed.row(stroke, drawing)]
        u = np.linspace(0, 1, 401)
        clear = np.minimum(np.abs(x - left), np.abs(x - left - BAR)) > 4.0  # its ink and an edge's are one otherwise
        wrong = is_seen[clear] != ((u >= begin) & (u <= end) & (end > begin))[clear]
        assert wrong.mean() < 0.15 if clear.any() else True


@pytest.mark.parametrize(("edge", "where"), [(80.0, 80.0), (150.0, 46.0)])
def test_an_edge_goes_on_as_it_went_if_it_has_ink_there_though_another_is_nearer(edge: float, where: float) -> None:
    across = [line(-10, y, 170, y) for y in (60.0, edge, 46.0)]
    nodes, positions = nodes_of([across[0], *FIGURE[:2]])
    before, after = (make_target(draw([*curves, *FIGURE[:2]]), SIZE) for curves in (across[:1], across[1:]))
    velocity = np.where(nodes.stroke == 0, 20.0, 0.0)[:, None] * (0.0, 1.0)
    source = source_of(nodes, positions, before)
    ways = positions, positions, positions + velocity
    front = np.array([True, False, False])
    found = find(source, ways, (front, np.full(3, 1.5)), (before, after), velocity, False)
    np.testing.assert_allclose(found.positions[nodes.stroke == 0, 1], where, atol=1.5)
