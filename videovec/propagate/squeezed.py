"""Closed strokes that are squeezed all at once, onto a line at last, or open again: an eye that blinks, a mouth.

Registration keeps strokes stiff: one side of an eye follows the lid, and nothing is left for the other. Here the shape
that was last seen open is squeezed as a whole, until it lies on all the ink there that no other stroke explains.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from videovec.propagate.nodes import Nodes
from videovec.propagate.registration import doubled
from videovec.propagate.support import Support
from videovec.propagate.target import Target

__all__ = ["is_narrow", "opened", "squeezed"]

Floats = NDArray[np.float64]
Bools = NDArray[np.bool_]

_FEWEST = 3
"""Centre-line points of the least ink that may be a stroke."""
_STEP = 2.0
"""Distance of the places along a stroke that are compared with ink. working px"""
_AROUND = 0.5
"""How far from the open stroke its ink is looked for, in diameters of it."""
_BESIDE = 2.5
"""Distance beyond its half-width up to which ink is another stroke's. working px"""
_TURNS = 6
"""Directions in which it may be squeezed at first,"""
_SHARES = (0.6, 0.3, 0.05)
"""and what is left of its size in them."""
_ITERATIONS = 12
_TAU = (8.0, 2.0)
"""Misfits, at the first and the last iteration, at which a pair loses three quarters of its weight. working px"""
_DIRECTION = 4.0
"""Weight of direction when nearest points are looked for. px"""
_FAR = 6.0
"""Distance beyond which a place costs no more. working px"""
_WHOLE = 0.95
"""Share of a stroke that must be seen for it to be where its ink is, and"""
_FITS = 1.0
"""the mean distance, each way, up to which they are in one place. working px"""
_GAIN = 0.5
"""By how much nearer to each other they must be than they were. working px"""
_PRICE = 2.0
"""What a change of the long side costs, for the logarithm of its factor, and a turn, for each radian. working px"""
_UNLIKE = 0.2
"""By how much farther the ink must be from the open stroke, wherever that may lie: else it is hidden in part, px,"""
_STRAYED = 0.03
"""and what each px by which the open stroke is moved counts as."""
_WIDE = (0.75, 1.3)
"""Factors by which the long side of a stroke may shrink or grow,"""
_NARROW = 0.25
"""Width of the open shape, of its length, below which it is not squeezed: it has little to shut."""
_OPEN = 0.8
"""and the share of its short side from which on it is not squeezed."""


@dataclass(frozen=True, slots=True, eq=False)
class _Ink:
    """Ink that is a stroke's own, if anyone's. Centre-line points [K, 2] working px and their directions [K, 2]"""

    points: Floats
    direction: Floats

    def features(self) -> Floats:
        return _features(self.points, self.direction)


