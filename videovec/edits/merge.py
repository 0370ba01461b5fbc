"""Make one stroke of two that continue one another."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from videovec.curves import arc_length, derivative, reverse, segments_of, sub_curve
from videovec.edits.bodies import Bodies
from videovec.edits.layers import Page, layers_of
from videovec.edits.shapes import Shape, shapes_of, strokes_of
from videovec.settings import EditSettings
from videovec.strokes import Strokes

__all__ = ["merge"]

Floats = NDArray[np.float64]

_TURN = 35.0  # degrees; most that a line may turn from one stroke to the next
_THICKER = 1.5  # how many times as wide one of the two may be
_CLEAR = 1.0  # widths around the gap in which no third stroke may pass
_STROKE = 10  # control points that a stroke less is worth
_ROUNDS = 5  # each may join every end once
_OVERLAP = 0.5  # px beyond the other's end that are cut off where two strokes overlap


@dataclass(frozen=True, slots=True, eq=False)
class _End:
    """One end of a stroke: which, whether its last point, where, in which unit direction it runs out, and how wide."""

    stroke: int
    is_last: bool
    place: Floats
    direction: Floats
    half_width: float


@dataclass(frozen=True, slots=True, eq=False)
class _Joint:
    """Two ends that may be joined: the better, the smaller the cost."""

    one: _End
    two: _End
    cost: float


def merge(strokes: Strokes, page: Page, settings: EditSettings) -> Strokes:
    """Join strokes end to end where the ink runs on, straight, with nothing else there.

    Args:
        strokes: Strokes of one drawing.
        page: They drawn, against the ink; changed as they change.
        settings: The longest gap, and the price of a control point.

    Returns:
        Fewer strokes; of two that were joined the longer one's identity stays.
    """
    shapes = shapes_of(strokes)
    layers = layers_of(strokes, page.size)
    refused: set[tuple[int, int]] = set()
    for _ in range(_ROUNDS):
        joints = [joint for joint in _joints(shapes, settings) if _key(joint, shapes) not in refused]
        if not joints:
            break
        joined = [_join(shapes, joint) for joint in joints]
        drawn = layers_of(strokes_of([replace(shape, id=n + 1) for n, shape in enumerate(joined)]), page.size)
        gone: set[int] = set()
        for joint, shape, layer in zip(joints, joined, drawn, strict=True):
            pair = sorted({joint.one.stroke, joint.two.stroke})
            old = [layers[i] for i in pair]
            saved = sum(len(shapes[i].points) for i in pair) - len(shape.points) + _STROKE
            if page.rise(old, [layer]) > settings.price * saved:
                refused.add(_key(joint, shapes))
                continue
            page.exchange(old, [layer])
            shapes[pair[0]], layers[pair[0]] = shape, layer
            gone |= set(pair[1:])
        shapes = [shape for i, shape in enumerate(shapes) if i not in gone]
        layers = [layer for i, layer in enumerate(layers) if i not in gone]
    return strokes_of(shapes)


def _key(joint: _Joint, shapes: list[Shape]) -> tuple[int, int]:
    """The ends of a joint by identity, the same from round to round."""
    ends = sorted(2 * shapes[end.stroke].id + end.is_last for end in (joint.one, joint.two))
    return ends[0], ends[1]


def _ends(shapes: list[Shape]) -> list[_End]:
    ends = []
    for i, shape in enumerate(shapes):
        if shape.is_closed:
            continue
        control = segments_of(shape.points)
        for is_last, segment, t in ((False, control[0], 0.05), (True, control[-1], 0.95)):
            tangent = derivative(segment, t) * (1.0 if is_last else -1.0)
            length = float(np.linalg.norm(tangent))
            if length > 1e-6:
                at = -1 if is_last else 0
                ends.append(_End(i, is_last, shape.points[at], tangent / length, float(shape.half_width[at])))
    return ends


def _joints(shapes: list[Shape], settings: EditSettings) -> list[_Joint]:
    """Pairs of ends that continue one another, no stroke in two of them, the best first."""
    ends = _ends(shapes)
    if len(ends) < 2:
        return []
    bodies = Bodies.of(shapes)
    found = []
    for i, j in cKDTree([end.place for end in ends]).query_pairs(settings.d_min):
        one, two = ends[i], ends[j]
        cost = _cost(one, two)
        if cost is None or not np.array_equal(shapes[one.stroke].color, shapes[two.stroke].color):
            continue
        gap = float(np.linalg.norm(one.place - two.place))
        if one.stroke == two.stroke and arc_length(shapes[one.stroke].points) < 4.0 * settings.d_min:
            continue
        radius = 0.5 * gap + _CLEAR * 2.0 * max(one.half_width, two.half_width)
        near = bodies.owner[bodies.tree.query_ball_point(0.5 * (one.place + two.place), radius)]
        if np.all((near == one.stroke) | (near == two.stroke)):
            found.append(_Joint(one, two, cost))
    taken: set[int] = set()
    chosen = []
    for joint in sorted(found, key=lambda joint: joint.cost):
        pair = {joint.one.stroke, joint.two.stroke}
        if not pair & taken:
            taken |= pair
            chosen.append(joint)
    return chosen


def _cost(one: _End, two: _End) -> float | None:
    """How far two ends are from continuing one another, px and radians alike; None where they do not."""
    turn = float(np.arccos(np.clip(-one.direction @ two.direction, -1.0, 1.0)))
    if turn > np.radians(_TURN):
        return None
    narrow, wide = sorted((one.half_width, two.half_width))
    if wide > _THICKER * narrow:
        return None
    across = two.place - one.place
    axis = one.direction - two.direction
    axis /= np.linalg.norm(axis)
    aside = abs(float(across[0] * axis[1] - across[1] * axis[0]))
    if aside > max(wide, float(across @ axis) * np.tan(np.radians(_TURN))):
        return None
    return turn + aside + abs(float(across @ axis))


def _join(shapes: list[Shape], joint: _Joint) -> Shape:
    """One stroke through a joint, in the direction of the longer one; it closes where both ends are one stroke's."""
    one, two = joint.one, joint.two
    a, b = shapes[one.stroke], shapes[two.stroke]
    kept = a if arc_length(a.points) >= arc_length(b.points) else b
    overlap = max(0.0, float((one.place - two.place) @ one.direction))
    cut = overlap + _OVERLAP if overlap > 0.0 else 0.0
    if one.stroke == two.stroke:
        points, widths = _trimmed(a.points, a.half_width, cut)
        first = reverse(*_trimmed(*reverse(points, widths), cut))
        return _bridged(replace(a, is_closed=True), first, first)
    first = (a.points, a.half_width) if one.is_last else reverse(a.points, a.half_width)
    second = reverse(b.points, b.half_width) if two.is_last else (b.points, b.half_width)
    first = _trimmed(*first, 0.5 * cut)
    second = reverse(*_trimmed(*reverse(*second), 0.5 * cut))
    shape = _bridged(kept, first, second)
    is_turned = (kept is a) != one.is_last if kept is a else two.is_last
    if is_turned:
        points, widths = reverse(shape.points, shape.half_width)
        return replace(shape, points=points, half_width=widths)
    return shape


