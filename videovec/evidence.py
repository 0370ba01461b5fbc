"""How well the ink of every drawing supports the strokes that are said to be there."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from videovec.strokes import Strokes

__all__ = ["Evidence", "gather_evidence"]

_STEPS = 8  # samples on a segment
_ACROSS = (-0.6, 0.0, 0.6)  # where the ink is looked at, in half-widths from the centre line


@dataclass(frozen=True, slots=True, eq=False)
class Evidence:
    """What the ink says of every row.

    Args:
        error: Root mean square difference of drawn and seen coverage on the visible part. [R]
        support: Seen over drawn ink on the visible part, at most 1; 1 where nothing is visible. [R]
    """

    error: NDArray[np.float64]
    support: NDArray[np.float64]


def gather_evidence(strokes: Strokes, seen: NDArray[np.uint8], drawn: NDArray[np.uint8]) -> Evidence:
    """Compare what is drawn with what is seen, stroke by stroke and drawing by drawing.

    Args:
        strokes: S strokes over D drawings.
        seen: Coverage of the drawings. uint8 [D, H, W]
        drawn: Coverage of the rendered strokes. uint8 [D, H, W]

    Returns:
        The evidence of each row.
    """
    layout = strokes.layout
    where, row = _samples(strokes)
    drawing = layout.row_drawing[row]
    values = []
    for image in (seen, drawn):
        at = np.stack([drawing + 0.0, where[:, 1] - 0.5, where[:, 0] - 0.5])
        values.append(ndimage.map_coordinates(image, at, output=np.float64, order=1, mode="nearest") / 255)
    count = np.maximum(np.bincount(row, minlength=strokes.row_count), 1)
    squared = np.bincount(row, (values[0] - values[1]) ** 2, strokes.row_count) / count
    ink = [np.bincount(row, value, strokes.row_count) for value in values]
    support = np.where(ink[1] > 0, ink[0] / np.maximum(ink[1], 1e-9), 1.0)
    return Evidence(np.sqrt(squared), np.minimum(support, 1.0))


def _samples(strokes: Strokes) -> tuple[NDArray[np.float64], NDArray[np.intp]]:
    """Points across the visible part of every row [N, 2], and their rows [N]."""
    t = (np.arange(_STEPS) + 0.5) / _STEPS
    s = 1 - t
    basis = np.stack([s**3, 3 * s**2 * t, 3 * s * t**2, t**3], axis=1)
    slope = np.stack([-3 * s**2, 3 * s**2 - 6 * s * t, 6 * s * t - 3 * t**2, 3 * t**2], axis=1)
    segments = strokes.segments()
    centre, along = basis @ segments, slope @ segments
    normal = np.stack([-along[..., 1], along[..., 0]], axis=2)
    normal /= np.maximum(np.linalg.norm(normal, axis=2, keepdims=True), 1e-9)
    ends = strokes.half_width[strokes.layout.segment_joints]
    half_width = ends[:, :1] * s + ends[:, 1:] * t
    points = np.stack([centre + k * half_width[..., None] * normal for k in _ACROSS], axis=2)
    row = np.repeat(strokes.layout.segment_row, _STEPS * len(_ACROSS))
    fraction = _arc_fractions(strokes, centre).repeat(len(_ACROSS))
    visible = (fraction >= strokes.visible[row, 0]) & (fraction <= strokes.visible[row, 1])
    return points.reshape(-1, 2)[visible], row[visible]


def _arc_fractions(strokes: Strokes, centre: NDArray[np.float64]) -> NDArray[np.float64]:
    """Arc fraction of each sample along its row. [G * M]"""
    layout = strokes.layout
    row = np.repeat(layout.segment_row, _STEPS)
    flat = centre.reshape(-1, 2)
    step = np.linalg.norm(np.diff(flat, axis=0, prepend=flat[:1]), axis=1)
    begin = layout.row_segments[:-1] * _STEPS
    step[begin] = 0.0
    arc = np.cumsum(step)
    arc -= arc[begin][row]
    total = np.maximum(arc[layout.row_segments[1:] * _STEPS - 1], 1e-9)
    return np.asarray(arc / total[row])
