"""How a stroke is best drawn by programs that know no variable width."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from videovec.curves import segment_lengths
from videovec.strokes import Strokes

__all__ = ["is_constant_width", "mean_half_widths"]

_EDGE_TOLERANCE = 0.25  # px between a stroke's edge and that of a line of its mean width (DESIGN 9)


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


def is_constant_width(strokes: Strokes) -> NDArray[np.bool_]:
    """Whether a line of constant width draws each stroke well on all of its drawings.

    One answer for a stroke's whole life, so that it is the same kind of object in every frame.

    Returns:
        True where no edge would be off by more than 0.25 px. bool [S]
    """
    layout = strokes.layout
    off = np.abs(strokes.half_width - mean_half_widths(strokes)[layout.joint_row])
    worst = np.zeros(len(strokes))
    np.maximum.at(worst, layout.row_stroke[layout.joint_row], off)
    return np.asarray(worst <= _EDGE_TOLERANCE)
