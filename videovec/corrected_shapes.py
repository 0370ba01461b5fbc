"""A stroke that was redrawn on one drawing: its new shape on its own segments, and what that says of its neighbours."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise

import cv2
import numpy as np
from numpy.typing import NDArray

from videovec.curves import arc_length, evaluate, parameter_at, sample_by_arc, segment_lengths, segments_of
from videovec.ink import Ink
from videovec.stroke_life import StrokeLife
from videovec.stroke_shape import StrokeShape

__all__ = ["carried_change", "reshaped", "widened"]

Floats = NDArray[np.float64]

_SAMPLES = 16  # on each segment that is fitted to a new shape
_WORSE = 0.1  # share of ink by which a changed neighbour may lie worse than it did


def reshaped(life: StrokeLife, drawing: int, points: Floats) -> Floats:
    """A new curve in the segments that a stroke has, run in its direction.

    Args:
        life: The stroke.
        drawing: The drawing on which it was redrawn.
        points: Its seen part as it was redrawn there, in any number of segments. [3m+1, 2] px

    Returns:
        Control points; a part that is hidden goes along with the nearest end of the seen one. [3n+1, 2] px
    """
    row = drawing - life.first
    old, (start, stop) = life.points[row], life.visible[row]
    if start <= 0 and stop >= 1:
        if not life.is_closed and _runs_against(old, points):
            points = points[::-1]
        return points if len(points) == len(old) else _in_segments(points, old)
    segment, t = parameter_at(old, np.array([start, stop]))
    ends = evaluate(segments_of(old)[segment], t)
    if _runs_against(ends, points):
        points = points[::-1]
    u = _fractions(old)
    inside = np.clip((u - start) / max(stop - start, 1e-9), 0.0, 1.0)
    there = np.clip(u, start, stop)
    return np.asarray(old + _at(points, inside) - _at(old, there))


def carried_change(life: StrokeLife, drawing: int, points: Floats, ink: Ink) -> StrokeLife:
    """The stroke with a new shape on one drawing, and on those around where the ink speaks for it no less.

    The change goes from drawing to drawing, turned and scaled as the stroke is, until the old shape lies on more ink.

    Args:
        life: The stroke.
        drawing: The drawing on which it was redrawn.
        points: Its control points there. [3n+1, 2] px
        ink: The ink of all drawings.
    """
    row = drawing - life.first
    change = points - life.points[row]
    moved = life.points.copy()
    moved[row] = points
    for steps in (range(row + 1, len(moved)), range(row - 1, -1, -1)):
        for k in steps:
            candidate = life.points[k] + _turned(change, life.points[row], life.points[k])
            coverage = ink.coverage[life.first + k]
            if _inked(candidate, coverage) < _inked(life.points[k], coverage) - _WORSE:
                break
            moved[k] = candidate
    return replace(life, points=moved)


def widened(life: StrokeLife, drawing: int, before: StrokeShape, after: StrokeShape) -> StrokeLife:
    """The stroke as much wider or thinner on one drawing as its seen part was made there.

    Args:
        life: The stroke.
        drawing: The drawing on which it was changed.
        before: Its seen part as it was shown, in any number of segments.
        after: As it was put back.
    """
    row = drawing - life.first
    start, stop = life.visible[row]
    u = np.clip((_fractions(life.points[row])[::3] - start) / max(stop - start, 1e-9), 0.0, 1.0)
    there = 1 - u if _runs_against(before.points, after.points) else u
    pairs = zip(u.tolist(), there.tolist(), strict=True)
    half_width = life.half_width.copy()
    half_width[row] *= [after.half_width_at(new) / before.half_width_at(old) for old, new in pairs]
    return replace(life, half_width=half_width)


def _runs_against(old: Floats, new: Floats) -> bool:
    same = np.linalg.norm(old[[0, -1]] - new[[0, -1]])
    return bool(np.linalg.norm(old[[0, -1]] - new[[-1, 0]]) < same)


def _at(points: Floats, u: Floats) -> Floats:
    segment, t = parameter_at(points, u)
    return evaluate(segments_of(points)[segment], t)


def _fractions(points: Floats) -> Floats:
    """Arc fraction that stands for each control point: joints where they are, handles a third of the way. [3n+1]"""
    joints = np.concatenate([[0.0], np.cumsum(segment_lengths(points))])
    joints = joints / max(float(joints[-1]), 1e-9)
    place = np.arange(len(points)) / 3
    return np.interp(place, np.arange(len(joints)), joints)


def _in_segments(points: Floats, old: Floats) -> Floats:
    """A curve in as many segments as another has, cut at the same arc fractions. [3n+1, 2]"""
    joints = _fractions(old)[::3]
    parts = [points[:1]]
    for a, b in pairwise(joints):
        line = _at(points, np.linspace(a, b, _SAMPLES))
        t = np.linspace(0.0, 1.0, _SAMPLES)[:, None]
        ends = (1 - t) ** 3 * line[0] + t**3 * line[-1]
        basis = np.hstack([3 * t * (1 - t) ** 2, 3 * t**2 * (1 - t)])
        parts += [np.linalg.lstsq(basis, line - ends, rcond=None)[0], line[-1:]]
    return np.concatenate(parts)


def _turned(change: Floats, source: Floats, target: Floats) -> Floats:
    """Differences [N, 2], turned and scaled by the similarity that takes one shape to another."""
    a, b = ((p - p.mean(0)) @ np.array([1, 1j]) for p in (source, target))
    size = float(np.vdot(a, a).real)
    ratio = np.vdot(a, b) / size if size > 1e-9 else 1.0
    z = ratio * (change @ np.array([1, 1j]))
    return np.stack([z.real, z.imag], axis=1)


def _inked(points: Floats, coverage: NDArray[np.uint8]) -> float:
    """Mean coverage along a curve, in [0, 1]."""
    where = sample_by_arc(points, max(8, round(arc_length(points) / 2))) - 0.5
    x, y = where.astype(np.float32).T
    return float(cv2.remap(coverage, x, y, cv2.INTER_LINEAR).mean()) / 255
