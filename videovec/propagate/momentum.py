"""Strokes whose ink runs together: where it cannot tell lines apart, each goes on as it went.

The sides of a disc that turns on edge become one blot, as does an arm that swings past the body. The centre line of
a blot is no stroke's own, so strokes are not drawn to it; they are where they would be if they moved on as before.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from videovec.propagate.nodes import Nodes

__all__ = ["Momentum", "affine_part", "merged_nodes", "momentum_of"]

Floats = NDArray[np.float64]
Bools = NDArray[np.bool_]

_GAP = 1.0
"""Width of bare paper between two lines below which they are one blot. working px"""
_PARALLEL = 0.8
"""Cosine of the largest angle between lines that run together."""
_AWAY = 3.0
"""How far along a stroke its own parts must lie from each other to be two lines, in distances at which they merge."""
_MOST = 0.4
"""Share of a stroke's nodes that must run together with others for it to go on as it went."""
_RIDGE = 6.0
"""Spread of a stroke's nodes in a direction below which its change of size there is not believed. working px"""
_STIFFNESS = 0.3
"""Of the pull of where a node is expected, against 1 of the ink's."""


@dataclass(frozen=True, slots=True, eq=False)
class Momentum:
    """Where strokes would be if they went on as they did, and where only that tells where they are.

    Args:
        goal: Where nodes are expected. [N, 2] working px
        moves: Whether a stroke goes on as it went. bool [S]
        merged: Nodes of such strokes that run together with others where they are expected. bool [N]
    """

    goal: Floats
    moves: Bools
    merged: Bools

    def hold(self) -> Floats:
        """Stiffness with which nodes are held at the goal. [N]"""
        return _STIFFNESS * self.merged


def momentum_of(nodes: Nodes, now: Floats, drift: Floats, half_width: Floats, may: Bools) -> Momentum:
    """Say which strokes go on as they went.

    Args:
        nodes: N nodes.
        now: Where they are. [N, 2] working px
        drift: How far each would go. [N, 2] working px
        half_width: Half-width of each stroke. [S] working px
        may: Strokes that may go on without ink of their own. bool [S]

    Returns:
        Their momentum.
    """
    goal = now + drift
    merged = merged_nodes(nodes, goal, half_width)
    share = np.maximum(_shares(nodes, merged), _shares(nodes, merged_nodes(nodes, now, half_width)))
    moves = may & (share >= _MOST)
    return Momentum(goal, moves, merged & moves[nodes.stroke])


def _shares(nodes: Nodes, values: Bools) -> Floats:
    """Mean over the nodes of each stroke. [S]"""
    count = len(nodes.bases)
    size = np.maximum(np.bincount(nodes.stroke, minlength=count), 1)
    return np.asarray(np.bincount(nodes.stroke, values, minlength=count) / size)


def merged_nodes(nodes: Nodes, positions: Floats, half_width: Floats) -> Bools:
    """Nodes beside which another line runs so near that there is no paper between. bool [N]

    Args:
        nodes: N nodes.
        positions: Where they are. [N, 2] working px
        half_width: Half-width of each stroke. [S] working px
    """
    merged = np.zeros(len(nodes), bool)
    if not len(nodes):
        return merged
    width = half_width[nodes.stroke]
    pairs = cKDTree(positions).query_pairs(2.0 * float(width.max()) + _GAP, output_type="ndarray")
    a, b = pairs.T
    tangent = nodes.tangents(positions)
    reach = width[a] + width[b] + _GAP
    beside = np.linalg.norm(positions[a] - positions[b], axis=1) <= reach
    beside &= np.abs((tangent[a] * tangent[b]).sum(1)) >= _PARALLEL
    beside &= (nodes.stroke[a] != nodes.stroke[b]) | (_along(nodes, positions, a, b) >= _AWAY * reach)
    merged[a[beside]] = merged[b[beside]] = True
    return merged


def _along(nodes: Nodes, positions: Floats, a: NDArray[np.intp], b: NDArray[np.intp]) -> Floats:
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
    normal = centred.T @ centred + len(positions) * (_RIDGE**2 * 0.1) * np.eye(2)
    change = np.linalg.solve(normal, centred.T @ velocity)
    return np.asarray(velocity.mean(axis=0) + centred @ change)


def stretched(nodes: Nodes, rest: Floats, positions: Floats, weight: Floats) -> Floats:
    """Strokes at rest in the shape that they are seen in now: each mapped affinely. [N, 2] px"""
    new = rest.copy()
    for s in range(len(nodes.bases)):
        own = slice(int(nodes.starts[s]), int(nodes.starts[s + 1]))
        seen = weight[own] > 0
        if seen.mean() < 0.9:
            continue
        middle, there = rest[own][seen].mean(0), positions[own][seen].mean(0)
        a, b = rest[own][seen] - middle, positions[own][seen] - there
        z, w = a @ np.array([1, 1j]), b @ np.array([1, 1j])
        turn = np.vdot(z, w)
        turn = turn / abs(turn) if abs(turn) > 1e-9 else 1.0
        r = np.array([[turn.real, turn.imag], [-turn.imag, turn.real]])
        a = a @ r
        normal = a.T @ a + len(a) * _RIDGE**2 * np.eye(2)
        change = np.linalg.solve(normal, a.T @ (b - a))
        new[own] = there + ((rest[own] - middle) @ r) @ (np.eye(2) + change)
    return new
