"""Bézier mathematics in numpy: evaluate, measure, sample, split and cut splines of cubic segments.

A spline of n segments is its 3n+1 control points; neighbouring segments share their joint. Nothing here knows of
ink, colour or time.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import ArrayLike, NDArray

from videovec.errors import FitError

__all__ = [
    "Ruler",
    "arc_length",
    "derivative",
    "evaluate",
    "parameter_at",
    "reverse",
    "sample_by_arc",
    "segment_lengths",
    "segments_of",
    "split",
    "sub_curve",
    "width_at",
]

Floats = NDArray[np.float64]
Ints = NDArray[np.intp]

_INTERVALS = 16  # pieces of a segment between which its arc length is tabulated
_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(5)


def _table_basis() -> Floats:
    """Velocity from the legs of a segment at all nodes of all its intervals. [80, 3]"""
    t = ((np.arange(_INTERVALS)[:, None] + 0.5 * (1.0 + _NODES)) / _INTERVALS).ravel()
    return 3.0 * np.stack([(1.0 - t) ** 2, 2.0 * (1.0 - t) * t, t * t], axis=-1)


_TABLE_BASIS = _table_basis()
_POWERS = np.array([[3.0, 0.0, 0.0], [-6.0, 6.0, 0.0], [3.0, -6.0, 3.0]])  # legs to velocity as a polynomial of t


def segments_of(points: Floats) -> Floats:
    """The segments of a spline.

    Args:
        points: Control points. [3n+1, 2]

    Returns:
        Control points of each segment. [n, 4, 2]

    Raises:
        FitError: The number of control points is not 3n+1 with n of at least one.
    """
    count = len(points) - 1
    if count < 3 or count % 3:
        raise FitError(f"a spline needs 3n+1 control points, n at least 1, got {len(points)}")
    return np.asarray(points[3 * np.arange(count // 3)[:, None] + np.arange(4)])


def evaluate(control: Floats, t: ArrayLike) -> Floats:
    """Points on cubic Bézier segments.

    Args:
        control: Control points. [..., 4, 2]
        t: Parameter, broadcast against the leading axes of ``control``. [...]

    Returns:
        One point each. [..., 2]
    """
    s = np.asarray(t, dtype=np.float64)[..., None]
    r = 1.0 - s
    p0, p1, p2, p3 = (control[..., i, :] for i in range(4))
    return np.asarray(r * r * (r * p0 + 3.0 * s * p1) + s * s * (3.0 * r * p2 + s * p3))


def derivative(control: Floats, t: ArrayLike) -> Floats:
    """Derivative by t of cubic Bézier segments; arguments and result as for `evaluate`."""
    s = np.asarray(t, dtype=np.float64)[..., None]
    r = 1.0 - s
    p0, p1, p2, p3 = (control[..., i, :] for i in range(4))
    return np.asarray(3.0 * (r * r * (p1 - p0) + 2.0 * r * s * (p2 - p1) + s * s * (p3 - p2)))


def split(control: Floats, t: ArrayLike) -> tuple[Floats, Floats]:
    """Cut segments in two by de Casteljau's construction.

    Args:
        control: Control points. [..., 4, 2]
        t: Where to cut, broadcast against the leading axes of ``control``. [...]

    Returns:
        Control points before and after the cut. Twice [..., 4, 2]
    """
    s = np.asarray(t, dtype=np.float64)[..., None]
    rows = [control[..., i, :] + 0.0 * s for i in range(4)]
    before, after = [rows[0]], [rows[3]]
    while len(rows) > 1:
        rows = [(1.0 - s) * a + s * b for a, b in pairwise(rows)]
        before.append(rows[0])
        after.append(rows[-1])
    return np.stack(before, axis=-2), np.stack(after[::-1], axis=-2)


def _speed_at(velocity: Floats, t: Floats) -> Floats:
    """Speed at parameters [K, M] of M segments whose velocity is this polynomial of t [3, 2, M]. [K, M]"""
    x, y = (velocity[0, i] + t * (velocity[1, i] + t * velocity[2, i]) for i in range(2))
    return np.asarray(np.sqrt(x * x + y * y))


def _lengths_between(velocity: Floats, start: Floats, stop: Floats) -> Floats:
    """Arc length between two parameters of M segments, likewise. [M]"""
    half = 0.5 * (stop - start)
    return np.asarray(half * (_WEIGHTS @ _speed_at(velocity, start + half * (1.0 + _NODES[:, None]))))


@dataclass(frozen=True, slots=True, eq=False)
class Ruler:
    """Arc length along segments one after the other, which need not touch: many splines are measured at once.

    Args:
        legs: Differences of the control points of each segment. [G, 3, 2]
        table: Arc length from the first segment to the ends of every interval of every segment. [16G+1]
    """

    legs: Floats
    table: Floats

    @staticmethod
    def of(segments: Floats) -> Ruler:
        """Measure segments [G, 4, 2]."""
        legs = np.diff(segments, axis=1)
        velocity = _TABLE_BASIS @ legs
        speed = np.sqrt(np.einsum("gtk,gtk->gt", velocity, velocity)).reshape(-1, len(_NODES))
        table = np.zeros(len(speed) + 1)
        np.cumsum(speed @ (0.5 / _INTERVALS * _WEIGHTS), out=table[1:])
        return Ruler(legs, table)

    @property
    def ends(self) -> Floats:
        """Arc length at which each segment begins, then that of all. [G+1]"""
        return self.table[::_INTERVALS]

    def arc_at(self, places: Floats) -> Floats:
        """Arc length up to places, given as segment plus parameter. [M]"""
        at = np.clip((places * _INTERVALS).astype(np.intp), 0, len(self.table) - 2)
        segment, interval = at // _INTERVALS, at % _INTERVALS
        t = np.clip(places - segment, 0.0, 1.0)
        return np.asarray(self.table[at] + _lengths_between(self._velocities(segment), interval / _INTERVALS, t))

    def place_at(self, arc: Floats) -> tuple[Ints, Floats]:
        """The segment and the parameter in it at arc lengths. int [M], [M]"""
        at = np.clip(np.searchsorted(self.table, arc, side="right") - 1, 0, len(self.table) - 2)
        segment, interval = at // _INTERVALS, at % _INTERVALS
        velocity = self._velocities(segment)
        start = interval / _INTERVALS
        along, width = arc - self.table[at], self.table[at + 1] - self.table[at]
        t = start + np.where(width > 0, along / np.where(width > 0, width, 1.0), 0.0) / _INTERVALS
        for _ in range(2):  # Newton on the arc length; the table's linear guess is close
            speed = _speed_at(velocity, t)
            excess = _lengths_between(velocity, start, t) - along
            step = np.where(speed > 1e-9, excess / np.maximum(speed, 1e-9), 0.0)
            t = np.minimum(np.maximum(t - step, start), start + 1.0 / _INTERVALS)
        return segment, t

    def _velocities(self, segment: Ints) -> Floats:
        """Velocity of segments as a polynomial of t. [3, 2, M]"""
        return np.ascontiguousarray((_POWERS @ self.legs[segment]).transpose(1, 2, 0))


def segment_lengths(points: Floats) -> Floats:
    """Arc length of each segment of a spline [3n+1, 2]. [n]"""
    return np.asarray(np.diff(Ruler.of(segments_of(points)).ends))


def arc_length(points: Floats) -> float:
    """Arc length of a spline [3n+1, 2]."""
    return float(Ruler.of(segments_of(points)).table[-1])


def parameter_at(points: Floats, u: ArrayLike) -> tuple[Ints, Floats]:
    """Where on a spline given fractions of its arc length lie.

    Args:
        points: Control points. [3n+1, 2]
        u: Arc fractions. [M] in [0, 1]

    Returns:
        Segment and parameter within it. int [M], [M]
    """
    ruler = Ruler.of(segments_of(points))
    return ruler.place_at(np.clip(np.asarray(u, dtype=np.float64), 0.0, 1.0) * ruler.table[-1])


def sample_by_arc(points: Floats, count: int) -> Floats:
    """Points at equal steps of arc length, both ends included.

    Args:
        points: Control points. [3n+1, 2]
        count: How many points, M.

    Returns:
        Points on the spline. [M, 2]
    """
    segment, t = parameter_at(points, np.linspace(0.0, 1.0, count))
    return evaluate(segments_of(points)[segment], t)


def width_at(half_width: Floats, segment: Ints, t: Floats) -> Floats:
    """Half-width at places on a spline, linear in t between its joints [n+1]. [M]"""
    return np.asarray((1.0 - t) * half_width[segment] + t * half_width[segment + 1])


def sub_curve(points: Floats, half_width: Floats, u0: float, u1: float) -> tuple[Floats, Floats]:
    """The part of a spline between two fractions of its arc length.

    Args:
        points: Control points. [3n+1, 2]
        half_width: Half-width at the joints. [n+1]
        u0: Where it begins, in [0, 1].
        u1: Where it ends, at least ``u0``.

    Returns:
        Control points [3m+1, 2] and half-widths [m+1] of the part, with 1 <= m <= n.
    """
    if u0 <= 0.0 and u1 >= 1.0:
        return points.copy(), half_width.copy()
    segment, t = parameter_at(points, np.array([u0, max(u0, u1)]))
    first, last = int(segment[0]), int(segment[1])
    if last > first and t[1] <= 0.0:
        last, t[1] = last - 1, 1.0
    if last > first and t[0] >= 1.0:
        first, t[0] = first + 1, 0.0
    control = segments_of(points)[first : last + 1].copy()
    widths = half_width[first : last + 2].copy()
    ends = width_at(half_width, np.array([first, last]), t)
    control[-1] = split(control[-1], t[1])[0]
    start = t[0] if last > first else (t[0] / t[1] if t[1] > 0.0 else 0.0)
    control[0] = split(control[0], start)[1]
    widths[0], widths[-1] = ends
    return np.concatenate([control[0, :1], control[:, 1:].reshape(-1, 2)]), widths


def reverse(points: Floats, half_width: Floats) -> tuple[Floats, Floats]:
    """The same spline and half-widths, run the other way."""
    return points[::-1].copy(), half_width[::-1].copy()
