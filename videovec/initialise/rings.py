"""Rings: smooth, convex closed lines that share stretches of ink with others, as pills in a stack or touching coins do.

Where two closed lines touch along a stretch, the skeleton forks smoothly at both ends of it. A junction that gives the
stretch to one of the two leaves the other with loose ends. So closed lines are looked for as a whole: a walk
that turns one way at every junction, comes back after one turn, and bounds a convex, smooth region is one stroke, and
the stretches that it shares with other rings are drawn by all of them.
"""

from __future__ import annotations

import cmath
import math
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from videovec.initialise.centreline import Chain, strung
from videovec.initialise.graph import Graph
from videovec.initialise.polyline import arc, corners, resample, smooth
from videovec.initialise.prune import Widths

__all__ = ["find_rings"]

Floats = NDArray[np.float64]
Complexes = NDArray[np.complex128]
End = tuple[int, int]

_FORK = 70.0  # degrees at most between a branch and the one it merges with; thinning keeps what touches together
_AGAINST = 90.0  # degrees that a walk may turn back: where three lines run together, the skeleton is none of them
_FULL = 450.0  # degrees that it turns at most before it closes
_LONGEST = 24  # branches
_MOST_STEPS = 20_000  # of the search over a whole drawing
_CONVEX = 0.97  # of the hull's area that a ring fills
_CORNER, _CORNER_REACH = 70.0, 1.5  # degrees, and widths to either side between which they are told
_STEP = 0.5  # px between samples
_SMOOTHING = 0.5  # widths
_LEAST = 3.0  # widths that a ring measures across at least
_OWN = 0.15  # of its length that a ring shares with no other
_LEAST_WIDTH = 4.0  # px; below, the pixels of the skeleton set the scale
_SKIP, _REACH = 0.45, 3.0  # widths from a junction between which a branch's direction there is told


@dataclass(frozen=True, slots=True)
class _Way:
    """A branch as it is walked from one end.

    Args:
        starts: Direction in which it sets out, as a complex number.
        ends: Direction in which it arrives.
        turn: How much it turns in all, towards y from x. degrees
        least: The least of its turns up to any of its places, at most 0.
        stop: Node at which it arrives.
    """

    starts: complex
    ends: complex
    turn: float
    least: float
    stop: int


def find_rings(graph: Graph, widths: Widths) -> list[Chain]:
    """Find the closed lines of a drawing that share stretches with each other; junctions know of all others.

    Args:
        graph: A clean skeleton graph.
        widths: How wide lines are.

    Returns:
        Closed chains; each has branches that are in others, too.
    """
    ways = {}
    for number in graph.branches:
        ways[number, 0], ways[number, 1] = _ways(graph, widths, number)
    walks = [Chain(ends, True) for ends in _walks(graph, ways)]
    rated = [(_convexity(*strung(graph, walk, widths)), walk) for walk in walks]
    rated = sorted((ring for ring in rated if ring[0] >= _CONVEX), key=lambda ring: -ring[0])
    return _with_own(graph, [ring for _, ring in rated])


def _ways(graph: Graph, widths: Widths, number: int) -> tuple[_Way, _Way]:
    """A branch as it is walked from its start, and from its stop."""
    branch = graph.branches[number]
    width = max(widths.of(branch), _LEAST_WIDTH)
    line = np.concatenate([graph.position[[branch.start]], branch.line[1:-1], graph.position[[branch.stop]]])
    along, places = arc(line), line @ np.array([1.0, 1.0j])
    total = float(along[-1])
    skip = min(_SKIP * width, 0.3 * total)
    apart = 0.5 * (min(skip + _REACH * width, total) - skip)
    first, last = skip + apart * np.arange(3), total - skip - apart * np.arange(3)
    course = np.linspace(0.0, total, max(2, round(total / width) + 1))
    x = np.interp(np.concatenate([first, last, course]), along, places)
    starts, stops = _setting_out(x[:3]), _setting_out(x[3:6])
    inner = np.diff(x[6:])[1:-1]
    course = np.concatenate([[starts], inner, [-stops]])
    turns = np.degrees(np.angle(course[1:] * np.conj(course[:-1])))
    return (
        _Way(starts, -stops, float(turns.sum()), min(float(np.cumsum(turns).min()), 0.0), branch.stop),
        _Way(stops, -starts, -float(turns.sum()), min(float(np.cumsum(-turns[::-1]).min()), 0.0), branch.start),
    )


def _setting_out(places: Complexes) -> complex:
    """Direction at the first of three places, equally apart, of the parabola through them."""
    return complex(4.0 * places[1] - 3.0 * places[0] - places[2])


def _walks(graph: Graph, ways: dict[End, _Way]) -> list[tuple[End, ...]]:
    """Closed walks that turn once round, never far back, and pass no branch and no node twice, each once."""
    following: dict[End, list[tuple[End, float]]] = {}
    for entry, way in ways.items():
        following[entry] = []
        for other in graph.ends_at(way.stop):
            turn = math.degrees(cmath.phase(ways[other].starts * way.ends.conjugate()))
            if other[0] != entry[0] and abs(turn) <= _FORK:
                following[entry].append((other, turn))
    walks: list[tuple[End, ...]] = []
    budget = _MOST_STEPS
    for first in sorted(ways):
        stack: list[tuple[tuple[End, ...], frozenset[int], float, float]] = [((first,), frozenset(), 0.0, 0.0)]
        while stack and budget:
            budget -= 1
            ends, nodes, turn, most = stack.pop()
            way = ways[ends[-1]]
            if turn + way.least < most - _AGAINST or turn + way.turn > _FULL or way.stop in nodes:
                continue
            turn, most = turn + way.turn, max(most, turn + way.turn)
            for other, step in following[ends[-1]]:
                if other == first and abs(turn + step - 360.0) < 1.0:
                    walks.append(ends)
                elif other[0] > first[0] and len(ends) < _LONGEST:
                    stack.append(((*ends, other), nodes | {way.stop}, turn + step, most))
    return walks


def _convexity(ring: Floats, width: float) -> float:
    """Share of its hull that a closed line [M, 2] fills; 0 if it has corners or is small."""
    line = resample(np.concatenate([ring, ring[:1]]), _STEP)[:-1]
    line = smooth(line, _SMOOTHING * width / _STEP, True)
    points = line.astype(np.float32)
    (_, size, _) = cv2.minAreaRect(points)
    reach = max(1, round(_CORNER_REACH * width / _STEP))
    if min(size) < _LEAST * width or len(corners(line, reach, _CORNER, True)):
        return 0.0
    hull = cv2.convexHull(points)
    return float(cv2.contourArea(points) / max(cv2.contourArea(hull), 1e-9))


def _with_own(graph: Graph, rings: list[Chain]) -> list[Chain]:
    """The rings that share branches with others, best first, and of which enough is in no other."""
    kept: list[Chain] = []
    for ring in rings:
        trial = [*kept, ring]
        if all(_own_share(graph, one, trial) >= _OWN for one in trial):
            kept.append(ring)
    return [ring for ring in kept if _own_share(graph, ring, kept) < 1.0]


def _own_share(graph: Graph, ring: Chain, rings: list[Chain]) -> float:
    """Share of a ring's length in branches that are in no other ring."""
    others = {number for other in rings if other is not ring for number, _ in other.ends}
    length = {number: graph.branches[number].length for number, _ in ring.ends}
    return sum(length[number] for number in length if number not in others) / max(sum(length.values()), 1e-9)
