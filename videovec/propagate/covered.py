"""Strokes that go under a line: what they lose there is hidden, not elsewhere."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from videovec.propagate.gaps import runs
from videovec.propagate.nodes import Nodes
from videovec.propagate.target import Target

__all__ = ["find_covered"]

Floats = NDArray[np.float64]
Bools = NDArray[np.bool_]

_LEFT = 4
"""Nodes with ink before the line that covers the rest, at least."""
_NEAR = 6.0
"""How near the last of them must come to that line. working px"""
_ACROSS = 0.85
"""Cosine of the smallest angle at which a line crosses a stroke that it covers."""


def find_covered(nodes: Nodes, positions: Floats, far: Bools, target: Target) -> Bools:
    """Nodes without ink from where a line crosses their stroke, of which enough is seen before it.

    Args:
        nodes: N nodes.
        positions: Where they are. [N, 2] working px
        far: Which have no ink near them. bool [N]
        target: The drawing.

    Returns:
        Which nodes are covered. bool [N]
    """
    covered = np.zeros(len(nodes), bool)
    if not len(target):
        return covered
    tangent = nodes.tangents(positions)
    for s in np.unique(nodes.stroke[far]).tolist():
        begin, end = int(nodes.starts[s]), int(nodes.starts[s + 1])
        for first, last in runs(far[begin:end]):
            sides = ((begin + first, -1, begin - 1), (begin + last, 1, end))
            if any(_goes_under(side, far, positions, tangent, target) for side in sides):
                covered[begin + first : begin + last + 1] = True
    return covered


def _goes_under(side: tuple[int, int, int], far: Bools, positions: Floats, tangent: Floats, target: Target) -> bool:
    """Whether a line crosses a stroke between a node without ink and its neighbour in a direction, with ink beyond."""
    node, step, stop = side
    before = np.arange(node + step, stop, step)[:_LEFT]
    if len(before) < _LEFT or far[before].any():
        return False
    middle = 0.5 * (positions[node] + positions[before[0]])
    near = np.linalg.norm(target.points - middle, axis=1) <= _NEAR
    return bool((np.abs(target.direction[near] @ tangent[before[1]]) < _ACROSS).any())
