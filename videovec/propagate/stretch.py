"""Strokes that are foreshortened: what they are squeezed by as a whole is their shape now, and no bend."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from videovec.propagate.affine import affine_change
from videovec.propagate.nodes import Nodes

__all__ = ["stretched"]

Floats = NDArray[np.float64]
Bools = NDArray[np.bool_]

_SEEN = 0.9
"""Share of a stroke's nodes that must follow the ink for its shape to be known."""
_EXPLAINED = 0.5
"""Share of the squared misfit of a stroke that only turned which a change of size may leave for it to be believed."""
_AS_COMPLEX = np.array([1.0, 1.0j])
_SPREAD = 6.0
"""Spread of a stroke's nodes in a direction up to which its change of size there is not believed. working px"""


def stretched(nodes: Nodes, rest: Floats, positions: Floats, follows: Floats, merged: Bools) -> Floats:
    """Give strokes at rest, where they are, the affine part of the shape that they have now.

    Rigidity holds a disc that turns on edge round, and dents it at its sides; a disc that was squeezed as a whole has
    no reason to be dented.

    Args:
        nodes: N nodes.
        rest: Where they are at rest. [N, 2] working px
        positions: Where registration put them. [N, 2] working px
        follows: 1 for nodes that follow the ink, else 0. [N]
        merged: Nodes that the ink does not tell apart from others'. bool [N]

    Returns:
        Where they are at rest now; strokes of which too little is seen are as they were. [N, 2] working px
    """
    new = rest.copy()
    for start, stop in zip(nodes.starts[:-1], nodes.starts[1:], strict=True):
        own = slice(int(start), int(stop))
        seen = (follows[own] > 0) & ~merged[own]
        if seen.mean() >= _SEEN:
            new[own] = _changed(rest[own], positions[own], seen)
    return new


def _changed(rest: Floats, positions: Floats, seen: Bools) -> Floats:
    """One stroke changed in size, more so in directions in which it is wide, if that is what happened to it."""
    middle = rest[seen].mean(axis=0)
    before = rest[seen] - middle
    after = _turned_back(before, positions[seen] - positions[seen].mean(axis=0))
    change = affine_change(before, after - before, _SPREAD)
    left, whole = np.square(after - before - before @ change).sum(), np.square(after - before).sum()
    return np.asarray(rest + (rest - middle) @ change) if left <= _EXPLAINED * whole else rest


def _turned_back(before: Floats, after: Floats) -> Floats:
    """Vectors without the rotation that best takes others to them."""
    z = after @ _AS_COMPLEX
    turn = np.vdot(before @ _AS_COMPLEX, z)
    z = z * (np.conj(turn) / abs(turn) if abs(turn) > 0 else 1.0)
    return np.stack([z.real, z.imag], axis=1)
