"""How well material points are followed: five on every true stroke, from the first drawing on which it is seen.

Each is handed to the nearest found stroke there, and from then on is where that stroke says. The figures are those of
TAP-Vid where queries are given on the first drawing; its distances are px of a page of 256 x 256, ours px of the clip.

Source:
    Doersch et al. 2022, "TAP-Vid: A Benchmark for Tracking Any Point in a Video", section 3.3.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from videovec.curves import arc_length, evaluate, parameter_at, segments_of
from videovec.strokes import Strokes
from videovec.true_strokes import TrueStroke

__all__ = ["THRESHOLDS", "TOLERANCE", "FollowedPoints", "PointScore", "follow_points", "has_ink", "score_points"]

Floats = NDArray[np.float64]
Bools = NDArray[np.bool_]
Images = NDArray[np.uint8]

THRESHOLDS = (1.0, 2.0, 4.0, 8.0, 16.0)
"""Distances up to which a followed point is in place. px"""
QUERIES = (0.1, 0.3, 0.5, 0.7, 0.9)
"""Arc fractions, of the part that is seen first, of the points that are followed on every stroke."""
TOLERANCE = 3.0
"""Distance within which a stroke covers a point. px"""
_INK = 0.3  # coverage from which on a pixel is drawn on


@dataclass(frozen=True, slots=True, eq=False)
class FollowedPoints:
    """Q points over D drawings.

    Args:
        query: The drawing on which each is asked for. int [Q]
        truth: Where each is, NaN where it is nowhere. [Q, D, 2] px
        is_seen: Whether each is seen there. bool [Q, D]
        is_known: Whether the truth can say either. bool [Q, D]
        found: Where each was found, NaN where it is lost. [Q, D, 2] px
        is_found: Whether each was said to be seen. bool [Q, D]
    """

    query: NDArray[np.intp]
    truth: Floats
    is_seen: Bools
    is_known: Bools
    found: Floats
    is_found: Bools

    @property
    def is_asked(self) -> Bools:
        """The drawings that count: all after the query of which the truth is known. [Q, D]"""
        return np.asarray((np.arange(self.truth.shape[1]) > self.query[:, None]) & self.is_known)

    @property
    def distance(self) -> Floats:
        """From the truth; infinite where a point is lost. [Q, D] px"""
        distance = np.linalg.norm(self.found - self.truth, axis=-1)
        return np.asarray(np.where(np.isnan(distance), np.inf, distance))


@dataclass(frozen=True, slots=True)
class PointScore:
    """How well points were followed; shares are in [0, 1], NaN where there is nothing to measure.

    Args:
        position: Share of points within each of `THRESHOLDS` of the truth, where they are to be seen.
        jaccard: Mean over `THRESHOLDS` of TAP-Vid's Jaccard index: points that are seen, said to be and in place, over
            these, those wrongly said to be seen, those out of place, and those missed.
        occlusion: Share of points and drawings on which it is known whether the point is seen.
        error: Mean distance of points that are to be seen and are not lost. px
        jitter: Mean length of the second difference of found points less that of the truth. px
        error_over_time: `error` for each drawing. D px
    """

    position: tuple[float, ...]
    jaccard: float
    occlusion: float
    error: float
    jitter: float
    error_over_time: tuple[float, ...]


def score_points(points: FollowedPoints) -> PointScore:
    """Measure how well points were followed."""
    asked, distance = points.is_asked, points.distance
    to_be_seen, said = points.is_seen & asked, points.is_found & asked
    position, jaccard = [], []
    for limit in THRESHOLDS:
        near = distance < limit
        position.append(_mean(near[to_be_seen]))
        hits = int((near & to_be_seen & said).sum())
        alarms = int((said & ~(points.is_seen & near)).sum())
        jaccard.append(hits / (int(to_be_seen.sum()) + alarms) if to_be_seen.any() or alarms else np.nan)
    known = to_be_seen & np.isfinite(distance)
    shakes = np.linalg.norm(np.diff(points.found - points.truth, 2, axis=1), axis=-1)
    return PointScore(
        position=tuple(position),
        jaccard=float(np.mean(jaccard)),
        occlusion=_mean((points.is_found == points.is_seen)[asked]),
        error=_mean(distance[known]),
        jitter=_mean(shakes[np.isfinite(shakes)]),
        error_over_time=tuple(_mean(distance[known[:, d], d]) for d in range(distance.shape[1])),
    )


@dataclass(frozen=True, slots=True)
class _Place:
    """A material point: where on the cubics of a stroke, and at which arc fraction that is first."""

    segment: int
    t: float
    u: float

    def on(self, points: Floats) -> Floats:
        """Where it is. [2] px"""
        return np.asarray(evaluate(segments_of(points)[self.segment], self.t))

    @staticmethod
    def at(points: Floats, u: float) -> _Place:
        """The point at an arc fraction."""
        segment, t = parameter_at(points, np.array([u]))
        return _Place(int(segment[0]), float(t[0]), u)


def follow_points(
    truth: list[list[TrueStroke]], strokes: Strokes, ink: Images | None = None, *, by_arc: bool = False
) -> FollowedPoints:
    """Follow points of every true stroke on the found ones.

    Args:
        truth: The true strokes of each of D drawings.
        strokes: S strokes over the same drawings.
        ink: Coverage; where it is given, a true point is seen only where there is ink. uint8 [D, H, W]
        by_arc: Keep the arc fraction of a found point, not its parameter: for strokes of drawings that were vectorised
            alone, whose control points do not correspond.

    Returns:
        Five points for each true stroke.
    """
    table = [{stroke.id: stroke for stroke in drawing} for drawing in truth]
    queries = list(_queries(truth))
    shape = (len(queries), len(truth))
    result = FollowedPoints(
        query=np.array([start for start, _, _ in queries], dtype=np.intp),
        truth=np.full((*shape, 2), np.nan),
        is_seen=np.zeros(shape, bool),
        is_known=np.ones(shape, bool),
        found=np.full((*shape, 2), np.nan),
        is_found=np.zeros(shape, bool),
    )
    for k, (start, identity, u) in enumerate(queries):
        first = table[start][identity].points
        place = _Place.at(first, u)
        hit = _nearest_place(strokes, start, place.on(first))
        for d in range(start, len(truth)):
            true = table[d].get(identity)
            if true is not None and len(true.points) == len(first):
                result.truth[k, d] = place.on(true.points)
                result.is_seen[k, d] = any(a <= u <= b for a, b in true.visible)
            elif true is not None:
                result.is_known[k, d] = False  # drawn with other segments: which point it is cannot be told
            if hit is not None and strokes.layout.first[hit[0]] <= d <= strokes.layout.last[hit[0]]:
                points, (u0, u1) = _row(strokes, hit[0], d)
                found = _Place.at(points, hit[1].u) if by_arc else hit[1]
                result.found[k, d] = found.on(points)
                result.is_found[k, d] = u1 > u0 and u0 <= found.u <= u1
    if ink is not None:
        result.is_seen[...] &= _on_ink(result.truth, ink)
    return result


def _queries(truth: list[list[TrueStroke]]) -> list[tuple[int, int, float]]:
    """Drawing, identity and arc fraction of every point that is followed."""
    known: set[int] = set()
    queries = []
    for t, drawing in enumerate(truth):
        for stroke in drawing:
            if stroke.id in known or not stroke.visible:
                continue
            known.add(stroke.id)
            a, b = max(stroke.visible, key=lambda part: part[1] - part[0])
            queries += [(t, stroke.id, a + q * (b - a)) for q in QUERIES]
    return queries


def _row(strokes: Strokes, stroke: int, drawing: int) -> tuple[Floats, Floats]:
    """Control points and visible interval of a stroke on a drawing of its life."""
    row = strokes.row(stroke, drawing)
    return strokes.points_of(row), strokes.visible[row]


def _nearest_place(strokes: Strokes, drawing: int, point: Floats) -> tuple[int, _Place] | None:
    """The stroke and the place on it that are nearest to a point; none within the tolerance."""
    best: tuple[int, _Place] | None = None
    gap = TOLERANCE
    for row in strokes.rows_at(drawing):
        points = strokes.points_of(row)
        u0, u1 = map(float, strokes.visible[row])
        outside = np.maximum(points.min(0) - point, point - points.max(0)).max()
        if outside > gap or arc_length(points) < 1e-6 or u1 <= u0:
            continue
        for u in _from_coarse_to_fine(points, point, (u0, u1)):
            place = _Place.at(points, u)
            distance = float(np.linalg.norm(place.on(points) - point))
            if distance < gap:
                gap, best = distance, (int(strokes.layout.row_stroke[row]), place)
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


def has_ink(ink: NDArray[np.uint8], points: Floats) -> Bools:
    """Whether there is ink at points on a page [H, W]; nowhere outside it. [N, 2] px -> bool [N]"""
    is_inside: Bools = np.all((points >= 0) & (points < ink.shape[::-1]), axis=1)  # NaN is nowhere
    column, row = points[is_inside].astype(np.intp).T
    is_inside[is_inside] = ink[row, column] > _INK * 255
    return is_inside


def _on_ink(points: Floats, ink: Images) -> Bools:
    """Whether there is ink at each point on each drawing. bool [Q, D]"""
    on = [has_ink(page, points[:, d]) for d, page in enumerate(ink)]
    return np.stack(on, axis=1) if on else np.zeros(points.shape[:2], bool)


def _mean(values: Floats | Bools) -> float:
    return float(np.mean(values)) if len(values) else float("nan")
