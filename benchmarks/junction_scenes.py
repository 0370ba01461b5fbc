"""A page on which nearer outlines hide what lies behind them, and limbs with hands, cuffs and folds to draw on it.

What is hidden is not drawn; every visible piece of an outline is one stroke, and it ends on the outline that hides the
rest, as artists draw.
"""

from __future__ import annotations

from itertools import pairwise

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import gaussian_filter1d

__all__ = [
    "Limb",
    "Page",
    "add_cuffs",
    "add_folds",
    "add_limb",
    "blob",
    "densify",
    "frame",
    "free_curve",
    "heading_of",
    "is_inside",
    "polygon",
    "spine_from",
    "turned",
]

Floats = NDArray[np.float64]
Random = np.random.Generator

_STEP = 0.004  # between samples of outlines; a page is about 1 wide


def densify(line: Floats, step: float) -> Floats:
    """The same polyline with more samples, at most ``step`` apart."""
    parts = []
    for a, b in pairwise(line):
        count = max(1, int(np.ceil(np.linalg.norm(b - a) / step)))
        parts.append(a + (b - a) * np.arange(count)[:, None] / count)
    return np.concatenate([*parts, line[-1:]])


def is_inside(ring: Floats, points: Floats) -> NDArray[np.bool_]:
    contour = ring.astype(np.float32).reshape(-1, 1, 2)
    return np.array([cv2.pointPolygonTest(contour, (float(x), float(y)), False) >= 0 for x, y in points])


def turned(points: Floats, angle: float) -> Floats:
    c, s = np.cos(angle), np.sin(angle)
    return np.asarray(points @ np.array([[c, -s], [s, c]]).T)


def heading_of(vector: Floats) -> float:
    return float(np.arctan2(vector[1], vector[0]))


class Page:
    """Strokes drawn so far, the nearest thing last."""

    def __init__(self, rng: Random) -> None:
        self.strokes: list[Floats] = []
        self.rng = rng

    def hide(self, ring: Floats) -> None:
        """Erase what lies inside a ring; what is left of a line runs on to it."""
        kept = []
        for line in self.strokes:
            if (line.max(axis=0) < ring.min(axis=0)).any() or (line.min(axis=0) > ring.max(axis=0)).any():
                kept.append(line)
                continue
            seen = ~is_inside(ring, line)
            if seen.all():
                kept.append(line)
                continue
            if np.linalg.norm(line[0] - line[-1]) < 1e-6 and seen.any():
                first = int(np.flatnonzero(~seen)[0])
                line = np.concatenate([line[first:-1], line[: first + 1]])
                seen = np.concatenate([seen[first:-1], seen[: first + 1]])
            where = np.flatnonzero(seen)
            for run in np.split(where, np.flatnonzero(np.diff(where) > 1) + 1):
                if len(run) > 4:
                    kept.append(line[max(run[0] - 1, 0) : min(run[-1] + 1, len(line) - 1) + 1])
        self.strokes = kept

    def shape(self, ring: Floats, hides: bool = True, gap: tuple[float, float] | None = None) -> Floats:
        """Draw a ring, which does not repeat its first point, but for a share of it; returns its samples, closed."""
        ring = densify(np.concatenate([ring, ring[:1]]), _STEP)
        if hides:
            self.hide(ring)
        if gap is None:
            self.strokes.append(ring)
            return ring
        count = len(ring) - 1
        low, high = int(gap[0] * count), int(gap[1] * count)
        drawn = np.roll(ring[:-1], -high, axis=0)[: count - (high - low)]
        if len(drawn) > 6:
            self.strokes.append(drawn)
        return ring

    def line(self, line: Floats, within: Floats | None = None) -> None:
        """Draw a line, until it leaves a ring if one is given."""
        line = densify(line, _STEP)
        if within is not None:
            outside = np.flatnonzero(~is_inside(within, line)[3:])
            if len(outside):
                line = line[: outside[0] + 4]
        if len(line) > 8:
            self.strokes.append(line)


