"""Strokes that are foreshortened: what they are squeezed by as a whole is their shape now, and no bend."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from videovec.propagate.nodes import Nodes

__all__ = ["stretched"]

Floats = NDArray[np.float64]
Bools = NDArray[np.bool_]

_SEEN = 0.9
"""Share of a stroke's nodes that must follow the ink for its shape to be known."""
_FEWEST = 3
"""Seen nodes from which it can be told how a stroke moved; if there are fewer, hidden ones are believed too."""
_AS_COMPLEX = np.array([1.0, 1.0j])
_SPREAD = 6.0
"""Spread of a stroke's nodes in a direction up to which its change of size there is not believed. working px"""


def stretched(nodes: Nodes, rest: Floats, positions: Floats, follows: Floats, merged: Bools) -> Floats:
    """Bring strokes at rest to where they are now, in the affine part of the shape that they have there.

    Rigidity holds a disc that turns on edge round, and dents it at its sides; a disc that was squeezed as a whole has
    no reason to be dented.

    Args:
        nodes: N nodes.
        rest: Where they are at rest. [N, 2] working px
        positions: Where registration put them. [N, 2] working px
        follows: 1 for nodes that follow the ink, else 0. [N]
        merged: Nodes that the ink does not tell apart from others'; strokes with many of them are at rest already
            where they are expected. bool [N]

    Returns:
        Where they are at rest now; strokes of which too little is seen keep their shape. [N, 2] working px
    """
    new = rest.copy()
    for start, stop in zip(nodes.starts[:-1], nodes.starts[1:], strict=True):
        own = slice(int(start), int(stop))
        if merged[own].mean() > 1.0 - _SEEN:
            continue
        seen = (follows[own] > 0) & ~merged[own]
        share = float(seen.mean())
        if seen.sum() < _FEWEST:
            seen = np.ones(len(seen), bool)
        new[own] = _brought(rest[own], positions[own], seen, share >= _SEEN)
    return new


def _brought(rest: Floats, positions: Floats, seen: Bools, may_change: bool) -> Floats:
    """One stroke, turned and shifted, and changed in size, more so in directions in which it is wide."""
    middle, there = rest[seen].mean(axis=0), positions[seen].mean(axis=0)
    z = (rest - middle) @ _AS_COMPLEX
    after = positions[seen] - there
    turn = np.vdot(z[seen], after @ _AS_COMPLEX)
    z = z * (turn / abs(turn) if abs(turn) > 0 else 1.0)
    turned = np.stack([z.real, z.imag], axis=1)
    if may_change:
        before = turned[seen]
        normal = before.T @ before + len(before) * _SPREAD**2 * np.eye(2)
        turned = turned + turned @ np.linalg.solve(normal, before.T @ (after - before))
    return np.asarray(there + turned)
