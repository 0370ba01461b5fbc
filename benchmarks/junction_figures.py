"""Made-up line drawings with known strokes: figures with limbs, hair and details, and scenes of any shapes."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import gaussian_filter1d

from benchmarks.junction_scenes import (
    Page,
    add_limb,
    blob,
    densify,
    frame,
    free_curve,
    heading_of,
    is_inside,
    polygon,
    spine_from,
    turned,
)

__all__ = ["figure", "scene"]

Floats = NDArray[np.float64]
Random = np.random.Generator


def _zigzag(page: Page, rng: Random, corners: list[Floats], center: Floats) -> None:
    """One line of hair along the head, with cusps."""
    parts = []
    u = np.linspace(0, 1, 12)[:, None]
    for a, b in pairwise(corners):
        middle = (a + b) / 2
        tip = middle + (center - middle) * rng.uniform(-0.8, 0.7) + rng.normal(0, 0.02, 2)
        bulge = rng.normal(0, 0.03, 2)
        parts += [a * (1 - u) + tip * u + u * (1 - u) * bulge]
        parts += [tip * (1 - u) + b * u + u * (1 - u) * rng.normal(0, 0.03, 2)]
    line = np.concatenate(parts)
    page.line(line[np.r_[True, np.linalg.norm(np.diff(line, axis=0), axis=1) > 1e-6]])


def _lock(page: Page, rng: Random, a: Floats, b: Floats, center: Floats) -> None:
    """A pointed lock of hair between two points of the head."""
    middle = (a + b) / 2
    out = middle - center
    out /= np.linalg.norm(out) + 1e-9
    tip = middle + out * rng.uniform(0.02, 0.16) * rng.choice([1, -1]) + rng.normal(0, 0.04, 2)
    u = np.linspace(0, 1, 25)[:, None]
    one, two = rng.normal(0, 0.05, 2), rng.normal(0, 0.05, 2)
    there = a * (1 - u) + tip * u + u * (1 - u) * 1.2 * one
    back = tip * (1 - u) + b * u + u * (1 - u) * 1.2 * two
    if rng.random() < 0.5:
        page.shape(np.concatenate([there, back[1:], (b * (1 - u) + a * u)[1:-1]]), True, (0.72, 0.999))
    else:
        page.line(np.concatenate([there, back[1:]]))


def _hair(page: Page, rng: Random, head: Floats, center: Floats) -> None:
    count = len(head)
    start, span = rng.integers(count), int(count * rng.uniform(0.2, 0.6))
    locks, kind = rng.integers(2, 7), rng.random()
    corners = [head[k] for k in (start + np.linspace(0, span, locks + 1).astype(int)) % count]
    if kind < 0.5:
        _zigzag(page, rng, corners, center)
        return
    for a, b in pairwise(corners):
        _lock(page, rng, a, b, center)


def _head(page: Page, rng: Random, neck: Floats, up: Floats) -> None:
    shape = blob(rng, 100) if rng.random() < 0.7 else polygon(rng)
    radius = rng.uniform(0.06, 0.14)
    center = neck + up * radius * rng.uniform(0.5, 1.1)
    head = turned(shape, rng.uniform(0, 6.3)) * radius + center
    page.shape(head, True, None if rng.random() < 0.7 else (0.2, 0.2 + rng.uniform(0.05, 0.25)))
    for _ in range(rng.integers(0, 3)):
        _hair(page, rng, head, center)
    for _ in range(rng.integers(0, 5)):  # eyes, ears, mouth
        part = blob(rng, 50) * rng.uniform(0.08, 0.3) * radius + center + rng.normal(0, 0.45, 2) * radius
        page.shape(part, True, None if rng.random() < 0.6 else (0.1, 0.6))


def _detail(page: Page, rng: Random) -> None:
    """A small object on a line or beside it, such as a button or a buckle."""
    if not page.strokes:
        return
    line = page.strokes[rng.integers(len(page.strokes))]
    k, radius = rng.integers(len(line)), rng.uniform(0.012, 0.06)
    center = line[k] + rng.normal(0, 1, 2) * radius * rng.choice([0.2, 0.9])
    kind = rng.random()
    if kind < 0.8:
        shape = blob(rng, 60) if kind < 0.5 else polygon(rng)
    else:
        angle = np.linspace(0, 6.2, 50)
        shape = np.stack([np.cos(angle), np.sin(angle) * rng.uniform(0.4, 1)], axis=1)
    ring = turned(shape, rng.uniform(0, 6.3)) * radius + center
    hides = rng.random() < 0.85
    drawn = page.shape(ring, hides, None if rng.random() < 0.8 else (0.1, 0.1 + rng.uniform(0.05, 0.3)))
    if rng.random() < 0.4:
        page.shape((drawn[:-1:2] - center) * rng.uniform(0.4, 0.75) + center)


def _belt(page: Page, rng: Random, body: Floats, half: Floats) -> None:
    tangent, normal = frame(body)
    i = rng.integers(4, len(body) - 8)
    j = i + rng.integers(2, 6)
    u, bow = np.linspace(-1, 1, 25)[:, None], rng.normal(0, 0.25)
    top, low = (body[k] + normal[k] * u * half[k] + tangent[k] * (1 - u * u) * half[k] * bow for k in (i, j))
    sides = (body + normal * half[:, None])[i + 1 : j], (body - normal * half[:, None])[i + 1 : j]
    if rng.random() < 0.5:
        page.shape(np.concatenate([top, sides[0], low[::-1], sides[1][::-1]]))
    else:
        page.line(top)
        page.line(low)


def figure(rng: Random) -> list[Floats]:
    """Strokes of a body with limbs before and behind it, a head and details, on a page about one wide."""
    page = Page(rng)
    width, center = rng.uniform(0.05, 0.13), rng.uniform(-0.05, 0.05, 2)
    body = spine_from(rng, center, -np.pi / 2 + rng.normal(0, 0.4), rng.uniform(0.2, 0.35))
    tangent, normal = frame(body)
    count = len(body)

    def arm(k: int, length: float, half: float) -> None:
        side = rng.choice([-1, 1])
        start = body[k] + normal[k] * side * width * rng.uniform(0.2, 1.0)
        add_limb(page, rng, start, heading_of(normal[k] * side) + rng.normal(0, 0.8), (length, half))

    for _ in range(rng.integers(0, 3)):
        arm(int(rng.integers(0, count)), rng.uniform(0.2, 0.4), width * rng.uniform(0.3, 0.7))
    waist = [rng.uniform(0.7, 1.3), rng.uniform(0.6, 1), rng.uniform(0.8, 1.3)]
    half = width * np.interp(np.linspace(0, 1, count), [0, 0.4, 1], waist)
    ring = np.concatenate([body + normal * half[:, None], (body - normal * half[:, None])[::-1]])
    ring = gaussian_filter1d(ring, rng.uniform(0.5, 4), axis=0, mode="wrap")
    page.shape(ring, True, None if rng.random() < 0.6 else (0.45, 0.55))
    for _ in range(rng.poisson(0.8)):
        _belt(page, rng, body, half)
    for _ in range(rng.integers(0, 4)):
        arm(int(rng.integers(0, count)), rng.uniform(0.2, 0.45), width * rng.uniform(0.35, 0.8))
    if rng.random() < 0.8:
        _head(page, rng, body[-1], tangent[-1])
    for _ in range(rng.poisson(2.0)):
        _detail(page, rng)
    for _ in range(rng.poisson(0.6)):
        if page.strokes:
            line = page.strokes[rng.integers(len(page.strokes))]
            start = line[rng.integers(len(line))]
            page.line(free_curve(rng) * 0.5 + start)
    return [line for line in page.strokes if len(line) > 3]


def _tube(rng: Random) -> Floats:
    spine = free_curve(rng, 50)
    half = rng.uniform(0.03, 0.12) * np.linspace(1, rng.uniform(0.5, 1.3), len(spine))
    normal = frame(spine)[1]
    return np.concatenate([spine + normal * half[:, None], (spine - normal * half[:, None])[::-1]])


def _inner_line(page: Page, rng: Random, ring: Floats) -> None:
    """A line from the outline inwards; many stop where they meet it again."""
    start = ring[rng.integers(len(ring) - 1)]
    line = free_curve(rng) * rng.uniform(0.3, 1.0)
    angle = heading_of(ring[:-1].mean(axis=0) - start) + rng.normal(0, 0.6) - heading_of(line[6] - line[0])
    page.line(turned(line, angle) + start, ring if rng.random() < 0.6 else None)


def _band(page: Page, rng: Random, ring: Floats) -> None:
    """Two lines side by side across a shape."""
    count = len(ring) - 1
    i, j = sorted(rng.integers(0, count, 2))
    if j - i <= 12:
        return
    t = np.linspace(0, 1, 60)[:, None]
    for shift in (0, rng.integers(4, 9)):
        a, b = ring[(i + shift) % count], ring[(j - shift) % count]
        middle = (a + b) / 2 + (b - a)[::-1] * [-1, 1] * rng.normal(0, 0.08)
        line = (1 - t) ** 2 * a + 2 * t * (1 - t) * (2 * middle - (a + b) / 2) + t * t * b
        if is_inside(ring, line).mean() > 0.9:
            page.strokes.append(line)


def _branching_line(page: Page, rng: Random) -> None:
    """A line that starts on another, some of them along it."""
    base = page.strokes[rng.integers(len(page.strokes))]
    line = free_curve(rng) + base[rng.integers(len(base))]
    k = min(int(rng.integers(len(base))), len(base) - 8)
    if rng.random() < 0.4 and k > 0:
        angle = heading_of(base[k + 6] - base[k]) - heading_of(line[6] - line[0]) + rng.normal(0, 0.25)
        line = turned(line - line[0], angle) + base[k]
    page.strokes.append(densify(line, 0.006))


def scene(rng: Random) -> list[Floats]:
    """Strokes of shapes that hide each other, with lines in them and from them, on a page about one wide."""
    page = Page(rng)
    for _ in range(rng.integers(2, 8)):
        kind, center = rng.random(), rng.uniform(-0.4, 0.4, 2)
        size, angle = rng.uniform(0.08, 0.35), rng.uniform(0, 6.3)
        ring = blob(rng, 160) * size if kind < 0.35 else polygon(rng) * size if kind < 0.65 else _tube(rng)
        is_open = rng.random() < 0.3
        low = rng.uniform(0, 0.5)
        gap = (low, low + rng.uniform(0.05, 0.5)) if is_open else None
        drawn = page.shape(turned(ring - ring.mean(axis=0), angle) + center, rng.random() < 0.85, gap)
        for _ in range(rng.poisson(0.8)):
            _inner_line(page, rng, drawn)
        if rng.random() < 0.25:
            _band(page, rng, drawn)
    for _ in range(rng.poisson(1.5)):
        if page.strokes:
            _branching_line(page, rng)
    return [line for line in page.strokes if len(line) > 3]
