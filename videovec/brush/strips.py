"""Strokes unrolled: the ink along a stroke as a strip, and what of it the brush's profile leaves unexplained."""

from __future__ import annotations

from dataclasses import dataclass, replace

import cv2
import numpy as np
from numpy.typing import NDArray

from videovec.brush.coordinates import RowSamples, find_coordinates, sample_rows
from videovec.brush.refine import Laid
from videovec.brushwork import SUPPORT
from videovec.curves import derivative, evaluate
from videovec.strokes import Strokes

__all__ = ["TEXELS_ACROSS", "TEXELS_PER_WIDTH", "Strip", "joint_arcs", "unroll"]

Floats = NDArray[np.float64]

TEXELS_PER_WIDTH = 12
TEXELS_ACROSS = 24
_SLOW = 2.0  # widths; ink that varies more slowly along a stroke is density, not grain


@dataclass(frozen=True, slots=True, eq=False)
class Strip:
    """One stroke unrolled from its beginning, in its own direction; texel k is at arc (k + 0.5) / 12 widths.

    Args:
        grain: Ink against density, less the profile; mean over the drawings. [L, V]
        weight: In how many drawings each texel was seen alone. [L, V]
        density: Ink along the stroke that varies slowly, profile divided out. [L]
        agreement: Correlation of the grain of single drawings with that of the others; nan for one drawing.
    """

    grain: Floats
    weight: Floats
    density: Floats
    agreement: float

    def turned(self) -> Strip:
        """The strip as seen by a pen that comes from the other end."""
        return replace(self, grain=self.grain[::-1, ::-1], weight=self.weight[::-1, ::-1], density=self.density[::-1])


def unroll(laid: Laid, coverage: NDArray[np.uint8]) -> list[Strip]:
    """Unroll every stroke over all its drawings.

    Args:
        laid: Strokes that a profile explains.
        coverage: Ink fraction, 255 is full. uint8 [D, H, W]

    Returns:
        S strips.
    """
    strokes = laid.strokes
    alone = _alone(strokes, coverage.shape)
    samples = sample_rows(strokes)
    return [_strip(laid, stroke, samples, coverage, alone) for stroke in range(len(strokes))]


def _alone(strokes: Strokes, size: tuple[int, ...]) -> NDArray[np.float32]:
    """1 at pixels that at most one pass of one stroke can touch. [D, H, W]"""
    found = find_coordinates(strokes, (size[0], size[1], size[2]), SUPPORT, 1.0)
    passes = np.bincount(found.pixel, minlength=int(np.prod(size)))
    return (passes <= 1).astype(np.float32).reshape(size)


def _strip(
    laid: Laid, stroke: int, samples: RowSamples, coverage: NDArray[np.uint8], alone: NDArray[np.float32]
) -> Strip:
    layout = laid.strokes.layout
    rows = range(int(layout.stroke_rows[stroke]), int(layout.stroke_rows[stroke + 1]))
    length = max(float(samples.lengths[row]) for row in rows)
    count = max(int(np.ceil(length / laid.brush.width * TEXELS_PER_WIDTH)), 1)
    profile = laid.brush.profile
    if laid.laying.sign[stroke] < 0:
        profile = profile[::-1]
    grains, seen, densities = [], [], []
    for row in rows:
        ink, weight, base = _unroll_row(laid, row, count, samples, coverage, alone)
        density = _slow_density(ink, weight, profile, base)
        grains.append(np.where(weight > 0, ink / np.maximum(density, 0.05)[:, None] - profile, 0.0))
        seen.append(weight)
        densities.append(density)
    total = np.sum(seen, axis=0)
    mean = np.sum([g * w for g, w in zip(grains, seen, strict=True)], axis=0) / np.maximum(total, 1e-9)
    return Strip(mean, total, np.mean(densities, axis=0), _agreement(grains, seen))