def _trimmed(points: Floats, half_width: Floats, length: float) -> tuple[Floats, Floats]:
    """A spline without its last stretch; its first half stays."""
    if length <= 0.0:
        return points, half_width
    total = max(arc_length(points), 1e-9)
    return sub_curve(points, half_width, 0.0, 1.0 - min(length / total, 0.5))


def _bridged(shape: Shape, first: tuple[Floats, Floats], second: tuple[Floats, Floats]) -> Shape:
    """A stroke along two splines; what lies between them is a segment of its own unless they touch."""
    (a, wa), (b, wb) = first, second
    gap = float(np.linalg.norm(b[0] - a[-1]))
    if gap < 0.25 and not shape.is_closed:
        middle, width = 0.5 * (a[-1:] + b[:1]), 0.5 * (wa[-1:] + wb[:1])
        points, widths = np.concatenate([a[:-1], middle, b[1:]]), np.concatenate([wa[:-1], width, wb[1:]])
        return replace(shape, points=points, half_width=widths)
    leave, arrive = (_unit(v) * gap / 3.0 for v in (a[-1] - a[-2], b[1] - b[0]))
    handles = np.stack([a[-1] + leave, b[0] - arrive])
    if shape.is_closed:
        return replace(shape, points=np.concatenate([a, handles, a[:1]]), half_width=np.append(wa, wa[0]))
    return replace(shape, points=np.concatenate([a, handles, b]), half_width=np.concatenate([wa, wb]))


def _unit(vector: Floats) -> Floats:
    return np.asarray(vector / max(float(np.linalg.norm(vector)), 1e-9))
