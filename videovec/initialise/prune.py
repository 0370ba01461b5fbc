"""Clean a skeleton graph of what thinning adds: stems in sharp corners, spurs, and split crossings."""

from __future__ import annotations

from itertools import combinations

import numpy as np
from numpy.typing import NDArray

from videovec.initialise.graph import Branch, Graph
from videovec.initialise.polyline import angle_between, direction

__all__ = ["Widths", "clean"]

Floats = NDArray[np.float64]

_SHARP = 75.0  # degrees between two branches below which a leaf between them may be the stem of a sharp corner
_OFF_AXIS = 41.0  # degrees by which the stem may leave the corner's axis
_SPUR = 0.35  # widths beyond the edge of the ink that a branch must reach to be more than a spur
_CLUSTER = 1.0  # widths below which a branch between two junctions is part of one crossing


class Widths:
    """Widths of lines for the rules of geometry: the mask's radius, scaled to what the ink weighs.

    Args:
        calibration: Width of a line over twice the mask's radius.
        least: Width below which a line counts as this wide. px
    """

    def __init__(self, calibration: float, least: float) -> None:
        self.calibration = calibration
        self.least = least

    def of(self, branch: Branch) -> float:
        """Width of a branch. px"""
        return max(self.least, 2.0 * self.calibration * branch.thickness)

    def at(self, graph: Graph, node: int) -> float:
        """Width of the widest line at a node. px"""
        return max(self.of(graph.branches[number]) for number, _ in graph.ends_at(node))


def _leaves(graph: Graph, node: int) -> list[int]:
    """Branches that end at a node and lead nowhere."""
    return [
        number
        for number, end in graph.ends_at(node)
        if graph.branches[number].start != graph.branches[number].stop
        and graph.degree(graph.outward(number, end).stop) == 1
    ]


def _is_stem(graph: Graph, node: int, leaf: int, width: float) -> bool:
    """Whether a leaf at a three-way node is the merged tip of the two others, which meet in a sharp corner."""
    others = [graph.outward(number, end) for number, end in graph.ends_at(node) if number != leaf]
    one, two = (direction(other.line, 0.8 * width, 3.0 * width) for other in others)
    opening = angle_between(one, two)
    if opening >= _SHARP:
        return False
    stem = graph.branches[leaf].leaving(node)
    axis = -(one + two)
    if angle_between(direction(stem.line, 0.0, max(stem.length, 1e-6)), axis) > _OFF_AXIS:
        return False
    merged = (width + 1.0) / (2.0 * np.sin(np.radians(max(opening, 5.0)) / 2.0))
    return bool(stem.length < min(1.3 * merged + 0.5 * width, 8.0 * width))


def _sharpen_corners(graph: Graph, widths: Widths) -> None:
    """Replace a Y whose stem is the tip of a sharp V by the V."""
    for node in graph.nodes():
        leaves = _leaves(graph, node)
        if graph.degree(node) != 3 or len(leaves) == 3:
            continue
        if len({number for number, _ in graph.ends_at(node)}) < 3:
            continue
        width = widths.at(graph, node)
        for leaf in sorted(leaves, key=lambda number: graph.branches[number].length):
            if _is_stem(graph, node, leaf, width):
                tip = graph.remove(leaf).leaving(node).line[-1:]
                graph.dissolve(node, via=tip)
                break


def _drop_spurs(graph: Graph, widths: Widths) -> None:
    """Drop branches that hardly leave the ink of the line that they grow on, the shortest first."""
    while True:
        found = []
        for node in graph.nodes():
            if graph.degree(node) < 3:
                continue
            width = widths.at(graph, node)
            reach = max(graph.radius[node], 0.5 * width) + _SPUR * width
            found += [
                (graph.branches[leaf].length, leaf, node)
                for leaf in _leaves(graph, node)
                if graph.branches[leaf].length < reach
            ]
        if not found:
            return
        _, leaf, node = min(found)
        graph.remove(leaf)
        if graph.degree(node) == 2:
            graph.dissolve(node)


def _join_clusters(graph: Graph, widths: Widths) -> None:
    """Make one node of junctions that lie closer than a line is wide, and drop the small loops between them."""
    while True:
        found = []
        for number, branch in graph.branches.items():
            if min(graph.degree(branch.start), graph.degree(branch.stop)) < 3:
                continue
            width = max(widths.at(graph, branch.start), widths.at(graph, branch.stop))
            limit = 2.0 * _CLUSTER * width if branch.start == branch.stop else _CLUSTER * width
            if branch.length < limit:
                found.append((branch.length, number))
        if not found:
            return
        _, number = min(found)
        node = graph.contract(number)
        if graph.degree(node) == 2:
            graph.dissolve(node)


def _drop_twins(graph: Graph, widths: Widths) -> None:
    """Drop one of two branches between the same junctions that never part by more than their width."""
    for one, two in combinations(sorted(graph.branches), 2):
        if one not in graph.branches or two not in graph.branches:
            continue
        a, b = graph.branches[one], graph.branches[two]
        if {a.start, a.stop} != {b.start, b.stop} or a.start == a.stop:
            continue
        width = min(widths.at(graph, a.start), widths.at(graph, a.stop))
        if max(a.length, b.length) > 4.0 * width:
            continue
        gap = np.linalg.norm(a.line[:, None] - b.line[None], axis=2).min(axis=1).max()
        if gap < 0.8 * width:
            longer = one if a.length > b.length else two
            ends = graph.branches[longer].start, graph.branches[longer].stop
            graph.remove(longer)
            for node in ends:
                if graph.degree(node) == 2:
                    graph.dissolve(node)


def clean(graph: Graph, widths: Widths) -> None:
    """Make the graph say what was drawn, in place.

    Args:
        graph: The graph of a skeleton.
        widths: How wide lines are.
    """
    _sharpen_corners(graph, widths)
    _drop_spurs(graph, widths)
    _sharpen_corners(graph, widths)
    _drop_twins(graph, widths)
    _join_clusters(graph, widths)
    _drop_spurs(graph, widths)
