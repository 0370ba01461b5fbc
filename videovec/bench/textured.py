"""Textured drawings with known strokes: true curves drawn with the tips of real brushes.

The protocol: pen of ``width`` px; pressure along a stroke is slow noise in 0.45..1.1 that falls off over the last two
widths at either end; half-width is pressure times half the pen's width; opacity is 0.35 + 0.65 min(pressure, 1);
drawn at three times the size and averaged in boxes of 3 x 3. Three engines: ``strip`` maps a periodic strip of 16
widths along the stroke, at a random phase, every other stroke drawn from its end; ``dabs`` stamps the tip at every
quarter of a width, in its own direction, the stroke's, or a random one; ``paper`` multiplies a round tip by a grain
that is fixed to the page.
"""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import gaussian_filter1d, map_coordinates
from scipy.spatial import cKDTree

from videovec.bench.tips import TrueBrush, read_tips

__all__ = ["Drawn", "draw"]

Floats = NDArray[np.float64]
SUPERSAMPLE = 3
STRIP_WIDTHS = 16


@dataclass(frozen=True, slots=True, eq=False)
class Drawn:
    """A textured drawing and what is true of it.

    Args:
        coverage: Ink fraction. [H, W] in [0, 1]
        curves: Control points of each stroke. [3n+1, 2] px
        half_widths: Half-width at the joints of each stroke. [n+1] px
        phases: For a strip: the phase at each stroke's beginning. [S] widths
        is_reversed: For a strip: whether each stroke is drawn from its end. bool [S]
    """

    coverage: Floats
    curves: list[Floats]
    half_widths: list[Floats]
    phases: Floats
    is_reversed: NDArray[np.bool_]


def _pressure(length: float, width: float, rng: np.random.Generator) -> tuple[Floats, Floats]:
    """Arc positions and the pressure there: slow noise about 0.8 that falls off at both ends."""
    at = np.linspace(0, length, max(int(length / 2), 16))
    slow = gaussian_filter1d(rng.normal(size=len(at) + 200), 15)[100:-100]
    level = 0.83 + 0.12 * slow / max(float(np.std(slow)), 1e-9)
    ends = np.minimum(at, length - at) / min(2 * width, length / 2)
    return at, np.clip(level * (0.75 + 0.25 * np.minimum(ends, 1)), 0.45, 1.1)


def _sample(curve: Floats, step: float) -> tuple[Floats, Floats, Floats]:
    """Points about ``step`` apart on a curve, their arc length, and their parameter in segments."""
    segments = (len(curve) - 1) // 3
    control = np.stack([curve[3 * k : 3 * k + 4] for k in range(segments)])
    count = int(np.ceil(np.abs(np.diff(control, axis=1)).sum((1, 2)).max() / step)) + 2
    t = np.linspace(0, 1, count)
    weights = np.stack([(1 - t) ** 3, 3 * t * (1 - t) ** 2, 3 * t * t * (1 - t), t**3], 1)
    points = (weights @ control).reshape(-1, 2)
    arc = np.concatenate([[0], np.cumsum(np.hypot(*np.diff(points, axis=0).T))])
    return points, arc, (np.arange(segments)[:, None] + t).ravel()


