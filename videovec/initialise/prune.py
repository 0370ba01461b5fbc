"""Clean a skeleton graph of what thinning adds: stems in sharp corners, spurs, and split crossings."""

from __future__ import annotations

from heapq import heapify, heappop, heappush
from itertools import combinations

import numpy as np
from numpy.typing import NDArray

from videovec.initialise.graph import Branch, Graph
from videovec.initialise.polyline import angle_between, direction

__all__ = ["Widths", "clean"]

Floats = NDArray[np.float64]

_SHARP = 75.0  # degrees between two branches below which a leaf between them may be the stem of a sharp corner
_OFF_AXIS = 41.0  # degrees by which the stem may leave the corner's axis
_CLEAR = 1.2  # times the distance from a corner's tip at which its lines part, from which on a skeleton is theirs
_STAR = 2.0  # times the length of the stem that the arms of a V which ends there must have
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


def _opening(graph: Graph, node: int, leaf: int, width: float) -> float | None:
    """Degrees between two branches at a three-way node if a leaf is the merged tip of the corner that they make."""
    others = [graph.outward(number, end) for number, end in graph.ends_at(node) if number != leaf]
    one, two = (direction(other.line, 0.8 * width, 3.0 * width) for other in others)
    opening = angle_between(one, two)
    if opening >= _SHARP:
        return None
    stem = graph.branches[leaf].leaving(node)
    axis = -(one + two)
    if angle_between(direction(stem.line, 0.0, max(stem.length, 1e-6)), axis) > _OFF_AXIS:
        return None
    opening = max(opening, 5.0)
    merged = (width + 1.0) / (2.0 * np.sin(np.radians(opening) / 2.0))
    return opening if stem.length < min(1.3 * merged + 0.5 * width, 8.0 * width) else None


def _sharpen_corners(graph: Graph, widths: Widths) -> None:
    """Replace a Y whose stem is the tip of a sharp V by the V."""
    for node in graph.nodes():
        leaves = sorted(_leaves(graph, node), key=lambda number: graph.branches[number].length)
        if graph.degree(node) != 3 or len({number for number, _ in graph.ends_at(node)}) < 3:
            continue
        if len(leaves) == 3:  # a star: any of the three may be what it is about, but a much shorter one
            is_short = _STAR * graph.branches[leaves[0]].length <= graph.branches[leaves[1]].length
            leaves = leaves[:1] if is_short else []
        width = widths.at(graph, node)
        for leaf in leaves:
            opening = _opening(graph, node, leaf, width)
            if opening is not None:
                tip = graph.remove(leaf).leaving(node).line[-1]
                merged = width / (2.0 * np.tan(np.radians(opening) / 2.0))  # from there on each line has two edges
                reach = min(_CLEAR * merged, 4.0 * width) if width > widths.least else 0.0  # hairlines part at once
                graph.sharpen(node, tip, reach)
                break


def _spurs(graph: Graph, widths: Widths, node: int) -> list[tuple[float, int, int]]:
    """Branches at a node that hardly leave the ink of the line that they grow on: length, number and node."""
    if graph.degree(node) < 3:
        return []
    width = widths.at(graph, node)
    reach = max(graph.radius[node], 0.5 * width) + _SPUR * width
    leaves = _leaves(graph, node)
    return [(graph.branches[leaf].length, leaf, node) for leaf in leaves if graph.branches[leaf].length < reach]


def _drop_spurs(graph: Graph, widths: Widths) -> None:
    """Drop spurs, the shortest first; what is left of a node is looked at again."""
    found = [spur for node in graph.nodes() for spur in _spurs(graph, widths, node)]
    heapify(found)
    while found:
        spur = heappop(found)
        _, leaf, node = spur
        if leaf not in graph.branches or spur not in _spurs(graph, widths, node):
            continue
        graph.remove(leaf)
        for near in _settled(graph, node):
            for again in _spurs(graph, widths, near):
                heappush(found, again)


def _settled(graph: Graph, node: int) -> tuple[int, ...]:
    """Join what is left at a node if it is two branches; the nodes of which a branch or the degree has changed."""
    if graph.degree(node) != 2:
        return (node,)
    around = tuple(graph.outward(*end).stop for end in graph.ends_at(node))
    graph.dissolve(node)
    return around


def _bridge(graph: Graph, widths: Widths, number: int) -> tuple[float, int] | None:
    """Length and number of a branch between two junctions that are one, or of a small loop at one; none of others."""
    branch = graph.branches[number]
    if min(graph.degree(branch.start), graph.degree(branch.stop)) < 3:
        return None
    width = max(widths.at(graph, branch.start), widths.at(graph, branch.stop))
    limit = 2.0 * _CLUSTER * width if branch.start == branch.stop else _CLUSTER * width
    return (branch.length, number) if branch.length < limit else None


def _join_clusters(graph: Graph, widths: Widths) -> None:
    """Make one node of junctions that lie closer than a line is wide, and drop the small loops between them."""
    found = [bridge for number in graph.branches if (bridge := _bridge(graph, widths, number))]
    heapify(found)
    while found:
        bridge = heappop(found)
        if bridge[1] not in graph.branches or bridge != _bridge(graph, widths, bridge[1]):
            continue
        for node in _settled(graph, graph.contract(bridge[1])):
            for number in {end[0] for end in graph.ends_at(node)}:
                if again := _bridge(graph, widths, number):
                    heappush(found, again)


def _drop_twins(graph: Graph, widths: Widths) -> None:
    """Drop one of two branches between the same junctions that never part by more than their width."""
    between: dict[frozenset[int], list[int]] = {}
    for number, branch in sorted(graph.branches.items()):
        if branch.start != branch.stop:
            between.setdefault(frozenset((branch.start, branch.stop)), []).append(number)
    for ends, numbers in between.items():
        for one, two in combinations(numbers, 2):
            if one in graph.branches and two in graph.branches and _are_twins(graph, widths, one, two):
                graph.remove(one if graph.branches[one].length > graph.branches[two].length else two)
                for node in ends:
                    _settled(graph, node)


def _are_twins(graph: Graph, widths: Widths, one: int, two: int) -> bool:
    """Whether two branches between the same nodes are one line that a pinhole splits."""
    a, b = graph.branches[one], graph.branches[two]
    if {a.start, a.stop} != {b.start, b.stop}:
        return False
    width = min(widths.at(graph, a.start), widths.at(graph, a.stop))
    if max(a.length, b.length) > 4.0 * width:
        return False
    gap = np.linalg.norm(a.line[:, None] - b.line[None], axis=2).min(axis=1).max()
    return bool(gap < 0.8 * width)


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
