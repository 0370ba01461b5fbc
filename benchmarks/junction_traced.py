"""Made-up figures as people trace them by hand: few vertices, ends that run past what they meet or stop short of it,
outlines that end on themselves, in two strokes, or side by side."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import gaussian_filter1d
from scipy.spatial import cKDTree

from benchmarks.junction_figures import figure
from benchmarks.junction_parts import draw_part, jointed
from benchmarks.junction_scenes import Page, blob, densify, heading_of, is_inside, polygon, spine_from, turned

__all__ = ["by_hand", "traced"]

Floats = NDArray[np.float64]
Random = np.random.Generator

_STEP = 0.003  # between samples; a page is about 1 wide
_MET = 0.012  # within which the end of a stroke meets another, or itself
_FADE = 0.06  # along a stroke over which a moved end bends it


def _after(ring: Floats, k: int) -> Floats:
    """Samples of a ring from one of them on, all the way round. A ring does not repeat its first point."""
    return np.roll(ring, -k, axis=0)


def _corner(ring: Floats, rng: Random) -> int:
    """A place on a ring: most often one of its sharpest corners."""
    if rng.random() < 0.4:
        return int(rng.integers(len(ring)))
    reach = max(2, len(ring) // 30)
    before, behind = ring - np.roll(ring, reach, axis=0), np.roll(ring, -reach, axis=0) - ring
    turn = np.abs(np.angle((behind @ [1, 1j]) * np.conj(before @ [1, 1j])))
    return int(rng.choice(np.argsort(-turn)[: max(3, len(ring) // 12)]))


def _run_on(line: Floats, rng: Random, length: float, bend: float) -> Floats:
    """A line that goes on past its end."""
    heading = heading_of(line[-1] - line[-min(len(line), 6)])
    angles = heading + bend * np.linspace(0, 1, 12) + rng.normal(0, 0.1)
    steps = np.stack([np.cos(angles), np.sin(angles)], axis=1) * length / 12
    return np.concatenate([line, line[-1] + np.cumsum(steps, axis=0)])


def _round_and_in(page: Page, rng: Random, ring: Floats) -> None:
    """An outline that comes back to its beginning and goes on inside, such as a shoe and its sole."""
    ring = _after(densify(np.concatenate([ring, ring[:1]]), _STEP)[:-1], _corner(ring, rng))
    page.hide(ring)
    line = np.concatenate([ring, ring[:1]])
    inward = heading_of(ring.mean(axis=0) - line[-1])
    turn = (inward - heading_of(line[-1] - line[-6]) + np.pi) % (2 * np.pi) - np.pi
    size = float(np.ptp(ring, axis=0).max())
    start = heading_of(line[-1] - line[-6]) + turn * rng.uniform(0.1, 0.7)
    onward = spine_from(rng, line[-1], start, size * rng.uniform(0.2, 1.2), 40)[1:]
    outside = np.flatnonzero(~is_inside(ring, onward)[3:])
    onward = onward[: outside[0] + 4] if len(outside) else onward
    page.strokes.append(np.concatenate([line, onward]))


def _in_two(page: Page, rng: Random, ring: Floats, parent: Floats | None) -> None:
    """An outline in two strokes, each of which may run on past the beginning of the other."""
    dense = densify(np.concatenate([ring, ring[:1]]), _STEP)[:-1]
    dense = _after(dense, _corner(dense, rng))
    page.hide(dense)
    if parent is not None:
        inside = is_inside(parent, dense)
        if inside.any() and not inside.all():
            dense = _after(dense, int(np.flatnonzero(inside & ~np.roll(inside, -1))[0]))
            dense = dense[: max(int((~is_inside(parent, dense)).sum()), 12)]
    cut = min(max(_corner(dense, rng), 6), len(dense) - 6)
    for part in (dense[: cut + 1], dense[cut:][::-1]):
        if len(part) > 6:
            length = rng.choice([0.0, rng.uniform(0.004, 0.05)])
            page.strokes.append(_run_on(part, rng, length, rng.normal(0, 0.6)) if length else part)


def _band(page: Page, rng: Random, ring: Floats) -> None:
    """Two lines close together across a shape: there and back in one stroke, or in two, with or without ends."""
    a, b = ring[rng.integers(0, len(ring), 2)]
    along = b - a
    length = float(np.linalg.norm(along))
    if length < 0.05:
        return
    t = np.linspace(0, 1, 40)[:, None]
    across = np.array([-along[1], along[0]]) / length
    there = a + along * t + across * length * rng.normal(0, 0.12) * 4 * t * (1 - t)
    gap = rng.uniform(0.006, 0.022) * (1 + rng.normal(0, 0.4) * (t - 0.5)) + rng.normal(0, 0.002) * np.sin(7 * t)
    back = there + across * gap
    kind = rng.random()
    if kind < 0.35:
        page.strokes += [there, back]
    elif kind < 0.7:
        page.strokes.append(np.concatenate([there, back[::-1]]))
    else:
        sliver = np.concatenate([there, back[::-1]])
        page.hide(sliver)
        page.strokes.append(np.concatenate([sliver, sliver[:1]]))


def _knot(page: Page, rng: Random) -> None:
    """A small loop on a line, closed or not, most often hiding what it lies on."""
    line = page.strokes[rng.integers(len(page.strokes))]
    center = line[rng.integers(len(line))]
    ring = turned(blob(rng, 40) if rng.random() < 0.7 else polygon(rng), rng.uniform(0, 6.3))
    ring = ring * rng.uniform(0.01, 0.035) + center + rng.normal(0, 0.01, 2)
    gap = None if rng.random() < 0.5 else (0.1, rng.uniform(0.12, 0.4))
    page.shape(ring, rng.random() < 0.8, gap)


def _fist(page: Page, rng: Random) -> None:
    """Cells side by side, each open where it lies behind or against the one before."""
    line = page.strokes[rng.integers(len(page.strokes))]
    center, size = line[rng.integers(len(line))], rng.uniform(0.02, 0.05)
    heading = rng.uniform(0, 6.3)
    step = size * rng.uniform(0.8, 1.4) * np.array([np.cos(heading), np.sin(heading)])
    before: Floats | None = None
    for k in range(rng.integers(2, 6)):
        shape = (polygon(rng) if rng.random() < 0.5 else blob(rng, 50)) * [0.8, 1.4]
        ring = turned(shape * size * rng.uniform(0.8, 1.2), heading) + center + step * k
        draw_part(page, rng, ring, before)
        before = ring


def _part(page: Page, rng: Random, ring: Floats, parent: Floats | None) -> None:
    """Draw a part in one of the ways in which people trace it."""
    kind = rng.random()
    if kind < 0.5:
        draw_part(page, rng, ring, parent)
    elif kind < 0.65:
        _round_and_in(page, rng, ring)
    else:
        _in_two(page, rng, ring, parent)
    if rng.random() < 0.25:
        _band(page, rng, ring)
    for _ in range(rng.poisson(0.25)):
        _knot(page, rng)
    if rng.random() < 0.12:
        _fist(page, rng)


def _along(line: Floats) -> Floats:
    return np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(line, axis=0), axis=1))])


def _with_few_vertices(line: Floats, rng: Random, coarse: float, soft: float) -> Floats:
    """A line as someone traces it: straight from vertex to vertex, or as rounded as the pen's smoothing."""
    vertices = cv2.approxPolyDP(line.astype(np.float32).reshape(-1, 1, 2), coarse, False).reshape(-1, 2).astype(float)
    if len(vertices) < 2:
        return line
    vertices[1:-1] += rng.normal(0, 0.3 * coarse, (len(vertices) - 2, 2))
    if np.linalg.norm(line[0] - line[-1]) < 1e-6:
        vertices[-1] = vertices[0]
    dense = densify(vertices, _STEP)
    if soft <= 0 or len(dense) < 4:
        return dense
    mirrored = np.concatenate([2 * dense[0] - dense[:0:-1], dense, 2 * dense[-1] - dense[-2::-1]])
    smooth = gaussian_filter1d(mirrored, soft / _STEP, axis=0)[len(dense) - 1 : 2 * len(dense) - 1]
    return np.concatenate([dense[:1], smooth[1:-1], dense[-1:]])


