"""Strokes drawn with a brush, as tensors: coverage at the pixels near them, with gradients.

For every pair of a pixel and a pass, v is the signed distance in half-widths and u the arc length in widths plus the
phase; alpha is the strip there, read bilinearly, times density. Pairs of one pixel are composited with "over", which
for one ink is a product of clearness in any order.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor

from videovec.brush.coordinates import Coordinates, find_coordinates
from videovec.brushwork import SUPPORT, Brush, Laying, stroke_joints
from videovec.strokes import Strokes

__all__ = ["BrushTensors", "Pairs", "find_pair_groups", "find_pairs", "paint"]

_OPAQUE = 0.9995  # the largest alpha, so that clearness keeps a logarithm


@dataclass(frozen=True, slots=True, eq=False)
class Pairs:
    """What painting needs of N pairs at A active pixels.

    Args:
        pixels: Active pixels, flat in [D, H, W]. int64 [A]
        at: Active pixel of each pair. int64 [N]
        row: Row of each pair. int64 [N]
        points: Control points of its segment. int64 [N, 4]
        joints: Joints of its segment. int64 [N, 2]
        phases: Its two joints in `Laying.phase`. int64 [N, 2]
        weights: Bernstein weights at the nearest point. [N, 4]
        t: Parameter there. [N]
        direction: Along which distance is signed. [N, 2]
        offset: Pixel centre along that direction. [N] px
        arc: Arc length. [N] px
        origin: First control point of its row. int64 [N]
        tangent: Unit tangent of the row there. [N, 2]
        begin: That control point along that tangent when the arc was measured. [N] px
        sign: Sign of the stroke's laying. [N]
    """

    pixels: Tensor
    at: Tensor
    row: Tensor
    points: Tensor
    joints: Tensor
    phases: Tensor
    weights: Tensor
    t: Tensor
    direction: Tensor
    offset: Tensor
    arc: Tensor
    origin: Tensor
    tangent: Tensor
    begin: Tensor
    sign: Tensor


@dataclass(frozen=True, slots=True, eq=False)
class BrushTensors:
    """What painting reads.

    Args:
        points: Control points. [P, 2] px
        half_width: Half-width at joints. [J] px
        density: Ink at joints, opacity included. [J] in [0, 1]
        phase: Phase at joints of strokes. [sum of n+1] widths
        shift: Shift at joints. [J] widths
        strip: Ink of the brush. [U, V] in [0, 1]
        width: Width that a unit of u stands for. px
        repeat: Length of the strip. Widths
    """

    points: Tensor
    half_width: Tensor
    density: Tensor
    phase: Tensor
    shift: Tensor
    strip: Tensor
    width: float
    repeat: float

    @staticmethod
    def of(strokes: Strokes, laying: Laying, brush: Brush) -> BrushTensors:
        """Tensors that stand for strokes laid with a brush. float32"""

        def tensor(values: NDArray[np.float64]) -> Tensor:
            return torch.as_tensor(values, dtype=torch.float32)

        return BrushTensors(
            points=tensor(strokes.points),
            half_width=tensor(strokes.half_width),
            density=tensor(laying.density * strokes.opacity[strokes.layout.joint_row]),
            phase=tensor(laying.phase),
            shift=tensor(laying.shift),
            strip=tensor(brush.strip),
            width=brush.width,
            repeat=brush.repeat,
        )


def find_pairs(strokes: Strokes, laying: Laying, size: tuple[int, int, int], reach: float = SUPPORT) -> Pairs:
    """Pairs of all pixels that the strokes can touch on D pages of H x W px."""
    return _pairs(strokes, laying, find_coordinates(strokes, size, reach), size)


def find_pair_groups(strokes: Strokes, laying: Laying, size: tuple[int, int, int], drawings: int) -> list[Pairs]:
    """The pairs of `find_pairs`, for a few drawings at a time: what is differentiated at once bounds memory."""
    found = find_coordinates(strokes, size, SUPPORT)
    group = found.pixel // (size[1] * size[2] * drawings)
    return [_pairs(strokes, laying, found.select(group == k), size) for k in np.unique(group)]


def _pairs(strokes: Strokes, laying: Laying, found: Coordinates, size: tuple[int, int, int]) -> Pairs:
    layout = strokes.layout
    pixels, at = np.unique(found.pixel, return_inverse=True)
    row = layout.segment_row[found.segment]
    stroke = layout.row_stroke[row]
    first = stroke_joints(layout)[stroke] + found.segment - layout.row_segments[row]
    t, s = found.t, 1 - found.t
    place = found.pixel % (size[1] * size[2])
    centre = np.stack([place % size[2] + 0.5, place // size[2] + 0.5], axis=1)

    origin = layout.row_points[:-1]
    tangent = strokes.points[origin + 1] - strokes.points[origin]
    tangent /= np.maximum(np.linalg.norm(tangent, axis=1, keepdims=True), 1e-9)

    def index(values: NDArray[np.intp]) -> Tensor:
        return torch.as_tensor(values, dtype=torch.int64)

    def tensor(values: NDArray[np.float64]) -> Tensor:
        return torch.as_tensor(values, dtype=torch.float32)

    return Pairs(
        pixels=index(pixels),
        at=index(at),
        row=index(row),
        points=index(layout.segment_points[found.segment]),
        joints=index(layout.segment_joints[found.segment]),
        phases=index(np.stack([first, first + 1], axis=1)),
        weights=tensor(np.stack([s**3, 3 * s * s * t, 3 * s * t * t, t**3], axis=1)),
        t=tensor(t),
        direction=tensor(found.direction),
        offset=tensor((centre * found.direction).sum(1)),
        arc=tensor(found.arc),
        origin=index(origin[row]),
        tangent=tensor(tangent[row]),
        begin=tensor((strokes.points[origin] * tangent).sum(1)[row]),
        sign=tensor(laying.sign[stroke]),
    )


def _between(values: Tensor, ends: Tensor, t: Tensor) -> Tensor:
    """Values at joints, linear in t. [N]"""
    return torch.lerp(values[ends[:, 0]], values[ends[:, 1]], t)


def stroke_coordinates(pairs: Pairs, tensors: BrushTensors) -> tuple[Tensor, Tensor]:
    """u in widths, phase included, and v in half-widths of every pair. [N] twice

    By the envelope theorem t may stay while points move. To first order arc length changes by what the row's first
    point moves along the stroke, and by nothing else: what tells a hidden end where it is.
    """
    nearest = (pairs.weights[:, :, None] * tensors.points[pairs.points]).sum(1)
    distance = pairs.offset - (nearest * pairs.direction).sum(1)
    half_width = _between(tensors.half_width, pairs.joints, pairs.t).clamp(min=1e-3)
    moved = (tensors.points[pairs.origin] * pairs.tangent).sum(1) - pairs.begin
    laid = _between(tensors.phase, pairs.phases, pairs.t) + _between(tensors.shift, pairs.joints, pairs.t)
    return pairs.sign * (pairs.arc - moved) / tensors.width + laid, pairs.sign * distance / half_width


def read_strip(strip: Tensor, u: Tensor, v: Tensor) -> Tensor:
    """Bilinear values of a strip.

    Args:
        strip: Texels, periodic along the first axis, 0 beyond the second. [U, V]
        u: Place along the strip, in strip lengths. [N]
        v: Place across, in half-widths. [N]

    Returns:
        Values. [N]
    """
    columns, rows = strip.shape
    padded = torch.nn.functional.pad(strip, (1, 1))
    x = u * columns - 0.5
    y = ((v / SUPPORT + 1) * (rows / 2) + 0.5).clamp(0, rows + 1 - 1e-4)
    left, low = x.detach().floor(), y.detach().floor()
    column = torch.remainder(left, columns).long().clamp(max=columns - 1)
    following = torch.remainder(column + 1, columns)
    row = low.long()
    flat = padded.reshape(-1)
    wide = rows + 2
    first, second = column * wide + row, following * wide + row
    below = torch.lerp(flat[first], flat[first + 1], y - low)
    above = torch.lerp(flat[second], flat[second + 1], y - low)
    return torch.lerp(below, above, x - left)


def alphas(pairs: Pairs, tensors: BrushTensors) -> Tensor:
    """Alpha of every pair. [N] in [0, 1)"""
    u, v = stroke_coordinates(pairs, tensors)
    value = read_strip(tensors.strip, u / tensors.repeat, v)
    density = _between(tensors.density, pairs.joints, pairs.t)
    return value * density * _OPAQUE


def paint(pairs: Pairs, tensors: BrushTensors) -> Tensor:
    """Coverage at the active pixels. [A] in [0, 1)"""
    clear = torch.log1p(-alphas(pairs, tensors))
    total = clear.new_zeros(len(pairs.pixels)).index_add(0, pairs.at, clear)
    return 1 - total.exp()
