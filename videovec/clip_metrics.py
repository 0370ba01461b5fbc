"""How well strokes keep their identity over a clip, against true strokes that do.

Identity is measured by the length of true strokes that is covered, not by counts of strokes; position, occlusion and
jitter by material points that are followed from the first drawing on which they are seen.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import linear_sum_assignment
from scipy.spatial import cKDTree

from videovec.curves import arc_length, derivative, evaluate, parameter_at, segments_of
from videovec.strokes import Strokes

__all__ = ["ClipScore", "TrueStroke", "score_clip"]

Floats = NDArray[np.float64]
Ints = NDArray[np.intp]

THRESHOLDS = (1.0, 2.0, 4.0, 8.0, 16.0)
"""Distances up to which a followed point is in place. px"""
QUERIES = (0.1, 0.3, 0.5, 0.7, 0.9)
"""Arc fractions, of the part that is seen first, of the points that are followed on every stroke."""
TOLERANCE = 3.0
"""Distance within which a stroke covers a point. px"""
_TURN = np.cos(np.radians(45.0))
"""Cosine of the angle by which a covering stroke may differ in direction."""
_STEP = 1.0
"""Distance of the samples on a stroke. px"""


@dataclass(frozen=True, slots=True, eq=False)
class TrueStroke:
    """A true stroke on one drawing.

    Args:
        id: Its identity over the clip.
        points: Control points. [3n+1, 2] px
        visible: Arc fractions that are seen; none if it is hidden.
    """

    id: int
    points: Floats
    visible: tuple[tuple[float, float], ...] = ((0.0, 1.0),)


@dataclass(frozen=True, slots=True)
class ClipScore:
    """How well strokes keep their identity; shares are in [0, 1], NaN where there is nothing to measure.

    Args:
        idf1: Harmonic mean of the shares of true and of found stroke length under the best one-to-one identities.
        persistence: Share of a true stroke's drawings that carry its most frequent identity; mean over strokes.
        full_life: Share of true strokes with one identity on all drawings on which they are seen.
        position: Share of followed points within each of `THRESHOLDS`, while they are to be seen.
        error: Mean distance of followed points. px
        occlusion: Share of followed points and drawings on which it is known whether the point is seen.
        jitter: Mean length of the second difference of followed points less that of the truth. px
        flicker: Mean change of the number of seen strokes from drawing to drawing, less that of the truth.
        births: Share of true births that are found within one drawing.
        deaths: Share of true deaths that are found within one drawing.
    """

    idf1: float
    persistence: float
    full_life: float
    position: tuple[float, ...]
    error: float
    occlusion: float
    jitter: float
    flicker: float
    births: float
    deaths: float


def score_clip(truth: list[list[TrueStroke]], strokes: Strokes, ink: NDArray[np.uint8] | None = None) -> ClipScore:
    """Compare strokes with the truth.

    Args:
        truth: The true strokes of each of D drawings.
        strokes: S strokes over the same drawings.
        ink: Coverage; where it is given, true strokes count only where there is ink. uint8 [D, H, W]

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
    covered = sum(float(overlap[:, i, j].sum()) for i, j in partner.items())
    total = float(true_length.sum() + found_length.sum())
    persistence = _persistence(overlap, true_length)
    seen_true, seen_found = true_length > 0, found_length > 0
    followed = _follow(truth, strokes)
    return ClipScore(
        idf1=2 * covered / total if total else np.nan,
        persistence=_mean(persistence),
        full_life=_mean(persistence == 1.0),
        position=tuple(_mean(followed.error[followed.both] <= limit) for limit in THRESHOLDS),
        error=_mean(followed.error[followed.both & np.isfinite(followed.error)]),
        occlusion=_mean(followed.knows[followed.asked]),
        jitter=followed.jitter,
        flicker=_mean(np.abs(np.diff(seen_found.sum(1)) - np.diff(seen_true.sum(1)))),
        births=_found_ends(seen_true, seen_found, partner),
        deaths=_found_ends(seen_true[::-1], seen_found[::-1], partner),
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
    column, row = np.floor(samples.points).astype(np.intp).T
    inside = (row >= 0) & (column >= 0) & (row < ink.shape[0]) & (column < ink.shape[1])
    inside[inside] = ink[row[inside], column[inside]] > 0.3 * 255
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


@dataclass(frozen=True, slots=True, eq=False)
class _Followed:
    """Q points over D drawings: distance to the truth (inf where lost), what was asked, what was known, the jitter."""

    error: Floats
    both: NDArray[np.bool_]
    asked: NDArray[np.bool_]
    knows: NDArray[np.bool_]
    jitter: float


def _follow(truth: list[list[TrueStroke]], strokes: Strokes) -> _Followed:
    """Follow points of every true stroke from the first drawing on which it is seen."""
    tracks = [(t, q) for t, q in _queries(truth)]
    error, both = np.full((len(tracks), len(truth)), np.inf), np.zeros((len(tracks), len(truth)), bool)
    asked, knows, shakes = both.copy(), both.copy(), []
    table = [{stroke.id: stroke for stroke in drawing} for drawing in truth]
    for k, (start, (identity, u)) in enumerate(tracks):
        first = table[start][identity]
        segment, t = parameter_at(first.points, np.array([u]))
        place = int(segment[0]), float(t[0])
        hit = _nearest_place(strokes, start, _at(first.points, place))
        gaps = np.full((len(truth), 2), np.nan)
        for d in range(start, len(truth)):
            true = table[d].get(identity)
            same = true is not None and len(true.points) == len(first.points)
            is_seen = true is not None and same and any(a <= u <= b for a, b in true.visible)
            asked[k, d] = d > start
            both[k, d] = is_seen and d > start
            found = None if hit is None else _found_at(strokes, hit, d)
            knows[k, d] = (found is not None and found[1]) == is_seen
            if found is not None and true is not None and same:
                gaps[d] = found[0] - _at(true.points, place)
                error[k, d] = float(np.hypot(*gaps[d]))
        shakes.append(np.linalg.norm(np.diff(gaps, 2, axis=0), axis=1))
    shake = np.concatenate([np.zeros(0), *shakes])
    return _Followed(error, both, asked, knows, _mean(shake[np.isfinite(shake)]))


def _queries(truth: list[list[TrueStroke]]) -> list[tuple[int, tuple[int, float]]]:
    """Drawing, identity and arc fraction of every point that is followed."""
    known: set[int] = set()
    queries = []
    for t, drawing in enumerate(truth):
        for stroke in drawing:
            if stroke.id in known or not stroke.visible:
                continue
            known.add(stroke.id)
            a, b = max(stroke.visible, key=lambda part: part[1] - part[0])
            queries += [(t, (stroke.id, a + q * (b - a))) for q in QUERIES]
    return queries


def _at(points: Floats, place: tuple[int, float]) -> Floats:
    return np.asarray(evaluate(segments_of(points)[place[0]], place[1]))


def _nearest_place(strokes: Strokes, drawing: int, point: Floats) -> tuple[int, int, float, float] | None:
    """Stroke, segment, parameter and arc fraction nearest to a point; none within the tolerance. px"""
    best: tuple[int, int, float, float] | None = None
    gap = TOLERANCE
    for row in strokes.rows_at(drawing):
        points = strokes.points_of(row)
        u0, u1 = map(float, strokes.visible[row])
        if arc_length(points) < 1e-6 or u1 <= u0:
            continue
        for u in _from_coarse_to_fine(points, point, (u0, u1)):
            segment, t = parameter_at(points, np.array([u]))
            distance = float(np.linalg.norm(_at(points, (int(segment[0]), float(t[0]))) - point))
            if distance < gap:
                gap = distance
                best = int(strokes.layout.row_stroke[row]), int(segment[0]), float(t[0]), u
    return best


def _from_coarse_to_fine(points: Floats, point: Floats, visible: tuple[float, float]) -> list[float]:
    """The arc fraction nearest to a point, at two resolutions."""
    found = []
    for count in (max(2, round(2 * arc_length(points))), 65):
        u = np.linspace(*visible, count)
        segment, t = parameter_at(points, u)
        k = int(np.linalg.norm(evaluate(segments_of(points)[segment], t) - point, axis=1).argmin())
        found.append(float(u[k]))
        visible = float(u[max(k - 1, 0)]), float(u[min(k + 1, count - 1)])
    return found


def _found_at(strokes: Strokes, hit: tuple[int, int, float, float], drawing: int) -> tuple[Floats, bool] | None:
    """Where a material point of a found stroke is, and whether it is seen."""
    stroke, segment, t, u = hit
    if not strokes.layout.first[stroke] <= drawing <= strokes.layout.last[stroke]:
        return None
    row = strokes.row(stroke, drawing)
    u0, u1 = strokes.visible[row]
    return _at(strokes.points_of(row), (segment, t)), bool(u1 > u0 and u0 <= u <= u1)


def _mean(values: Floats | NDArray[np.bool_]) -> float:
    return float(np.mean(values)) if len(values) else float("nan")
