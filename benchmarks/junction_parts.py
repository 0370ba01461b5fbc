"""Made-up figures of jointed parts: each part is an outline of its own that is open where it grows out of another."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import gaussian_filter1d

from benchmarks.junction_scenes import (
    Limb,
    Page,
    add_cuffs,
    add_folds,
    blob,
    heading_of,
    is_inside,
    polygon,
    spine_from,
    turned,
)

__all__ = ["DrawPart", "draw_part", "jointed"]

Floats = NDArray[np.float64]
Random = np.random.Generator
DrawPart = Callable[[Page, Random, Floats, Floats | None], None]
"""Draws the outline of a part, given that of the part that it grows out of."""


def _capsule(rng: Random, a: Floats, b: Floats, half: float) -> tuple[Floats, Limb]:
    """A limb's part from joint to joint, round at both ends, and its tube."""
    along = b - a
    length = float(np.linalg.norm(along)) + 1e-9
    count = 40
    spine = spine_from(rng, a, heading_of(along), length, count)
    spine = a + turned(spine - a, heading_of(along) - heading_of(spine[-1] - a))
    s = np.linspace(0, 1, len(spine))
    shape = 1 + rng.uniform(-0.1, 0.35) * np.sin(np.pi * s ** rng.uniform(0.5, 1.5)) - rng.uniform(0, 0.45) * s
    limb = Limb(spine, half * shape)
    angle = np.linspace(0, np.pi, 14)[1:-1, None]
    bulge = rng.uniform(0.3, 1.0, 2)
    caps = []
    for k, sign in ((-1, 1.0), (0, -1.0)):
        round_end = limb.normal[k] * np.cos(angle) + bulge[k] * limb.tangent[k] * np.sin(angle)
        caps.append(limb.spine[k] + sign * half * shape[k] * round_end)
    ring = np.concatenate([limb.left, caps[0], limb.right[::-1], caps[1]])
    return gaussian_filter1d(ring, rng.uniform(0.3, 1.5), axis=0, mode="wrap"), limb


def _sleeve(rng: Random, a: Floats, b: Floats, half: float) -> Floats:
    """A part that widens towards its end, with a hem."""
    along = (b - a) / (np.linalg.norm(b - a) + 1e-9)
    across, wide = np.array([-along[1], along[0]]), half * rng.uniform(1.0, 2.2)
    u = np.linspace(-1, 1, 20)[:, None]
    hem = b + across * u * wide + along * (1 - u * u) * half * rng.normal(0, 0.4)
    hem += along * rng.normal(0, 0.2) * half * u
    root = a + across * np.linspace(1, -1, 8)[:, None] * half
    t = np.linspace(0, 1, 14)[1:-1, None]
    sides = [root[-1] * (1 - t) + hem[0] * t, hem[-1] * (1 - t) + root[0] * t]
    bends = [across * rng.normal(0, 0.25) * half * np.sin(np.pi * t) for _ in sides]
    return np.concatenate([root, sides[0] + bends[0], hem, sides[1] + bends[1]])


def _fingers(rng: Random, center: Floats, heading: float, size: float) -> Floats:
    """A hand as one outline with fingers."""
    angle = np.linspace(0, 2 * np.pi, 240, endpoint=False)
    radius = np.full(240, 0.55)
    count = int(rng.integers(2, 6))
    for where in np.linspace(-0.9, 0.9, count) * rng.uniform(0.5, 1.1) + rng.normal(0, 0.06, count):
        apart = (angle - where + np.pi) % (2 * np.pi) - np.pi
        radius += rng.uniform(0.4, 1.1) * np.exp(-((apart / rng.uniform(0.1, 0.22)) ** 4))
    points = np.stack([np.cos(angle) * radius, np.sin(angle) * radius * rng.uniform(0.6, 1.2)], axis=1)
    return turned(gaussian_filter1d(points, 1.0, axis=0, mode="wrap") * size, heading) + center


