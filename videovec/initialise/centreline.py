"""Centre lines of strokes: branches strung together, smoothed between corners, run out to their true ends."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import cv2
import numpy as np
from numpy.typing import NDArray

from videovec.initialise.graph import Graph
from videovec.initialise.junctions import Pairing
from videovec.initialise.polyline import angle_between, arc, at_arc, corners, direction, resample, sharpen, smooth
from videovec.initialise.prune import Widths

__all__ = ["CentreLine", "Chain", "centre_line", "chains", "closed_line", "strung"]

Floats = NDArray[np.float64]
Ints = NDArray[np.intp]
End = tuple[int, int]

_STEP = 0.5  # px between samples of a centre line
_TRIM = 0.5  # widths that are left out on both sides of a junction that a stroke runs through
_KINK = 60.0  # degrees beyond which a stroke that runs through a junction has a corner there
_CORNER = 50.0  # degrees
_CORNER_REACH = 1.2  # widths to either side between which a corner is told
_ROUNDED = 0.8  # widths next to a corner in which thinning rounds it off
_SMOOTHING = 0.3  # widths
_THICK, _THICK_SHARE = 4.0, 0.3  # px up to which a skeleton wobbles with its line's width, and how it does beyond


@dataclass(frozen=True, slots=True, eq=False)
class Chain:
    """Branches that make one stroke.

    Args:
        ends: The end at which each branch is entered, in order.
        is_closed: Whether the last branch runs on into the first.
    """

    ends: tuple[End, ...]
    is_closed: bool


@dataclass(frozen=True, slots=True, eq=False)
class CentreLine:
    """The middle of one stroke.

    Args:
        line: Samples about half a px apart; a closed line repeats its first as its last. [M, 2] px
        corners: Samples at which it turns sharply. int [K]
        width: Width of its lines by the mask. px
        is_closed: Whether it is closed.
    """

    line: Floats
    corners: Ints
    width: float
    is_closed: bool


def _opposite(end: End) -> End:
    return end[0], 1 - end[1]


def chains(graph: Graph, pairings: list[Pairing], rings: Sequence[Chain] = ()) -> list[Chain]:
    """String branches together as the junctions decided.

    Args:
        graph: The graph.
        pairings: A decision for every node where branches meet.
        rings: Chains that are known; none of their branches is in ``pairings``.

    Returns:
        Every other branch once, in chains, open chains first; then the rings.
    """
    link: dict[End, End] = {}
    for pairing in pairings:
        for i, j in pairing.links:
            link[pairing.ends[i]], link[pairing.ends[j]] = pairing.ends[j], pairing.ends[i]
    used = {number for ring in rings for number, _ in ring.ends}
    result = []
    starts = [(n, e) for n in sorted(graph.branches) for e in (0, 1) if (n, e) not in link]
    for is_closed, candidates in ((False, starts), (True, [(n, 0) for n in sorted(graph.branches)])):
        for entry in candidates:
            if entry[0] in used:
                continue
            ends = []
            here: End | None = entry
            while here is not None and here[0] not in used:
                used.add(here[0])
                ends.append(here)
                here = link.get(_opposite(here))
            result.append(Chain(tuple(ends), is_closed))
    return [*result, *rings]


def _trimmed(line: Floats, before: float, after: float) -> Floats:
    """A line without its first and last stretch; at least its middle is kept."""
    along = arc(line)
    total = along[-1]
    low, high = min(before, 0.45 * total), total - min(after, 0.45 * total)
    inner = line[(along > low) & (along < high)]
    ends = at_arc(line, np.array([low, high]))
    return np.concatenate([ends[:1], inner, ends[1:]])


def strung(graph: Graph, chain: Chain, widths: Widths) -> tuple[Floats, float]:
    """Samples of a chain, and its width."""
    parts: list[Floats] = []
    branches = [graph.outward(*end) for end in chain.ends]
    count = len(branches)
    for i, branch in enumerate(branches):
        is_first, is_last = i == 0 and not chain.is_closed, i == count - 1 and not chain.is_closed
        width_before, width_after = widths.at(graph, branch.start), widths.at(graph, branch.stop)
        before = 0.0 if is_first else _TRIM * width_before
        after = 0.0 if is_last else _TRIM * width_after
        if is_first and graph.degree(branch.start) > 1:
            parts.append(graph.position[[branch.start]])
            before = 0.5 * _TRIM * width_before
        stop_at_node = is_last and graph.degree(branch.stop) > 1
        if stop_at_node:
            after = 0.5 * _TRIM * width_after
        parts.append(_trimmed(branch.line, before, after))
        if stop_at_node:
            parts.append(graph.position[[branch.stop]])
        elif not is_last:
            following = branches[(i + 1) % count]
            reach = 2.0 * width_after
            turn = angle_between(
                -direction(branch.line[::-1], _TRIM * width_after, reach),
                direction(following.line, _TRIM * width_after, reach),
            )
            if turn > _KINK:
                parts.append(graph.position[[branch.stop]])
    weights = np.array([branch.length for branch in branches])
    width = float(np.average([widths.of(branch) for branch in branches], weights=weights + 1e-9))
    return np.concatenate(parts), width


def _run_out(line: Floats, width: float, coverage: NDArray[np.float32]) -> Floats:
    """Move the last sample of a line to the middle of its round cap, told by how far the ink reaches beyond it."""
    inward = direction(line[::-1], 0.3 * width, 1.5 * width + 1.0)
    if not inward.any():
        return line
    along = np.arange(-0.5, 2.0 * width + 2.0, 0.25)
    where = (line[-1] - along[:, None] * inward - 0.5).astype(np.float32)
    profile = cv2.remap(coverage, where[:, 0], where[:, 1], cv2.INTER_LINEAR).ravel()
    peak = max(float(profile[:3].max()), 1e-6)
    empty = np.flatnonzero(profile < 0.25 * peak)
    stop = int(empty[0]) + 1 if len(empty) else len(profile)
    if stop == len(profile):  # the ink goes on: another line's
        return line
    reach = 0.25 * float(profile[:stop].sum()) / peak - 0.5
    extension = reach - 0.5 * width
    if extension > 0.0:
        return np.concatenate([line, [line[-1] - min(extension, width) * inward]])
    total = arc(line)[-1]
    return _trimmed(line, 0.0, min(-extension, 0.3 * total))


def _tempered(width: float) -> float:
    """Scale of a skeleton's wobble: a line's width, growing more slowly where lines are wide. px"""
    return min(width, _THICK) + _THICK_SHARE * max(width - _THICK, 0.0)


def _smoothed(line: Floats, width: float, is_closed: bool, step: float) -> tuple[Floats, Ints]:
    """Smooth a line between its corners. A closed one is given, and returned, with its first sample repeated."""
    reach = max(1, round(max(_CORNER_REACH * _tempered(width), 2.5) / step))
    sigma = max(_SMOOTHING * _tempered(width), 0.6) / step
    if is_closed:
        ring = line[:-1]
        found = corners(ring, reach, _CORNER, True)
        if len(found) == 0:
            ring = smooth(ring, sigma, True)
            return np.concatenate([ring, ring[:1]]), found
        ring = np.roll(ring, -found[0], axis=0)
        line, found = np.concatenate([ring, ring[:1]]), found - found[0]
    else:
        found = corners(line, reach, _CORNER, False)
    skip, side = max(1, round(_ROUNDED * width / step)), max(3, round(width / step))
    for corner in found:
        line = sharpen(line, int(corner), skip, side, width)
    cuts = np.unique(np.concatenate([[0], found, [len(line) - 1]]))
    parts = [smooth(line[low : high + 1], sigma, False) for low, high in pairwise(cuts)]
    return np.concatenate([parts[0], *(part[1:] for part in parts[1:])]), found


def centre_line(graph: Graph, chain: Chain, widths: Widths, coverage: NDArray[np.float32]) -> CentreLine:
    """The centre line of a chain.

    Args:
        graph: The graph.
        chain: Its branches.
        widths: How wide lines are.
        coverage: The ink. [H, W] in [0, 1]

    Returns:
        Its samples and corners.
    """
    line, width = strung(graph, chain, widths)
    if chain.is_closed:
        return closed_line(line, width)
    first, last = graph.outward(*chain.ends[0]).start, graph.outward(*chain.ends[-1]).stop
    line = resample(line, _STEP)
    if graph.degree(last) == 1:
        line = _run_out(line, width, coverage)
    if graph.degree(first) == 1:
        line = _run_out(line[::-1], width, coverage)[::-1]
    line = resample(line, _STEP)
    line, found = _smoothed(line, width, False, float(arc(line)[-1]) / max(len(line) - 1, 1) or _STEP)
    return CentreLine(line, found, width, False)


def closed_line(ring: Floats, width: float) -> CentreLine:
    """The centre line of a closed run of samples, the first not repeated."""
    line = resample(np.concatenate([ring, ring[:1]]), _STEP)
    line, found = _smoothed(line, width, True, _STEP)
    return CentreLine(line, found, width, True)
