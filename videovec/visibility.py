"""The visible part of strokes, from arc fractions to the parameter interval of every segment."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from videovec.strokes import Strokes

__all__ = ["visible_intervals"]

_SAMPLES = 17  # points on a segment between which arc length is taken as straight


def visible_intervals(strokes: Strokes) -> NDArray[np.float64]:
    """What is visible of every segment.

    Args:
        strokes: S strokes with the visible arc fractions of each row.

    Returns:
        Begin and end in t of each segment, row by row; equal where nothing of it is visible. [G, 2] in [0, 1]
    """
    layout = strokes.layout
    row = layout.segment_row
    intervals = np.tile([0.0, 1.0], (len(row), 1))
    partial = np.flatnonzero((strokes.visible[row] != [0.0, 1.0]).any(axis=1))
    if not len(partial):
        return intervals
    arc = _arc_table(strokes.segments()[partial])
    length = arc[:, -1]
    rows, which = np.unique(row[partial], return_inverse=True)
    total = np.bincount(which, weights=length)
    before = np.cumsum(length) - length
    before -= before[np.searchsorted(which, np.arange(len(rows)))][which]
    wanted = strokes.visible[row[partial]] * total[which, None] - before[:, None]
    t = np.linspace(0.0, 1.0, _SAMPLES)
    for k in range(len(partial)):
        intervals[partial[k]] = np.interp(wanted[k], arc[k], t) if length[k] > 0 else (wanted[k] > 0).astype(float)
    hidden = (wanted[:, 0] >= length) | (wanted[:, 1] <= 0) | (wanted[:, 0] >= wanted[:, 1])
    whole = (total[which] == 0) & (strokes.visible[row[partial], 0] < strokes.visible[row[partial], 1])
    intervals[partial[hidden & ~whole]] = 0.0
    intervals[partial[whole]] = (0.0, 1.0)
    return intervals


def _arc_table(segments: NDArray[np.float64]) -> NDArray[np.float64]:
    """Arc length up to equal steps of t. [G, M]"""
    t = np.linspace(0.0, 1.0, _SAMPLES)[:, None]
    s = 1 - t
    basis = np.concatenate([s**3, 3 * s**2 * t, 3 * s * t**2, t**3], axis=1)
    steps = np.linalg.norm(np.diff(basis @ segments, axis=1), axis=2)
    return np.concatenate([np.zeros((len(segments), 1)), np.cumsum(steps, axis=1)], axis=1)
