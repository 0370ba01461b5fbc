"""Where the pen was lifted inside a stroke: a brush begins anew with every stroke that is drawn, and says so.

Tracing takes strokes that meet end to end for one. Along one that a pen drew, the place in the texture goes on and the
direction stays; where another place or the other direction explains the rest of the stroke far better, two were drawn.
"""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from videovec.brush.align import Alignment
from videovec.brush.refine import Laid
from videovec.brush.strips import TEXELS_PER_WIDTH, Strip, joint_arcs
from videovec.brushwork import Laying, stroke_joints
from videovec.strokes import Layout

__all__ = ["find_lifts", "part_strokes"]

Floats = NDArray[np.float64]
Ints = NDArray[np.intp]

_HOP = 6  # texels of arc over which the place in the texture drifts by at most one
_DRIFT, _LIFT = 6.0, 600.0  # prices of a drift and of a lift, in texels' worth of unexplained grain
_NEAR = 2.5  # widths within which a stroke is parted at its sharpest joint


def find_lifts(strips: list[Strip], found: Alignment) -> list[Floats]:
    """Where along each stroke the texture begins anew.

    Args:
        strips: S strips.
        found: The texture, as far as it was learned from them.

    Returns:
        Arcs of each stroke. S times [K] widths
    """
    return [_lifts_of(strip, found.texture, found.repeat) for strip in strips]


def _lifts_of(strip: Strip, texture: Floats, repeat: float) -> Floats:
    seen = float(strip.weight.sum())
    unit = float((strip.weight * strip.grain**2).sum()) / max(seen, 1e-9)
    if seen < 2 * _LIFT:
        return np.zeros(0)
    begins = np.arange(0, len(strip.grain), _HOP)
    costs = np.stack([-np.add.reduceat(_drops(strip, texture, repeat, way), begins) for way in (0, 1)], axis=1)
    lifted = _cheapest(costs, _DRIFT * unit, _LIFT * unit)
    return np.asarray(begins[lifted] / TEXELS_PER_WIDTH, dtype=np.float64)


def _drops(strip: Strip, texture: Floats, repeat: float, way: int) -> Floats:
    """By how much each column of the texture explains each texel along a stroke, if it begins there. [L, U]"""
    grain, weight = (part[:, ::-1] if way else part for part in (strip.grain, strip.weight))
    drop = 2 * (weight * grain) @ texture.T - weight @ (texture * texture).T
    columns = len(texture)
    moved = (-1 if way else 1) * np.arange(len(grain)) * columns / (repeat * TEXELS_PER_WIDTH)
    column = np.round(moved).astype(np.intp)[:, None] + np.arange(columns)
    return np.asarray(np.take_along_axis(drop, column % columns, axis=1))


def _cheapest(costs: Floats, drift: float, lift: float) -> Ints:
    """Steps before which the cheapest path through states [K, 2, U] lifts the pen. int"""
    best = costs[0]
    came = np.zeros(costs.shape, np.intp)
    states = np.arange(best.size).reshape(best.shape)
    for k in range(1, len(costs)):
        anew = int(np.argmin(best))
        options = np.stack(
            [
                best,
                np.roll(best, 1, axis=1) + drift,
                np.roll(best, -1, axis=1) + drift,
                np.full_like(best, best.flat[anew] + lift),
            ]
        )
        sources = np.stack(
            [states, np.roll(states, 1, axis=1), np.roll(states, -1, axis=1), np.full_like(states, anew)]
        )
        choice = options.argmin(axis=0)[None]
        came[k] = np.where(choice[0] == 3, -1 - anew, np.take_along_axis(sources, choice, axis=0)[0])
        best = np.take_along_axis(options, choice, axis=0)[0] + costs[k]
    state, lifted = int(np.argmin(best)), []
    for k in range(len(costs) - 1, 0, -1):
        source = int(came[k].flat[state])
        if source < 0:
            lifted.append(k)
        state = source if source >= 0 else -1 - source
    return np.array(lifted[::-1], dtype=np.intp)


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
    return Laid(cut, Laying(laying.sign[source], phase, laying.density[joint], laying.shift[rows]), laid.brush)