def blob(rng: Random, count: int) -> Floats:
    """A smooth closed shape of about unit size."""
    angle = np.linspace(0, 2 * np.pi, count, endpoint=False)
    waves = [rng.normal(0, 0.35 / (k + 1)) * np.cos(k * angle + rng.uniform(0, 6.3)) for k in range(1, 6)]
    radius = np.clip(1 + np.sum(waves, axis=0), 0.35, 2)
    return np.stack([np.cos(angle) * radius, np.sin(angle) * radius * rng.uniform(0.4, 1)], axis=1)


def polygon(rng: Random) -> Floats:
    """A polygon of three to seven corners, most of them rounded."""
    count = rng.integers(3, 8)
    angle, radius = np.sort(rng.uniform(0, 2 * np.pi, count)), rng.uniform(0.5, 1.1, count)
    ring = np.stack([np.cos(angle) * radius, np.sin(angle) * radius * rng.uniform(0.4, 1)], axis=1)
    ring = densify(np.concatenate([ring, ring[:1]]), 0.04)[:-1]
    if rng.random() < 0.6:
        ring = gaussian_filter1d(ring, rng.uniform(0.3, 3), axis=0, mode="wrap")
    return ring


def free_curve(rng: Random, count: int = 60) -> Floats:
    """A line from the origin that bends, and has a corner now and then."""
    length = rng.uniform(0.15, 0.9)
    steady = rng.normal(0, 2.5 / max(length, 0.2) * 0.6)
    bend = steady + rng.normal(0, 3) * np.sin(np.linspace(0, rng.uniform(1, 7), count) + rng.uniform(0, 6))
    heading = rng.uniform(0, 6.3) + np.cumsum(bend) * length / count
    for _ in range(rng.poisson(0.6)):
        heading[rng.integers(5, count - 5) :] += rng.choice([-1, 1]) * rng.uniform(0.5, 2.2)
    steps = np.stack([np.cos(heading), np.sin(heading)], axis=1) * length / count
    return np.concatenate([[[0, 0]], np.cumsum(steps, axis=0)])


def spine_from(rng: Random, start: Floats, heading: float, length: float, count: int = 60) -> Floats:
    """The middle of a limb: it bends, and half of them have an elbow."""
    bend = rng.normal(0, 1.2) + rng.normal(0, 2.0) * np.sin(
        np.linspace(0, rng.uniform(1, 5), count) + rng.uniform(0, 6)
    )
    angle = heading + np.cumsum(np.full(count, 1.0) * bend) / count
    if rng.random() < 0.5:
        knee = rng.choice([-1, 1]) * rng.uniform(0.3, 1.7)
        angle += knee / (1 + np.exp(-(np.arange(count) - count * rng.uniform(0.35, 0.65)) / rng.uniform(0.5, 5)))
    steps = np.stack([np.cos(angle), np.sin(angle)], axis=1) * length / count
    return np.asarray(start + np.concatenate([[[0, 0]], np.cumsum(steps, axis=0)]))


def frame(spine: Floats) -> tuple[Floats, Floats]:
    """Tangents and normals of a line."""
    tangent = np.gradient(spine, axis=0)
    tangent /= np.linalg.norm(tangent, axis=1)[:, None] + 1e-9
    return tangent, np.stack([-tangent[:, 1], tangent[:, 0]], axis=1)


class Limb:
    """A tube around a spine."""

    def __init__(self, spine: Floats, half: Floats) -> None:
        self.spine, self.half = spine, half
        self.tangent, self.normal = frame(spine)
        self.left, self.right = spine + self.normal * half[:, None], spine - self.normal * half[:, None]
        self.ring = np.concatenate([self.left, self.right[::-1]])

    def across(self, k: int, bow: float, over: float = 0.0, count: int = 15) -> Floats:
        """A line from side to side that bulges along the limb."""
        k = min(max(k, 0), len(self.spine) - 1)
        u = np.linspace(-1, 1, count)[:, None]
        bulge = self.tangent[k] * (1 - u * u) * self.half[k] * bow
        return np.asarray(self.spine[k] + self.normal[k] * u * (self.half[k] + over) + bulge)


