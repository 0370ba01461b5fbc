"""Decisions at junctions: the same whatever way the page is turned, and those of anybody where nobody doubts."""

from __future__ import annotations

from itertools import combinations

import numpy as np
import pytest
from numpy.typing import NDArray

from benchmarks.junction_data import Drawn, drawings, raster, trace_lines
from benchmarks.junction_figures import scene
from benchmarks.junction_traced import by_hand
from benchmarks.junction_training import prepare, scores_of, to_bytes, train
from videovec.initialise import junction_net
from videovec.initialise.arrangement import arrange
from videovec.initialise.graph import Branch, Graph
from videovec.initialise.junction_features import describe
from videovec.initialise.junction_net import load_nets, read_nets, score_pairs
from videovec.initialise.junctions import Pairing, choose, pair_by_net
from videovec.initialise.polyline import resample
from videovec.initialise.prune import Widths

Floats = NDArray[np.float64]


def _drawn(lines: list[Floats], width: float = 4.0, size: int = 256) -> Drawn:
    """Known lines, in px, drawn with a pen and traced."""
    sampled = [resample(line, 0.5) for line in lines]
    drawn = trace_lines(sampled, raster(sampled, size, width))
    assert drawn is not None
    return drawn


@pytest.fixture(scope="module")
def sketch() -> Drawn:
    """A made-up drawing with a dozen junctions."""
    lines = scene(np.random.default_rng(3))
    low = np.min([line.min() for line in lines])
    most = np.max([line.max() for line in lines]) - low
    drawn = _drawn([(line - low) / most * 216 + 20 for line in lines])
    assert len(drawn.junctions) >= 10
    return drawn


def _moved(drawn: Drawn, matrix: Floats, shift: Floats, scale: float = 1.0) -> tuple[Graph, Widths]:
    """The same graph on a page that is turned, mirrored or enlarged."""
    graph = drawn.graph
    branches = {
        number: Branch(b.start, b.stop, b.line @ matrix.T * scale + shift, b.radius * scale)
        for number, b in graph.branches.items()
    }
    position = graph.position @ matrix.T * scale + shift
    moved = Graph(position, graph.radius * scale, branches, [], [], np.zeros((0, 3)))
    return moved, Widths(drawn.widths.calibration, drawn.widths.least * scale)


def _decisions(pairings: list[Pairing]) -> dict[int, tuple[set[frozenset[tuple[int, int]]], float]]:
    return {p.node: ({frozenset((p.ends[i], p.ends[j])) for i, j in p.links}, p.log_odds) for p in pairings}


def _assert_same(one: list[Pairing], two: list[Pairing], tolerance: float = 1e-3) -> None:
    a, b = _decisions(one), _decisions(two)
    assert a.keys() == b.keys()
    for node in a:
        assert a[node][1] == pytest.approx(b[node][1], abs=tolerance)
        assert a[node][0] == b[node][0] or a[node][1] < tolerance


@pytest.mark.parametrize("angle", [17.0, 90.0, 203.0])
@pytest.mark.parametrize("mirror", [1.0, -1.0])
def test_a_turned_or_mirrored_page_has_the_same_decisions(sketch: Drawn, angle: float, mirror: float) -> None:
    c, s = np.cos(np.radians(angle)), np.sin(np.radians(angle))
    moved = _moved(sketch, np.array([[c, -s], [s, c]]) @ np.diag([1.0, mirror]), np.array([300.0, -40.0]))
    _assert_same(pair_by_net(sketch.graph, sketch.widths), pair_by_net(*moved))


def test_an_enlarged_page_has_the_same_decisions(sketch: Drawn) -> None:
    _assert_same(
        pair_by_net(sketch.graph, sketch.widths), pair_by_net(*_moved(sketch, np.eye(2), np.zeros(2), scale=3.5))
    )


def test_neither_the_order_nor_the_direction_of_branches_matters(sketch: Drawn) -> None:
    graph, rng = sketch.graph, np.random.default_rng(0)
    numbers = sorted(graph.branches)
    renamed = dict(zip(numbers, rng.permutation(numbers).tolist(), strict=True))
    turned = {number: bool(rng.random() < 0.5) for number in numbers}
    branches = {
        renamed[n]: graph.branches[n].reversed() if turned[n] else graph.branches[n] for n in rng.permutation(numbers)
    }
    other = pair_by_net(Graph(graph.position, graph.radius, branches, [], [], np.zeros((0, 3))), sketch.widths)
    back = {(renamed[n], end ^ turned[n]): (n, end) for n in numbers for end in (0, 1)}
    named = [Pairing(p.node, tuple(back[e] for e in p.ends), p.links, p.runner_up, p.log_odds) for p in other]
    _assert_same(pair_by_net(graph, sketch.widths), named)


