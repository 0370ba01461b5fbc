"""How a stroke is best drawn by programs that know no variable width."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from videovec.strokes import Strokes

__all__ = ["is_constant_width", "mean_half_widths"]

Floats = NDArray[np.float64]

_MOST = 0.95  # of a stroke's length must be drawn well


def mean_half_widths(strokes: Strokes) -> NDArray[np.float64]:
    """Half-width of each row, averaged over what is seen of its arc; over all of it if nothing is. [R] px"""
    layout = strokes.layout
    middles = strokes.half_width[layout.segment_joints].mean(1)
    lengths, seen = _lengths(strokes) + 1e-9, _seen_lengths(strokes)  # so that a dot has a mean too
    is_seen = np.bincount(layout.segment_row, seen, strokes.row_count) > 0
    lengths = np.where(is_seen[layout.segment_row], seen, lengths)
    weights = np.bincount(layout.segment_row, lengths, strokes.row_count)
    return np.asarray(np.bincount(layout.segment_row, lengths * middles, strokes.row_count) / weights)


def is_constant_width(strokes: Strokes, tolerance: float) -> NDArray[np.bool_]:
    """Whether a line of constant width draws each stroke well.

    One answer for a stroke's whole life, so that it is the same kind of object in every frame; and by nearly all of its
    edge, so that one odd joint among hundreds does not turn a clean line into an outline.

    Args:
        strokes: S strokes.
        tolerance: How far the edge of a line of mean width may lie from the stroke's. px

    Returns:
        True where 95 % of the length that is seen, over all drawings, is within the tolerance. bool [S]
    """
    layout = strokes.layout
    off = (strokes.half_width - mean_half_widths(strokes)[layout.joint_row])[layout.segment_joints]
    length = _seen_lengths(strokes)
    stroke = layout.row_stroke[layout.segment_row]
    off_length = np.bincount(stroke, length * _share_beyond(off[:, 0], off[:, 1], tolerance), len(strokes))
    return np.asarray(off_length <= (1 - _MOST) * np.bincount(stroke, length, len(strokes)))


def _share_beyond(start: Floats, end: Floats, limit: float) -> Floats:
    """The share of the way from one value to another on which they are larger than a limit, either sign. [G]"""
    low, high = np.minimum(start, end), np.maximum(start, end)
    beyond = np.maximum(high - np.maximum(low, limit), 0) + np.maximum(np.minimum(high, -limit) - low, 0)
    is_even = high - low < 1e-9
    share = np.where(is_even, np.abs(high) > limit, beyond / np.where(is_even, 1.0, high - low))
    return np.asarray(share, dtype=np.float64)


def _seen_lengths(strokes: Strokes) -> NDArray[np.float64]:
    """About how much of each segment is seen. [G] px"""
    row, length = strokes.layout.segment_row, _lengths(strokes) + 1e-9
    stop = np.cumsum(length)
    whole = np.bincount(row, length, strokes.row_count)
    before = (np.cumsum(whole) - whole)[row]
    low, high = (strokes.visible[row, end] * whole[row] + before for end in (0, 1))
    return np.asarray(np.clip(np.minimum(high, stop) - np.maximum(low, stop - length), 0.0, None))


def _lengths(strokes: Strokes) -> NDArray[np.float64]:
    """About how long each segment is. [G] px

    Source:
        J. Gravesen 1997, "Adaptive subdivision and the length and energy of Bézier curves": for cubics, the mean of
        chord and control polygon.
    """
    segments = strokes.segments()
    polygon = np.linalg.norm(np.diff(segments, axis=1), axis=-1).sum(1)
    return np.asarray((polygon + np.linalg.norm(segments[:, 3] - segments[:, 0], axis=-1)) / 2)