def squeezed(
    nodes: Nodes, positions: Floats, support: Support, half_width: Floats, ink: Target, whole: list[Floats | None]
) -> dict[int, Floats]:
    """Find the closed strokes that are squeezed, or open again, and do not lie on their ink.

    Args:
        nodes: N nodes.
        positions: Where registration put them. [N, 2] working px
        support: What is seen of them there.
        half_width: Of each stroke. [S] working px
        ink: The drawing's ink, without that of strokes in front.
        whole: The nodes of each stroke that may be squeezed, as they were when it was open. [n, 2] working px

    Returns:
        Where the nodes of such strokes are, by the position of the stroke. [n, 2] working px
    """
    found: dict[int, Floats] = {}
    explains = support.explains(nodes) > 0
    for s, shape in enumerate(whole):
        if shape is None or not len(ink) or is_narrow(shape):
            continue
        own = slice(int(nodes.starts[s]), int(nodes.starts[s + 1]))
        others = explains & (nodes.stroke != s)
        left = _left(ink, shape, positions[others], half_width[nodes.stroke[others]])
        if len(left.points) < _FEWEST:
            continue
        ring = _ring(positions[own])
        before = _misfit(ring, left, np.repeat(explains[own], len(ring) // len(shape)))
        if max(before) > _FITS or explains[own].mean() < _WHOLE:
            place = _squeeze(shape, left, sum(before) - _GAIN)
            found |= {} if place is None else {s: place}
    return found


def opened(shape: Floats, positions: Floats) -> Floats:
    """A stroke as it is when it is open, after a step: as it was, turned and moved along, if it is squeezed.

    Args:
        shape: As it was when it was open. [n, 2] px
        positions: Where it is now. [n, 2] px
    """
    middle, now = shape.mean(axis=0), positions.mean(axis=0)
    change = np.linalg.lstsq(shape - middle, positions - now, rcond=None)[0]
    left, size, right = np.linalg.svd(change)
    if size[1] >= _OPEN * min(size[0], 1.0):
        return positions
    return np.asarray((shape - middle) @ (left @ right) + now)


def is_narrow(shape: Floats) -> bool:
    """Whether a shape is much longer than wide even when it is open: a stick, which only bends and turns."""
    size = np.linalg.svd(shape - shape.mean(axis=0), compute_uv=False)
    return bool(size[1] < _NARROW * size[0])


def _left(ink: Target, shape: Floats, others: Floats, half_width: Floats) -> _Ink:
    """The ink around an open stroke that no other stroke explains."""
    low, high = shape.min(axis=0), shape.max(axis=0)
    reach = _AROUND * float((high - low).max())
    near = ((ink.points >= low - reach) & (ink.points <= high + reach)).all(axis=1)
    points, direction = ink.points[near], ink.direction[near]
    if len(others) and len(points):
        gap, which = cKDTree(others).query(points)
        free = gap > half_width[which] + _BESIDE
        points, direction = points[free], direction[free]
    return _Ink(points, direction)


def _ring(points: Floats) -> Floats:
    """Places all along a closed polyline, the same number after each of its points. [M, 2]"""
    step = np.roll(points, -1, axis=0) - points
    count = max(1, int(np.ceil(np.linalg.norm(step, axis=1).max() / _STEP)))
    share = np.arange(count)[:, None] / count
    return np.asarray((points[:, None] + share * step[:, None]).reshape(-1, 2))


def _tangents(ring: Floats) -> Floats:
    chord = np.roll(ring, -1, axis=0) - np.roll(ring, 1, axis=0)
    return np.asarray(chord / np.maximum(np.linalg.norm(chord, axis=1, keepdims=True), 1e-9))


def _features(points: Floats, direction: Floats) -> Floats:
    return np.concatenate([points, _DIRECTION * doubled(direction)], axis=1)


def _misfit(ring: Floats, ink: _Ink, shown: Bools) -> tuple[float, float]:
    """Mean distance of a stroke from its ink, where what is not shown is far, and of the ink from what is shown. px"""
    to_ink = np.where(shown, np.minimum(cKDTree(ink.points).query(ring)[0], _FAR), _FAR)
    if not shown.any():
        return _FAR, _FAR
    to_ring = np.minimum(cKDTree(ring[shown]).query(ink.points)[0], _FAR)
    return float(to_ink.mean()), float(to_ring.mean())


def _squeeze(shape: Floats, ink: _Ink, most: float) -> Floats | None:
    """An open stroke squeezed onto some ink; none if that fits badly, or if the ink may be some of it as it is. [n, 2]

    Args:
        shape: The open stroke. [n, 2] working px
        ink: Its own.
        most: What the squeeze and the distances that are left may cost at most. working px
    """
    middle = shape.mean(axis=0)
    ring = _ring(shape) - middle
    goal = 0.5 * (ink.points.min(axis=0) + ink.points.max(axis=0))
    best, found, left = most, None, 0.0
    for k in range(_TURNS):
        axis = np.array([np.cos(np.pi * k / _TURNS), np.sin(np.pi * k / _TURNS)])
        for share in _SHARES:
            change = np.eye(2) + (share - 1.0) * np.outer(axis, axis)
            fit = _fitted(ring, np.concatenate([change, goal[None]]), ink)
            misfit = _misfit(ring @ fit[:2] + fit[2], ink, np.ones(len(ring), bool))
            cost = sum(misfit) + _price(fit[:2])
            if max(misfit) <= _FITS and cost < best:
                best, found, left = cost, fit, misfit[1]
    if found is None:
        return None
    is_open = np.linalg.svd(found[:2], compute_uv=False)[1] >= _OPEN
    if not is_open and _as_it_is(ring, (goal, middle), ink) <= left + _UNLIKE:
        return None
    return np.asarray((shape - middle) @ found[:2] + found[2])


def _price(change: Floats) -> float:
    """What a linear map costs: nothing if it only squeezes; more than anything if it changes the long side too much."""
    left, size, right = np.linalg.svd(change)
    if not _WIDE[0] <= size[0] <= _WIDE[1]:
        return np.inf
    turn = left @ np.diag([1.0, np.linalg.det(left) * np.linalg.det(right)]) @ right
    return float(_PRICE * (abs(np.log(size[0])) + abs(np.arctan2(turn[0, 1], turn[0, 0]))))


def _as_it_is(ring: Floats, centres: tuple[Floats, Floats], ink: _Ink) -> float:
    """How far the ink is, on the whole, from an open stroke that is turned and moved there, and what moving costs. px

    Args:
        ring: Places along the stroke, around the origin. [M, 2] working px
        centres: The middle of the ink, and that of the stroke when it was open. [2] each, working px
        ink: The ink.
    """
    half = 0.5 * np.ptp(ring, axis=0)
    sides = [side * half * np.eye(2)[k] for k in (0, 1) for side in (-1.0, 1.0)]
    starts = [*centres, *(centres[0] + side for side in sides)]
    everything = np.ones(len(ring), bool)
    places = [_moved(ring + start, ink) for start in starts]
    strayed = [float(np.linalg.norm(place.mean(axis=0) - ring.mean(axis=0) - centres[1])) for place in places]
    return min(_misfit(place, ink, everything)[1] + _STRAYED * far for place, far in zip(places, strayed, strict=True))


def _moved(ring: Floats, ink: _Ink) -> Floats:
    """A ring turned and moved so that its nearest places lie on all the ink. [M, 2]"""
    target = ink.features()
    for tau in np.geomspace(*_TAU, _ITERATIONS):
        apart, of = cKDTree(_features(ring, _tangents(ring))).query(target)
        weight = 1.0 / (1.0 + (apart / tau) ** 2) ** 2
        here, there = (np.average(points, axis=0, weights=weight) for points in (ring[of], ink.points))
        spread = ((ring[of] - here) * weight[:, None]).T @ (ink.points - there)
        angle = np.arctan2(spread[0, 1] - spread[1, 0], spread[0, 0] + spread[1, 1])
        turn = np.array([[np.cos(angle), np.sin(angle)], [-np.sin(angle), np.cos(angle)]])
        ring = (ring - here) @ turn + there
    return ring


def _fitted(ring: Floats, change: Floats, ink: _Ink) -> Floats:
    """An affine map, refined so that it takes places to ink, and the places that are nearest to ink to it. [3, 2]"""
    target, tree = ink.features(), cKDTree(ink.features())
    flat = np.concatenate([ring, np.ones((len(ring), 1))], axis=1)
    share = np.concatenate([np.full(len(flat), 1 / len(flat)), np.full(len(target), 1 / len(target))])
    for tau in np.geomspace(*_TAU, _ITERATIONS):
        now = flat @ change
        features = _features(now, _tangents(now))
        ahead, to = tree.query(features)
        back, of = cKDTree(features).query(target)
        a, b = np.concatenate([flat, flat[of]]), np.concatenate([ink.points[to], ink.points])
        weight = (share / (1.0 + (np.concatenate([ahead, back]) / tau) ** 2) ** 2)[:, None]
        change = np.linalg.solve(a.T @ (weight * a) + 1e-9 * np.eye(3), a.T @ (weight * b))
    return np.asarray(change)
