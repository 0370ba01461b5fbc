"""Vector drawings in code: lines, fills that hide what lies below, their raster and their truth."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import cv2
import numpy as np
from numpy.typing import ArrayLike, NDArray

__all__ = [
    "Color",
    "Drawing",
    "Fill",
    "Line",
    "Movie",
    "arc_fractions",
    "drawn_curve",
    "ellipse",
    "flatten_curve",
    "hose",
    "paint",
    "place",
    "polygon",
    "rounded",
    "spline",
]

Floats = NDArray[np.float64]
Color = tuple[int, int, int]

SUPERSAMPLING = 8
"""Sub-pixels along each side of a pixel; coverage is their mean (a box filter)."""


@dataclass(frozen=True, slots=True, eq=False)
class Line:
    """A stroke with round caps.

    Args:
        name: What it is; the same in every drawing, one identity.
        points: Cubic control points. [3n+1, 2] px
        width: px
        color: sRGB, 0 .. 255
        is_closed: Whether it ends where it begins.
        drawn: The part that is drawn, as arc fractions.
    """

    name: str
    points: Floats
    width: float
    color: Color
    is_closed: bool = False
    drawn: tuple[float, float] = (0.0, 1.0)


@dataclass(frozen=True, slots=True, eq=False)
class Fill:
    """A page-coloured shape that hides what was drawn before it. [3n+1, 2] px"""

    points: Floats


Drawing = tuple["Line | Fill", ...]


@dataclass(frozen=True, slots=True, eq=False)
class Movie:
    """Drawings, and which of them each frame shows.

    Args:
        name: Stem of its files.
        size: Width and height. px
        drawings: In paint order each.
        drawing_of_frame: The drawing of each frame.
        frame_rate: Frames per second.
    """

    name: str
    size: tuple[int, int]
    drawings: tuple[Drawing, ...]
    drawing_of_frame: tuple[int, ...]
    frame_rate: int = 24

    @staticmethod
    def on_ones(name: str, size: tuple[int, int], drawings: Sequence[Drawing], frame_rate: int = 24) -> Movie:
        """A movie in which every frame is a new drawing."""
        return Movie(name, size, tuple(drawings), tuple(range(len(drawings))), frame_rate)


def spline(points: ArrayLike, *, is_closed: bool = False) -> Floats:
    """A smooth curve through points, as cubic control points. [3n+1, 2]

    Catmull-Rom tangents, scaled by the chord on each side so that uneven points give no loops; at a free end, the one
    that makes the last piece an arc.
    """
    knots = np.asarray(points, float)
    if is_closed:
        knots = np.concatenate([knots, knots[:1]])
    chords = np.diff(knots, axis=0)
    lengths = np.maximum(np.linalg.norm(chords, axis=1), 1e-9)[:, None]
    units = chords / lengths
    before = np.roll(units, 1, axis=0) if is_closed else np.concatenate([units[:1], units[:-1]])
    weight = np.roll(lengths, 1, axis=0) if is_closed else np.concatenate([lengths[:1], lengths[:-1]])
    blended = before / weight + units / lengths
    tangents = np.concatenate([blended, blended[:1] if is_closed else units[-1:]])
    tangents /= np.maximum(np.linalg.norm(tangents, axis=1, keepdims=True), 1e-9)
    if not is_closed and len(knots) > 2:
        for end, inner, unit in ((0, 1, units[0]), (-1, -2, units[-1])):
            tangents[end] = 2 * (unit @ tangents[inner]) * unit - tangents[inner]
    control = [knots[0]]
    for i, length in enumerate(lengths):
        control += [knots[i] + tangents[i] * length / 3, knots[i + 1] - tangents[i + 1] * length / 3, knots[i + 1]]
    return np.array(control)


def polygon(points: ArrayLike) -> Floats:
    """Straight edges through points, as cubic control points. [3n+1, 2]"""
    knots = np.asarray(points, float)
    control = [knots[0]]
    for a, b in pairwise(knots):
        control += [a + (b - a) / 3, a + (b - a) * 2 / 3, b]
    return np.array(control)


def ellipse(center: ArrayLike, radius: ArrayLike, start: float = 0.0, sweep: float = 360.0) -> Floats:
    """An arc of an ellipse, clockwise on the page from the x axis. degrees -> [3n+1, 2]"""
    count = max(1, math.ceil(abs(sweep) / 90))
    angles = np.radians(start + sweep * np.arange(count + 1) / count)
    reach = 4 / 3 * math.tan(math.radians(sweep / count) / 4)
    unit = np.stack([np.cos(angles), np.sin(angles)], axis=1)
    normal = np.stack([-np.sin(angles), np.cos(angles)], axis=1)
    control = [unit[0]]
    for i in range(count):
        control += [unit[i] + reach * normal[i], unit[i + 1] - reach * normal[i + 1], unit[i + 1]]
    points: Floats = np.asarray(center, float) + np.array(control) * np.asarray(radius, float)
    return points


def rounded(center: ArrayLike, half: ArrayLike, radius: float) -> Floats:
    """A rectangle with round corners. [25, 2]"""
    (x, y), (w, h) = np.asarray(center, float), np.asarray(half, float)
    corners = ((x + w - radius, y + h - radius, 0), (x - w + radius, y + h - radius, 90),
               (x - w + radius, y - h + radius, 180), (x + w - radius, y - h + radius, 270))  # fmt: skip
    parts = [ellipse((cx, cy), (radius, radius), start, 90) for cx, cy, start in corners]
    control = parts[0]
    for part in [*parts[1:], parts[0][:1]]:
        control = np.concatenate([control, polygon([control[-1], part[0]])[1:], part[1:]])
    return control


def hose(center_line: Floats, radius: float) -> tuple[Floats, Floats]:
    """The two sides of a tube around a curve. [3n+1, 2] each"""
    curve = flatten_curve(center_line, 12)
    tangent = np.gradient(curve, axis=0)
    normal = np.stack([-tangent[:, 1], tangent[:, 0]], axis=1) / np.linalg.norm(tangent, axis=1, keepdims=True)
    picked = np.linspace(0, len(curve) - 1, 5).round().astype(int)
    return spline((curve + radius * normal)[picked]), spline((curve - radius * normal)[picked])


def flatten_curve(points: Floats, per_segment: int = 24) -> Floats:
    """Points along a spline. [n * per_segment + 1, 2]"""
    t = np.linspace(0, 1, per_segment, endpoint=False)[:, None]
    segments = [points[k : k + 4] for k in range(0, len(points) - 1, 3)]
    curve = [(1 - t) ** 3 * a + 3 * (1 - t) ** 2 * t * b + 3 * (1 - t) * t**2 * c + t**3 * d for a, b, c, d in segments]
    return np.concatenate([*curve, points[-1:]])


def place(
    items: Sequence[Line | Fill],
    shift: ArrayLike = (0, 0),
    turn: float = 0.0,
    scale: ArrayLike = 1.0,
    about: ArrayLike = (0, 0),
) -> Drawing:
    """Items scaled, then turned clockwise (degrees), about a point, then shifted."""
    angle, pivot = math.radians(turn), np.asarray(about, float)
    matrix = np.array([[math.cos(angle), -math.sin(angle)], [math.sin(angle), math.cos(angle)]])
    offset = pivot + np.asarray(shift, float)
    return tuple(
        replace(item, points=((item.points - pivot) * np.asarray(scale, float)) @ matrix.T + offset) for item in items
    )


def arc_fractions(curve: Floats) -> Floats:
    """How far along its length each point of a polyline lies, in [0, 1]."""
    length = np.concatenate([[0], np.cumsum(np.linalg.norm(np.diff(curve, axis=0), axis=1))])
    fractions: Floats = length / max(float(length[-1]), 1e-9)
    return fractions


def drawn_curve(line: Line) -> Floats:
    """Points along the part of a line that is drawn; none if nothing is. [N, 2]"""
    curve = flatten_curve(line.points)
    start, end = line.drawn
    if end <= start:
        return np.zeros((0, 2))
    u = arc_fractions(curve)
    inside = u[(u > start) & (u < end)]
    at = np.concatenate([[start], inside, [end]])
    return np.stack([np.interp(at, u, curve[:, k]) for k in (0, 1)], axis=1)


def paint(drawing: Drawing, size: tuple[int, int]) -> NDArray[np.uint8]:
    """The raster of a drawing on white: area coverage by supersampling. uint8 [H, W, 3]"""
    inks = sorted({item.color for item in drawing if isinstance(item, Line)})
    labels = np.zeros((size[1] * SUPERSAMPLING, size[0] * SUPERSAMPLING), np.uint8)
    for item in drawing:
        if isinstance(item, Fill):
            cv2.fillPoly(labels, [_fixed(flatten_curve(item.points))], 0, shift=_SHIFT)
        else:
            _brush(labels, drawn_curve(item), item.width, 1 + inks.index(item.color))
    image = np.full((size[1], size[0], 3), 255.0)
    for index, color in enumerate(inks, start=1):
        covered = cv2.resize((labels == index).astype(np.float32), size, interpolation=cv2.INTER_AREA)
        image += covered[..., None] * (np.array(color) - 255.0)
    raster: NDArray[np.uint8] = np.clip(np.rint(image), 0, 255).astype(np.uint8)
    return raster


_SHIFT = 6
"""Fraction bits of OpenCV's fixed-point coordinates."""


def _fixed(curve: Floats) -> NDArray[np.int32]:
    """Page coordinates as OpenCV's on the supersampled raster, whose pixel centres are whole numbers."""
    return np.rint((curve * SUPERSAMPLING - 0.5) * (1 << _SHIFT)).astype(np.int32)


def _brush(labels: NDArray[np.uint8], curve: Floats, width: float, value: int) -> None:
    """Fill a round-capped line: discs at its points, boxes between them."""
    if not len(curve):
        return
    radius = width / 2
    for x, y in _fixed(curve):
        cv2.circle(labels, (int(x), int(y)), round(radius * SUPERSAMPLING * (1 << _SHIFT)), value, -1, shift=_SHIFT)
    for a, b in pairwise(curve):
        across = np.array([a[1] - b[1], b[0] - a[0]])
        across *= radius / max(float(np.linalg.norm(across)), 1e-9)
        box = _fixed(np.array([a + across, b + across, b - across, a - across]))
        cv2.fillConvexPoly(labels, box, value, shift=_SHIFT)
