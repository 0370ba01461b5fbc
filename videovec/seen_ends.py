"""What is seen of strokes ends at the edge of the page."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from videovec.curves import arc_length, sample_by_arc
from videovec.propagate.gaps import runs
from videovec.strokes import Strokes

__all__ = ["measure_ends"]

Floats = NDArray[np.float64]
Bools = NDArray[np.bool_]

_STEP = 0.5
"""Distance of the places that are looked at along a stroke. px"""
_CAP = 2.0
"""How far before its ink leaves the page a stroke ends at most, where its middle leaves it. half-widths"""


def measure_ends(strokes: Strokes, size: tuple[int, int]) -> Strokes:
    """Measure the seen interval of every row again.

    Args:
        strokes: S strokes over D drawings.
        size: Height and width of the page. px

    Returns:
        The same strokes; what is seen of them is on the page.
    """
    visible = strokes.visible.copy()
    page = np.array(size[::-1], float)
    for row in np.flatnonzero(visible[:, 1] > visible[:, 0]).tolist():
        points = strokes.points_of(row)
        if (points >= 0).all() and (points <= page).all():  # curves lie in the hull of their control points
            continue
        half_width = float(strokes.half_width_of(row).mean())
        visible[row] = _on_page(points, (float(visible[row, 0]), float(visible[row, 1])), page, half_width)
    return replace(strokes, visible=visible)


def _on_page(points: Floats, seen: tuple[float, float], page: Floats, half_width: float) -> tuple[float, float]:
    """The longest part of a seen interval on the page; a line along the edge of the page, half on it, is on it."""
    count = max(2, round(arc_length(points) / _STEP) + 1)
    u = np.linspace(0.0, 1.0, count)
    places = sample_by_arc(points, count)
    beyond = np.maximum(-places, places - page).max(axis=1)
    inside = (u >= seen[0]) & (u <= seen[1])
    inked = _longest(inside & (beyond < half_width))
    if inked is None:
        return 0.0, 0.0
    first, last = inked
    reach = round(_CAP * half_width / _STEP)
    middle = np.flatnonzero(beyond[first : last + 1] <= 0) + first
    if len(middle):
        first = int(middle[0]) if beyond[first] > 0 and middle[0] - first <= reach else first
        last = int(middle[-1]) if beyond[last] > 0 and last - middle[-1] <= reach else last
    low = seen[0] if first == 0 or not inside[first - 1] else float(u[first])
    high = seen[1] if last == count - 1 or not inside[last + 1] else float(u[last])
    return low, high


def _longest(values: Bools) -> tuple[int, int] | None:
    """First and last place of the longest run of true values."""
    return max(runs(values), key=lambda run: run[1] - run[0], default=None)
