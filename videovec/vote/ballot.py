"""What the strokes traced on one drawing say about junctions: which arms they run through in one go."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from videovec.curves import Ruler, derivative, evaluate
from videovec.strokes import Strokes
from videovec.vote.contacts import Arm, Contacts

__all__ = ["Ballot", "Traced", "Voice", "count", "hear", "traced_on"]

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
    segments, ends = strokes.segments(), strokes.layout.row_segments
    ruler = Ruler.of(segments)
    starts = ruler.ends[ends]
    length = np.diff(starts)
    count = np.where(length >= _STEP, np.ceil(length / _STEP).astype(np.intp) + 1, 0)
    if not count.any():
        return None
    owner = np.repeat(np.arange(strokes.row_count), count)
    sample = np.arange(len(owner)) - np.repeat(np.cumsum(count) - count, count)
    arc = sample * length[owner] / (count[owner] - 1)
    segment, t = _within(ruler.place_at(starts[owner] + arc), ends, owner)
    return Traced(
        cKDTree(evaluate(segments[segment], t)),
        _unit(derivative(segments[segment], t)),
        owner,
        arc,
        np.where(strokes.is_closed & (length >= _STEP), length, np.inf),
    )


def _within(places: tuple[Ints, Floats], ends: Ints, row: Ints) -> tuple[Ints, Floats]:
    """Places on segments, moved to the end of the row that they belong to where they lie beyond it."""
    segment, t = places
    first, last = ends[row], ends[row + 1] - 1
    t = np.where(segment > last, 1.0, np.where(segment < first, 0.0, t))
    return np.clip(segment, first, last), t


@dataclass(frozen=True, slots=True, eq=False)
class Voice:
    """What one drawing has to say.

    Args:
        covering: The traced stroke that lies along each arm, and where along it [M] px; none where there is none.
        loop: Length of each traced stroke that is closed, infinite for open ones. [S] px
    """

    covering: dict[Arm, tuple[int, Floats] | None]
    loop: Floats


def hear(strokes: Strokes, contacts: Contacts, drawing: int, traced: Traced) -> Voice:
    """Find which traced strokes lie along the arms of all junctions on a drawing.

    Args:
        strokes: The strokes that are carried, alive on the drawing.
        contacts: Their branches.
        drawing: Which.
        traced: What was traced on it.
    """
    arms = sorted({arm for junction in contacts.junctions for arm in junction})
    if not arms:
        return Voice({}, traced.loop)
    probes = _probes(strokes, contacts, arms, drawing)
    return Voice(dict(zip(arms, _covering(traced, probes, contacts.width), strict=True)), traced.loop)


def count(contacts: Contacts, junction: tuple[Arm, ...], voices: list[Voice]) -> Ballot:
    """Count the votes on a junction.

    Args:
        contacts: The branches of the strokes that are carried.
        junction: The arms that meet.
        voices: What each drawing says.
    """
    size = len(junction)
    linked, known = np.zeros((size, size)), np.zeros((size, size))
    for voice in voices:
        for i in range(size):
            for j in range(i):
                one, two = voice.covering[junction[i]], voice.covering[junction[j]]
                if one is None or two is None:
                    continue
                known[i, j] += 1
                linked[i, j] += one[0] == two[0] and _run_on(one[1], two[1], float(voice.loop[one[0]]), contacts.width)
    return Ballot(linked + linked.T, known + known.T)


def _probes(strokes: Strokes, contacts: Contacts, arms: list[Arm], drawing: int) -> Floats:
    """Points on arms, from the junction outwards. [A, _PROBES, 2] px"""
    segments, ends = strokes.segments(), strokes.layout.row_segments
    branches = [contacts.branches[arm[0]] for arm in arms]
    rows = np.array([strokes.row(branch.stroke, drawing) for branch in branches], np.intp)
    own, inverse = np.unique(rows, return_inverse=True)
    bounds = np.concatenate([[0], np.cumsum(ends[own + 1] - ends[own])])
    here = np.concatenate([segments[ends[row] : ends[row + 1]] for row in own])
    ruler = Ruler.of(here)
    places = np.array([[branch.start, branch.stop] for branch in branches]) + bounds[inverse][:, None]
    start, stop = ruler.arc_at(places.ravel()).reshape(-1, 2).T
    length, width = stop - start, contacts.width
    skip, reach = np.minimum(_SKIP * width, _SKIP_SHARE * length), np.minimum(_REACH * width, _REACH_SHARE * length)
    away = np.linspace(skip, reach, _PROBES, axis=1)
    is_stop = np.array([arm[1] == 1 for arm in arms])[:, None]
    arc = np.where(is_stop, stop[:, None] - away, start[:, None] + away)
    segment, t = _within(ruler.place_at(arc.ravel()), bounds, np.repeat(inverse, _PROBES))
    return evaluate(here[segment], t).reshape(-1, _PROBES, 2)


def _covering(traced: Traced, probes: Floats, width: float) -> list[tuple[int, Floats] | None]:
    """For each arm [A, P, 2] the traced stroke that covers most probes, and where along it they lie [M] px.

    None if it covers too few.
    """
    direction = _unit(np.gradient(probes, axis=1)).reshape(-1, 2)
    where = probes.reshape(-1, 2)
    found = traced.tree.query_ball_point(where, _NEAR * width)
    probe = np.repeat(np.arange(len(where)), [len(near) for near in found])
    near = np.concatenate([np.asarray(part, np.intp) for part in found])
    is_along = np.abs((traced.direction[near] * direction[probe]).sum(1)) >= _ALONG
    probe, near = probe[is_along], near[is_along]
    gap = np.linalg.norm(traced.tree.data[near] - where[probe], axis=1)
    order = np.lexsort((near, gap, traced.stroke[near], probe))
    probe, near = probe[order], near[order]
    is_nearest = np.ones(len(near), bool)  # the first of each stroke at each probe
    is_nearest[1:] = (np.diff(probe) != 0) | (np.diff(traced.stroke[near]) != 0)
    probe, near = probe[is_nearest], near[is_nearest]
    bounds = np.searchsorted(probe, probes.shape[1] * np.arange(len(probes) + 1))
    return [_most(traced, near[a:b], _COVERED * probes.shape[1]) for a, b in pairwise(bounds)]


def _most(traced: Traced, near: Ints, least: float) -> tuple[int, Floats] | None:
    """The stroke that most of some samples are of, and where along it they lie; none if they are too few."""
    strokes, counts = np.unique(traced.stroke[near], return_counts=True)
    if not len(strokes) or counts.max() < least:
        return None
    best = int(strokes[counts.argmax()])
    return best, traced.arc[near[traced.stroke[near] == best]]


def _run_on(one: Floats, two: Floats, loop: float, width: float) -> bool:
    """Whether a stroke runs from one arm through the junction into another."""
    gap, far = abs(one[0] - two[0]), abs(one[-1] - two[-1])
    gap, far = min(gap, loop - gap), min(far, loop - far)
    return bool(gap < _LINKED * width and far > gap)


def _unit(vectors: Floats) -> Floats:
    return np.asarray(vectors / np.maximum(np.linalg.norm(vectors, axis=-1, keepdims=True), 1e-9))
