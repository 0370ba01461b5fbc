"""How well strokes keep their identity over a clip, against true strokes that do.

Identity is measured by the length of true strokes that is covered, not by counts of strokes; position, occlusion and
jitter by material points, see `videovec.point_metrics`.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import linear_sum_assignment
from scipy.spatial import cKDTree

from videovec.curves import arc_length, derivative, evaluate, parameter_at, segments_of
from videovec.point_metrics import TOLERANCE, follow_points, has_ink, score_points
from videovec.strokes import Strokes
from videovec.true_strokes import TrueStroke

__all__ = ["ClipScore", "TrueStroke", "score_clip"]

Floats = NDArray[np.float64]
Ints = NDArray[np.intp]

_TURN = np.cos(np.radians(45.0))
"""Cosine of the angle by which a covering stroke may differ in direction."""
_STEP = 1.0
"""Distance of the samples on a stroke. px"""


@dataclass(frozen=True, slots=True)
class ClipScore:
    """How well strokes keep their identity; shares are in [0, 1], NaN where there is nothing to measure.

    Args:
        idf1: Harmonic mean of the shares of true and of found stroke length under the best one-to-one identities.
        persistence: Share of a true stroke's drawings that carry its most frequent identity; mean over strokes.
        full_life: Share of true strokes with one identity on all drawings on which they are seen.
        position: See `videovec.point_metrics.PointScore`, as for the next four.
        jaccard: Of position and occlusion together.
        occlusion: Share of points and drawings.
        error: px
        jitter: px
        flicker: Mean change of the number of seen strokes from drawing to drawing, less that of the truth.
        births: Share of true births that are found within one drawing.
        deaths: Share of true deaths that are found within one drawing.
        identity_over_time: Share of true stroke length on its stroke's best one-to-one identity. D
        error_over_time: px for each of D drawings.
    """

    idf1: float
    persistence: float
    full_life: float
    position: tuple[float, ...]
    jaccard: float
    occlusion: float
    error: float
    jitter: float
    flicker: float
    births: float
    deaths: float
    identity_over_time: tuple[float, ...]
    error_over_time: tuple[float, ...]


def score_clip(
    truth: list[list[TrueStroke]], strokes: Strokes, ink: NDArray[np.uint8] | None = None, *, by_arc: bool = False
) -> ClipScore:
    """Compare strokes with the truth.

    Args:
        truth: The true strokes of each of D drawings.
        strokes: S strokes over the same drawings.
        ink: Coverage; where it is given, true strokes count only where there is ink. uint8 [D, H, W]
        by_arc: See `videovec.point_metrics.follow_points`.

    Returns:
        All figures.
    """
    ids = sorted({stroke.id for drawing in truth for stroke in drawing})
    true_length, found_length = np.zeros((len(truth), len(ids))), np.zeros((len(truth), len(strokes)))
    overlap = np.zeros((len(truth), len(ids), len(strokes)))
    for t, drawing in enumerate(truth):
        seen = _true_samples(drawing, ids, None if ink is None else ink[t])
        found = _found_samples(strokes, t)
        true_length[t] = _STEP * np.bincount(seen.stroke, minlength=len(ids))
        found_length[t] = _STEP * np.bincount(found.stroke, minlength=len(strokes))
        overlap[t] = _overlap(seen, found, len(ids), len(strokes))
    partner = _partners(overlap)
    covered = sum((overlap[:, i, j] for i, j in partner.items()), start=np.zeros(len(truth)))
    shared = sum((np.minimum(overlap[:, i, j], found_length[:, j]).sum() for i, j in partner.items()), start=0.0)
    total = float(true_length.sum() + found_length.sum())
    persistence = _persistence(overlap, true_length)
    seen_true, seen_found = true_length > 0, found_length > 0
    points = score_points(follow_points(truth, strokes, ink, by_arc=by_arc))
    return ClipScore(
        idf1=2 * float(shared) / total if total else np.nan,
        persistence=_mean(persistence),
        full_life=_mean(persistence == 1.0),
        position=points.position,
        jaccard=points.jaccard,
        occlusion=points.occlusion,
        error=points.error,
        jitter=points.jitter,
        flicker=_mean(np.abs(np.diff(seen_found.sum(1)) - np.diff(seen_true.sum(1)))),
        births=_found_ends(seen_true, seen_found, partner),
        deaths=_found_ends(seen_true[::-1], seen_found[::-1], partner),
        identity_over_time=_shares(covered, true_length.sum(axis=1)),
        error_over_time=points.error_over_time,
    )


@dataclass(frozen=True, slots=True, eq=False)
class _Samples:
    """Points at equal steps on strokes [N, 2], their directions [N, 2] and strokes [N]."""

    points: Floats
    direction: Floats
    stroke: Ints


def _sample(points: Floats, visible: tuple[float, float]) -> tuple[Floats, Floats]:
    """Points and directions on a part of a spline."""
    length = arc_length(points) * (visible[1] - visible[0])
    count = max(1, round(length / _STEP))
    u = visible[0] + (visible[1] - visible[0]) * (np.arange(count) + 0.5) / count
    if arc_length(points) < 1e-6:
        return points[:1], np.zeros((1, 2))
    segment, t = parameter_at(points, u)
    control = segments_of(points)[segment]
    slope = derivative(control, t)
    return evaluate(control, t), slope / np.maximum(np.linalg.norm(slope, axis=1, keepdims=True), 1e-9)


def _collect(parts: list[tuple[Floats, Floats, int]]) -> _Samples:
    return _Samples(
        np.concatenate([np.zeros((0, 2)), *(p for p, _, _ in parts)]),
        np.concatenate([np.zeros((0, 2)), *(d for _, d, _ in parts)]),
        np.concatenate([np.zeros(0, np.intp), *(np.full(len(p), s, np.intp) for p, _, s in parts)]),
    )


def _true_samples(drawing: list[TrueStroke], ids: list[int], ink: NDArray[np.uint8] | None) -> _Samples:
    parts = [(*_sample(s.points, part), ids.index(s.id)) for s in drawing for part in s.visible]
    samples = _collect(parts)
    if ink is None or not len(samples.points):
        return samples
    inside = has_ink(ink, samples.points)
    return _Samples(samples.points[inside], samples.direction[inside], samples.stroke[inside])


def _found_samples(strokes: Strokes, drawing: int) -> _Samples:
    parts = []
    for row in strokes.rows_at(drawing):
        u0, u1 = strokes.visible[row]
        if u1 > u0:
            parts.append((*_sample(strokes.points_of(row), (u0, u1)), int(strokes.layout.row_stroke[row])))
    return _collect(parts)


def _overlap(seen: _Samples, found: _Samples, true_count: int, count: int) -> Floats:
    """Length of each true stroke that each found stroke covers. [true, found] px"""
    overlap = np.zeros((true_count, count))
    if not len(seen.points) or not len(found.points):
        return overlap
    near = cKDTree(seen.points).sparse_distance_matrix(cKDTree(found.points), TOLERANCE, output_type="coo_matrix")
    a, b = seen.direction[near.row], found.direction[near.col]
    dot = np.abs((a * b).sum(axis=1))
    agrees = (dot >= _TURN) | ~a.any(axis=1) | ~b.any(axis=1)
    pairs = np.unique(np.stack([near.row[agrees], found.stroke[near.col[agrees]]], axis=1), axis=0)
    np.add.at(overlap, (seen.stroke[pairs[:, 0]], pairs[:, 1]), _STEP)
    return overlap


def _partners(overlap: Floats) -> dict[int, int]:
    """The found stroke of each true one, one to one, such that most length is covered."""
    total = overlap.sum(axis=0)
    rows, columns = linear_sum_assignment(-total)
    return {int(i): int(j) for i, j in zip(rows, columns, strict=True) if total[i, j] > 0}


def _persistence(overlap: Floats, true_length: Floats) -> Floats:
    """Share of its drawings on which each true stroke has its most frequent identity. [true]"""
    shares = []
    for i in range(overlap.shape[1]):
        drawings = np.flatnonzero(true_length[:, i] > 0)
        if not len(drawings):
            continue
        if not overlap.shape[2]:
            shares.append(0.0)
            continue
        here = overlap[drawings, i]
        owner = here.argmax(axis=1)
        owned = here.max(axis=1) > 0.5 * true_length[drawings, i]
        count = np.bincount(owner[owned], minlength=1)
        shares.append(float(count.max()) / len(drawings))
    return np.array(shares)


def _found_ends(seen_true: NDArray[np.bool_], seen_found: NDArray[np.bool_], partner: dict[int, int]) -> float:
    """Share of beginnings of true strokes, but those of the first drawing, that are found within one drawing."""
    right = []
    for i in np.flatnonzero(seen_true.any(axis=0)):
        begin = int(seen_true[:, i].argmax())
        if begin == 0:
            continue
        j = partner.get(int(i))
        found = j is not None and seen_found[:, j].any()
        right.append(bool(found) and abs(int(seen_found[:, j].argmax()) - begin) <= 1)
    return _mean(np.array(right))


def _shares(parts: Floats, wholes: Floats) -> tuple[float, ...]:
    """Parts over wholes, NaN where there is no whole."""
    return tuple(float(a / b) if b else float("nan") for a, b in zip(parts, wholes, strict=True))


def _mean(values: Floats | NDArray[np.bool_]) -> float:
    return float(np.mean(values)) if len(values) else float("nan")
