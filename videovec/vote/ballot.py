"""What the strokes traced on one drawing say about junctions: which arms they run through in one go."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from videovec.curves import arc_length, arc_to, derivative, evaluate, parameter_at, segments_of
from videovec.strokes import Strokes
from videovec.vote.contacts import Arm, Contacts

__all__ = ["Ballot", "Traced", "count", "traced_on"]

Floats = NDArray[np.float64]
Ints = NDArray[np.intp]

_STEP = 0.5  # px between samples of traced strokes
_PROBES = 8  # on an arm
_SKIP, _REACH = 1.5, 6.0  # widths from the junction between which an arm is looked at
_SKIP_SHARE, _REACH_SHARE = 0.3, 0.6  # of a branch's length, likewise
_NEAR = 1.2  # widths within which a traced stroke lies on an arm
_ALONG = 0.7  # cosine of the angle between the two, at least
_COVERED = 0.6  # of an arm's probes that one traced stroke must cover
_LINKED = 8.0  # widths of a traced stroke between the first probes of two arms that it links


@dataclass(frozen=True, slots=True, eq=False)
class Traced:
    """Samples of the traced strokes of one drawing.

    Args:
        tree: Where they are.
        direction: [N, 2]
        stroke: [N]
        arc: How far along their stroke. [N] px
        loop: Length of each closed stroke, infinite for open ones. [S] px
    """

    tree: cKDTree
    direction: Floats
    stroke: Ints
    arc: Floats
    loop: Floats


@dataclass(frozen=True, slots=True, eq=False)
class Ballot:
    """Votes of all drawings on one junction of K arms.

    Args:
        linked: Drawings on which two arms are one stroke. [K, K]
        known: Drawings on which it can be told. [K, K]
    """

    linked: Floats
    known: Floats

    @property
    def share(self) -> Floats:
        """Share of the drawings that link two arms. [K, K]"""
        return np.asarray(self.linked / np.maximum(self.known, 1.0))


def traced_on(strokes: Strokes) -> Traced | None:
    """Samples of strokes that were traced on one drawing; nothing if there are none."""
    points, direction, owner, arcs = [], [], [], []
    loop = np.full(len(strokes), np.inf)
    for row in range(strokes.row_count):
        control = strokes.points_of(row)
        length = arc_length(control)
        if length < _STEP:
            continue
        u = np.linspace(0.0, 1.0, int(np.ceil(length / _STEP)) + 1)
        segment, t = parameter_at(control, u)
        points.append(evaluate(segments_of(control)[segment], t))
        direction.append(_unit(derivative(segments_of(control)[segment], t)))
        owner.append(np.full(len(u), row, np.intp))
        arcs.append(u * length)
        if strokes.is_closed[row]:
            loop[row] = length
    if not points:
        return None
    return Traced(
        cKDTree(np.concatenate(points)), np.concatenate(direction), np.concatenate(owner), np.concatenate(arcs), loop
    )


def count(strokes: Strokes, contacts: Contacts, junction: tuple[Arm, ...], drawings: dict[int, Traced]) -> Ballot:
    """Count the votes on a junction.

    Args:
        strokes: The strokes that are carried, alive on all of the drawings.
        contacts: Their branches.
        junction: The arms that meet.
        drawings: What was traced on each drawing.
    """
    size = len(junction)
    linked, known = np.zeros((size, size)), np.zeros((size, size))
    for drawing, traced in drawings.items():
        seen = [_covering(traced, _probes(strokes, contacts, arm, drawing), contacts.width) for arm in junction]
        for i in range(size):
            for j in range(i):
                one, two = seen[i], seen[j]
                if one is None or two is None:
                    continue
                known[i, j] += 1
                linked[i, j] += one[0] == two[0] and _run_on(one[1], two[1], float(traced.loop[one[0]]), contacts.width)
    return Ballot(linked + linked.T, known + known.T)


def _probes(strokes: Strokes, contacts: Contacts, arm: Arm, drawing: int) -> Floats:
    """Points on an arm, from the junction outwards. [_PROBES, 2] px"""
    branch = contacts.branches[arm[0]]
    control = strokes.points_of(strokes.row(branch.stroke, drawing))
    ends = np.array([branch.start, branch.stop, len(control) // 3])
    start, stop, whole = arc_to(control, ends).tolist()
    length, width = stop - start, contacts.width
    skip, reach = min(_SKIP * width, _SKIP_SHARE * length), min(_REACH * width, _REACH_SHARE * length)
    away = np.linspace(skip, reach, _PROBES)
    arc = stop - away if arm[1] else start + away
    segment, t = parameter_at(control, arc / max(whole, 1e-9))
    return evaluate(segments_of(control)[segment], t)


def _covering(traced: Traced, probes: Floats, width: float) -> tuple[int, Floats] | None:
    """The traced stroke that covers most probes, and where along it they lie [M] px; none if it covers too few."""
    direction = _unit(np.gradient(probes, axis=0))
    found = traced.tree.query_ball_point(probes, _NEAR * width)
    probe = np.repeat(np.arange(len(probes)), [len(near) for near in found])
    near = np.concatenate([np.asarray(part, np.intp) for part in found])
    is_along = np.abs((traced.direction[near] * direction[probe]).sum(1)) >= _ALONG
    probe, near = probe[is_along], near[is_along]
    gap = np.linalg.norm(traced.tree.data[near] - probes[probe], axis=1)
    order = np.lexsort((near, gap, probe, traced.stroke[near]))
    stroke, probe, near = traced.stroke[near][order], probe[order], near[order]
    is_nearest = np.ones(len(near), bool)  # the first of each stroke and probe
    is_nearest[1:] = (np.diff(stroke) != 0) | (np.diff(probe) != 0)
    stroke, near = stroke[is_nearest], near[is_nearest]
    strokes, counts = np.unique(stroke, return_counts=True)
    if not len(strokes) or counts.max() < _COVERED * len(probes):
        return None
    best = int(strokes[counts.argmax()])
    return best, traced.arc[near[stroke == best]]


def _run_on(one: Floats, two: Floats, loop: float, width: float) -> bool:
    """Whether a stroke runs from one arm through the junction into another."""
    gap, far = abs(one[0] - two[0]), abs(one[-1] - two[-1])
    gap, far = min(gap, loop - gap), min(far, loop - far)
    return bool(gap < _LINKED * width and far > gap)


def _unit(vectors: Floats) -> Floats:
    return np.asarray(vectors / np.maximum(np.linalg.norm(vectors, axis=-1, keepdims=True), 1e-9))