def draw_part(page: Page, rng: Random, ring: Floats, parent: Floats | None) -> None:
    """Draw a part, closed, or open where it lies in the one that it grows out of but for a little of its line."""
    inside = np.zeros(len(ring), bool) if parent is None else is_inside(parent, ring)
    if rng.random() < 0.3 or not inside.any() or inside.all():
        page.shape(ring, rng.random() < 0.95)
        return
    ring = np.roll(ring, -int(np.flatnonzero(~inside)[0]), axis=0)
    inside = np.roll(inside, -int(np.flatnonzero(~inside)[0]))
    where = np.flatnonzero(inside)
    run = max(np.split(where, np.flatnonzero(np.diff(where) > 1) + 1), key=len)
    kept = [rng.choice([0.0, rng.uniform(0, 0.45)]) * len(run) for _ in range(2)]
    low, high = (run[0] + kept[0]) / len(ring), (run[-1] + 1 - kept[1]) / len(ring)
    page.shape(ring, True, (float(low), float(high)) if high - low > 0.01 else None)


@dataclass(frozen=True, slots=True, eq=False)
class _Part:
    """One part of a figure.

    Args:
        depth: Parts of greater depth are drawn later and hide others.
        ring: Its outline.
        parent: The part that it grows out of; -1 for none.
        limb: Its tube, if it is one.
    """

    depth: float
    ring: Floats
    parent: int
    limb: Limb | None = None


def _hand(rng: Random, where: Floats, heading: float, half: float) -> Floats:
    """A hand or a foot at the end of a limb."""
    kind, scale = rng.random(), half * rng.uniform(1.2, 2.2)
    middle = where + scale * rng.uniform(0.3, 0.9) * np.array([np.cos(heading), np.sin(heading)])
    if kind < 0.4:
        return _fingers(rng, middle, heading, scale)
    return turned((blob(rng, 70) if kind < 0.7 else polygon(rng)) * [1.3, 0.8] * scale, heading) + middle


def _chain(rng: Random, parts: list[_Part], trunk: Floats, size: float) -> None:
    """Add a limb of one to three parts to a trunk around the origin."""
    start = trunk[rng.integers(len(trunk))] * rng.uniform(0.5, 1.0)
    heading, half = heading_of(start) + rng.normal(0, 0.5), size * rng.uniform(0.2, 0.5)
    parent, depth = 0, rng.normal(0, 1)
    for k in range(rng.integers(1, 4)):
        stop = start + half * rng.uniform(2.5, 5.5) * np.array([np.cos(heading), np.sin(heading)])
        tube = None if rng.random() < 0.2 else _capsule(rng, start, stop, half)
        depth += rng.normal(0, 0.5)
        if tube is None:
            parts.append(_Part(depth, _sleeve(rng, start, stop, half), parent))
        else:
            parts.append(_Part(depth, tube[0], parent, tube[1]))
        parent = len(parts) - 1
        start = stop - (stop - start) * rng.uniform(0.0, 0.25)
        heading += rng.normal(0, 0.7) + (k == 0) * rng.normal(0, 0.5)
        half *= rng.uniform(0.6, 0.95)
    if rng.random() < 0.75:
        ring = _hand(rng, start, heading, half)
        parts.append(_Part(depth + rng.normal(0, 0.5), ring, parent))


def jointed(rng: Random, draw: DrawPart = draw_part) -> list[Floats]:
    """Strokes of a body whose limbs are chains of parts, on a page about one wide."""
    page, size = Page(rng), rng.uniform(0.08, 0.16)
    trunk = polygon(rng) if rng.random() < 0.4 else blob(rng, 120)
    trunk = turned(trunk, rng.uniform(0, 6.3)) * size
    parts = [_Part(rng.normal(0, 1), trunk, -1)]
    for _ in range(rng.integers(2, 6)):
        _chain(rng, parts, trunk, size)
    if rng.random() < 0.7:
        head = turned(blob(rng, 100), rng.uniform(0, 6.3)) * size * rng.uniform(0.6, 1.1)
        parts.append(_Part(rng.normal(0.5, 1), head - size * np.array([0.0, rng.uniform(0.9, 1.5)]), 0))
    for part in sorted(parts, key=lambda part: part.depth):
        draw(page, rng, part.ring, parts[part.parent].ring if part.parent >= 0 else None)
        if part.limb is not None and rng.random() < 0.5:
            add_cuffs(page, rng, part.limb)
            add_folds(page, rng, part.limb)
    return [line for line in page.strokes if len(line) > 3]
