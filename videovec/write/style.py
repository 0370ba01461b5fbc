"""How a stroke is best drawn by programs that know no variable width."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from videovec.curves import segment_lengths
from videovec.strokes import Strokes

__all__ = ["is_constant_width", "mean_half_widths"]

_MOST = 0.95  # of a stroke's length must be drawn well


def mean_half_widths(strokes: Strokes) -> NDArray[np.float64]:
    """Half-width of each row, averaged over its arc. [R] px"""
    means = np.empty(strokes.row_count)
    for row in range(strokes.row_count):
        half_width = strokes.half_width_of(row)
        if np.ptp(half_width) == 0:
            means[row] = half_width[0]
            continue
        lengths = segment_lengths(strokes.points_of(row))
        middles = (half_width[:-1] + half_width[1:]) / 2
        means[row] = np.average(middles, weights=lengths) if lengths.sum() > 0 else middles.mean()
    return means


def is_constant_width(strokes: Strokes, tolerance: float) -> NDArray[np.bool_]:
    """Whether a line of constant width draws each stroke well.

    One answer for a stroke's whole life, so that it is the same kind of object in every frame; and by nearly all of its
    edge, so that one odd joint among hundreds does not turn a clean line into an outline.

    Args:
        strokes: S strokes.
        tolerance: How far the edge of a line of mean width may lie from the stroke's. px

    Returns:
        True where 95 % of the length, over all drawings, is within the tolerance. bool [S]
    """
    layout = strokes.layout
    off = np.abs(strokes.half_width - mean_half_widths(strokes)[layout.joint_row])
    is_off = off[layout.segment_joints].max(1) > tolerance
    length = np.linalg.norm(np.diff(strokes.segments(), axis=1), axis=-1).sum(1) + 1e-9  # of the control polygon
    stroke = layout.row_stroke[layout.segment_row]
    off_length = np.bincount(stroke[is_off], length[is_off], len(strokes))
    return np.asarray(off_length <= (1 - _MOST) * np.bincount(stroke, length, len(strokes)))
