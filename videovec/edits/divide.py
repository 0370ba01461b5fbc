"""Split segments that cannot bend as the ink does."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import map_coordinates

from videovec.curves import derivative, evaluate, split, width_at
from videovec.edits.layers import Page, layers_of
from videovec.edits.shapes import Shape, shapes_of, strokes_of
from videovec.settings import EditSettings
from videovec.strokes import Strokes

__all__ = ["divide"]

Floats = NDArray[np.float64]

_SAMPLES = 16  # on a segment
_STEP = 0.5  # px across, between places where the residual is read
_BEYOND = 1.5  # px beyond the edge up to which it is read
_FARTHEST = 1.0  # px; the residual cannot tell larger displacements
_POINTS = 3  # control points that a split adds
_MISREAD = 0.05  # relative error of a displacement that the residual tells
_SHARE = 0.5  # of what a second segment could explain that it is expected to


def divide(strokes: Strokes, page: Page, settings: EditSettings) -> Strokes:
    """Split segments where the ink lies off them in a way that no single cubic follows.

    What the residual says about the ink's distance from the line is fitted with a cubic: that part the optimiser will
    see to. The rest is what a second segment can explain; where that earns its price, the segment is split.

    Args:
        strokes: Strokes of one drawing.
        page: They drawn, against the ink; redrawn where strokes change by rounding.
        settings: The price of a control point, and the least length of a stroke.

    Returns:
        The same curves in more segments.
    """
    shapes, layers = shapes_of(strokes), layers_of(strokes, page.size)
    residual = page.residual
    every = [shape.points[3 * np.arange(len(shape.half_width) - 1)[:, None] + np.arange(4)] for shape in shapes]
    if not every:
        return strokes
    widths = [np.stack([shape.half_width[:-1], shape.half_width[1:]], axis=1) for shape in shapes]
    counts = [len(segments) for segments in every]
    opacity = np.repeat([shape.opacity for shape in shapes], counts)
    gain, t = _gains(np.concatenate(every), np.concatenate(widths), residual, opacity)
    length = np.linalg.norm(np.diff(np.concatenate(every), axis=1), axis=-1).sum(axis=1)
    is_worth_it = (length > 2.0 * settings.d_min) & (_SHARE * gain > settings.price * _POINTS)
    begin = np.cumsum([0, *counts])
    for i, segments in enumerate(every):
        chosen = np.flatnonzero(is_worth_it[begin[i] : begin[i + 1]])
        if len(chosen):
            shapes[i] = _divided(shapes[i], segments, chosen, t[begin[i] + chosen])
    changed = [i for i in range(len(shapes)) if is_worth_it[begin[i] : begin[i + 1]].any()]
    drawn = layers_of(strokes_of([shapes[i] for i in changed]), page.size)
    page.exchange([layers[i] for i in changed], drawn)
    return strokes_of(shapes)


def _gains(segments: Floats, half_width: Floats, residual: Floats, opacity: Floats) -> tuple[Floats, Floats]:
    """By how much the loss of each segment could fall with a second one, and where it would be split. [n], [n]"""
    t = (np.arange(_SAMPLES) + 0.5) / _SAMPLES
    where, slope = evaluate(segments[:, None], t), derivative(segments[:, None], t)
    speed = np.linalg.norm(slope, axis=-1)
    normal = np.stack([-slope[..., 1], slope[..., 0]], axis=-1) / np.maximum(speed, 1e-9)[..., None]
    reach = half_width[:, :1] + (half_width[:, 1:] - half_width[:, :1]) * t + _BEYOND
    across = np.arange(_STEP / 2, float(reach.max()), _STEP)
    displaced = np.zeros(speed.shape)
    for offset in (*across, *-across):
        at = where + offset * normal - 0.5
        value = map_coordinates(residual, [at[..., 1], at[..., 0]], order=1, mode="constant")
        displaced += np.where(abs(offset) <= reach, np.sign(offset) * value, 0.0) * _STEP / 2.0
    peak = opacity[:, None] * np.minimum(1.0, 2.0 * (reach - _BEYOND))  # coverage on the centre line
    displaced = np.clip(displaced / np.maximum(peak, 1e-3), -_FARTHEST, _FARTHEST)
    weight = 2.0 * peak**2 * speed / _SAMPLES  # both edges
    whole, left = _unexplained(displaced, weight, t)
    one, _ = _unexplained(displaced[:, : _SAMPLES // 2], weight[:, : _SAMPLES // 2], t[: _SAMPLES // 2])
    two, _ = _unexplained(displaced[:, _SAMPLES // 2 :], weight[:, _SAMPLES // 2 :], t[_SAMPLES // 2 :])
    energy = np.cumsum(weight * left**2, axis=1)
    middle = t[np.argmax(energy >= 0.5 * energy[:, -1:], axis=1)]
    misread = _MISREAD**2 * (weight * displaced**2).sum(axis=1)
    return whole - one - two - misread, np.clip(middle, 0.3, 0.7)


def _unexplained(displaced: Floats, weight: Floats, t: Floats) -> tuple[Floats, Floats]:
    """Weighted squares that are left of displacements after the best cubic, [n], and what is left. [n, M]"""
    s = 1.0 - t
    basis = np.stack([s**3, 3 * s**2 * t, 3 * s * t**2, t**3], axis=1)
    system = np.einsum("nm,mi,mj->nij", weight, basis, basis) + 1e-9 * np.eye(4)
    right = np.einsum("nm,mi,nm->ni", weight, basis, displaced)
    left = displaced - np.linalg.solve(system, right[..., None])[..., 0] @ basis.T
    return (weight * left**2).sum(axis=1), left


def _divided(shape: Shape, segments: Floats, chosen: NDArray[np.intp], t: Floats) -> Shape:
    """A stroke with some of its segments in two."""
    before, after = split(segments[chosen], t)
    middle = width_at(shape.half_width, chosen, t)
    pieces = np.insert(segments, chosen + 1, after, axis=0)
    pieces[chosen + np.arange(len(chosen))] = before
    points = np.concatenate([pieces[0, :1], pieces[:, 1:].reshape(-1, 2)])
    return replace(shape, points=points, half_width=np.insert(shape.half_width, chosen + 1, middle))