def _unroll_row(
    laid: Laid, row: int, count: int, samples: RowSamples, coverage: NDArray[np.uint8], alone: NDArray[np.float32]
) -> tuple[Floats, Floats, Floats]:
    """Ink [L, V], where it may be trusted [L, V], and the density that the fit has there [L]."""
    strokes = laid.strokes
    part = slice(samples.starts[row], samples.starts[row + 1])
    arc = (np.arange(count) + 0.5) / TEXELS_PER_WIDTH * laid.brush.width
    v = ((np.arange(TEXELS_ACROSS) + 0.5) / TEXELS_ACROSS * 2 - 1) * SUPPORT
    if part.start == part.stop:
        return np.zeros((count, len(v))), np.zeros((count, len(v))), np.ones(count)
    known = samples.arc[part]
    nearest = np.clip(np.searchsorted(known, arc), 0, len(known) - 1) + part.start
    control = strokes.segments()[samples.segment[nearest]]
    t = samples.t[nearest]
    speed = np.maximum(np.linalg.norm(derivative(control, t), axis=1), 1e-6)
    t = np.clip(t + (arc - samples.arc[nearest]) / speed, 0, 1)
    tangent = derivative(control, t)
    tangent = tangent / np.maximum(np.linalg.norm(tangent, axis=1), 1e-6)[:, None]
    joints = strokes.layout.segment_joints[samples.segment[nearest]]
    half = (1 - t) * strokes.half_width[joints[:, 0]] + t * strokes.half_width[joints[:, 1]]
    ink_at = laid.laying.density * strokes.opacity[strokes.layout.joint_row]
    density = (1 - t) * ink_at[joints[:, 0]] + t * ink_at[joints[:, 1]]
    normal = np.stack([-tangent[:, 1], tangent[:, 0]], axis=1)
    where = evaluate(control, t)[:, None] + normal[:, None] * (half[:, None] * v)[:, :, None]
    page = int(strokes.layout.row_drawing[row])
    x, y = (where - 0.5).astype(np.float32).transpose(2, 0, 1)
    ink = cv2.remap(coverage[page].astype(np.float32) / 255, x, y, cv2.INTER_CUBIC, borderValue=0)
    sure = cv2.remap(alone[page], x, y, cv2.INTER_LINEAR, borderValue=0) > 0.99
    is_here = (arc >= known[0]) & (arc <= known[-1])
    return ink.astype(np.float64), (sure & is_here[:, None]).astype(np.float64), density


def _slow_density(ink: Floats, weight: Floats, profile: Floats, base: Floats) -> Floats:
    """Density [L] that varies over widths: least squares against the profile, smoothed, pulled to the fitted one."""
    share = weight * profile
    seen, fits = (share * ink).sum(1), (share * profile).sum(1)
    sigma = _SLOW * TEXELS_PER_WIDTH
    pull = 0.2 * float(profile @ profile)
    return np.asarray((_smooth(seen, sigma) + pull * base) / (_smooth(fits, sigma) + pull))


def _smooth(values: Floats, sigma: float) -> Floats:
    at = np.arange(-int(3 * sigma), int(3 * sigma) + 1)
    kernel = np.exp(-0.5 * (at / sigma) ** 2)
    padded = np.pad(values, len(at) // 2)
    return np.convolve(padded, kernel / kernel.sum(), mode="valid")


def _agreement(grains: list[Floats], seen: list[Floats]) -> float:
    """How well the grain of each drawing is predicted by the mean of the others, as a correlation."""
    if len(grains) < 2:
        return float("nan")
    total = np.sum([g * w for g, w in zip(grains, seen, strict=True)], axis=0)
    count = np.sum(seen, axis=0)
    both = own = other = 0.0
    for grain, weight in zip(grains, seen, strict=True):
        rest = (total - grain * weight) / np.maximum(count - weight, 1)
        shared = weight * (count > weight)
        both += float((shared * grain * rest).sum())
        own += float((shared * grain * grain).sum())
        other += float((shared * rest * rest).sum())
    return both / max(float(np.sqrt(own * other)), 1e-12)


def joint_arcs(strokes: Strokes) -> list[Floats]:
    """Arc length of every joint of each stroke, mean over its drawings. S times [n+1] px"""
    layout, samples = strokes.layout, sample_rows(strokes)
    arcs = []
    for stroke in range(len(strokes)):
        rows = range(int(layout.stroke_rows[stroke]), int(layout.stroke_rows[stroke + 1]))
        count = int(layout.segments[stroke]) + 1
        found = [_joint_arcs(layout.row_segments[row], count, samples, row) for row in rows]
        arcs.append(np.mean(found, axis=0))
    return arcs


def _joint_arcs(first: int, count: int, samples: RowSamples, row: int) -> Floats:
    part = slice(samples.starts[row], samples.starts[row + 1])
    place = samples.segment[part] - first + samples.t[part]
    if not len(place):
        return np.linspace(0, samples.lengths[row], count)
    return np.interp(np.arange(count), place, samples.arc[part])