def make_strip(tip: Floats, rng: np.random.Generator, rows: int = 48) -> Floats:
    """A periodic strip of 16 widths, rubbed with a tip at random rotations. [rows, 16 rows] in [0, 1]"""
    side = int(1.3 * rows)
    small = cv2.resize(tip, (side, side), interpolation=cv2.INTER_AREA)
    length = STRIP_WIDTHS * rows
    clear = np.ones((side, length))
    for x in np.arange(0, length, rows * 0.3):
        turn = cv2.getRotationMatrix2D((side / 2, side / 2), rng.uniform(0, 360), rng.uniform(0.75, 1.0))
        dab = cv2.warpAffine(small, turn, (side, side))
        columns = (int(x) + np.arange(side)) % length
        clear[:, columns] *= 1 - 0.75 * dab
    strip = 1 - clear[(side - rows) // 2 :][:rows]
    return np.clip(strip / np.quantile(strip, 0.98), 0, 1)


def _draw_strip(strip: Floats, samples: tuple[Floats, ...], phase: float, width: float, size: int) -> Floats:
    """Alpha of one stroke along which a strip is laid, nearest point by nearest point. [size, size]"""
    points, arc, half, opacity = samples
    grid, box = _pixels_near(points, half.max() * 1.05 + 2, size)
    _, nearest = cKDTree(points).query(grid)
    tangent = np.gradient(points, axis=0)[nearest]
    tangent /= np.maximum(np.linalg.norm(tangent, axis=1, keepdims=True), 1e-12)
    offset = grid - points[nearest]
    along = (offset * tangent).sum(1)
    side = tangent[:, 0] * offset[:, 1] - tangent[:, 1] * offset[:, 0]
    across = np.where(side >= 0, 1, -1) * np.linalg.norm(offset, axis=1) / half[nearest]
    rows, columns = strip.shape
    u = ((arc[nearest] + along) / width + phase) / STRIP_WIDTHS * columns
    v = (across + 1) / 2 * rows - 0.5
    padded = np.pad(strip, ((2, 2), (0, 0)))
    value = map_coordinates(
        np.pad(padded, ((0, 0), (0, 2)), mode="wrap"), [v + 2, u % columns], order=1, mode="constant"
    )
    alpha = np.zeros((size, size))
    alpha[box] = (value * opacity[nearest]).reshape(alpha[box].shape)
    return alpha


def _pixels_near(points: Floats, reach: float, size: int) -> tuple[Floats, tuple[slice, slice]]:
    low = np.clip(np.floor(points.min(0) - reach), 0, size - 1).astype(int)
    high = np.clip(np.ceil(points.max(0) + reach), low + 1, size).astype(int)
    box = (slice(low[1], high[1]), slice(low[0], high[0]))
    y, x = np.mgrid[box]
    return np.stack([x.ravel() + 0.5, y.ravel() + 0.5], 1), box


def _draw_dabs(
    tips: list[Floats], brush: TrueBrush, samples: tuple[Floats, ...], size: int, rng: np.random.Generator
) -> Floats:
    """Alpha of one stroke of dabs, each a quarter of a width after the last. [size, size]"""
    points, arc, half, opacity = samples
    clear = np.ones((size, size))
    tangent = np.gradient(points, axis=0)
    at, spacing = 0.0, 0.25 * 2 * float(np.median(half))
    while at < arc[-1]:
        k = int(np.searchsorted(arc, at))
        tip = tips[rng.integers(len(tips)) if brush.is_random else 0]
        angle = {"fixed": 0.0, "follow": np.arctan2(tangent[k, 1], tangent[k, 0]), "random": rng.uniform(0, 2 * np.pi)}
        _stamp(clear, tip, (points[k], float(half[k]), float(angle[brush.rotation])), 0.7 * opacity[k])
        at += spacing
    return 1 - clear


def _stamp(clear: Floats, tip: Floats, pose: tuple[Floats, float, float], flow: float) -> None:
    centre, half, angle = pose
    corner = np.floor(centre - half * 1.5).astype(int)
    side = int(np.ceil(half * 3)) + 2
    scale = 2 * half / max(tip.shape)
    c, s = np.cos(angle) * scale, np.sin(angle) * scale
    middle = np.array([tip.shape[1] - 1, tip.shape[0] - 1]) / 2
    shift = centre - corner - 0.5 - np.array([c * middle[0] - s * middle[1], s * middle[0] + c * middle[1]])
    dab = cv2.warpAffine(tip, np.array([[c, -s, shift[0]], [s, c, shift[1]]]), (side, side), flags=cv2.INTER_LINEAR)
    low, high = np.maximum(corner, 0), np.minimum(corner + side, clear.shape[0])
    if np.any(low >= high):
        return
    part = dab[low[1] - corner[1] : high[1] - corner[1], low[0] - corner[0] : high[0] - corner[0]]
    clear[low[1] : high[1], low[0] : high[0]] *= 1 - flow * part


def _draw_paper(samples: tuple[Floats, ...], size: int) -> Floats:
    """Alpha of one round stroke, before the page's grain. [size, size]"""
    points, _, half, opacity = samples
    grid, box = _pixels_near(points, half.max() + 2, size)
    distance, nearest = cKDTree(points).query(grid)
    alpha = np.zeros((size, size))
    solid = np.clip(half[nearest] - distance + 0.5, 0, 1) * opacity[nearest]
    alpha[box] = solid.reshape(alpha[box].shape)
    return alpha


def _page_grain(pattern: Floats, size: int, width: float) -> Floats:
    """A grain over the page whose 0.1 and 0.9 quantiles are 0 and 1, at one pattern pixel for 1/16 of a width."""
    zoom = width / 16
    y, x = np.mgrid[:size, :size] / max(zoom, 0.5)
    wrapped = [y % pattern.shape[0], x % pattern.shape[1]]
    grain = map_coordinates(np.pad(pattern, ((0, 1), (0, 1)), mode="wrap"), wrapped, order=1)
    low, high = np.quantile(grain, [0.1, 0.9])
    return np.asarray(np.clip((grain - low) / max(high - low, 1e-9), 0, 1))


def _shrink(tip: Floats, width: float) -> Floats:
    side = 1.5 * width
    factor = side / max(tip.shape)
    if factor >= 1:
        return tip
    return np.asarray(cv2.resize(tip, None, fx=factor, fy=factor, interpolation=cv2.INTER_AREA), dtype=np.float64)


def draw(curves: list[Floats], brush: TrueBrush, size: int, width: float, seed: int, grain_seed: int = 0) -> Drawn:
    """Draw strokes with a real brush.

    Args:
        curves: Control points of each stroke. [3n+1, 2] px
        brush: The brush.
        size: Side of the square page. px
        width: Width of the pen at pressure 1. px
        seed: Of pressure.
        grain_seed: Of phases, cells and rotations: another one is the same brush drawn again.
    """
    rng, grain_rng = np.random.default_rng(seed), np.random.default_rng([grain_seed, 1])
    tips = read_tips(brush.source)
    large, wide = size * SUPERSAMPLE, width * SUPERSAMPLE
    strip = make_strip(tips[0], np.random.default_rng(7)) if brush.engine == "strip" else np.zeros((0, 0))
    tips = [_shrink(tip, wide) for tip in tips] if brush.engine == "dabs" else tips
    phases = grain_rng.uniform(0, STRIP_WIDTHS, len(curves))
    is_reversed = np.arange(len(curves)) % 2 == 1
    clear, half_widths = np.ones((large, large)), []
    for k, curve in enumerate(curves):
        points, arc, t = _sample(curve * SUPERSAMPLE, 0.5)
        at, pressure = _pressure(float(arc[-1]) / SUPERSAMPLE, width, rng)
        level = np.interp(arc / SUPERSAMPLE, at, pressure)
        samples = (points, arc, wide / 2 * level, 0.35 + 0.65 * np.minimum(level, 1))
        half_widths.append(np.interp(np.arange((len(curve) - 1) // 3 + 1), t, samples[2]) / SUPERSAMPLE)
        if brush.engine == "strip" and is_reversed[k]:
            samples = (points[::-1], arc[-1] - arc[::-1], samples[2][::-1], samples[3][::-1])
        if brush.engine == "strip":
            alpha = _draw_strip(strip, samples, float(phases[k]), wide, large)
        elif brush.engine == "dabs":
            alpha = _draw_dabs(tips, brush, samples, large, grain_rng)
        else:
            alpha = _draw_paper(samples, large)
        clear *= 1 - alpha
    if brush.engine == "paper":
        shift = grain_rng.integers(0, tips[0].shape[0], 2) if grain_seed else np.zeros(2, int)
        clear = 1 - (1 - clear) * _page_grain(np.roll(tips[0], shift, (0, 1)), large, wide)
    blocks = (1 - clear).reshape(size, SUPERSAMPLE, size, SUPERSAMPLE)
    return Drawn(blocks.mean((1, 3)), curves, half_widths, phases, is_reversed)
