"""Where strokes go: those that hide others first, then the others in the ink that is left, and both in two steps."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from videovec.propagate.ends import widened
from videovec.propagate.front import behind, passed_over, untied, without
from videovec.propagate.hypotheses import moved_on, place, place_growing
from videovec.propagate.judge import between_nodes
from videovec.propagate.kernels import nearest
from videovec.propagate.nodes import Nodes
from videovec.propagate.predict import Hold
from videovec.propagate.registration import SETTLE, SIMILAR, Source, parted, register
from videovec.propagate.residual import find_residual
from videovec.propagate.support import Inks, Support
from videovec.propagate.target import Target, sample

__all__ = ["Found", "emerging", "find", "is_still", "settled"]

Floats = NDArray[np.float64]
Bools = NDArray[np.bool_]

_ON_INK = 3.5
"""Distance within which a node has ink. working px"""
_STEADY = 0.95
"""Share of the nodes of strokes in front that must have ink where these would be by their last step."""
_AROUND = 10.0
"""How far from where it waits a hidden part of a stroke is looked for, and a steady edge is found. working px"""
_ALIKE = 0.8
"""Cosine of the largest angle between it and the ink that it may be."""
_ERASED = 3
"""Nodes of seen parts on bare paper, and of hidden ones on ink, from which on something is erased or drawn on."""
_RESTS, _THICK = 0.7, 4.0
"""Median distance from centre lines up to which strokes have not moved, and the half-width at which it is twice that,
as centre lines of thick ink are rougher. working px"""
_EVERY = 2
"""Pixels from one to the next that is looked at."""
_BESIDE = 1.5
"""How far ink may reach beyond the line of a stroke that stands still. working px"""
_STRANGE = 0.04
"""Share of the ink that may lie elsewhere."""
_FEWEST = 2
"""Nodes that must have such ink for a stroke to be moved there."""


@dataclass(frozen=True, slots=True, eq=False)
class Found:
    """Where strokes went, to about a pixel.

    Args:
        ahead: What was registered to find strokes in front.
        loose: What was registered to find the others; the same if none is in front.
        positions: Of N nodes. [N, 2] working px
        ink: The drawing's ink.
        little: Strokes of which any bit may be all that is seen: something passed over them, or they are erased or
            drawn on. bool [S]
    """

    ahead: Source
    loose: Source
    positions: Floats
    ink: Inks
    little: Bools


def find(
    source: Source,
    ways: tuple[Floats, Floats, Floats],
    strokes: tuple[Bools, Floats],
    targets: tuple[Target, Target],
    velocity: Floats,
    grows: bool,
) -> Found:
    """Find strokes in front first, among all ink, then the others in what is left.

    Args:
        source: The strokes at rest.
        ways: Where nodes were, where they would go by themselves, and by their last step. [N, 2] each, working px
        strokes: Which strokes are in front, and half-widths. [S] each
        targets: Both drawings.
        velocity: How each node moved in the last step. [N, 2] working px
        grows: Whether less of the strokes may be drawn there.
    """
    nodes, front, search = source.nodes, strokes[0], place_growing if grows else place
    if not front.any() and is_still(source, strokes[1], targets[1]):
        return Found(source, source, source.rest, _inks(targets[1], nodes, source.rest, strokes), ~front)
    passed = passed_over(nodes, ways[:2], ways[2], front)
    ahead = replace(untied(source, front), weight=np.where(passed, 0.0, source.weight))
    steady = _as_before(ahead, targets[1], velocity, front)
    ahead, positions = search(ahead, targets[1], targets[0], velocity) if steady is None else (ahead, steady)
    ink = _inks(targets[1], nodes, positions, strokes)
    if not front.any():
        return Found(ahead, ahead, positions, ink, front)
    passed = passed_over(nodes, ways[:2], positions, front)
    loose, positions = search(behind(source, positions, front, passed), ink.own, targets[0], velocity)
    return Found(ahead, loose, positions, ink, nodes.shares(passed) > 0)


def is_still(source: Source, half_width: Floats, target: Target) -> bool:
    """Whether lines are only erased and drawn on: some are seen no longer, or again, and all ink is where they were.

    Registered, what has lost its ink, or found it again, would pull the rest along its line.

    Args:
        source: The strokes, at rest; hidden parts count as well.
        half_width: Of each. [S] working px
        target: The drawing.
    """
    nodes = source.nodes
    is_bare = sample(widened(target), source.rest) <= target.threshold
    if not len(target) or is_bare.all() or np.sum(is_bare == (source.weight > 0)) < _ERASED:
        return False
    slack = _RESTS * (1.0 + half_width[nodes.stroke] / _THICK)
    if np.median((target.distance_at(source.rest) / slack)[~is_bare]) > 1.0:
        return False
    row, column = np.nonzero(target.ink[::_EVERY, ::_EVERY] > target.threshold)
    inked = np.stack([column, row], axis=1).astype(np.float64) * _EVERY + 0.5
    dense, owner = between_nodes(nodes, source.rest)
    found, squared = nearest(inked, np.ascontiguousarray(dense), np.zeros(len(inked), np.int64))
    return bool(np.mean(np.sqrt(squared) - half_width[nodes.stroke[owner[found]]] > _BESIDE) <= _STRANGE)


def _as_before(source: Source, target: Target, velocity: Floats, front: Bools) -> Floats | None:
    """Where nodes are if those of strokes in front went on as in the last step; none if these have no ink there. [N, 2]

    Edges of one thing are alike: each would else be found where another has come to be.
    """
    which = front[source.nodes.stroke] & (source.weight > 0)
    start = source.rest + velocity
    if not which.any() or not len(target):
        return None
    positions = moved_on(source, target, velocity)
    which &= target.on_page(positions)
    near = (target.distance_at(positions) <= _ON_INK) & (np.linalg.norm(positions - start, axis=1) <= _AROUND)
    return positions if which.any() and near[which].mean() >= _STEADY else None


def _inks(target: Target, nodes: Nodes, positions: Floats, strokes: tuple[Bools, Floats]) -> Inks:
    """A drawing's ink; ``strokes`` says which are in front, and half-widths."""
    front, half_width = strokes
    return Inks(target, without(target, nodes, positions, half_width, front), front)


