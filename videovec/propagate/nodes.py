"""Nodes: material points on strokes, through which strokes are moved."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from videovec.curves import arc_length, parameter_at
from videovec.strokes import Strokes

__all__ = ["Basis", "Nodes", "bases_of", "basis_of", "gather"]

Floats = NDArray[np.float64]
Ints = NDArray[np.intp]

_SMOOTHING = 0.02
"""Weight of differences between the displacements of neighbouring control points, against 1 for each node."""
_REPEATS = 5
"""How often the nodes' displacements are brought back to control points."""
_FEWEST = 3
"""Nodes of the shortest stroke."""


@dataclass(frozen=True, slots=True, eq=False)
class Basis:
    """How the nodes of one stroke hang on its control points, and how they move them.

    Args:
        u: Arc fraction of each node when it was placed. [n]
        weights: Node positions are these times the control points. [n, p]
        inverse: Control-point displacements are these times the node displacements. [p, n]
        is_closed: Whether the last node is a neighbour of the first.
    """

    u: Floats
    weights: Floats
    inverse: Floats
    is_closed: bool


def basis_of(points: Floats, spacing: float, is_closed: bool) -> Basis:
    """Place nodes along a stroke at equal steps of arc length.

    Args:
        points: Control points. [3n+1, 2] px
        spacing: Wanted distance between neighbouring nodes. px
        is_closed: Whether the last control point is the first.

    Returns:
        Nodes; displacements go back to control points by least squares with a little smoothing, since nodes may be
        fewer than control points.
    """
    length = arc_length(points)
    steps = max(_FEWEST, round(length / spacing))
    u = np.arange(steps) / steps if is_closed else np.linspace(0.0, 1.0, steps)
    count = (len(points) - 1) // 3
    if length > 1e-6:
        segment, t = parameter_at(points, u)
    else:
        segment = np.minimum((u * count).astype(np.intp), count - 1)
        t = u * count - segment
    weights = np.zeros((len(u), len(points)))
    bernstein = np.stack([(1 - t) ** 3, 3 * (1 - t) ** 2 * t, 3 * (1 - t) * t**2, t**3], axis=1)
    for i in range(4):
        weights[np.arange(len(u)), 3 * segment + i] += bernstein[:, i]
    fold = np.eye(len(points))
    if is_closed:
        fold[-1, 0] = 1.0
        fold = fold[:, :-1]
    free = weights @ fold
    difference = np.diff(fold, axis=0)
    normal = free.T @ free + _SMOOTHING * difference.T @ difference
    inverse = fold @ np.linalg.solve(normal + 1e-9 * np.eye(len(normal)), free.T)
    return Basis(u, weights, inverse, is_closed)


@dataclass(frozen=True, eq=False)
class Nodes:
    """N nodes on the S strokes of one drawing.

    Args:
        bases: The nodes of each stroke. S of them
        weights: All bases in one block-diagonal matrix. sparse [N, P]
        inverse: All inverses likewise. sparse [P, N]
    """

    bases: tuple[Basis, ...]
    weights: sparse.csr_matrix
    inverse: sparse.csr_matrix

    def __len__(self) -> int:
        """N."""
        return int(self.weights.shape[0])

    @cached_property
    def starts(self) -> Ints:
        """Node at which each stroke begins, then N. int [S+1]"""
        return np.concatenate([[0], np.cumsum([len(b.u) for b in self.bases])]).astype(np.intp)

    @cached_property
    def stroke(self) -> Ints:
        """Stroke of each node. int [N]"""
        return np.repeat(np.arange(len(self.bases)), np.diff(self.starts))

    @cached_property
    def u(self) -> Floats:
        """Arc fraction of each node. [N]"""
        return np.concatenate([np.zeros(0), *(b.u for b in self.bases)])

    @cached_property
    def before(self) -> Ints:
        """The neighbour towards the start of the stroke; an end is its own. int [N]"""
        return self._neighbour(-1)

    @cached_property
    def after(self) -> Ints:
        """The neighbour towards the end of the stroke; an end is its own. int [N]"""
        return self._neighbour(1)

    @cached_property
    def is_end(self) -> NDArray[np.bool_]:
        """Whether a node is an end of an open stroke. bool [N]"""
        own = np.arange(len(self))
        return np.asarray((self.before == own) | (self.after == own))

    def hop(self, distance: int) -> Ints:
        """Pairs of nodes that lie so many steps apart on one stroke. int [E, 2]"""
        pairs = []
        for start, basis in zip(self.starts, self.bases, strict=False):
            n = len(basis.u)
            first = np.arange(n if basis.is_closed and n > 2 * distance else max(n - distance, 0))
            pairs.append(start + np.stack([first, (first + distance) % n], axis=1))
        return np.concatenate([np.zeros((0, 2), np.intp), *pairs]).astype(np.intp)

    def shares(self, values: NDArray[np.bool_]) -> Floats:
        """Share of the nodes of each stroke of which something holds. [S]"""
        count = len(self.bases)
        size = np.maximum(np.bincount(self.stroke, minlength=count), 1)
        return np.asarray(np.bincount(self.stroke, values, minlength=count) / size)

    def positions(self, points: Floats) -> Floats:
        """Where the nodes are, given all control points [P, 2]. [N, 2] px"""
        return np.asarray(self.weights @ points)

    def moved(self, points: Floats, positions: Floats) -> Floats:
        """Control points [P, 2] after the nodes went to other positions [N, 2]. [P, 2] px

        What the smoothing takes away, a turn above all, is given back by repetition.
        """
        moved = points
        for _ in range(_REPEATS):
            moved = moved + self.inverse @ (positions - self.weights @ moved)
        return np.asarray(moved)

    def tangents(self, positions: Floats) -> Floats:
        """Unit tangents; zero where neighbouring nodes coincide. [N, 2]"""
        chord = positions[self.after] - positions[self.before]
        return np.asarray(chord / np.maximum(np.linalg.norm(chord, axis=1, keepdims=True), 1e-9))

    def _neighbour(self, step: int) -> Ints:
        own = np.arange(len(self))
        starts, counts = self.starts[:-1][self.stroke], np.diff(self.starts)[self.stroke]
        closed = np.array([b.is_closed for b in self.bases], bool)[self.stroke]
        local = own - starts + step
        local = np.where(closed, local % np.maximum(counts, 1), np.clip(local, 0, counts - 1))
        return (starts + local).astype(np.intp)


def gather(bases: list[Basis]) -> Nodes:
    """Nodes of several strokes as one."""
    if not bases:
        return Nodes((), sparse.csr_matrix((0, 0)), sparse.csr_matrix((0, 0)))
    weights = sparse.block_diag([b.weights for b in bases], format="csr")
    inverse = sparse.block_diag([b.inverse for b in bases], format="csr")
    return Nodes(tuple(bases), weights, inverse)


def bases_of(strokes: Strokes, spacing: float) -> list[Basis]:
    """Nodes of every stroke of one drawing."""
    return [basis_of(strokes.points_of(s), spacing, bool(strokes.is_closed[s])) for s in range(len(strokes))]
