"""The drawing around its junctions as arrays: branch ends, pairs of ends that may be one stroke, and regions."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from videovec.initialise.graph import Graph
from videovec.initialise.prune import Widths

__all__ = ["Arrangement", "arrange"]

Floats = NDArray[np.float64]
Ints = NDArray[np.intp]
End = tuple[int, int]

_LEAST_UNIT = 2.0  # px; below, the pixels of the skeleton and not the line set the scale
_FITTED = ((0.45, 3.45), (0.6, 8.0))  # units of arc over which the two tangents of an end are told
_SAMPLES = 12  # samples of each fit
REACHES = np.array([0.5, 1.0, 1.5, 3.0, 6.0, 12.0, 24.0])
"""Arc lengths at which ends are sampled, in units."""


@dataclass(frozen=True, slots=True, eq=False)
class Arrangement:
    """E branch ends, P pairs of ends at one node, F regions, and how they touch.

    A unit is the width of the lines at a node, at least 2 px. Lengths are in units of the end's node, those of regions
    in units of the whole drawing.

    Args:
        ends: The branch end that each is.
        node: The node that it is at. int [E]
        degree: How many ends there are at that node. int [E]
        opposite: The other end of its branch. int [E]
        points: Where its branch is at each of ``REACHES``, from the node. [E, R, 2] units
        tangents: Direction in which it leaves, told over a short and a long reach. [E, 2, 2]
        curvatures: Signed curvature over them. [E, 2] per unit
        length: Of its branch. [E] units
        straightness: Chord over length of the branch. [E]
        swing: Sum of all turns along the branch. [E] rad
        thickness: Width of the branch over the unit. [E]
        gap: Angle from it to the next end around the node. [E] rad
        pairs: Ends of each pair. int [P, 2]
        wedge: For each end, the pair that it makes with the next around the node; -1 for a free end. int [E]
        region: For each end, the region between it and the next around the node. int [E]
        sides: Regions on the two sides of its branch. int [E, 2]
        area: Of each region; negative for the outside of a connected part. [F] units^2
        perimeter: [F] units
        turning: Sum of all turns along its boundary, over one turn: 1 for a convex one. [F]
    """

    ends: tuple[End, ...]
    node: Ints
    degree: Ints
    opposite: Ints
    points: Floats
    tangents: Floats
    curvatures: Floats
    length: Floats
    straightness: Floats
    swing: Floats
    thickness: Floats
    gap: Floats
    pairs: Ints
    wedge: Ints
    region: Ints
    sides: Ints
    area: Floats
    perimeter: Floats
    turning: Floats


@dataclass(frozen=True, slots=True, eq=False)
class _Lines:
    """All branches as one polyline, so that they are sampled at once; a gap of arc length lies between two.

    Args:
        points: Samples of all branches. [N, 2] px
        along: Arc length up to each. [N] px
        first: Sample at which each branch begins. int [B]
        last: And ends. int [B]
    """

    points: Floats
    along: Floats
    first: Ints
    last: Ints

    @staticmethod
    def of(graph: Graph) -> _Lines:
        parts: list[Floats] = []
        for number in sorted(graph.branches):
            branch = graph.branches[number]
            parts += [graph.position[[branch.start]], branch.line[1:-1], graph.position[[branch.stop]]]
        counts = np.array([len(part) for part in parts], np.intp).reshape(-1, 3).sum(axis=1)
        points = np.concatenate(parts) if parts else np.zeros((0, 2))
        last = np.cumsum(counts) - 1
        steps = np.linalg.norm(np.diff(points, axis=0), axis=1)
        steps[last[:-1]] = 1.0
        return _Lines(points, np.append(0.0, np.cumsum(steps))[: len(points)], last - counts + 1, last)

    @property
    def length(self) -> Floats:
        """Of each branch. [B] px"""
        return np.asarray(self.along[self.last] - self.along[self.first])

    def at(self, branch: Ints, lengths: Floats) -> Floats:
        """Points of branches at arc lengths from their starts. [..., 2] px"""
        where = self.along[self.first[branch]] + lengths
        x, y = self.points.T
        return np.stack([np.interp(where, self.along, x), np.interp(where, self.along, y)], axis=-1)

    def swept(self) -> Floats:
        """Integral of x dy - y dx along each branch. [B] px^2"""
        x, y = self.points.T
        area = np.append(x[:-1] * y[1:] - x[1:] * y[:-1], 0.0)
        area[self.last] = 0.0
        return np.asarray(np.add.reduceat(area, self.first))

    def swing(self, step: Floats) -> Floats:
        """Sum of the turns of each branch, sampled so coarsely [B] px; none of one shorter than two steps. [B] rad"""
        counts = np.maximum((self.length / step).astype(np.intp), 1)
        owner = np.repeat(np.arange(len(counts)), counts + 1)
        within = np.arange(len(owner)) - np.repeat(np.cumsum(counts + 1) - counts - 1, counts + 1)
        points = self.at(owner, self.length[owner] * within / counts[owner]) @ np.array([1.0, 1.0j])
        way = np.diff(points)
        turns = np.abs(np.angle(way[1:] * np.conj(way[:-1])))
        return np.asarray(
            np.bincount(owner[1:-1], np.where(owner[2:] == owner[:-2], turns, 0.0), len(counts)), np.float64
        )


def _around(graph: Graph, node: int, index: dict[End, int], points: Floats) -> Ints:
    """Ends of a node in the order of their angles."""
    ends = np.array([index[end] for end in graph.ends_at(node)], np.intp)
    where = points[ends, 2]
    return ends[np.argsort(np.arctan2(where[:, 1], where[:, 0]), kind="stable")]


def _fits(samples: Floats, start: Floats, stop: Floats, reach: float) -> tuple[Floats, Floats]:
    """Tangents at arc length zero and curvatures, from parabolas through samples at equal steps. [E, 2], [E]"""
    lengths = start[:, None] + (stop - start)[:, None] * np.linspace(0.0, 1.0, _SAMPLES)
    is_bent = stop - start > 0.6 * reach
    powers = np.stack([np.ones_like(lengths), lengths, np.where(is_bent[:, None], lengths**2, 0.0)], axis=2)
    solved = np.linalg.pinv(powers, rcond=1e-9) @ samples
    speed = np.maximum(np.linalg.norm(solved[:, 1], axis=1), 1e-9)
    first, second = solved[:, 1] / speed[:, None], 2.0 * solved[:, 2]
    return first, (first[:, 0] * second[:, 1] - first[:, 1] * second[:, 0]) / speed**2


def _regions(follow: Ints) -> tuple[Ints, int]:
    """Number the closed walks of a permutation."""
    walk = np.full(len(follow), -1, np.intp)
    count = 0
    for first in range(len(follow)):
        here = first
        if walk[here] >= 0:
            continue
        while walk[here] < 0:
            walk[here] = count
            here = int(follow[here])
        count += 1
    return walk, count


@dataclass(frozen=True, slots=True, eq=False)
class _Branches:
    """What is told of each branch end by its samples."""

    points: Floats
    tangents: Floats
    curvatures: Floats
    length: Floats
    straightness: Floats
    swing: Floats
    swept: Floats


def _measure(graph: Graph, unit: Floats) -> _Branches:
    """Sample every branch from both of its ends; all in units but ``swept``, the integral of x dy - y dx. px^2"""
    lines = _Lines.of(graph)
    branch = np.repeat(np.arange(len(lines.first)), 2)  # both ends of a branch stand side by side
    is_stop = np.arange(len(branch)) % 2 == 1
    total = lines.length[branch]
    origin = lines.points[np.where(is_stop, lines.last[branch], lines.first[branch])]

    def sampled(lengths: Floats) -> Floats:
        """Points at arc lengths from each end, relative to its node. [E, M, 2] units"""
        lengths = np.minimum(lengths, total[:, None])
        lengths = np.where(is_stop[:, None], total[:, None] - lengths, lengths)
        where = lines.at(np.repeat(branch[:, None], lengths.shape[1], axis=1), lengths)
        return np.asarray((where - origin[:, None]) / unit[:, None, None])

    steps = np.linspace(0.0, 1.0, _SAMPLES)
    fits = []
    for low, high in _FITTED:
        start, stop = np.minimum(low * unit, 0.3 * total), np.minimum(high * unit, total)
        samples = sampled(start[:, None] + (stop - start)[:, None] * steps)
        fits.append(_fits(samples, start / unit, stop / unit, high - low))
    chord = np.linalg.norm(origin - origin[np.arange(len(branch)) ^ 1], axis=1)
    return _Branches(
        sampled(unit[:, None] * REACHES),
        np.stack([fit[0] for fit in fits], axis=1),
        np.stack([fit[1] for fit in fits], axis=1),
        total / unit,
        chord / np.maximum(total, 1e-9),
        lines.swing(np.maximum(unit[::2], unit[1::2]))[branch],
        lines.swept()[branch] * np.where(is_stop, -1.0, 1.0),
    )


def arrange(graph: Graph, widths: Widths) -> Arrangement:
    """Lay a graph out as arrays.

    Args:
        graph: A clean skeleton graph.
        widths: How wide lines are.

    Returns:
        Its ends, pairs and regions.
    """
    ends = [(number, end) for number in sorted(graph.branches) for end in (0, 1)]
    index = {end: number for number, end in enumerate(ends)}
    count = len(ends)
    at = {node: max(_LEAST_UNIT, widths.at(graph, node)) for node in graph.nodes()}
    node = np.array([graph.branches[n].stop if end else graph.branches[n].start for n, end in ends], np.intp)
    unit = np.array([at[n] for n in node.tolist()])
    told = _measure(graph, unit)
    degree = np.array([graph.degree(n) for n in node.tolist()], np.intp)
    following, wedge, gap = np.arange(count), np.full(count, -1, np.intp), np.full(count, 2.0 * np.pi)
    pairs: list[tuple[int, int]] = []
    for here in graph.nodes():
        around = _around(graph, here, index, told.points)
        if len(around) < 2:
            continue
        angles = np.arctan2(told.points[around, 2, 1], told.points[around, 2, 0])
        following[around] = np.roll(around, -1)
        gap[around] = np.diff(np.append(angles, angles[0] + 2.0 * np.pi))
        numbers = {}
        for i, one in enumerate(around.tolist()):
            for two in around[i + 1 :].tolist():
                numbers[one, two] = numbers[two, one] = len(pairs)
                pairs.append((one, two))
        wedge[around] = [numbers[e, int(following[e])] for e in around.tolist()]
    opposite = np.arange(count) ^ 1
    walk, regions = _regions(following[opposite])
    drawing_unit = max(float(np.median(unit)), 1e-9) if count else 1.0
    thickness = np.array([widths.of(graph.branches[n]) for n, _ in ends]) / unit
    turned = np.abs(np.pi - gap)
    return Arrangement(
        tuple(ends),
        node,
        degree,
        opposite,
        told.points,
        told.tangents,
        told.curvatures,
        told.length,
        told.straightness,
        told.swing,
        thickness,
        gap,
        np.array(pairs, np.intp).reshape(-1, 2),
        wedge,
        walk[following],
        np.stack([walk, walk[opposite]], axis=1),
        np.asarray(-0.5 * np.bincount(walk, told.swept, regions) / drawing_unit**2),
        np.bincount(walk, told.length * unit, regions) / drawing_unit,
        (np.bincount(walk, told.swing, regions) + np.bincount(walk[following], turned, regions)) / (2.0 * np.pi),
    )
