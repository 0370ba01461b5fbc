"""Remove joints that the tolerance does not need: two segments become one where that draws the same."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from videovec.edits.layers import Page, layers_of
from videovec.edits.shapes import Shape, shapes_of, strokes_of
from videovec.edits.spans import span
from videovec.settings import EditSettings
from videovec.strokes import Strokes

__all__ = ["remove_joints"]

Floats = NDArray[np.float64]

_SMOOTH = 20.0  # degrees; where a line turns more it has a corner, which stays
_ROUNDS = 6  # each may halve the number of a stroke's segments
_PROMISE = 2.0  # prices that a removal may seem to cost before it is drawn
_POINTS = 3  # control points that go with a joint


@dataclass(frozen=True, slots=True, eq=False)
class _Removal:
    """A joint that can go: its place in the stroke, the cubic across it [4, 2], and what that seems to cost."""

    joint: int
    cubic: Floats
    cost: float


def remove_joints(strokes: Strokes, page: Page, settings: EditSettings) -> Strokes:
    """Join neighbouring segments, each time those that change the drawing least.

    Args:
        strokes: Strokes of one drawing.
        page: They drawn, against the ink; changed as they change.
        settings: The tolerance, and the price of a control point.

    Returns:
        The same strokes with fewer segments; corners stay.
    """
    shapes = shapes_of(strokes)
    layers = layers_of(strokes, page.size)
    removals = _removals(shapes, settings)
    for _ in range(_ROUNDS):
        trials = {i: _apart(found) for i, found in enumerate(removals) if found}
        if not trials:
            break
        changed = [_without(shapes[i], found) for i, found in trials.items()]
        drawn = layers_of(strokes_of(changed), page.size)
        taken = []
        for (i, found), shape, layer in zip(trials.items(), changed, drawn, strict=True):
            if page.rise([layers[i]], [layer]) <= settings.price * _POINTS * len(found):
                page.exchange([layers[i]], [layer])
                shapes[i], layers[i] = shape, layer
                taken.append(i)
            else:
                removals[i] = sorted(found, key=lambda removal: removal.cost)[: len(found) // 2]
        for i, found in zip(taken, _removals([shapes[i] for i in taken], settings), strict=True):
            removals[i] = found
    return strokes_of(shapes)


def _removals(shapes: list[Shape], settings: EditSettings) -> list[list[_Removal]]:
    """The joints of each stroke that can go, alone, within the tolerance."""
    found: list[list[_Removal]] = [[] for _ in shapes]
    joined = [_inner_joints(shape) for shape in shapes]
    owner = np.repeat(np.arange(len(shapes)), [len(joints) for joints, _, _ in joined])
    if not len(owner):
        return found
    joints, pairs, is_held = (np.concatenate([parts[n] for parts in joined]) for n in range(3))
    widths = np.concatenate([_around(shapes[i].half_width, parts[0]) for i, parts in enumerate(joined)])
    cubics, errors, arcs = span(pairs[:, :4], pairs[:, 3:], is_held)
    cost = 2.0 * (np.square(errors) * arcs).sum(axis=1)  # both edges move by the error
    half = arcs.shape[1] // 2
    total = arcs.sum(axis=1)
    share = arcs[:, :half].sum(axis=1) / np.maximum(total, 1e-9)
    widened = (1.0 - share) * widths[:, 0] + share * widths[:, 2] - widths[:, 1]
    cost = (cost + np.square(widened) * total) * np.minimum(1.0, 2.0 * widths[:, 1]) ** 2
    within = (errors.max(axis=1) <= settings.tolerance) & (cost <= _PROMISE * settings.price * _POINTS)
    for n in np.flatnonzero(within).tolist():
        found[owner[n]].append(_Removal(int(joints[n]), cubics[n], float(cost[n])))
    return found


def _inner_joints(shape: Shape) -> tuple[NDArray[np.intp], Floats, NDArray[np.bool_]]:
    """The joints [B] of a stroke that are no corners, control points from the one before to the one after [B, 7, 2],
    and whether the line has a direction there that must stay. bool [B, 2]
    """
    control = shape.points[3 * np.arange(len(shape.half_width) - 1)[:, None] + np.arange(4)]
    is_smooth = _smooth_joints(control, shape.is_closed)
    joints = np.flatnonzero(is_smooth[1:-1]) + 1
    pairs = shape.points[3 * joints[:, None] + np.arange(-3, 4)]
    return joints, pairs, np.stack([is_smooth[joints - 1], is_smooth[joints + 1]], axis=1)


def _around(values: Floats, joints: NDArray[np.intp]) -> Floats:
    """Values at the joints before, at and after some. [B, 3]"""
    return np.asarray(values[joints[:, None] + np.arange(-1, 2)])


def _apart(found: list[_Removal]) -> list[_Removal]:
    """The cheapest removals of which no two touch the same segment."""
    taken: dict[int, _Removal] = {}
    for removal in sorted(found, key=lambda removal: removal.cost):
        if removal.joint - 1 not in taken and removal.joint + 1 not in taken:
            taken[removal.joint] = removal
    return list(taken.values())


def _without(shape: Shape, removals: list[_Removal]) -> Shape:
    """A stroke after some removals."""
    points, keep = shape.points.copy(), np.ones(len(shape.points), bool)
    for removal in removals:
        middle = 3 * removal.joint
        points[[middle - 2, middle + 2]] = removal.cubic[1:3]
        keep[middle - 1 : middle + 2] = False
    joints = np.delete(shape.half_width, [removal.joint for removal in removals])
    return replace(shape, points=points[keep], half_width=joints)


def _smooth_joints(control: Floats, is_closed: bool) -> NDArray[np.bool_]:
    """Whether the line runs through each joint without a corner; ends of an open one are corners. bool [n+1]"""
    arrive, leave = _unit(control[:-1, 3] - control[:-1, 2]), _unit(control[1:, 1] - control[1:, 0])
    inside = (arrive * leave).sum(axis=1) > np.cos(np.radians(_SMOOTH))
    seam = float(_unit(control[-1, 3] - control[-1, 2]) @ _unit(control[0, 1] - control[0, 0]))
    ends = np.array([is_closed and seam > np.cos(np.radians(_SMOOTH))])
    return np.concatenate([ends, inside, ends])


def _unit(vectors: Floats) -> Floats:
    return np.asarray(vectors / np.maximum(np.linalg.norm(vectors, axis=-1, keepdims=True), 1e-9))
