"""Strokes that are foreshortened: what they are squeezed by as a whole is their shape now, and no bend."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from videovec.propagate.nodes import Nodes

__all__ = ["stretched"]

Floats = NDArray[np.float64]

_SEEN = 0.9
"""Share of a stroke's nodes that must follow the ink for its shape to be known."""
_SPREAD = 6.0
"""Spread of a stroke's nodes in a direction up to which its change of size there is not believed. working px"""


def stretched(nodes: Nodes, rest: Floats, positions: Floats, follows: Floats) -> Floats:
    """Give strokes at rest the affine part of where they are now.

    Rigidity holds a disc that turns on edge round, and dents it at its sides; a disc that was squeezed as a whole has
    no reason to be dented.

    Args:
        nodes: N nodes.
        rest: Where they are at rest. [N, 2] working px
        positions: Where registration put them. [N, 2] working px
        follows: 1 for nodes that follow the ink, else 0. [N]

    Returns:
        Where they are at rest now; strokes of which too little is seen are as they were. [N, 2] working px
    """
    new = rest.copy()
    for start, stop in zip(nodes.starts[:-1], nodes.starts[1:], strict=True):
        own, seen = slice(int(start), int(stop)), follows[start:stop] > 0
        if seen.mean() >= _SEEN:
            new[own] = _mapped(rest[own], positions[own], seen)
    return new


def _mapped(rest: Floats, positions: Floats, seen: NDArray[np.bool_]) -> Floats:
    """One stroke, turned as it was and then changed in size, more so in directions in which it is wide."""
    middle, there = rest[seen].mean(axis=0), positions[seen].mean(axis=0)
    turned = _turned(rest - middle, rest[seen] - middle, positions[seen] - there)
    a, b = turned[seen], positions[seen] - there
    change = np.linalg.solve(a.T @ a + len(a) * _SPREAD**2 * np.eye(2), a.T @ (b - a))
    return np.asarray(there + turned + turned @ change)


def _turned(points: Floats, before: Floats, after: Floats) -> Floats:
    """Points turned by the rotation that best takes some vectors to others."""
    turn = np.vdot(before @ _IMAGINARY, after @ _IMAGINARY)
    turn = turn / abs(turn) if abs(turn) > 0 else 1.0 + 0.0j
    z = (points @ _IMAGINARY) * turn
    return np.stack([z.real, z.imag], axis=1)


_IMAGINARY = np.array([1.0, 1.0j])
