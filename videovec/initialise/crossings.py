"""Lines of one ink that pass under another ink: put together again across it."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from videovec.initialise.centreline import CentreLine
from videovec.initialise.graph import Graph
from videovec.initialise.junctions import Pairing
from videovec.initialise.polyline import angle_between, arc, end_tangent
from videovec.initialise.prune import Widths

__all__ = ["bridge_gaps", "is_sliver", "lies_amid"]

Floats = NDArray[np.float64]
Coverage = NDArray[np.float32]

_LONGEST = 60.0  # px that a line may be hidden
_LARGEST_TURN = 35.0  # degrees between a line's end and the way to where it goes on
_INKED = 0.4  # coverage on all of that way
_CLOSE = 2.0  # px between ends below which the way between them has no direction
_SLIVER = 1.5  # widths of length below which a stroke amid other ink is a mixture of inks and not a stroke


def _values(coverage: Coverage, points: Floats) -> Coverage:
    """Coverage at points [K, 2] px. [K]"""
    where = (points - 0.5).astype(np.float32)
    return np.asarray(cv2.remap(coverage, where[:, 0], where[:, 1], cv2.INTER_LINEAR).ravel(), dtype=np.float32)


def _turn(one: tuple[Floats, Floats], two: tuple[Floats, Floats], inked: Coverage) -> float:
    """How much a line turns that goes on from one tip (position, outward direction) at another; 180 if it cannot."""
    way = two[0] - one[0]
    gap = float(np.linalg.norm(way))
    turn = angle_between(one[1], -two[1])
    if gap < _CLOSE:
        return turn
    points = one[0] + np.linspace(0.0, 1.0, max(3, round(2.0 * gap)))[:, None] * way
    if float(_values(inked, points).min()) < _INKED:
        return 180.0
    return max(turn, angle_between(one[1], way), angle_between(two[1], -way))


def bridge_gaps(graph: Graph, widths: Widths, inked: Coverage) -> list[Pairing]:
    """Find ends of lines that go on behind other ink.

    Args:
        graph: The lines of one ink.
        widths: How wide they are.
        inked: Coverage by any ink. [H, W]

    Returns:
        A decision for each pair of ends that are one stroke.
    """
    nodes = [node for node in graph.nodes() if graph.degree(node) == 1]
    if len(nodes) < 2:
        return []
    ends = [graph.ends_at(node)[0] for node in nodes]
    tips: list[tuple[Floats, Floats]] = []
    for end in ends:
        branch = graph.outward(*end)
        width = widths.of(branch)
        tips.append((branch.line[0], -end_tangent(branch.line, width, 4.0 * width)))
    pairs = cKDTree(np.stack([tip[0] for tip in tips])).query_pairs(_LONGEST)
    turns = sorted((_turn(tips[i], tips[j], inked), i, j) for i, j in pairs)
    used: set[int] = set()
    found = []
    for turn, i, j in turns:
        if turn > _LARGEST_TURN:
            break
        if not used & {i, j} and ends[i][0] != ends[j][0]:
            used |= {i, j}
            found.append(Pairing(nodes[i], (ends[i], ends[j]), ((0, 1),), (), _LARGEST_TURN - turn))
    return found


def is_sliver(line: CentreLine, width: float, others: Coverage) -> bool:
    """Whether a line is so short, for lines of a width, and so much amid other inks, that it is where they mix."""
    return bool(arc(line.line)[-1] <= _SLIVER * width) and lies_amid(line.line, others)


def lies_amid(points: Floats, others: Coverage) -> bool:
    """Whether points [K, 2] px lie on, or right beside, other inks."""
    reach = cv2.dilate(others, np.ones((3, 3), np.uint8)).astype(np.float32)
    return bool(_values(reach, points).mean() > _INKED)
