"""Where exactly what is seen of a stroke begins and ends: a walk along it, on its ink."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from videovec.propagate.gaps import Piece, nodes_of
from videovec.propagate.judge import between_nodes
from videovec.propagate.nodes import Nodes
from videovec.propagate.record import Interval
from videovec.propagate.target import Image, Target, sample

__all__ = ["find_ends", "widened"]

Floats = NDArray[np.float64]
Ints = NDArray[np.intp]

_STEP = 0.5
"""Distance of the places that are looked at. working px"""
_INSIDE = 4
"""Nodes inside the seen part from which the walk begins."""
_OUTSIDE = 3
"""Nodes beyond the seen part that it may reach."""
_WIDENED = 1.0
"""By how much ink is widened, for strokes that lie beside its middle. working px"""
_THICK = 4.0
"""Half-width from which on the form of an end can be made out. working px"""
_ROUND, _SHOULDER = 0.3, 1.0
"""So far before its tip, and so far from its middle, a round end has no ink and one that is cut off has. Half-widths"""
_CUT_OFF = 0.5
"""How far a line is taken to reach beyond an end that is cut off, as round ends will be drawn there. Half-widths"""
_BEYOND = 1.5
"""How far beyond the line of another stroke the last ink may lie. working px"""
_LONG = 3.0
"""Length of the shortest end that is remembered never to have been seen. working px"""
_SURE = 2.0
"""An end that the walk reaches but for this is reached. working px"""
_SAME = 3.0
"""Where a line hides an end that was never seen, that end is where it was, but for a change beyond this. working px"""
_FREE = 6.0
"""Likewise, where nothing hides the end: a tip that lies beyond its ink was misplaced, or has slid. working px"""


@dataclass(frozen=True, slots=True, eq=False)
class _Scene:
    """What walks go over.

    Args:
        ink: Coverage, widened. float32 [H, W]
        threshold: From which on it is ink.
        points: Points on seen strokes. [K, 2] working px
        stroke: The stroke of each. int [K]
        half_width: Of each stroke. [S] working px
    """

    ink: Image
    threshold: float
    points: Floats
    stroke: Ints
    half_width: Floats

    def crossing(self, stroke: int, places: Floats) -> int | None:
        """The place that is nearest to the middle of another stroke on whose line the last place lies, if it does."""
        low, high = places.min(axis=0) - 8.0, places.max(axis=0) + 8.0
        near = (self.stroke != stroke) & ((self.points >= low) & (self.points <= high)).all(axis=1)
        if not near.any():
            return None
        gap = np.linalg.norm(places[:, None] - self.points[near], axis=2)
        reach = self.half_width[self.stroke[near]] + _WIDENED
        if (gap[-1] > reach + _BEYOND).all():
            return None
        place, other = np.unravel_index(int(gap.argmin()), gap.shape)
        return int(place) if gap[place, other] <= reach[other] else None

    def tip(self, places: Floats, bare: int, half_width: float) -> float:
        """How far ink reaches beyond the end of a line: half its width if that is round, less if it is cut off.

        Args:
            places: Along the line, `_STEP` apart. [M, 2] working px
            bare: The first of them that is not on ink.
            half_width: Of the line. working px

        Returns:
            The distance. working px
        """
        inside = max(bare - round((_WIDENED + _ROUND * half_width) / _STEP), 0)
        if half_width < _THICK or inside == 0:
            return _CUT_OFF * half_width
        step = places[inside] - places[max(inside - 2, 0)]
        across = np.array([-step[1], step[0]]) / max(float(np.linalg.norm(step)), 1e-9)
        sides = places[inside] + np.outer((-1.0, 1.0), _SHOULDER * half_width * across)
        is_round = (sample(self.ink, sides) <= self.threshold).any()
        return half_width if is_round else _CUT_OFF * half_width


def find_ends(
    nodes: Nodes,
    positions: Floats,
    half_width: Floats,
    seen: tuple[list[list[Piece]], Floats],
    target: Target,
) -> list[tuple[Interval, ...]]:
    """Find the seen parts of every stroke to a fraction of a node.

    A hidden stroke goes under the line of what hides it; the middle of that line is the end of what is seen.

    Args:
        nodes: N nodes.
        positions: Where they are. [N, 2] working px
        half_width: Half-width of each stroke. [S] working px
        seen: The runs of seen nodes of each stroke; and the most that was seen before, as arc fractions. [S, 2]
        target: The drawing's ink.

    Returns:
        The seen parts of each stroke as arc fractions, in their order. S of them
    """
    if not len(nodes):
        return [() for _ in nodes.bases]
    dense, owner = between_nodes(nodes, positions)
    scene = _Scene(widened(target), target.threshold, *_shown(nodes, dense, owner, seen[0]), half_width)
    parts: list[tuple[Interval, ...]] = []
    for s, basis in enumerate(nodes.bases):
        own = positions[nodes.starts[s] : nodes.starts[s + 1]]
        if not seen[0][s]:
            parts.append(())
        elif basis.is_closed and seen[0][s] == [(0, len(own) - 1)]:
            parts.append(((0.0, 1.0),))
        else:
            path = own, basis.u
            if basis.is_closed:
                parts.append(_ring_parts(scene, s, path, seen[0][s]))
            else:
                parts.append(_parts(scene, s, path, seen[0][s], _known(own, seen[1][s])))
    return parts


def widened(target: Target) -> Image:
    """Coverage, widened: ink is also where a stroke lies a little beside it. float32 [H, W]"""
    return np.asarray(cv2.dilate(target.ink, np.ones((3, 3), np.uint8)), np.float32)


def _shown(nodes: Nodes, dense: Floats, owner: Ints, seen: list[list[Piece]]) -> tuple[Floats, Ints]:
    """The points on seen runs [K, 2], and their strokes [K]."""
    shown = np.zeros(len(nodes), bool)
    for start, stop, pieces in zip(nodes.starts[:-1], nodes.starts[1:], seen, strict=True):
        for piece in pieces:
            shown[start + nodes_of(piece, stop - start)] = True
    return dense[shown[owner]], nodes.stroke[owner[shown[owner]]]


def _known(own: Floats, most_seen: Floats) -> tuple[float, float]:
    """The ends of the most that was seen; all, but where an end is missing that is long enough to be remembered."""
    length = float(np.linalg.norm(np.diff(own, axis=0), axis=1).sum())
    begin, end = most_seen.tolist()
    return begin if begin * length > _LONG else 0.0, end if (1.0 - end) * length > _LONG else 1.0


def _parts(
    scene: _Scene, stroke: int, path: tuple[Floats, Floats], pieces: list[Piece], known: tuple[float, float]
) -> tuple[Interval, ...]:
    """Where the seen parts of a stroke begin and end, from the runs of its nodes."""
    points, u = path
    count, back = len(points), (points[::-1], 1.0 - u[::-1])
    parts: list[Interval] = []
    for k, (first, last) in enumerate(pieces):
        low, high = (
            known if len(pieces) == 1 else (known[0] if k == 0 else 0.0, known[1] if k + 1 == len(pieces) else 1.0)
        )
        end = _walk_out(scene, stroke, path, (first, last, high))
        begin = 1.0 - _walk_out(scene, stroke, back, (count - 1 - last, count - 1 - first, 1.0 - low))
        parts.append((begin, end) if begin < end else (float(u[first]), float(u[last])))
    return _apart(parts)


def _ring_parts(scene: _Scene, stroke: int, path: tuple[Floats, Floats], pieces: list[Piece]) -> tuple[Interval, ...]:
    """Where the seen parts of a closed stroke with gaps begin and end; one over the seam is two parts."""
    count = len(path[1])
    points, u = np.tile(path[0], (3, 1)), np.concatenate([path[1] - 1.0, path[1], path[1] + 1.0])
    parts: list[Interval] = []
    for first, last in pieces:
        start, stop = first + count, last + count
        end = _walk_out(scene, stroke, (points, u), (start, stop, np.inf))
        begin = -_walk_out(
            scene, stroke, (points[::-1], -u[::-1]), (3 * count - 1 - stop, 3 * count - 1 - start, np.inf)
        )
        begin, end = (begin, end) if begin < end else (float(u[start]), float(u[stop]))
        turns = float(np.floor(begin))
        begin, end = begin - turns, end - turns
        parts += [(begin, end)] if end <= 1.0 else [(begin, 1.0), (0.0, end - 1.0)]
    return _apart(sorted(parts))


def _apart(parts: list[Interval]) -> tuple[Interval, ...]:
    """Intervals of which no two overlap: those that do are one."""
    joined = parts[:1]
    for begin, end in parts[1:]:
        if begin <= joined[-1][1]:
            joined[-1] = joined[-1][0], max(end, joined[-1][1])
        else:
            joined.append((begin, end))
    return tuple(joined)


def _walk_out(scene: _Scene, stroke: int, path: tuple[Floats, Floats], seen: tuple[int, int, float]) -> float:
    """Arc fraction at which the seen part ends, counted towards the end of a path of nodes and their fractions.

    ``seen`` is the run and the fraction at which the most that was ever seen ends; none of a closed stroke.
    An end that was never seen may have come to lie under the line that hides it: it is no more seen than before.
    """
    points, u = path
    start, stop = max(seen[0], seen[1] - _INSIDE), min(len(points) - 1, seen[1] + _OUTSIDE)
    along = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(points[start : stop + 1], axis=0), axis=1))])
    if along[-1] < _STEP:
        return float(u[stop])
    at = np.append(np.arange(0.0, along[-1], _STEP), along[-1])
    places = np.stack([np.interp(at, along, points[start : stop + 1, k]) for k in (0, 1)], axis=1)
    bare = np.flatnonzero(sample(scene.ink, places) <= scene.threshold)
    is_end = stop == len(points) - 1
    if not len(bare) and (seen[2] >= 1.0 or not is_end):
        return 1.0 if is_end else float(u[stop])
    half_width = float(scene.half_width[stroke])
    stop_at = int(bare[0]) if len(bare) else len(at) - 1
    last = np.flatnonzero(at[: stop_at + 1] >= at[stop_at] - 4.0 * half_width - 2.0 * _WIDENED)
    crossing = scene.crossing(stroke, places[last])
    shown = at[stop_at] - (_WIDENED + scene.tip(places, stop_at, half_width) if len(bare) else 0.0)
    reach = max(0.0, shown) if crossing is None else at[last[crossing]]
    if crossing is not None and seen[2] < 1.0:
        known = np.interp(seen[2], u[start : stop + 1], along, left=-np.inf, right=np.inf)
        if abs(float(known) - reach) <= _SAME:
            return seen[2]
    if is_end and along[-1] - reach <= (_FREE if crossing is None else _SURE):
        return 1.0
    return float(np.interp(reach, along, u[start : stop + 1]))
