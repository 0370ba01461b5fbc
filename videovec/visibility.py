"""The visible part of strokes, from arc fractions to the parameter interval of every segment."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from videovec.curves import parameter_at
from videovec.strokes import Strokes

__all__ = ["visible_intervals"]


def visible_intervals(strokes: Strokes) -> NDArray[np.float64]:
    """What is visible of every segment.

    Args:
        strokes: S strokes with the visible arc fractions of each row.

    Returns:
        Begin and end in t of each segment, row by row; equal where nothing of it is visible. [G, 2] in [0, 1]
    """
    starts = strokes.layout.row_segments
    intervals = np.tile([0.0, 1.0], (int(starts[-1]), 1))
    for row in np.flatnonzero((strokes.visible != [0.0, 1.0]).any(axis=1)).tolist():
        part = intervals[starts[row] : starts[row + 1]]
        begin, end = strokes.visible[row]
        if begin >= end:
            part[:] = 0.0
            continue
        if np.ptp(strokes.points_of(row), axis=0).max() == 0:  # a dot has no arc: it is seen whole
            continue
        (first, last), (t_first, t_last) = parameter_at(strokes.points_of(row), [begin, end])
        part[:first] = part[last + 1 :] = 0.0
        part[first, 0], part[last, 1] = t_first, t_last
    return intervals
