"""What tells whether two branches are one stroke: numbers without a unit, direction, order or handedness."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from videovec.initialise.arrangement import Arrangement

__all__ = ["END_FEATURES", "IS_RING", "LENGTH", "PAIR_FEATURES", "REGION_FEATURES", "TURN", "Features", "describe"]

Floats = NDArray[np.float64]
Ints = NDArray[np.intp]

END_FEATURES, PAIR_FEATURES, REGION_FEATURES = 15, 36, 8
"""How many numbers are told of each."""
TURN, LENGTH, IS_RING = 11, 23, 29
"""Which numbers of a pair are the angle, over half a turn, by which geometry goes, the logarithm of 1 plus the length
of its longer branch, and whether both ends are of one branch."""
_CHORDS = ((0, 2), (1, 3), (1, 4), (2, 5), (3, 6))  # reaches between which the directions of ends are compared
_FAR = 4.0  # of a turn, at most, and of other numbers without bound


@dataclass(frozen=True, slots=True, eq=False)
class Features:
    """Numbers of each end [E, 15], pair [P, 36] and region [F, 8]."""

    ends: Floats
    pairs: Floats
    regions: Floats


def _angle(one: Floats, two: Floats) -> Floats:
    """Angles between directions, over half a turn. [K]"""
    return np.asarray(np.abs(_signed(one, two)) / np.pi)


def _signed(one: Floats, two: Floats) -> Floats:
    """Angles from directions to others. rad [K]"""
    cross = one[:, 0] * two[:, 1] - one[:, 1] * two[:, 0]
    return np.asarray(np.arctan2(cross, (one * two).sum(axis=1)))


def _bounded(values: Floats) -> Floats:
    return np.asarray(np.clip(values, -_FAR, _FAR))


def _ends(drawn: Arrangement) -> Floats:
    far = drawn.degree[drawn.opposite]
    is_loop = drawn.node == drawn.node[drawn.opposite]
    return np.stack(
        [
            np.log1p(drawn.length),
            np.minimum(drawn.length, 12.0) / 6.0,
            drawn.straightness,
            _bounded(drawn.swing / np.pi),
            _bounded(3.0 * np.abs(drawn.curvatures[:, 0])),
            _bounded(6.0 * np.abs(drawn.curvatures[:, 1])),
            far == 1,
            far == 2,
            far == 3,
            far > 3,
            is_loop,
            drawn.thickness,
            drawn.degree == 2,
            drawn.degree == 3,
            drawn.degree > 3,
        ],
        axis=1,
    ).astype(np.float64)


def _rivals(drawn: Arrangement, turn: Floats) -> tuple[Floats, Floats]:
    """Least turn of the other pairs of either end: the smaller and the larger. [P]"""
    one, two = drawn.pairs.T
    best = np.full((len(drawn.ends), 2), 1.0)
    first = np.full(len(drawn.ends), -1, np.intp)
    for pair in np.argsort(turn, kind="stable").tolist():
        for end in (one[pair], two[pair]):
            if first[end] < 0:
                first[end], best[end, 0] = pair, turn[pair]
            elif best[end, 1] == 1.0:
                best[end, 1] = turn[pair]
    number = np.arange(len(turn))
    others = [np.where(first[end] == number, best[end, 1], best[end, 0]) for end in (one, two)]
    return np.minimum(*others), np.maximum(*others)


def _pairs(drawn: Arrangement) -> Floats:
    one, two = drawn.pairs.T
    tangents, curvatures = drawn.tangents, drawn.curvatures
    columns: list[Floats | NDArray[np.bool_]] = []
    for low, high in _CHORDS:
        way = drawn.points[:, high] - drawn.points[:, low]
        angle = _angle(-way[one], way[two])
        columns += [angle, np.cos(np.pi * angle)]
    chord = drawn.points[:, 3] - drawn.points[:, 0]
    costs = []
    for k in (0, 1):
        turn = _angle(-tangents[one, k], tangents[two, k])
        mixed = _angle(-chord[one], tangents[two, k]) + _angle(-tangents[one, k], chord[two])
        costs.append(np.maximum(turn, (turn + mixed) / 3.0))
        bend = _signed(-tangents[one, k], tangents[two, k])
        scale = 3.0 * (1 + k)
        columns += [
            turn,
            costs[-1],
            _bounded(scale * np.abs(curvatures[one, k] + curvatures[two, k])),
            _bounded(scale * np.abs(curvatures[two, k] - curvatures[one, k])),
            _bounded(scale * bend * (curvatures[two, k] - curvatures[one, k])),
        ]
    axis = tangents[two, 0] - tangents[one, 0]
    axis /= np.maximum(np.linalg.norm(axis, axis=1), 1e-9)[:, None]
    between = drawn.points[two, 2] - drawn.points[one, 2]
    offset = np.abs(axis[:, 0] * between[:, 1] - axis[:, 1] * between[:, 0])
    less, more = _rivals(drawn, costs[0])
    gap_of = np.full(len(drawn.pairs), 0.0)
    is_wedge = drawn.wedge >= 0
    gap_of[drawn.wedge[is_wedge]] = np.minimum(drawn.gap[is_wedge], 2.0 * np.pi) / np.pi
    adjacent = np.bincount(drawn.wedge[is_wedge], minlength=len(drawn.pairs)) > 0
    far = drawn.node[drawn.opposite]
    thickness = drawn.thickness
    short, long = (pick(drawn.length[one], drawn.length[two]) for pick in (np.minimum, np.maximum))
    columns += [
        _bounded(offset),
        np.abs(thickness[one] - thickness[two]),
        np.log1p(short),
        np.log1p(long),
        less,
        more,
        costs[0] - less,
        costs[0] - more,
        (far[one] == far[two]) & (drawn.opposite[one] != two),
        drawn.opposite[one] == two,
        (drawn.degree[drawn.opposite[one]] == 1) & (drawn.degree[drawn.opposite[two]] == 1),
        adjacent,
        np.where(adjacent, gap_of, 1.0),
        drawn.degree[one] == 2,
        drawn.degree[one] == 3,
        drawn.degree[one] > 3,
    ]
    return np.stack(columns, axis=1).astype(np.float64)


def _regions(drawn: Arrangement) -> Floats:
    size = np.abs(drawn.area)
    corners = np.bincount(drawn.region, minlength=len(size))
    hollows = np.bincount(drawn.region, drawn.gap > 1.1 * np.pi, minlength=len(size))
    perimeter = np.maximum(drawn.perimeter, 1e-9)
    return np.stack(
        [
            drawn.area <= 0.0,
            np.log1p(size) / 4.0,
            np.log1p(perimeter) / 4.0,
            4.0 * np.pi * size / perimeter**2,
            np.log(np.maximum(corners, 1)),
            hollows / np.maximum(corners, 1),
            _bounded(drawn.turning - 1.0),
            np.sqrt(np.minimum(size, 100.0)) / 5.0,
        ],
        axis=1,
    ).astype(np.float64)


def describe(drawn: Arrangement) -> Features:
    """Tell what a drawing's ends, pairs and regions look like.

    Args:
        drawn: A drawing's branches as arrays.

    Returns:
        Its numbers, the same for a drawing that is moved, turned, mirrored or enlarged.
    """
    return Features(_ends(drawn), _pairs(drawn), _regions(drawn))
