"""Registration: move the nodes of one drawing's strokes onto the ink of another drawing.

Nearest points are looked for both ways, among features that know direction and surroundings, and the strokes bend as
little as that allows: rigid at first, softer as they settle.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import Delaunay, QhullError

from videovec.propagate.kernels import assemble, nearest, relax, rotations
from videovec.propagate.nodes import Nodes
from videovec.propagate.target import Target

__all__ = [
    "COARSE",
    "FINE",
    "RIGID",
    "SETTLE",
    "SIMILAR",
    "Phase",
    "Source",
    "doubled",
    "parted",
    "recall",
    "register",
    "source_of",
]

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

_HOPS = ((1, 1.0), (2, 0.5), (4, 0.25))
"""Steps along a stroke that an edge spans, and its share of stiffness."""
_ALONG = 0.15
"""Pull along a line as a share of the pull towards it."""
_REVERSE = 0.5
"""Weight of a pull from ink to strokes, against 1 from strokes to ink."""
_CROSS_REACH = 12.0
"""Distance at which an edge between strokes has half of its stiffness. px"""
_RECALL = 0.3
"""Pull of where strokes are against their remembered shape: bends of less than some eight nodes are learned slowly."""
_PARTED = 8.0
"""Motion of two strokes against each other at which the ties between them have a quarter of their stiffness. px"""
_STAY = 1e-3
"""Pull of where nodes are, against 1 of ink nearby: strokes far from all ink would else be flung anywhere."""
_SOLVES = 2
_ITERATIONS = 40


@dataclass(frozen=True, slots=True)
class Phase:
    """A schedule; each pair is the value at the first and the last iteration, geometric in between.

    Args:
        iterations: How many nearest-point searches.
        tau: Feature distance at which a pair loses three quarters of its weight. px
        beta: Weight of direction in the feature distance. px
        gamma: Weight of the surrounding ink in the feature distance. px
        along: Stiffness of edges along strokes.
        across: Stiffness of edges between strokes.
        scale: Least and largest local scale.
    """

    iterations: int
    tau: tuple[float, float]
    beta: tuple[float, float]
    gamma: tuple[float, float]
    along: tuple[float, float]
    across: tuple[float, float]
    scale: tuple[float, float] = (1.0, 1.0)

    def at(self, iteration: int) -> tuple[float, float, float, float, float]:
        """tau, beta, gamma, along and across at an iteration."""
        share = iteration / max(self.iterations - 1, 1)
        pairs = (self.tau, self.beta, self.gamma, self.along, self.across)
        tau, beta, gamma, along, across = (first ** (1 - share) * last**share for first, last in pairs)
        return tau, beta, gamma, along, across


RIGID = Phase(40, (40.0, 2.5), (20.0, 6.0), (30.0, 8.0), (20.0, 0.6), (20.0, 0.02))
"""From the previous drawing, whatever the motion."""
COARSE = Phase(15, (40.0, 6.0), (20.0, 10.0), (30.0, 12.0), (20.0, 2.0), (20.0, 0.2))
"""From a guess at the motion."""
FINE = Phase(10, (6.0, 2.5), (10.0, 6.0), (12.0, 8.0), (2.0, 0.6), (0.2, 0.02))
"""After `COARSE`."""
SETTLE = Phase(10, (6.0, 2.5), (10.0, 6.0), (12.0, 8.0), (4.0, 1.0), (0.4, 0.1))
"""When it is known which parts are seen: what is not seen goes back into shape."""
SIMILAR = Phase(12, (6.0, 4.0), (6.0, 6.0), (4.0, 2.0), (2.0, 2.0), (0.3, 0.3), (0.7, 1.4))
"""Last: local scale may change, which keeps points from sliding along their strokes."""


@dataclass(frozen=True, slots=True, eq=False)
class Source:
    """What is registered.

    Args:
        nodes: N nodes and the strokes that they lie on.
        rest: Their positions at rest. [N, 2] working px
        moments: Pull of the ink around them at rest. [N, 4]
        weight: How much each follows the ink; 0 is carried by its neighbours alone. [N]
        indptr: Where the edges of each node begin. int [N+1]
        index: Other end of each edge. int [E]
        along: Share of stiffness along the stroke of each edge. [E]
        across: Share of stiffness between strokes of each edge. [E]
        hold: Stiffness with which each node is held at ``goal``, against 1 of the pull of the ink. [N]
        goal: Where nodes are held. [N, 2] working px
    """

    nodes: Nodes
    rest: Floats
    moments: Floats
    weight: Floats
    indptr: Ints
    index: Ints
    along: Floats
    across: Floats
    hold: Floats
    goal: Floats

    def stiffness(self, along: float, across: float) -> tuple[Ints, Ints, Floats]:
        """Edges for `relax`."""
        return self.indptr, self.index, along * self.along + across * self.across


def source_of(nodes: Nodes, rest: Floats, ink: Target, weight: Floats | None = None) -> Source:
    """Prepare strokes at rest on a drawing.

    Args:
        nodes: N nodes.
        rest: Where they are. [N, 2] working px
        ink: The drawing on which they are there.
        weight: How much each follows the ink; 1 unless told. [N]

    Returns:
        The source, with edges along strokes and, by triangulation, between them.
    """
    pairs = [nodes.hop(distance) for distance, _ in _HOPS]
    along = np.concatenate([np.full(len(p), share) for p, (_, share) in zip(pairs, _HOPS, strict=True)])
    cross = _edges_between(rest)
    reach = np.linalg.norm(rest[cross[:, 0]] - rest[cross[:, 1]], axis=1)
    across = 1.0 / (1.0 + (reach / _CROSS_REACH) ** 2) + 0.02
    both = np.concatenate([*pairs, cross])
    both = np.concatenate([both, both[:, ::-1]])
    order = np.argsort(both[:, 0], kind="stable")
    counts = np.bincount(both[:, 0], minlength=len(nodes))
    zero_along, zero_cross = np.zeros(len(cross)), np.zeros(len(along))
    return Source(
        nodes=nodes,
        rest=rest,
        moments=ink.moments(rest),
        weight=np.ones(len(nodes)) if weight is None else weight,
        indptr=np.concatenate([[0], np.cumsum(counts)]).astype(np.int64),
        index=both[order, 1].astype(np.int64),
        along=np.tile(np.concatenate([along, zero_along]), 2)[order],
        across=np.tile(np.concatenate([zero_cross, across]), 2)[order],
        hold=np.zeros(len(nodes)),
        goal=rest,
    )


def recall(source: Source, shape: Floats) -> Source:
    """Give strokes the rest shape that they have had for long, where they are now.

    A zigzag over ink that belongs to several strokes would otherwise be the rest shape of the next step, and grow.

    Args:
        source: Strokes at rest where they are.
        shape: The shape that they had at rest in the step before. [N, 2] working px

    Returns:
        The source with another rest: long bends as they are, short ones as they were.
    """
    if not len(source.rest):
        return source
    pull, rhs = np.full((len(source.rest), 1), _RECALL) * (1.0, 0.0, 1.0), _RECALL * source.rest
    rest = relax(source.rest, shape, source.stiffness(1.0, 0.0), (pull, rhs), SIMILAR.scale, _ITERATIONS)
    return replace(source, rest=rest, goal=rest)


def parted(source: Source, positions: Floats) -> Source:
    """Loosen the ties between strokes that went different ways, such as one that passes before another.

    Args:
        source: The strokes at rest.
        positions: Where they went. [N, 2] working px

    Returns:
        The source with less stiffness across where its rest, turned along, does not lead to the positions.
    """
    if not len(source.rest):
        return source
    turn = rotations(positions, source.rest, *source.stiffness(1.0, 0.05), 1.0, 1.0)
    own = np.repeat(np.arange(len(source.rest)), np.diff(source.indptr))
    (x, y), (cos, sin) = (source.rest[source.index] - source.rest[own]).T, turn[own].T
    led = np.stack([cos * x - sin * y, sin * x + cos * y], axis=1)
    gap = np.linalg.norm(positions[source.index] - positions[own] - led, axis=1)
    return replace(source, across=source.across / (1.0 + (gap / _PARTED) ** 2) ** 2)


def _edges_between(positions: Floats) -> NDArray[np.intp]:
    """Edges of the Delaunay triangulation; none where the points do not span a plane. int [E, 2]"""
    if len(positions) < 4:
        return np.zeros((0, 2), np.intp)
    try:
        corners = Delaunay(positions).simplices
    except QhullError:
        return np.zeros((0, 2), np.intp)
    edges = np.sort(corners[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1)
    return np.unique(edges, axis=0).astype(np.intp)


def doubled(direction: Floats) -> Floats:
    """Directions at twice their angle, so that opposite ones are equal. [N, 2]"""
    x, y = direction[:, 0], direction[:, 1]
    return np.stack([x * x - y * y, 2 * x * y], axis=1)


def register(source: Source, target: Target, start: Floats, phases: tuple[Phase, ...] = (RIGID, SIMILAR)) -> Floats:
    """Move nodes onto a drawing's ink.

    Args:
        source: The strokes at rest, usually as they were on the previous drawing.
        target: The drawing to move to.
        start: Where the search begins; the rest positions if nothing better is known. [N, 2] working px
        phases: What to do, in order.

    Returns:
        New positions of the nodes. [N, 2] working px

    Source:
        Two-sided iterated closest points with as-rigid-as-possible regularisation, after Amberg et al. 2007, "Optimal
        Step Nonrigid ICP".
    """
    positions = start.copy()
    if len(source.nodes) == 0 or len(target) == 0:
        return positions
    held = _held(source)
    along_ink, around_ink = doubled(target.direction), target.moments(target.points)
    to_ink = np.zeros(len(positions), np.int64)
    to_node = np.zeros((len(target) + 1) // 2, np.int64)
    for phase in phases:
        for iteration in range(phase.iterations):
            tau, beta, gamma, along, across = phase.at(iteration)
            edges = source.stiffness(along, across)
            turn = rotations(positions, source.rest, *edges, 1.0, 1.0)
            features = _node_features(source, positions, turn, beta, gamma)
            ink = np.concatenate([target.points, beta * along_ink, gamma * around_ink], axis=1)
            to_ink, squared = nearest(features, ink, to_ink)
            to_node, squared_back = nearest(ink[::2], features, to_node)
            pull, rhs = held[0].copy(), held[1].copy()
            led = source.weight * target.on_page(positions)
            weight = led * _robust(squared, tau)
            own = np.arange(len(positions))
            assemble(pull, rhs, own, target.points[to_ink], target.direction[to_ink], weight, np.full(len(own), _ALONG))
            weight = _REVERSE * led[to_node] * _robust(squared_back, tau)
            share = np.where(source.nodes.is_end[to_node], 1.0, _ALONG)
            assemble(pull, rhs, to_node, target.points[::2], target.direction[::2], weight, share)
            pull[:, [0, 2]] += _STAY
            rhs += _STAY * positions
            for _ in range(_SOLVES):
                positions = relax(positions, source.rest, edges, (pull, rhs), phase.scale, _ITERATIONS)
    return positions


def _held(source: Source) -> tuple[Floats, Floats]:
    """Springs [N, 3] and right-hand side [N, 2] of what holds nodes: those that follow the ink, along it alone."""
    tangent = source.nodes.tangents(source.goal)
    follows = source.weight > 0
    tx, ty = np.where(follows[:, None], tangent, (1.0, 0.0)).T
    yy = np.where(follows, ty * ty, 1.0)
    pull = source.hold[:, None] * np.stack([tx * tx, tx * ty, yy], axis=1)
    x, y = source.goal.T
    return pull, np.stack([pull[:, 0] * x + pull[:, 1] * y, pull[:, 1] * x + pull[:, 2] * y], axis=1)


def _robust(squared: Floats, tau: float) -> Floats:
    """Geman and McClure's weight."""
    return np.asarray(1.0 / (1.0 + squared / tau**2) ** 2)


def _node_features(source: Source, positions: Floats, turn: Floats, beta: float, gamma: float) -> Floats:
    """Place, doubled direction and the moments of the rest drawing, turned with the node. [N, 8]"""
    tangent = source.nodes.tangents(positions)
    moments = source.moments.reshape(-1, 2, 2)
    cos, sin = turn[:, None, 0], turn[:, None, 1]
    turned = np.stack([cos * moments[..., 0] - sin * moments[..., 1], sin * moments[..., 0] + cos * moments[..., 1]], 2)
    return np.concatenate([positions, beta * doubled(tangent), gamma * turned.reshape(-1, 4)], axis=1)