def add_hand(page: Page, rng: Random, limb: Limb) -> None:
    """Something at the end of a limb, with a few fingers drawn into it."""
    size = limb.half[-1] * rng.uniform(0.9, 1.8)
    shape = blob(rng, 80) if rng.random() < 0.6 else polygon(rng)
    ring = turned(shape * [1.2, 0.8] * size, heading_of(limb.tangent[-1]))
    ring = ring + limb.spine[-1] + limb.tangent[-1] * size * rng.uniform(0.2, 0.9)
    if rng.random() < 0.5:
        page.shape(ring)
    else:
        page.shape(ring, True, (0.45, 0.45 + rng.uniform(0.05, 0.2)))
    for _ in range(rng.poisson(1.0)):
        k = rng.integers(len(ring))
        heading = heading_of(ring.mean(axis=0) - ring[k]) + rng.normal(0, 0.5)
        page.line(spine_from(rng, ring[k], heading, size * rng.uniform(0.3, 0.9), 20), ring)


def add_cuffs(page: Page, rng: Random, limb: Limb) -> None:
    """Bands around a limb: objects of their own that interrupt its outline, or single lines across it."""
    count = len(limb.spine)
    for _ in range(rng.poisson(0.9)):
        i = int(rng.integers(5, count - 12))
        j = i + int(rng.integers(3, 9))
        over, bow = rng.choice([0.0, 0.0, 0.002, 0.006, 0.012]), rng.normal(0, 0.3)
        top, low = limb.across(i, bow, over), limb.across(min(j, count - 1), bow + rng.normal(0, 0.1), over)
        outward = limb.normal[i:j] * (limb.half[i:j] + over)[:, None]
        sides = limb.spine[i:j] + outward, limb.spine[i:j] - outward
        kind = rng.random()
        if kind < 0.6:
            page.shape(np.concatenate([top, sides[0][1:-1], low[::-1], sides[1][::-1][1:-1]]))
        elif kind < 0.85:
            page.line(top)
            if rng.random() < 0.6:
                page.line(low)
        else:
            page.line(top)


def add_folds(page: Page, rng: Random, limb: Limb) -> None:
    """Lines from the edge of a limb into it, most of them leaving it gently."""
    for _ in range(rng.poisson(1.2)):
        side = limb.left if rng.random() < 0.5 else limb.right
        k, sign = rng.integers(3, len(side) - 6), rng.choice([-1, 1])
        base, inward = heading_of(sign * limb.tangent[k]), heading_of(limb.spine[k] - side[k])
        turn = (inward - base + np.pi) % (2 * np.pi) - np.pi
        heading = base + turn * rng.choice([0.15, 0.35, 0.6, 1.0]) + rng.normal(0, 0.1)
        page.line(spine_from(rng, side[k], heading, limb.half[k] * rng.uniform(0.6, 2.2), 30), limb.ring)


def add_limb(page: Page, rng: Random, start: Floats, heading: float, size: tuple[float, float], depth: int = 0) -> None:
    """Draw a limb of some length and half-width, with what is on it and, at times, another that grows from it."""
    length, width = size
    spine = spine_from(rng, start, heading, length)
    count = len(spine)
    taper = [1, rng.uniform(0.8, 1.25), rng.uniform(0.6, 1.1), rng.uniform(0.4, 0.9)]
    limb = Limb(spine, width * np.interp(np.linspace(0, 1, count), [0, 0.3, 0.6, 1], taper))
    ring = limb.ring
    if rng.random() < 0.6:
        ring = gaussian_filter1d(ring, rng.uniform(0.5, 2.5), axis=0, mode="wrap")
    if rng.random() < 0.55:  # open where it joins the body
        rest = rng.uniform(0, 0.06)
        page.shape(np.roll(ring, -3, axis=0), True, (0.97 - rest, 0.999))
    else:
        page.shape(ring, rng.random() < 0.9)
    if rng.random() < 0.6:
        add_hand(page, rng, limb)
    add_cuffs(page, rng, limb)
    add_folds(page, rng, limb)
    if depth < 1 and rng.random() < 0.35:
        k = rng.integers(count // 2, count)
        away = heading_of(limb.tangent[k]) + rng.normal(0, 0.9)
        smaller = length * rng.uniform(0.4, 0.8), limb.half[k] * rng.uniform(0.5, 1)
        add_limb(page, rng, spine[k], away, smaller, depth + 1)
