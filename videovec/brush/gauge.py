"""What a fit leaves free without changing the picture, fixed: centre line, width and scale of ink.

A profile that lies to one side and a centre line moved to that side are one picture; so are a wide profile on thin
strokes and a narrow one on thick strokes, and a pale brush at full density and a dark one at little.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from videovec.brush.refine import Laid, split_density
from videovec.brushwork import SUPPORT, Brush
from videovec.strokes import Strokes

__all__ = ["centre_support", "full_scale"]

Floats = NDArray[np.float64]

_EDGE = 0.25  # share of its greatest ink at which a profile ends
_FULL = 0.995  # quantile of the texels that stands for full ink


def centre_support(laid: Laid) -> Laid:
    """Move centre lines to the middle of the ink, and let the half-width be where the ink ends."""
    low, high = support_of(laid.brush.profile)
    middle, extent = 0.5 * (low + high), 0.5 * (high - low)
    strokes = laid.strokes
    shift = middle * laid.laying.sign[strokes.layout.row_stroke]
    moved = replace(strokes, points=_beside(strokes, shift), half_width=strokes.half_width * extent)
    strip = _across(laid.brush.strip, middle, extent)
    return Laid(moved, laid.laying, replace(laid.brush, strip=strip))


def full_scale(brush: Brush, laid: Laid) -> Laid:
    """The strokes laid with a brush whose darkest texels are 1; density takes up the difference."""
    scale = max(float(np.quantile(brush.strip, _FULL)), 1e-6)
    layout = laid.strokes.layout
    ink = np.minimum(laid.laying.density * laid.strokes.opacity[layout.joint_row] * scale, 1.0)
    opacity, density = split_density(ink, layout)
    strip = np.clip(brush.strip / scale, 0.0, 1.0)
    return Laid(
        replace(laid.strokes, opacity=opacity), replace(laid.laying, density=density), replace(brush, strip=strip)
    )


def support_of(profile: Floats) -> tuple[float, float]:
    """Where a profile [V] first and last crosses a quarter of its greatest value. Half-widths"""
    level = profile / max(float(profile.max()), 1e-9) - _EDGE
    v = ((np.arange(len(profile)) + 0.5) / len(profile) * 2 - 1) * SUPPORT
    inside = np.flatnonzero(level > 0)
    ends = []
    for at, step in ((int(inside[0]), -1), (int(inside[-1]), 1)):
        beyond = at + step
        if not 0 <= beyond < len(profile):
            ends.append(step * SUPPORT)
            continue
        share = level[at] / max(level[at] - level[beyond], 1e-9)
        ends.append(float(v[at] + share * (v[beyond] - v[at])))
    return ends[0], ends[1]


def _across(strip: Floats, middle: float, extent: float) -> Floats:
    """The strip in coordinates in which its support is -1 .. 1. [U, V]"""
    count = strip.shape[1]
    v = ((np.arange(count) + 0.5) / count * 2 - 1) * SUPPORT
    wanted = middle + extent * v
    return np.stack([np.interp(wanted, v, row, left=0.0, right=0.0) for row in strip])


def _beside(strokes: Strokes, shift: Floats) -> Floats:
    """Control points moved sideways by a share of the half-width, one for each row [R]. [P, 2] px"""
    layout = strokes.layout
    row = layout.point_row
    place = np.arange(len(row)) - layout.row_points[row]
    joint = layout.row_joints[row] + (place + 1) // 3
    last = layout.row_points[row + 1] - 1
    first = layout.row_points[row]
    ahead = np.minimum(np.arange(len(row)) + 1, last)
    behind = np.maximum(np.arange(len(row)) - 1, first)
    tangent = strokes.points[ahead] - strokes.points[behind]
    tangent /= np.maximum(np.linalg.norm(tangent, axis=1, keepdims=True), 1e-9)
    normal = np.stack([-tangent[:, 1], tangent[:, 0]], axis=1)
    return strokes.points + normal * (shift[row] * strokes.half_width[joint])[:, None]
