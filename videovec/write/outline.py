"""A stroke of variable width as the closed path around it.

The stroke is the union of its cross-sections (centre line plus and minus half-width along the normal), of half discs at
its ends and of fans at its corners. The outline runs along one side, around the end and back along the other, so that
each of these pieces is swept in the same sense, and the *nonzero* rule fills exactly their union, however the stroke
crosses itself. Two things would break that, and are mended where they arise:

* where the centre line bends more tightly than the half-width, the inner side would run backwards: it is held at the
  centre of curvature. Nothing is lost, for what lies beyond is nearer to another part of the stroke;
* at a corner the radius of curvature is zero, so the inner side passes through the joint itself.

How many pieces a side has is a plan apart from the outline, so that one plan can serve a stroke for its whole life, as
Lottie needs.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from videovec.curves import evaluate, parameter_at, segments_of
from videovec.stroke_shape import StrokeShape
from videovec.write.sections import Stations, angle_between, cut_at_cusps, even_grid, find_cusps, shared_out

__all__ = ["OutlinePlan", "outline", "plan_outline"]

Floats = NDArray[np.float64]
Ints = NDArray[np.intp]

_ABOUT = 3.0  # radians of turn, of pi, from which a corner is one that turns about
_INSIDE = 0.02  # px by which a side nearer to another part of the stroke lies within its ink
_SHORTEST = 1.5  # px along a side under which a piece is not cut again, however the curve twists there
_TOLERANCE = 0.02  # px between an offset curve and the cubics that stand for it
_PIECES = (1, 2, 3, 4, 5, 6, 8, 10, 12, 16, 24, 32)
_THIRDS = np.arange(4) / 3
_BETWEEN = np.array([1, 3, 5]) / 6
# Handles of the cubic that passes through four samples at t = 0, 1/3, 2/3, 1.
_THROUGH = np.array([[6, 0, 0, 0], [-5, 18, -9, 2], [2, -9, 18, -5], [0, 0, 0, 6]]) / 6
_STRAIGHT = np.array([[3, 0, 0, 0], [2, 0, 0, 1], [1, 0, 0, 2], [0, 0, 0, 3]]) / 3


@dataclass(frozen=True, slots=True, eq=False)
class OutlinePlan:
    """How many cubics the outline of a stroke of n segments has, and where.

    Args:
        is_cut: Which segments turn about on the spot on some drawing, and are cut in two there. bool [n]
        pieces: Cubics on each side of each segment, after those cuts. int [m]
        turns: Cubics on each side of the joint after each segment: none where it is smooth, one for a slight corner,
            two for a sharp one. int [m]
        is_loop: Whether the outline is a ring, with an outer and an inner loop; otherwise it has two round ends.
    """

    is_cut: NDArray[np.bool_]
    pieces: Ints
    turns: Ints
    is_loop: bool


def plan_outline(shapes: Sequence[StrokeShape], tolerance: float = _TOLERANCE) -> OutlinePlan:
    """A plan that draws a stroke within a tolerance in each of its shapes.

    Args:
        shapes: One stroke, on one or more drawings.
        tolerance: How far a side may lie from the true offset curve, where that is no twist smaller than a pixel. px

    Returns:
        The plan, with as few pieces as will do for all.
    """
    is_cut = np.asarray(find_cusps(np.stack([segments_of(shape.points) for shape in shapes]))[0].any(0))
    control, joints = _splines(shapes, is_cut)
    widths = np.stack([joints[:, :-1], joints[:, 1:]], -1)
    is_loop = all(shape.is_closed and shape.is_whole for shape in shapes)
    turns = _turns_needed(control, widths, tolerance)
    if not is_loop:
        turns[-1] = 0
    return OutlinePlan(is_cut, _pieces_needed(control, widths, tolerance), turns, is_loop)


def outline(shapes: Sequence[StrokeShape], plan: OutlinePlan) -> tuple[Floats, ...]:
    """The outline of the visible part of a stroke, to be filled by the nonzero rule.

    Args:
        shapes: One stroke, on K drawings; hidden ends shrink their pieces to nothing, so that the number of cubics
            stays the plan's.
        plan: How many cubics it has.

    Returns:
        One closed spline, or two for a ring: the last point of each equals its first. [K, 3m+1, 2] px
    """
    control, widths = _splines(shapes, plan.is_cut)
    segment, t = _knots(control, widths, shapes, plan)
    each = np.arange(len(shapes))[:, None]
    before, after = widths[each, segment][..., None], widths[each, segment + 1][..., None]
    stations = Stations.at(control[each, segment], before + (after - before) * t, t)
    left, right = (_side(stations, sign, plan) for sign in (1.0, -1.0))
    if plan.is_loop:
        return _joined(left), _joined(right[:, ::-1, ::-1])
    quarter = np.broadcast_to(np.pi / 2, (len(shapes), 3))
    head = _arcs(stations, (-1, 3), quarter * [1, 0, -1])
    tail = _arcs(stations, (0, 0), quarter * [-1, -2, -3])
    left[:, -1, 3], right[:, 0, 0] = head[:, 0, 0], tail[:, 0, 0]  # round ends have their full width, however tight
    return (_joined(np.concatenate([left, head, right[:, ::-1, ::-1], tail], axis=1)),)


def _pieces_needed(control: Floats, widths: Floats, tolerance: float) -> Ints:
    """Cubics on a side of each segment, the same for all K shapes. int [n]"""
    needed = np.full(control.shape[1], _PIECES[-1], dtype=np.intp)
    open_ = np.arange(control.shape[1])
    grid, extent = even_grid(control.reshape(-1, 4, 2), widths.reshape(-1, 2))
    grid, enough = grid.reshape(*widths.shape[:2], -1), (extent / _SHORTEST).reshape(widths.shape[:2])
    for count in _PIECES[:-1]:
        some, wide, cuts = (array[:, open_].reshape(-1, *array.shape[2:]) for array in (control, widths, grid))
        error = _side_error(some, wide, cuts, count, tolerance).reshape(len(control), -1)
        is_good = ((error <= tolerance) | (count >= enough[:, open_])).all(0)
        needed[open_[is_good]] = count
        open_ = open_[~is_good]
        if not len(open_):
            break
    return needed


def _side_error(control: Floats, widths: Floats, grid: Floats, count: int, tolerance: float) -> Floats:
    """How far ``count`` cubics lie from the sides of each segment, along the normal, where they are seen. [G] px"""
    edges = shared_out(grid, count)
    start, step = edges[:, :-1, None], np.diff(edges, axis=1)[..., None]
    at_knots, at_between = (
        Stations.at(control, widths[:, :1] + (widths[:, 1:] - widths[:, :1]) * t, t)
        for t in ((start + step * within).reshape(len(control), -1) for within in (_THIRDS, _BETWEEN))
    )
    worst = np.zeros(len(control))
    for sign in (1.0, -1.0):
        cubics = _through(at_knots.side(sign).reshape(-1, count, 4, 2), at_knots.is_tight(sign).reshape(-1, count, 4))
        drawn = evaluate(cubics[..., None, :, :], _BETWEEN).reshape(len(control), -1, 2)
        error = np.abs(((drawn - at_between.side(sign)) * at_between.normal).sum(-1))
        error[at_between.is_tight(sign)] = 0.0
        segment, place = np.nonzero(error > tolerance)
        to_others = at_between.side(sign)[segment, place][:, None] - evaluate(control[segment, None], grid[segment])
        reach = widths[segment, :1] + (widths[segment, 1:] - widths[segment, :1]) * grid[segment]
        reach = np.minimum(reach, at_between.half_width[segment, place][:, None])
        is_inside = (np.linalg.norm(to_others, axis=-1) < reach - _INSIDE).any(1)
        error[segment[is_inside], place[is_inside]] = 0.0
        worst = np.maximum(worst, error.max(1))
    return worst


def _through(samples: Floats, is_tight: NDArray[np.bool_]) -> Floats:
    """Cubics through four samples each; straight ones where the side is held back, for those lie inside the ink."""
    straight = np.asarray(is_tight.all(-1))[..., None, None]
    return np.where(straight, _STRAIGHT @ samples, _THROUGH @ samples)


def _turns_needed(control: Floats, widths: Floats, tolerance: float) -> Ints:
    """Cubics at the joint after each segment, the last joint being the first again. int [n]"""
    ends = np.broadcast_to([0.0, 1.0], widths.shape)
    stations = Stations.at(control, widths, ends)
    turn = np.abs(angle_between(stations.tangent[:, :, 1], np.roll(stations.tangent[:, :, 0], -1, axis=1)))
    swing = turn * widths[:, :, 1]
    reach = np.linalg.norm(control[:, :, 3] - control[:, :, 0], axis=-1)
    room = np.minimum(reach, np.roll(reach, -1, axis=1))
    is_sharp = (turn > 1.0) | (swing > 0.25 * room)
    turns: Ints = np.where(swing <= tolerance / 2, 0, np.where(is_sharp, 2, 1)).max(0).astype(np.intp)
    return turns


def _side(stations: Stations, sign: float, plan: OutlinePlan) -> Floats:
    """The cubics along one side, those of its corners between. [K, m, 4, 2]"""
    pieces = _through(stations.side(sign), stations.is_tight(sign))
    starts = np.concatenate([[0], np.cumsum(plan.pieces)])
    parts: list[Floats] = []
    for k, turns in enumerate(plan.turns):
        parts.append(pieces[:, starts[k] : starts[k + 1]])
        if turns:
            joint = int(starts[k + 1]) - 1, int(starts[(k + 1) % len(plan.turns)])
            corner = _corner(stations, sign, joint, int(turns))
            pieces[:, joint[0], 3] = corner[:, 0, 0]  # a fan has its full width, however tight the sides are there
            pieces[:, joint[1], 0] = corner[:, -1, 3]
            parts.append(corner)
    return np.concatenate(parts, axis=1)


def _corner(stations: Stations, sign: float, joint: tuple[int, int], turns: int) -> Floats:
    """One side of a corner: a fan where it is the outer one, else the way through the joint. [K, turns, 4, 2]"""
    before, after = joint
    turn = angle_between(stations.tangent[:, before, 3], stations.tangent[:, after, 0])
    bend = stations.curvature[:, before, 3] + stations.curvature[:, after, 0]
    is_about = np.abs(turn) > _ABOUT  # such a turn may go either way; it goes as the curve bends
    turn = np.where(is_about & (turn * bend < 0), turn - 2 * np.pi * np.sign(turn), turn)[:, None]
    fan = _arcs(stations, (before, 3), sign * np.pi / 2 + turn * np.arange(turns + 1) / turns)
    side = stations.side(sign)
    way = [side[:, before, 3], side[:, after, 0]]
    if turns == 2:
        way.insert(1, stations.center[:, before, 3])
    straight = np.stack([_STRAIGHT @ np.stack([a, a, b, b], axis=1) for a, b in pairwise(way)], axis=1)
    return np.where((sign * turn <= 0)[..., None, None], fan, straight)


def _arcs(stations: Stations, place: tuple[int, int], angles: Floats) -> Floats:
    """Circular arcs around a station, between angles [K, A] from its tangent to the left. [K, A - 1, 4, 2]

    Source:
        Handles of (4/3) tan(angle / 4) radii: within 3e-4 of the radius for a quarter turn.
    """
    center, tangent = (array[:, *place][:, None] for array in (stations.center, stations.tangent))
    radius = stations.half_width[:, *place][:, None, None]
    heading = np.arctan2(tangent[..., 1], tangent[..., 0]) + angles
    outward = radius * np.stack([np.cos(heading), np.sin(heading)], -1)
    along = np.stack([-outward[..., 1], outward[..., 0]], -1)
    handle = (4 / 3 * np.tan(np.diff(angles) / 4))[..., None]
    on = center + outward
    return np.stack([on[:, :-1], on[:, :-1] + handle * along[:, :-1], on[:, 1:] - handle * along[:, 1:], on[:, 1:]], 2)


def _joined(cubics: Floats) -> Floats:
    """One closed spline out of cubics that follow each other. [K, m, 4, 2] -> [K, 3m+1, 2]"""
    points = cubics[:, :, 1:].reshape(len(cubics), -1, 2)
    return np.concatenate([points[:, -1:], points], axis=1)


def _splines(shapes: Sequence[StrokeShape], is_cut: NDArray[np.bool_]) -> tuple[Floats, Floats]:
    """Segments [K, m, 4, 2] and half-widths [K, m+1] of a stroke on K drawings, cut where the plan says."""
    control = np.stack([segments_of(shape.points) for shape in shapes])
    widths = np.stack([shape.half_width for shape in shapes])
    return cut_at_cusps(control, widths, is_cut) if is_cut.any() else (control, widths)


def _knots(control: Floats, widths: Floats, shapes: Sequence[StrokeShape], plan: OutlinePlan) -> tuple[Ints, Floats]:
    """Segment [K, Q] and four parameters [K, Q, 4] of each piece; hidden pieces lie at the end of the visible part."""
    count = len(plan.pieces)
    ends = np.stack([widths[:, :-1], widths[:, 1:]], -1)
    grid = even_grid(control.reshape(-1, 4, 2), ends.reshape(-1, 2))[0].reshape(len(shapes), count, -1)
    cuts = [k + shared_out(grid[:, k], int(pieces)) for k, pieces in enumerate(plan.pieces)]
    edges = np.concatenate([np.stack([cut[:, :-1], cut[:, 1:]], -1) for cut in cuts], axis=1)  # [K, Q, 2]
    segment = np.tile(np.repeat(np.arange(count), plan.pieces), (len(shapes), 1))
    for k, shape in enumerate(shapes):
        if not shape.is_whole:
            spline = np.concatenate([control[k, 0, :1], control[k, :, 1:].reshape(-1, 2)])
            at, t = parameter_at(spline, np.asarray(shape.visible))
            edges[k] = np.clip(edges[k], (at + t)[0], max(at + t))
            is_hidden = edges[k, :, 0] == edges[k, :, 1]
            segment[k, is_hidden] = np.minimum(edges[k, is_hidden, 0].astype(np.intp), count - 1)
    edges = edges - segment[..., None]
    return segment, edges[..., :1] + (edges[..., 1:] - edges[..., :1]) * _THIRDS
