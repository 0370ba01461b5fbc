"""Strokes whose ink runs together: where it cannot tell lines apart, each goes on as it went.

The sides of a disc that turns on edge become one blot, as does an arm that swings past the body. The centre line of
a blot is no stroke's own, so strokes are not drawn to it; they are where they would be if they moved on as before.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from videovec.propagate.affine import affine_change
from videovec.propagate.nodes import Nodes
from videovec.propagate.registration import Source

__all__ = ["PATIENCE", "Momentum", "affine_part", "merged_nodes", "momentum_of"]

Floats = NDArray[np.float64]
Bools = NDArray[np.bool_]
Ints = NDArray[np.intp]

_GAP = 1.0
"""Width of bare paper between two lines below which they are one blot. working px"""
_PARALLEL = 0.8
"""Cosine of the largest angle between lines that run together."""
_AWAY = 3.0
"""How far along a stroke its own parts must lie from each other to be two lines, in distances at which they merge."""
_MOST = 0.4
"""Share of a stroke's nodes that must run together with others for it to go on as it went."""
_SPREAD = 2.0
"""Spread of a stroke's nodes in a direction up to which its change of size there is not believed. working px"""
PATIENCE = 6
"""For how many drawings a stroke may not be told apart before it is drawn to the ink again."""
_MEETS = 6
"""For how many drawings two lines run together at most that pass each other: slower ones go side by side."""
_STIFFNESS = 0.3
"""Of the pull of where a node is expected, against 1 of the ink's."""


@dataclass(frozen=True, slots=True, eq=False)
class Momentum:
    """Where strokes would be if they went on as they did, and where only that tells where they are.

    Args:
        goal: Where nodes are expected. [N, 2] working px
        moves: Strokes that go on as they went. bool [S]
        merged: Nodes of such strokes that run together with others where they are expected. bool [N]
        waits: For how many drawings strokes have not been told apart from others, with this one. int [S]
    """

    goal: Floats
    moves: Bools
    merged: Bools
    waits: Ints

    def hold(self) -> Floats:
        """Stiffness with which nodes are held at the goal. [N]"""
        return np.where(self.merged, _STIFFNESS, 0.0)

    def is_blind(self, own: slice) -> bool:
        """Whether the ink says little of the stroke of some nodes."""
        return bool(self.merged[own].mean() >= _MOST)


def momentum_of(source: Source, drift: Floats, half_width: Floats, waited: Ints) -> Momentum:
    """Say which strokes go on as they went: those that were told apart from others, but no longer are, or will not be.

    Args:
        source: The strokes where they are.
        drift: How far each node would go. [N, 2] working px
        half_width: Half-width of each stroke. [S] working px
        waited: For how many drawings each stroke has not been told apart. int [S]

    Returns:
        Their momentum.
    """
    nodes, goal, drawn = source.nodes, source.rest + drift, source.weight > 0
    merged = merged_nodes(nodes, goal, drift, half_width, drawn)
    is_blind = nodes.shares(merged_nodes(nodes, source.rest, drift, half_width, drawn)) >= _MOST
    waits = np.where(is_blind, waited + 1, 0)
    moves = (is_blind | (nodes.shares(merged) >= _MOST)) & (waits < PATIENCE)
    return Momentum(goal, moves, merged & moves[nodes.stroke], waits)


def merged_nodes(nodes: Nodes, positions: Floats, drift: Floats, half_width: Floats, drawn: Bools) -> Bools:
    """Nodes beside which a line that comes or goes runs so near that there is no paper between. bool [N]

    Lines that go side by side keep their distance by what ties them; if they went on as they did, they would slide.

    Args:
        nodes: N nodes.
        positions: Where they are. [N, 2] working px
        drift: How far each goes in a step. [N, 2] working px
        half_width: Half-width of each stroke. [S] working px
        drawn: Nodes in seen parts of their strokes. bool [N]
    """
    merged = np.zeros(len(nodes), bool)
    if not len(nodes):
        return merged
    width = half_width[nodes.stroke]
    pairs = cKDTree(positions).query_pairs(2.0 * float(width.max()) + _GAP, output_type="ndarray")
    a, b = pairs[drawn[pairs].all(axis=1)].T
    tangent = nodes.tangents(positions)
    reach = width[a] + width[b] + _GAP
    beside = np.linalg.norm(positions[a] - positions[b], axis=1) <= reach
    beside &= np.abs((tangent[a] * tangent[b]).sum(1)) >= _PARALLEL
    beside &= (nodes.stroke[a] != nodes.stroke[b]) | (_along(nodes, positions, a, b) >= _AWAY * reach)
    beside &= _approach((tangent[a], tangent[b]), drift[a] - drift[b]) >= reach / _MEETS
    merged[a[beside]] = merged[b[beside]] = True
    return merged


def _approach(tangents: tuple[Floats, Floats], drift: Floats) -> Floats:
    """How fast lines come nearer across themselves, or part; ``drift`` is of one against the other. [K] working px"""
    one, two = tangents
    along = one + np.where((one * two).sum(1) < 0, -1.0, 1.0)[:, None] * two
    along /= np.maximum(np.linalg.norm(along, axis=1), 1e-9)[:, None]
    return np.abs(along[:, 0] * drift[:, 1] - along[:, 1] * drift[:, 0])


def _along(nodes: Nodes, positions: Floats, a: Ints, b: Ints) -> Floats:
    """How far along their stroke pairs of its nodes lie from each other. working px"""
    step = np.linalg.norm(positions[nodes.after] - positions, axis=1)
    run = np.concatenate([[0.0], np.cumsum(step)])
    between = np.abs(run[b] - run[a])
    closed = np.array([basis.is_closed for basis in nodes.bases], bool)[nodes.stroke[a]]
    whole = (run[nodes.starts[1:]] - run[nodes.starts[:-1]])[nodes.stroke[a]]
    return np.asarray(np.where(closed, np.minimum(between, np.abs(whole - between)), between))


def affine_part(positions: Floats, velocity: Floats) -> Floats:
    """The part of a stroke's motion that is an affine map of it. [n, 2] px

    Args:
        positions: Its nodes. [n, 2] px
        velocity: How far each went. [n, 2] px
    """
    centred = positions - positions.mean(axis=0)
    return np.asarray(velocity.mean(axis=0) + centred @ affine_change(centred, velocity, _SPREAD))
