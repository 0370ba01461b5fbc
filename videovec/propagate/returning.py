"""Strokes that come back after the page was blank: what has the shape of a stroke from before it is that stroke."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from videovec.curves import sub_curve
from videovec.life_edits import join_in_time
from videovec.propagate.record import Life
from videovec.propagate.relink import same_shape

__all__ = ["join_returning"]

_COLOR = 0.25
"""Largest difference of a channel between a stroke and what may be it."""


def join_returning(lives: list[Life], blanks: list[int], memory: int) -> list[Life]:
    """Make one life of two of the same shape, one before and one after a blank page.

    Args:
        lives: All lives of one ink.
        blanks: The first drawings after blank pages.
        memory: For how many drawings a stroke may be gone.

    Returns:
        The lives; those that have come back have rows on all drawings between, and the others are gone.
    """
    left = {life.id: life for life in lives if life.rows}
    for blank in sorted(set(blanks)):
        before = [life for life in left.values() if life.last < blank and blank - life.last <= memory + 1]
        after = [life for life in left.values() if life.first >= blank]
        costs = [
            (cost, a.id, b.id)
            for a in before
            for b in after
            if b.first - a.last <= memory + 1 and (cost := _difference(a, b)) is not None
        ]
        for _, a, b in sorted(costs):
            if a in left and b in left and left[a].last < blank:
                pair = left[a], left.pop(b)
                left[a] = pair[0].becoming(join_in_time(pair[0].whole(), pair[1].whole()), pair)
    return list(left.values())


def _difference(a: Life, b: Life) -> float | None:
    """How far the shapes of two lives are from each other, each where most of it is seen; none if they differ."""
    if a.is_closed != b.is_closed or np.abs(a.color - b.color).max() > _COLOR or a.has_gaps or b.has_gaps:
        return None
    match = same_shape(_most(a), _most(b), a.is_closed)
    return None if match is None else match[0]


def _most(life: Life) -> NDArray[np.float64]:
    """The part of a stroke that is seen on the drawing on which that is most. Control points [3n+1, 2] px"""
    row = max(life.rows.values(), key=lambda row: row.seen)
    return sub_curve(row.points, row.half_width, *row.visible)[0]