def _meet(lines: list[Floats], told: list[list[bool]], rng: Random, over: float) -> list[Floats]:
    """Strokes whose ends meet again what they met before they were traced, give or take a little."""
    owner = np.repeat(np.arange(len(lines)), [len(line) for line in lines])
    place = np.concatenate([_along(line) for line in lines])
    tree = cKDTree(np.concatenate(lines))
    result = []
    for number, line in enumerate(lines):
        along = _along(line)
        for end, far in ((0, along), (-1, along[-1] - along)):
            if not told[number][end]:
                continue
            near = np.array(tree.query_ball_point(line[end], 4 * _MET), np.intp)
            here = owner[near] == number
            near = near[~here | (np.abs(place[near] - along[end]) > 5 * _MET)]
            if not len(near):
                continue
            target = tree.data[near[np.linalg.norm(tree.data[near] - line[end], axis=1).argmin()]]
            way = line[end] - line[min(6, len(line) - 1) if end == 0 else max(-7, -len(line))]
            target = target + way / (np.linalg.norm(way) + 1e-9) * rng.normal(0.2 * over, over)
            line = line + (target - line[end]) * np.clip(1 - far / _FADE, 0, 1)[:, None]
        result.append(line)
    return result


def _meets(lines: list[Floats]) -> list[list[bool]]:
    """Whether the first and the last point of each line lie on another line, or on a far part of itself."""
    told = []
    for number, line in enumerate(lines):
        others = [other for k, other in enumerate(lines) if k != number]
        tree = cKDTree(np.concatenate(others)) if others else None
        ends = []
        for end in (0, -1):
            far = line[np.abs(_along(line) - _along(line)[end]) > 5 * _MET]
            own = np.linalg.norm(far - line[end], axis=1).min(initial=np.inf)
            ends.append(min(own, tree.query(line[end])[0] if tree else np.inf) < _MET)
        told.append(ends)
    return told


def by_hand(lines: list[Floats], rng: Random) -> list[Floats]:
    """Strokes as someone traces them who sets few vertices and does not aim at ends with care."""
    lines = [line for line in lines if _along(line)[-1] > 0.01]
    coarse, soft = rng.uniform(0.001, 0.012), rng.choice([0.0, rng.uniform(0.002, 0.012)])
    told = _meets(lines)
    made = [_with_few_vertices(line, rng, coarse, soft) for line in lines]
    closed = [bool(np.linalg.norm(line[0] - line[-1]) < 1e-6) for line in made]
    told = [[False, False] if shut else ends for ends, shut in zip(told, closed, strict=True)]
    return _meet(made, told, rng, rng.uniform(0.0, 0.005))


def traced(rng: Random) -> list[Floats]:
    """Strokes of a figure that was traced by hand, on a page about one wide."""
    lines = jointed(rng, _part) if rng.random() < 0.75 else figure(rng)
    return by_hand(lines, rng) if lines else []