def test_the_check_of_decisions_can_fail(sketch: Drawn) -> None:
    squeezed = _moved(sketch, np.diag([1.0, 0.4]), np.zeros(2))
    with pytest.raises(AssertionError):
        _assert_same(pair_by_net(sketch.graph, sketch.widths), pair_by_net(*squeezed))


def test_decisions_do_not_change_from_run_to_run(sketch: Drawn) -> None:
    one, two = (_decisions(pair_by_net(sketch.graph, sketch.widths)) for _ in range(2))
    assert one == two


@pytest.mark.parametrize("arms", [2, 3, 4, 5])
def test_the_confidence_is_that_of_the_best_of_all_decisions(arms: int) -> None:
    score = np.random.default_rng(arms).normal(0, 2, (arms, arms))
    score = score + score.T
    edges = list(combinations(range(arms), 2))
    total = {}
    for size in range(0 if arms == 2 else 1, arms // 2 + 1):  # where three meet, one line at least runs on
        for chosen in combinations(edges, size):
            if len({arm for edge in chosen for arm in edge}) == 2 * size:
                total[frozenset(chosen)] = sum(score[edge] for edge in chosen)
    weight = {matching: np.exp(value) for matching, value in total.items()}
    best = max(weight, key=lambda matching: weight[matching])
    share = weight[best] / sum(weight.values())
    links, runner_up, log_odds = choose(score)
    assert frozenset(links) == best
    assert frozenset(runner_up) == sorted(weight, key=lambda matching: -weight[matching])[1]
    assert log_odds == pytest.approx(np.log(share / (1 - share)))


def _angle(degrees: float, length: float = 90.0) -> Floats:
    return np.array([128.0, 128.0]) + length * np.array([np.cos(np.radians(degrees)), np.sin(np.radians(degrees))])


def _only_junction(drawn: Drawn) -> tuple[Pairing, list[float]]:
    """The decision at the one junction, and the direction of its ends in degrees."""
    (pairing,) = (p for p in pair_by_net(drawn.graph, drawn.widths) if len(p.ends) > 2)
    directions = []
    for end in pairing.ends:
        line = drawn.graph.outward(*end).line
        away = line[min(60, len(line) - 1)] - line[min(12, len(line) - 2)]  # beyond what thinning bends
        directions.append(float(np.degrees(np.arctan2(away[1], away[0]))))
    return pairing, directions


@pytest.mark.parametrize("turn", [0.0, 33.0])
def test_crossing_lines_go_through(turn: float) -> None:
    lines = [np.array([_angle(a + turn), _angle(a + turn + 180)]) for a in (0, 75)]
    pairing, directions = _only_junction(_drawn(lines))
    assert len(pairing.links) == 2
    for i, j in pairing.links:
        assert np.cos(np.radians(directions[i] - directions[j])) == pytest.approx(-1.0, abs=0.02)


@pytest.mark.parametrize("turn", [0.0, 33.0])
def test_a_line_that_meets_another_squarely_ends_there(turn: float) -> None:
    lines = [np.array([_angle(turn), _angle(turn + 180)]), np.array([_angle(turn + 90), [128.0, 128.0]])]
    pairing, directions = _only_junction(_drawn(lines))
    ((i, j),) = pairing.links
    assert np.cos(np.radians(directions[i] - directions[j])) == pytest.approx(-1.0, abs=0.02)


def test_a_small_closed_object_on_a_line_is_closed() -> None:
    angle = np.linspace(0, 2 * np.pi, 100)
    ring = np.array([128.0, 128.0]) + 16 * np.stack([np.cos(angle), np.sin(angle)], axis=1)
    bar = [np.array([[20.0, 128.0], [112.0, 128.0]]), np.array([[144.0, 128.0], [236.0, 128.0]])]
    drawn = _drawn([ring, *bar])
    for pairing in pair_by_net(drawn.graph, drawn.widths):
        if len(pairing.ends) == 3:
            ((i, j),) = pairing.links
            ends = [drawn.graph.branches[pairing.ends[k][0]] for k in (i, j)]
            assert all(branch.line[:, 0].min() > 100 and branch.line[:, 0].max() < 156 for branch in ends)


def test_regions_are_those_of_a_plane_drawing(sketch: Drawn) -> None:
    laid = arrange(sketch.graph, sketch.widths)
    nodes = set(laid.node.tolist())
    parts = {node: node for node in nodes}

    def root(node: int) -> int:
        return node if parts[node] == node else root(parts[node])

    for branch in sketch.graph.branches.values():
        parts[root(branch.start)] = root(branch.stop)
    connected = len({root(node) for node in nodes})
    assert len(laid.area) == len(laid.ends) // 2 - len(nodes) + 2 * connected  # Euler, with an outside for each part
    assert (laid.area <= 0).sum() == connected
    assert laid.area.sum() == pytest.approx(0.0, abs=1e-6)


def test_a_square_with_a_diagonal_has_two_triangles() -> None:
    corners = np.array([[60.0, 60], [200, 60], [200, 200], [60, 200], [60, 60]])
    drawn = _drawn([corners, corners[[0, 2]]])
    laid = arrange(drawn.graph, drawn.widths)
    inner = laid.area > 0
    assert inner.sum() == 2
    np.testing.assert_allclose(laid.perimeter[inner] / np.sqrt(laid.area[inner]), 2 * np.sqrt(2) + 2, rtol=0.03)
    np.testing.assert_allclose(laid.turning[inner], 1.0, atol=0.15)


def test_true_matchings_are_those_of_the_strokes_that_were_drawn() -> None:
    crossing = [np.array([_angle(a), _angle(a + 180)]) for a in (10, 100)]
    tee = [crossing[0], np.array([_angle(100), [128.0, 128.0]])]
    corner = [np.array([_angle(10), [128.0, 128.0], _angle(100)]), np.array([_angle(190), [128.0, 128.0]])]
    found = []
    for lines in (crossing, tee, corner):
        drawn = _drawn(lines)
        (known,) = (k for k in drawn.junctions if len(k.ends) > 2)
        assert known.is_clear
        tips = {}
        for k, end in enumerate(known.ends):
            away = drawn.graph.outward(*end).line[-1] - 128.0
            tips[k] = round(float(np.degrees(np.arctan2(away[1], away[0]))) / 10) * 10 % 360
        found.append({frozenset((tips[i], tips[j])) for i, j in known.links})
    assert found == [
        {frozenset((10, 190)), frozenset((100, 280))},
        {frozenset((10, 190))},
        {frozenset((10, 100))},
    ]


def test_lines_traced_by_hand_have_few_vertices_and_still_meet_what_they_met() -> None:
    x = np.linspace(-0.4, 0.4, 300)
    bar = np.stack([x, 0.1 * np.sin(8 * x)], axis=1)
    stem = np.stack([np.full(100, 0.1), np.linspace(0.4, 0.1 * np.sin(0.8), 100)], axis=1)
    corners = []
    for seed in range(12):
        straight, ends_on_it = by_hand([bar, stem], np.random.default_rng(seed))
        away = np.linalg.norm(straight - ends_on_it[-1], axis=1).min()
        assert away < 0.02
        np.testing.assert_allclose(ends_on_it[0], stem[0], atol=1e-6)
        way = np.diff(straight, axis=0)
        corners.append(np.abs(np.diff(np.unwrap(np.arctan2(way[:, 1], way[:, 0])))) > 0.02)
    assert min(turned.sum() for turned in corners) < 20  # some are straight from vertex to vertex


def test_the_library_computes_what_was_trained() -> None:
    known = [drawn for drawn in drawings("scene", 4, 1, None) if any(k.is_clear for k in drawn.junctions)]
    examples = [prepare(drawn) for drawn in known]
    nets = [train(examples, epochs=2, seed=seed, batch=2) for seed in (0, 1)]
    ours = read_nets(to_bytes(nets))
    assert len(ours) == 2
    for drawn, example in zip(known, examples, strict=True):
        laid = arrange(drawn.graph, drawn.widths)
        expected = scores_of(nets, example).numpy()
        np.testing.assert_allclose(score_pairs(ours, laid, describe(laid)), expected, atol=0.02)


def test_other_weights_are_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    assert all(net.rounds > 0 for net in load_nets())
    load_nets.cache_clear()
    monkeypatch.setattr(junction_net, "CHECKSUM", "0" * 64)
    with pytest.raises(Exception, match="must have sha256 000"):
        load_nets()
    monkeypatch.undo()
    load_nets.cache_clear()
