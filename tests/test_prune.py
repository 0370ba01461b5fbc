"""Cleaning of skeleton graphs: what is left is what looking at every branch again after each change leaves."""

from __future__ import annotations

from collections.abc import Callable
from copy import deepcopy

import cv2
import numpy as np
import pytest

from videovec.initialise import prune
from videovec.initialise.graph import Graph, skeleton_graph
from videovec.initialise.prune import Widths
from videovec.initialise.thinning import thin

WIDTHS = Widths(1.0, 1.2)


def _scribble(seed: int) -> Graph:
    """The graph of a tangle of thick lines with frayed edges: many spurs and split crossings."""
    rng = np.random.default_rng(seed)
    page = np.zeros((160, 160), np.uint8)
    for start, stop in rng.integers(8, 152, (14, 2, 2)):
        cv2.line(page, start.tolist(), stop.tolist(), 255, int(rng.integers(3, 8)))
    page[rng.random(page.shape) < 0.03] = 0
    radius = cv2.distanceTransform(page, cv2.DIST_L2, 5).astype(np.float32)
    return skeleton_graph(thin(page), radius, 1)


def _one_after_the_other(graph: Graph, find: Callable[[], list[tuple[float, int]]], act: Callable[[int], int]) -> None:
    """Act on the shortest branch that is found, until none is; nodes of two branches go."""
    while found := find():
        node = act(min(found)[1])
        if graph.degree(node) == 2:
            graph.dissolve(node)


def _shape(graph: Graph) -> list[tuple[int, int, float]]:
    ends = [(min(b.start, b.stop), max(b.start, b.stop), round(b.length, 6)) for b in graph.branches.values()]
    return sorted(ends)


@pytest.mark.parametrize("seed", range(4))
def test_spurs_and_clusters_go_as_if_all_were_looked_at_again(seed: int) -> None:
    graph = _scribble(seed)
    slow = deepcopy(graph)
    before = len(graph.branches)

    def spurs() -> list[tuple[float, int]]:
        return [(length, leaf) for node in slow.nodes() for length, leaf, _ in prune._spurs(slow, WIDTHS, node)]

    def drop(leaf: int) -> int:
        branch = slow.remove(leaf)
        return branch.start if slow.degree(branch.start) else branch.stop

    _one_after_the_other(slow, spurs, drop)
    prune._drop_spurs(graph, WIDTHS)
    assert _shape(graph) == _shape(slow)
    assert len(graph.branches) < before

    def bridges() -> list[tuple[float, int]]:
        return [bridge for number in slow.branches if (bridge := prune._bridge(slow, WIDTHS, number))]

    _one_after_the_other(slow, bridges, slow.contract)
    prune._join_clusters(graph, WIDTHS)
    assert _shape(graph) == _shape(slow)
