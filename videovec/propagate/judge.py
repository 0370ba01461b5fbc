"""How well placed strokes explain a drawing's ink, and the ink them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from videovec.propagate.covered import find_covered
from videovec.propagate.kernels import nearest, rotations
from videovec.propagate.nodes import Nodes
from videovec.propagate.registration import Source, doubled
from videovec.propagate.target import Target

__all__ = ["Verdict", "between_nodes", "judge"]

Floats = NDArray[np.float64]
Bools = NDArray[np.bool_]

_FAR = 3.5
"""Distance at which ink and stroke have nothing to do with each other. px"""
_TRUNCATION = 10.0
"""Feature distance beyond which a point costs no more. px"""
_DIRECTION = 6.0
"""Weight of direction in the feature distance. px"""
_BENDING = 0.3
"""Weight of the root of the deformation energy; without it a crumpled stroke would win."""
_BENT = 1.0
"""Deformation at which strokes that have ink may be crumpled. px"""
_REACH = 2
"""Nodes on either side of the one that ink has chosen that it claims too."""
_COVERED = 3.0
"""What a node costs at most that lies under something or off the page, and at least one on another stroke's ink. px"""
_APART = 4.0
"""Motion of strokes against each other that costs half of what bending does; no motion costs more than this one. px"""
_STIFFNESS = (1.0, 0.05)
"""Of edges along and between strokes, in the deformation energy."""


@dataclass(frozen=True, slots=True, eq=False)
class Verdict:
    """How well strokes and ink agree.

    Args:
        cost: Mean truncated feature distance both ways and deformation; the lower the better. px
        node_cost: Truncated feature distance of each node to the ink. [N] px
        ink_cost: Truncated feature distance of each centre-line point to the strokes. [M] px
        node_far: Which nodes have no ink near them. bool [N]
        ink_far: Which centre-line points have no stroke near them. bool [M]
        bend: Deformation energy of each node. [N] px²
        hidden: Nodes on the page that follow no ink. bool [N]
    """

    cost: float
    node_cost: Floats
    ink_cost: Floats
    node_far: Bools
    ink_far: Bools
    bend: Floats
    hidden: Bools

    def is_accepted(self, share: float) -> bool:
        """Whether there is hardly any ink left to find, or no stroke that could be sent for it.

        Args:
            share: Share of ink without strokes, and of nodes without ink, that is let pass.
        """
        if not len(self.node_far) or not len(self.ink_far) or self.ink_far.mean() <= share:
            return True
        return bool(np.mean(self.node_far) <= share and np.sqrt(np.mean(self.bend)) <= _BENT)


def between_nodes(nodes: Nodes, positions: Floats) -> tuple[Floats, NDArray[np.intp]]:
    """Nodes and the middles of their edges, which are a denser picture of the strokes.

    Returns:
        Positions and the node of each. [K, 2], int [K]
    """
    edges = nodes.hop(1)
    middle = 0.5 * (positions[edges[:, 0]] + positions[edges[:, 1]])
    owner = np.concatenate([np.arange(len(nodes)), edges[:, 0]])
    return np.concatenate([positions, middle]), owner


def judge(source: Source, target: Target, positions: Floats) -> Verdict:
    """Measure a placement of nodes.

    Args:
        source: The strokes at rest.
        target: The drawing's ink.
        positions: Where the nodes were put. [N, 2] working px

    Returns:
        The verdict; nodes that do not follow the ink cost nothing, but ink at those that are held is explained.
    """
    counts = source.weight > 0
    stands = counts | (source.hold > 0)
    bend, on_page = _bending(source, positions), target.on_page(positions)
    if not len(target) or not stands.any():
        nothing = np.full(len(positions), _TRUNCATION), np.full(len(target), _TRUNCATION)
        far = counts.copy(), np.ones(len(target), bool)
        return Verdict(2 * _TRUNCATION, *nothing, *far, bend, ~counts & on_page)
    tangent = source.nodes.tangents(positions)
    dense, owner = between_nodes(source.nodes, positions)
    features = np.concatenate([dense, _DIRECTION * doubled(tangent)[owner]], axis=1)
    own, features = features[: len(positions)][counts], features[stands[owner]]
    ink = np.concatenate([target.points, _DIRECTION * doubled(target.direction)], axis=1)
    _, to_ink = nearest(own, ink, np.zeros(len(own), np.int64))
    chosen, to_node = nearest(ink, features, np.zeros(len(ink), np.int64))
    node_cost = np.zeros(len(positions))
    node_cost[counts] = np.minimum(np.sqrt(to_ink), _TRUNCATION)
    ink_cost = np.minimum(np.sqrt(to_node), _TRUNCATION)
    _, gap = nearest(target.points, np.ascontiguousarray(features[:, :2]), np.zeros(len(ink), np.int64))
    node_far = counts & (target.distance_at(positions) > _FAR)
    covered = find_covered(source.nodes, positions, node_far, target) | ~on_page
    node_cost[covered] = np.minimum(node_cost[covered], _COVERED)
    is_own = claimed(owner[stands[owner]][chosen], source.nodes)
    node_cost[counts & ~is_own] = np.maximum(node_cost[counts & ~is_own], _COVERED)
    node_far &= ~covered
    cost = float(_mean(node_cost[counts]) + ink_cost.mean() + _BENDING * np.sqrt(_mean(bend[counts])))
    return Verdict(cost, node_cost, ink_cost, node_far, gap > _FAR**2, bend, ~counts & on_page)


def claimed(chosen: NDArray[np.intp], nodes: Nodes) -> Bools:
    """Nodes that some ink chose as its nearest, and their neighbours. bool [N]"""
    is_own = np.zeros(len(nodes), bool)
    is_own[chosen] = True
    for _ in range(_REACH):
        is_own = is_own | is_own[nodes.before] | is_own[nodes.after]
    return is_own


def _mean(values: Floats) -> float:
    """Nothing costs nothing."""
    return float(values.mean()) if len(values) else 0.0


def _bending(source: Source, positions: Floats) -> Floats:
    """As-rigid-as-possible energy of every node. [N] px²"""
    indptr, index, weight = source.stiffness(*_STIFFNESS)
    turn = rotations(positions, source.rest, indptr, index, weight, 1.0, 1.0)
    own = np.repeat(np.arange(len(positions)), np.diff(indptr))
    rest, now = source.rest[index] - source.rest[own], positions[index] - positions[own]
    re, im = turn[own, 0], turn[own, 1]
    turned = np.stack([re * rest[:, 0] - im * rest[:, 1], im * rest[:, 0] + re * rest[:, 1]], axis=1)
    squared = ((now - turned) ** 2).sum(axis=1)
    apart = _STIFFNESS[1] * source.across / (1.0 + squared / _APART**2)
    energy = (_STIFFNESS[0] * source.along + apart) * squared
    return np.asarray(np.bincount(own, energy, minlength=len(positions)), np.float64)