def settled(found: Found, rest: Floats, half_width: Floats, support: Support, hold: Hold) -> tuple[Inks, Floats]:
    """Settle strokes in front, then the others; the ink as it is then divided, and where nodes are."""
    nodes, ink, positions = found.loose.nodes, found.ink, found.positions
    is_front = ink.front[nodes.stroke]
    if is_front.any():
        alone = behind(replace(found.ahead, rest=rest), positions, ~ink.front, np.zeros(len(nodes), bool))
        positions = _settle(alone, ink.whole, positions, support, hold.staying(positions, ~is_front))
        ink = _inks(ink.whole, nodes, positions, (ink.front, half_width))
        hold = hold.staying(positions, is_front)
    return ink, _settle(replace(found.loose, rest=rest), ink.own, positions, support, hold)


def _settle(source: Source, target: Target, positions: Floats, support: Support, hold: Hold) -> Floats:
    """Let go of nodes without ink, then allow local scale."""
    weight = np.where(source.hold > 0, 0.0, support.follows())  # a source is held where ink tells nothing apart
    is_led = (weight == 0) & (hold.stiffness > 0)
    positions = np.where(is_led[:, None], hold.goal, positions)
    phases = (SIMILAR,) if np.array_equal(weight, source.weight) and weight.all() else (SETTLE, SIMILAR)
    source = replace(parted(source, positions), weight=weight, hold=hold.stiffness, goal=hold.goal)
    return register(source, target, positions, phases)


def emerging(nodes: Nodes, positions: Floats, half_width: Floats, support: Support, ink: Inks) -> Support | None:
    """Let hidden nodes follow ink around them that no stroke explains.

    Args:
        nodes: N nodes.
        positions: Where they are. [N, 2] working px
        half_width: Of each stroke. [S] working px
        support: What is seen of them.
        ink: The drawing's ink.

    Returns:
        The support with these nodes seen; none if there are no such nodes.
    """
    hidden = ~support.shown & ~ink.front[nodes.stroke]
    if not hidden.any() or not len(ink.own):
        return None
    point = find_residual(nodes, positions, support.explains(nodes), half_width, ink.own).point
    if not point.any():
        return None
    gap, which = cKDTree(ink.own.points[point]).query(positions)
    alike = np.abs((ink.own.direction[point][which] * nodes.tangents(positions)).sum(1)) >= _ALIKE
    near = hidden & (gap <= _AROUND) & alike
    near &= (np.bincount(nodes.stroke, near, minlength=len(nodes.bases)) >= _FEWEST)[nodes.stroke]
    if not near.any():
        return None
    return replace(support, shown=support.shown | near, claimed=support.claimed | near)
