"""Strokes that pass before others: the edges of what hides, told by the lines that end at them.

An edge that hid something is in front from then on. What it passes over is hidden, not drawn along, and its ink is
nobody else's: a limb that runs almost along the edge would else be explained by it.
"""

from __future__ import annotations

from dataclasses import replace

import cv2
import numpy as np
from numpy.typing import NDArray

from videovec.propagate.gaps import runs
from videovec.propagate.judge import between_nodes
from videovec.propagate.kernels import nearest
from videovec.propagate.nodes import Nodes
from videovec.propagate.registration import Source
from videovec.propagate.residual import restricted
from videovec.propagate.target import Target

__all__ = ["behind", "covering", "ends_missing", "passed_over", "untied", "without"]

Floats = NDArray[np.float64]
Bools = NDArray[np.bool_]

_AT = 3.0
"""How near the line of what hides it a stroke ends, beyond that line's half-width. working px"""
_INSIDE = 3.0
"""How far within the line that point lies, in its half-widths: a stroke that ends at another's end is not hidden."""
_ACROSS = 0.9
"""Cosine of the smallest angle between a stroke and what hides it."""
_MISSING = 8.0
"""Length that is missing of a stroke beyond the line that hides it. working px"""
_BESIDE = 1.5
"""How far from the middle of a line its own ink lies, at most. working px"""
_ALONG = 0.8
"""Cosine of the largest angle between a line and its own ink."""
_FAR = 60.0
"""How far from an edge what it passed over lies at most. working px"""
_HELD = 10.0
"""Stiffness with which strokes in front are held where they are, against 1 of the ink's pull."""


def covering(
    nodes: Nodes,
    positions: Floats,
    half_width: Floats,
    shown: Bools,
    missing: list[list[tuple[int, int]]],
) -> Bools:
    """Say which strokes hide others: where what is seen of a stroke ends within the line of another.

    Args:
        nodes: N nodes.
        positions: Where they are. [N, 2] working px
        half_width: Of each stroke. [S] working px
        shown: Nodes in seen parts of their strokes. bool [N]
        missing: For each stroke, the last seen node before a part that is missing and the step towards it. S of them

    Returns:
        Which strokes hide something. bool [S]
    """
    covers = np.zeros(len(nodes.bases), bool)
    dense, owner = between_nodes(nodes, positions)
    tangent = nodes.tangents(positions)
    for s, places in enumerate(missing):
        others = shown[owner] & (nodes.stroke[owner] != s)
        if not others.any():
            break
        for node, step in places:
            inside = int(np.clip(node - step, 0, len(positions) - 1))
            reach = float(np.linalg.norm(positions[node] - positions[inside]))
            end = positions[node] + 0.5 * (positions[node + step] - positions[node])
            gap = np.linalg.norm(dense[others] - end, axis=1)
            nearest_node = int(owner[others][int(gap.argmin())])
            t = int(nodes.stroke[nearest_node])
            near = float(gap.min()) <= half_width[t] + _AT + 0.5 * min(reach, 4.0)
            ends = positions[[nodes.starts[t], nodes.starts[t + 1] - 1]]
            inner = nodes.bases[t].is_closed or np.linalg.norm(ends - end, axis=1).min() > _INSIDE * half_width[t]
            covers[t] |= bool(near and inner and abs(tangent[node] @ tangent[nearest_node]) < _ACROSS)
    return covers


def ends_missing(nodes: Nodes, positions: Floats, shown: Bools, most_seen: Floats) -> list[list[tuple[int, int]]]:
    """The last seen node before each part that was seen once and is not now, and the step towards that part.

    Args:
        nodes: N nodes.
        positions: Where they are. [N, 2] working px
        shown: Nodes in seen parts of their strokes. bool [N]
        most_seen: The most that was ever seen of each stroke, as arc fractions. [S, 2]
    """
    step_length = np.linalg.norm(positions[nodes.after] - positions, axis=1)
    found: list[list[tuple[int, int]]] = []
    for s in range(len(nodes.bases)):
        own = slice(int(nodes.starts[s]), int(nodes.starts[s + 1]))
        known = (nodes.u[own] >= most_seen[s, 0] - 1e-9) & (nodes.u[own] <= most_seen[s, 1] + 1e-9)
        places = []
        for first, last in runs(~shown[own] & known):
            if step_length[own][first : last + 1].sum() < _MISSING:
                continue
            if first > 0 and shown[own][first - 1]:
                places.append((own.start + first - 1, 1))
            if last + 1 < len(known) and shown[own][last + 1]:
                places.append((own.start + last + 1, -1))
        found.append(places)
    return found


