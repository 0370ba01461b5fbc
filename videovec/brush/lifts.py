"""Where the pen was lifted inside a stroke: a brush begins anew with every stroke that is drawn, and says so.

Tracing takes strokes that meet end to end for one. Along one that a pen drew, the place in the texture goes on and the
direction stays; where another place or the other direction explains the rest of the stroke far better, two were drawn.
A stroke has many places to choose from, so that the best of them always explains something: a lift counts only if the
texture of the *other* strokes, followed along the ink of one side of the centre line, explains so much more of the ink
on the *other* side that it pays for a stroke, and if either side alone says so at the same place.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from videovec.brush.align import Alignment
from videovec.brush.drift import textures_without
from videovec.brush.refine import Laid
from videovec.brush.strips import TEXELS_PER_WIDTH, Strip, joint_arcs
from videovec.brushwork import Laying, stroke_joints
from videovec.strokes import Layout

__all__ = ["find_lifts", "part_strokes"]

Floats = NDArray[np.float64]
Ints = NDArray[np.intp]

_HOP = 6  # texels of arc over which the place in the texture drifts by at most one
_DRIFT, _LIFT = 6.0, 300.0  # prices of a drift and of a lift, in texels' worth of unexplained grain
_PAYS = 600.0  # what a lift must explain of ink that did not choose it, in texels' worth of grain
_SLIP = 2.0  # widths that a place may jump in its own direction without a lift: arc lengths are wrong
_AGREED = 2.5  # widths that the two sides may differ by
_LEAST = 4.0  # widths of either part of a parted stroke
_NEAR = 2.5  # widths within which a stroke is parted at its sharpest joint


@dataclass(frozen=True, slots=True, eq=False)
class _Path:
    """The way along a texture that costs least: state of every step, and the steps before which it jumps. [K], [n]"""

    state: Ints
    jumps: Ints


def find_lifts(strips: list[Strip], found: Alignment, only_turned: bool = False) -> list[Floats]:
    """Where along each stroke the texture begins anew.

    Args:
        strips: S strips.
        found: The texture, as far as it was learned from them.
        only_turned: Whether to part strokes only where they turn round, which no error of the repeat explains.

    Returns:
        Arcs of each stroke. S times [K] widths
    """
    others, slip = textures_without(strips, found), np.inf if only_turned else _SLIP
    return [_lifts_of(strip, texture, found.repeat, slip) for strip, texture in zip(strips, others, strict=True)]


def _lifts_of(strip: Strip, texture: Floats, repeat: float, slip: float) -> Floats:
    none = np.zeros(0)
    length, seen = len(strip.grain) / TEXELS_PER_WIDTH, float(strip.weight.sum())
    unit = float((strip.weight * strip.grain**2).sum()) / max(seen, 1e-9)
    if length < 2 * _LEAST or seen < 2 * _PAYS:
        return none
    sides = [_costs(side, texture, repeat) for side in _sides(strip)]
    together = _cheapest(sides[0] + sides[1], _DRIFT * unit, _LIFT * unit)
    jumps = _far(together, len(texture), slip / repeat)
    if not len(jumps):
        return none
    alone = [_cheapest(side, 0.5 * _DRIFT * unit, 0.5 * _LIFT * unit) for side in sides]
    is_agreed = [all(_is_near(jump, path.jumps) for path in alone) for jump in jumps]
    lifts = jumps[is_agreed] * _HOP / TEXELS_PER_WIDTH
    lifts = lifts[(lifts >= _LEAST) & (lifts <= length - _LEAST)]
    whole = [_cheapest(side, 0.5 * _DRIFT * unit, np.inf) for side in sides]
    gain = sum(_cost(sides[1 - k], whole[k]) - _cost(sides[1 - k], alone[k]) for k in (0, 1))
    return lifts if gain > _PAYS * unit * len(lifts) else none


def _sides(strip: Strip) -> tuple[Strip, Strip]:
    """The strip with one side of its centre line unseen, and with the other."""
    is_left = np.arange(strip.weight.shape[1]) < strip.weight.shape[1] // 2
    return replace(strip, weight=strip.weight * is_left), replace(strip, weight=strip.weight * ~is_left)


def _costs(strip: Strip, texture: Floats, repeat: float) -> Floats:
    """Cost of each step along a stroke if its beginning lies at each column, laid forth or back. [K, 2, U]"""
    begins = np.arange(0, len(strip.grain), _HOP)
    ways = [-np.add.reduceat(_drops(strip, texture, repeat, way), begins) for way in (0, 1)]
    return np.stack(ways, axis=1)


def _drops(strip: Strip, texture: Floats, repeat: float, way: int) -> Floats:
    """By how much each column of the texture explains each texel along a stroke, if it begins there. [L, U]"""
    grain, weight = (part[:, ::-1] if way else part for part in (strip.grain, strip.weight))
    drop = 2 * (weight * grain) @ texture.T - weight @ (texture * texture).T
    columns = len(texture)
    moved = (-1 if way else 1) * np.arange(len(grain)) * columns / (repeat * TEXELS_PER_WIDTH)
    column = np.round(moved).astype(np.intp)[:, None] + np.arange(columns)
    return np.asarray(np.take_along_axis(drop, column % columns, axis=1))


def _cost(costs: Floats, path: _Path) -> float:
    """What a path costs without its prices."""
    return float(costs.reshape(len(costs), -1)[np.arange(len(costs)), path.state].sum())


def _far(path: _Path, columns: int, slip: float) -> Ints:
    """The jumps of a path that turn it round, or take it further than a slip, a share of the texture. [n]"""
    before, after = path.state[path.jumps - 1], path.state[path.jumps]
    moved = (after - before + columns // 2) % columns - columns // 2
    is_turned = before // columns != after // columns
    return np.asarray(path.jumps[is_turned | (np.abs(moved) > slip * columns)])


def _is_near(jump: np.intp, jumps: Ints) -> bool:
    return bool((np.abs(jumps - jump) * _HOP <= _AGREED * TEXELS_PER_WIDTH).any())


def _cheapest(costs: Floats, drift: float, jump: float) -> _Path:
    """The cheapest path through states [K, 2, U], at a price for a step to a neighbouring column and for a jump."""
    best = costs[0]
    came = np.zeros(costs.shape, np.intp)
    states = np.arange(best.size).reshape(best.shape)
    for k in range(1, len(costs)):
        anew = int(np.argmin(best))
        moved = [np.roll(best, step, axis=1) + drift for step in (1, -1)]
        options = np.stack([best, *moved, np.full_like(best, best.flat[anew] + jump)])
        places = [states, *(np.roll(states, step, axis=1) for step in (1, -1)), np.full_like(states, -1 - anew)]
        choice = options.argmin(axis=0)[None]
        came[k] = np.take_along_axis(np.stack(places), choice, axis=0)[0]
        best = np.take_along_axis(options, choice, axis=0)[0] + costs[k]
    state = np.zeros(len(costs), np.intp)
    state[-1], jumps = int(np.argmin(best)), []
    for k in range(len(costs) - 1, 0, -1):
        source = int(came[k].flat[state[k]])
        if source < 0:
            jumps.append(k)
        state[k - 1] = source if source >= 0 else -1 - source
    return _Path(state, np.array(jumps[::-1], dtype=np.intp))


def part_strokes(laid: Laid, lifts: list[Floats]) -> Laid:
    """Part strokes where the pen was lifted, at the sharpest joint nearby; closed and partly hidden ones stay whole.

    Args:
        laid: Strokes with their brush.
        lifts: Arcs at which each is parted. S times [K] widths

    Returns:
        The same with more strokes: the first part keeps the identity.
    """
    arcs = [arc / laid.brush.width for arc in joint_arcs(laid.strokes)]
    cuts = [_joints_near(laid, stroke, arcs[stroke], lifts[stroke]) for stroke in range(len(arcs))]
    if not any(len(cut) for cut in cuts):
        return laid
    ends = [[0, *cut.tolist(), len(arc) - 1] for cut, arc in zip(cuts, arcs, strict=True)]
    pieces = [(stroke, a, b) for stroke, joints in enumerate(ends) for a, b in pairwise(joints)]
    return _cut(laid, pieces)


def _joints_near(laid: Laid, stroke: int, arc: Floats, lifts: Floats) -> Ints:
    strokes = laid.strokes
    first, last = strokes.layout.stroke_rows[stroke : stroke + 2]
    is_whole = np.array_equal(strokes.visible[first:last], np.tile([0.0, 1.0], (last - first, 1)))
    if strokes.is_closed[stroke] or not is_whole or strokes.parent[stroke] or len(arc) < 3:
        return np.zeros(0, np.intp)
    points = strokes.points_of(int(first))
    before, after = points[3:-1:3] - points[2:-2:3], points[4::3] - points[3:-1:3]
    scale = np.maximum(np.linalg.norm(before, axis=1) * np.linalg.norm(after, axis=1), 1e-9)
    turn = 1 - (before * after).sum(1) / scale
    found = [
        1 + int(np.argmax(np.where(abs(arc[1:-1] - at) < _NEAR, turn, turn - 9.0) - 0.01 * abs(arc[1:-1] - at)))
        for at in lifts
    ]
    return np.unique(np.array(found, dtype=np.intp))


def _cut(laid: Laid, pieces: list[tuple[int, int, int]]) -> Laid:
    """Strokes of the pieces (stroke, first joint, last joint), in order."""
    strokes, layout = laid.strokes, laid.strokes.layout
    source = np.array([stroke for stroke, _, _ in pieces])
    is_new = np.concatenate([[False], source[1:] == source[:-1]])
    ids = np.where(is_new, strokes.ids.max() + np.cumsum(is_new), strokes.ids[source])
    rows, points, joints, phases = [], [], [], []
    starts = stroke_joints(layout)
    for stroke, a, b in pieces:
        phases.append(starts[stroke] + np.arange(a, b + 1))
        for row in range(layout.stroke_rows[stroke], layout.stroke_rows[stroke + 1]):
            rows.append(row)
            points.append(layout.row_points[row] + np.arange(3 * a, 3 * b + 1))
            joints.append(layout.row_joints[row] + np.arange(a, b + 1))
    point, joint = np.concatenate(points), np.concatenate(joints)
    cut = replace(
        strokes,
        ids=ids,
        layout=Layout(np.array([b - a for _, a, b in pieces]), layout.first[source], layout.last[source]),
        is_closed=strokes.is_closed[source],
        layer=strokes.layer[source],
        color=strokes.color[source],
        parent=strokes.parent[source],
        points=strokes.points[point],
        half_width=strokes.half_width[joint],
        opacity=strokes.opacity[rows],
        visible=strokes.visible[rows],
    )
    laying = laid.laying
    phase = laying.phase[np.concatenate(phases)]
    return Laid(cut, Laying(laying.sign[source], phase, laying.density[joint], laying.shift[joint]), laid.brush)
