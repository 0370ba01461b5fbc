"""Other beginnings for a registration that went wrong."""

from __future__ import annotations

from dataclasses import replace

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components

from videovec.propagate.judge import Verdict, judge
from videovec.propagate.registration import COARSE, FINE, RIGID, Source, parted, register
from videovec.propagate.search import find_motions, scene_of
from videovec.propagate.target import Target, sample

__all__ = ["moved_on", "place", "place_growing"]

Floats = NDArray[np.float64]
Ints = NDArray[np.intp]

_ACCEPT = 0.04
"""Share of nodes without ink, or of ink without nodes, up to which nothing else is tried."""
_TURNS = 24
_KEEP = 3
_FLOW_FALL = 10.0
"""Distance over which the picture that the optical flow sees falls off. px"""
_LOOSE = 0.02
"""What is left of the stiffness between groups that moved apart."""
_BAD = 0.25
"""Share of a stroke's nodes without ink from which on its group is searched for."""
_HIDDEN = 0.5
"""Share of a stroke that may be hidden on the page for it to be searched for."""
_AS_BEFORE = 1.02
"""Factor of the cost that is no reason to think that anything moved otherwise than before."""
_LEAP = 2.5
"""How far a part may be found again, in sizes of the part."""
_LEAP_PAGE = 0.08
"""How far any part may be found again, in long edges of the page."""
_FAST = 6.0
"""Motion of a node in the last step from which on it is also begun from where that leads. px"""
_LEFT = 12
"""Centre-line pixels without strokes that are worth a search."""
_TOUCH = 6.0
"""Strokes that come this near are one part. px"""
_FEWEST = 6
"""Nodes of the smallest group that is searched for."""
_STRAYED = 1.6
"""Mean feature distance from which on a part may lie on the ink of another, or wrong way round. px"""
_GAIN = 0.03
"""Share of the cost that a search must save; of less than a quarter of all nodes less is asked, in proportion."""
_ROUNDS = 8


def place(source: Source, target: Target, before: Target, velocity: Floats) -> tuple[Source, Floats]:
    """Find where strokes went, whatever the motion: rigidly, to about a pixel.

    Args:
        source: The strokes at rest on the previous drawing.
        target: The drawing to move to.
        before: The drawing that they come from.
        velocity: How each node moved in the last step. [N, 2] working px

    Returns:
        The source, with weaker ties between parts that moved apart, and positions [N, 2] in working px.
    """
    positions = register(source, target, source.rest, (RIGID,))
    verdict = judge(source, target, positions)
    if len(target) and np.abs(velocity).max(initial=0.0) > _FAST:
        positions, verdict = _as_before(source, target, velocity, (positions, verdict))
    if not verdict.is_accepted(_ACCEPT):
        positions, verdict = _best_start(source, target, before, velocity, (positions, verdict))
    if _is_settled(source, verdict):
        return source, positions
    return _search_parts(source, target, positions, verdict)


def place_growing(source: Source, target: Target, before: Target, velocity: Floats) -> tuple[Source, Floats]:
    """As `place`, for strokes of which less may be drawn: if they explain all ink where they are, they stay there.

    Exactly there, if that explains it as well as a registration that lets them move: what is drawn of a line would pull
    the rest of it along.
    """
    if len(target) and judge(source, target, source.rest).ink_far.mean() <= _ACCEPT:
        return source, source.rest
    near = target.distance_at(source.rest) <= _TOUCH
    positions = register(replace(source, weight=near.astype(float)), target, source.rest, (FINE,))
    if len(target) and judge(source, target, positions).ink_far.mean() <= 2 * _ACCEPT:
        return source, positions
    return place(source, target, before, velocity)


def moved_on(source: Source, target: Target, velocity: Floats) -> Floats:
    """Register strokes from where they are if everything moves as in the last step. [N, 2] working px"""
    start = source.rest + velocity
    return register(parted(source, start), target, start, (FINE,))


def _as_before(
    source: Source, target: Target, velocity: Floats, best: tuple[Floats, Verdict]
) -> tuple[Floats, Verdict]:
    """Try whether everything moves on as in the last step: what passes before the rest must not drag it along."""
    positions = moved_on(source, target, velocity)
    verdict = judge(source, target, positions)
    return (positions, verdict) if verdict.cost < _AS_BEFORE * best[1].cost else best


def _best_start(
    source: Source, target: Target, before: Target, velocity: Floats, best: tuple[Floats, Verdict]
) -> tuple[Floats, Verdict]:
    """Try the whole drawing from other beginnings."""
    starts = [source.rest + _flow(before, target, source.rest)]
    if np.abs(velocity).max(initial=0.0) > 1.0:
        starts.append(source.rest + velocity)
    tangents = source.nodes.tangents(source.rest)
    follows = source.weight > 0
    if follows.any():
        scene = scene_of(target, np.ones(len(target)))
        rest = source.rest[follows]
        motions = find_motions(scene, rest, tangents[follows], _TURNS, _KEEP)
        motions = [motion for motion in motions if _is_leap_plausible(rest, motion.apply(rest), target)]
        starts.extend(motion.apply(source.rest) for motion in motions)
    for start in starts:
        positions = register(source, target, start, (COARSE, FINE))
        verdict = judge(source, target, positions)
        if verdict.cost < best[1].cost:
            best = positions, verdict
    return best