def passed_over(nodes: Nodes, ways: tuple[Floats, Floats], edges: Floats, front: Bools) -> Bools:
    """Nodes that come to lie on the other side of strokes in front.

    Args:
        nodes: N nodes.
        ways: Where all nodes were, and where they would go by themselves. [N, 2] each, working px
        edges: Where the nodes of strokes in front go. [N, 2] working px
        front: Which strokes are in front. bool [S]

    Returns:
        Nodes of other strokes over which an odd number of edges passed. bool [N]
    """
    before, onward = ways
    passed = np.zeros(len(nodes), bool)
    for s in np.flatnonzero(front).tolist():
        own = slice(int(nodes.starts[s]), int(nodes.starts[s + 1]))
        is_closed = nodes.bases[s].is_closed
        then, now = _side(before, before[own], is_closed), _side(onward, edges[own], is_closed)
        passed ^= then * now < 0
    return passed & ~front[nodes.stroke]


def _side(points: Floats, edge: Floats, is_closed: bool) -> Floats:
    """1 on one side of a line, -1 on the other, 0 where that is not known. [N]"""
    if is_closed:
        ring = np.ascontiguousarray(edge[:, None], np.float32)
        return np.array([np.sign(cv2.pointPolygonTest(ring, (float(x), float(y)), False)) for x, y in points])
    start, span = edge[:-1], np.diff(edge, axis=0)
    arm = points[:, None] - start
    t = (arm * span).sum(2) / np.maximum((span**2).sum(1), 1e-9)
    gap = np.linalg.norm(arm - np.clip(t, 0, 1)[..., None] * span, axis=2)
    own, at = np.arange(len(points)), gap.argmin(axis=1)
    cross = span[at, 0] * arm[own, at, 1] - span[at, 1] * arm[own, at, 0]
    beyond = ((at == 0) & (t[own, at] < 0)) | ((at == len(span) - 1) & (t[own, at] > 1))
    return np.asarray(np.where(beyond | (gap[own, at] > _FAR), 0.0, np.sign(cross)))


def without(target: Target, nodes: Nodes, positions: Floats, half_width: Floats, front: Bools) -> Target:
    """The drawing without the ink of strokes in front.

    Args:
        target: The drawing.
        nodes: N nodes.
        positions: Where they are. [N, 2] working px
        half_width: Of each stroke. [S] working px
        front: Which strokes are in front. bool [S]
    """
    dense, owner = between_nodes(nodes, positions)
    own = front[nodes.stroke[owner]]
    if not own.any() or not len(target):
        return target
    dense, owner = np.ascontiguousarray(dense[own]), owner[own]
    found, squared = nearest(target.points, dense, np.zeros(len(target), np.int64))
    tangent = nodes.tangents(positions)[owner[found]]
    beside = squared <= (_BESIDE + 0.5 * half_width[nodes.stroke[owner[found]]]) ** 2
    return restricted(target, ~(beside & (np.abs((target.direction * tangent).sum(1)) >= _ALONG)))


def behind(source: Source, positions: Floats, front: Bools, passed: Bools) -> Source:
    """The source with strokes in front held where they are, untied from others, which do not follow what hides them.

    Args:
        source: Strokes at rest.
        positions: Where those in front are. [N, 2] working px
        front: Which strokes are in front. bool [S]
        passed: Nodes that something passed over. bool [N]
    """
    is_front = front[source.nodes.stroke]
    return replace(
        untied(source, front),
        weight=np.where(is_front | passed, 0.0, source.weight),
        hold=np.where(is_front, _HELD, np.where(passed, 0.0, source.hold)),
        goal=np.where(is_front[:, None], positions, source.goal),
    )


def untied(source: Source, front: Bools) -> Source:
    """The source without ties between strokes in front and others."""
    is_front = front[source.nodes.stroke]
    own = np.repeat(np.arange(len(is_front)), np.diff(source.indptr))
    return replace(source, across=np.where(is_front[own] != is_front[source.index], 0.0, source.across))
