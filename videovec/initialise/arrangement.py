"""The drawing around its junctions as arrays: branch ends, pairs of ends that may be one stroke, and regions."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from videovec.initialise.graph import Graph
from videovec.initialise.polyline import arc
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


def _swing(line: Floats, along: Floats, step: float) -> float:
    """Sum of the turns of a line that is sampled coarsely. rad"""
    count = int(along[-1] / step)
    if count < 2:
        return 0.0
    lengths = np.linspace(0.0, along[-1], count + 1)
    way = np.diff(np.interp(lengths, along, line[:, 0]) + 1j * np.interp(lengths, along, line[:, 1]))
    return float(np.abs(np.angle(way[1:] * np.conj(way[:-1]))).sum())


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


def _measure(graph: Graph, ends: list[End], unit: Floats) -> _Branches:
    """Sample every branch from both of its ends; all in units but ``swept``, the integral of x dy - y dx. px^2"""
    count = len(ends)
    points = np.zeros((count, len(REACHES), 2))
    samples = np.zeros((2, count, _SAMPLES, 2))
    bounds = np.zeros((2, count, 2))
    total, chord, swing, swept = (np.zeros(count) for _ in range(4))
    steps = np.linspace(0.0, 1.0, _SAMPLES)
    for number in range(0, count, 2):  # both ends of a branch stand side by side
        branch = graph.branches[ends[number][0]]
        line = np.concatenate([graph.position[[branch.start]], branch.line[1:-1], graph.position[[branch.stop]]])
        along = arc(line)
        x, y = line.T
        total[number : number + 2] = along[-1]
        chord[number : number + 2] = np.linalg.norm(line[-1] - line[0])
        swing[number : number + 2] = _swing(line, along, float(unit[number : number + 2].max()))
        area = float((x[:-1] * y[1:] - x[1:] * y[:-1]).sum())
        swept[number : number + 2] = area, -area
        own = slice(number, number + 2)
        wanted = [unit[own, None] * REACHES]
        for k, (low, high) in enumerate(_FITTED):
            start, stop = np.minimum(low * unit[own], 0.3 * along[-1]), np.minimum(high * unit[own], along[-1])
            bounds[k, own] = np.stack([start, stop], axis=1) / unit[own, None]
            wanted.append(start[:, None] + (stop - start)[:, None] * steps)
        lengths = np.minimum(np.concatenate(wanted, axis=1), along[-1])
        lengths[1] = along[-1] - lengths[1]
        where = np.stack([np.interp(lengths, along, x), np.interp(lengths, along, y)], axis=2)
        where = (where - line[[0, -1], None]) / unit[own, None, None]
        points[own] = where[:, : len(REACHES)]
        samples[:, own] = where[:, len(REACHES) :].reshape(2, 2, _SAMPLES, 2).swapaxes(0, 1)
    fits = [_fits(samples[k], bounds[k, :, 0], bounds[k, :, 1], high - low) for k, (low, high) in enumerate(_FITTED)]
    tangents = np.stack([fit[0] for fit in fits], axis=1)
    curvatures = np.stack([fit[1] for fit in fits], axis=1)
    return _Branches(points, tangents, curvatures, total / unit, chord / np.maximum(total, 1e-9), swing, swept)


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
    told = _measure(graph, ends, unit)
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