def _flow(before: Target, target: Target, positions: Floats) -> Floats:
    """Dense optical flow between pictures that glow around the ink. [N, 2] px"""
    if min(before.ink.shape) < 16:
        return np.zeros_like(positions)
    first, second = ((255 * np.exp(-t.distance / _FLOW_FALL)).astype(np.uint8) for t in (before, target))
    flow = np.zeros((*before.ink.shape, 2), np.float32)
    solver = cv2.DISOpticalFlow.create(cv2.DISOPTICAL_FLOW_PRESET_MEDIUM)
    return sample(np.asarray(solver.calc(first, second, flow), np.float32), positions)


def _search_parts(source: Source, target: Target, positions: Floats, verdict: Verdict) -> tuple[Source, Floats]:
    """Search for parts that went astray, one after the other; each may move apart from the rest."""
    part = np.zeros(len(positions), np.intp)
    tried: set[tuple[int, ...]] = set()
    tangents = source.nodes.tangents(source.rest)
    for _ in range(_ROUNDS):
        group = _next_group(source, verdict, tried)
        if group is None or _is_settled(source, verdict):
            break
        members = np.isin(source.nodes.stroke, group)
        scene = scene_of(target, np.clip(verdict.ink_cost / 4.0, 0.25, 1.0))
        label = np.where(members, part.max() + 1, part)
        apart = _loosened(source, label)
        rest = source.rest[members]
        for motion in find_motions(scene, rest, tangents[members], _TURNS, _KEEP):
            if not _is_leap_plausible(rest, motion.apply(rest), target):
                continue
            start = np.where(members[:, None], motion.apply(source.rest), positions)
            moved = register(apart, target, start, (COARSE, FINE))
            new = judge(apart, target, moved)
            if new.cost < (1.0 - _GAIN * min(1.0, 4.0 * float(members.mean()))) * verdict.cost:
                positions, verdict, part = moved, new, label
        source = _loosened(source, part)
    return source, positions


def _is_leap_plausible(rest: Floats, moved: Floats, target: Target) -> bool:
    """Whether a part would go no farther than a few times its own size: an eye that closes is not a heart elsewhere."""
    leap = float(np.median(np.linalg.norm(moved - rest, axis=1)))
    return bool(leap <= max(_LEAP * float(np.ptp(rest, axis=0).max()), _LEAP_PAGE * max(target.ink.shape)))


def _is_settled(source: Source, verdict: Verdict) -> bool:
    """Whether no stroke has lost its ink, or there is not enough ink left for any that has."""
    return not _bad(source, verdict).any() or int(verdict.ink_far.sum()) < _LEFT


def _bad(source: Source, verdict: Verdict) -> NDArray[np.bool_]:
    """Strokes that lie off the ink with much of their length, and those of parts that fit badly. bool [S]

    Those of which little is seen would find too much that looks like that little.
    """
    stroke, count = source.nodes.stroke, len(source.nodes.bases)
    size = np.maximum(np.bincount(stroke, source.weight > 0, minlength=count), 1)
    part = _parts(source)[stroke]
    strayed = np.bincount(part, verdict.node_cost) > _STRAYED * np.maximum(np.bincount(part, source.weight > 0), 1)
    bad = (np.bincount(stroke, verdict.node_far, minlength=count) > _BAD * size) | strayed[_parts(source)]
    return np.asarray(bad & (source.nodes.shares(verdict.hidden) <= _HIDDEN))


def _next_group(source: Source, verdict: Verdict, tried: set[tuple[int, ...]]) -> Ints | None:
    """The largest group of bad strokes that was not searched for yet: a whole part, or one stroke."""
    stroke = source.nodes.stroke
    count = len(source.nodes.bases)
    size = np.bincount(stroke, source.weight > 0, minlength=count)
    bad = _bad(source, verdict)
    part = _parts(source)
    groups = [np.flatnonzero(part == p) for p in np.unique(part[bad])]
    groups += [np.flatnonzero((part == p) & bad) for p in np.unique(part[bad])]
    groups += [np.array([s]) for s in np.flatnonzero(bad)]
    groups = [g for g in groups if size[g].sum() >= _FEWEST and tuple(g) not in tried]
    if not groups:
        return None
    group = max(groups, key=lambda g: float(size[g].sum()))
    tried.add(tuple(group))
    return group


def _parts(source: Source) -> Ints:
    """Which strokes touch each other at rest, directly or through others. int [S]"""
    own = np.repeat(np.arange(len(source.nodes)), np.diff(source.indptr))
    gap = np.linalg.norm(source.rest[own] - source.rest[source.index], axis=1)
    touching = gap < _TOUCH
    a, b = source.nodes.stroke[own[touching]], source.nodes.stroke[source.index[touching]]
    count = len(source.nodes.bases)
    return np.asarray(connected_components(coo_matrix((np.ones(len(a)), (a, b)), shape=(count, count)))[1], np.intp)


def _loosened(source: Source, part: Ints) -> Source:
    """The source with weak edges between parts."""
    own = np.repeat(np.arange(len(source.nodes)), np.diff(source.indptr))
    apart = part[own] != part[source.index]
    return replace(source, across=np.where(apart, _LOOSE * source.across, source.across))
