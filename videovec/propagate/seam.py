"""Closed strokes hidden in part: their seam goes where they are hidden, so that one interval shows all else."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from videovec.curves import arc_length, parameter_at, segments_of, split
from videovec.propagate.gaps import runs
from videovec.propagate.record import Interval, Life, Row

__all__ = ["move_seam"]

Floats = NDArray[np.float64]
Bools = NDArray[np.bool_]

_PLACES = 256
"""Places along a stroke that are looked at."""
_CRUMB = 1.5
"""Half-widths up to which a part beside the seam is only the round end of what lies on its other side."""
_EDGE = 1e-3
"""Of a segment; a seam so near to a joint is one at the joint."""


def move_seam(life: Life) -> None:
    """Move the seam of a closed life to where it parts what is seen on the fewest drawings.

    What is left of a ring that is erased from one place on, and what is drawn of it from there, are one part each if
    that place is its seam.

    Args:
        life: A life; one that is open, or never hidden away from its seam, stays as it is.
    """
    if not life.is_closed or not any(row.gaps for row in life.rows.values()):
        return
    u = (np.arange(_PLACES) + 0.5) / _PLACES
    partly = [row for row in life.rows.values() if row.parts and row.parts != ((0.0, 1.0),)]
    shown = np.array([_is_shown(row, u) for row in partly])
    home = min((row for row in partly if row.gaps), key=lambda row: row.seen)
    crumb = _CRUMB * float(home.half_width.mean()) / max(arc_length(home.points), 1e-9)
    cost = _depth(shown, int(np.ceil(crumb * _PLACES))).sum(axis=0)
    if cost.min() >= max(cost[0], cost[-1]):
        return
    segment, t = parameter_at(home.points, np.array([u[_middle(cost == cost.min())]]))
    for drawing, row in life.rows.items():
        life.rows[drawing] = _opened_at(row, int(segment[0]), float(t[0]), crumb)


def _is_shown(row: Row, u: Floats) -> Bools:
    return np.asarray(np.any([(u >= begin) & (u <= end) for begin, end in row.parts], axis=0))


def _depth(shown: Bools, most: int) -> NDArray[np.intp]:
    """How far inside seen parts of closed strokes places lie, up to ``most``. int [D, P]"""
    depth = shown.astype(np.intp)
    inside = shown
    for k in range(1, most):
        inside = inside & np.roll(shown, k, axis=1) & np.roll(shown, -k, axis=1)
        depth += inside
    return depth


def _middle(values: Bools) -> int:
    """The middle of the longest run."""
    first, last = max(runs(values), key=lambda run: run[1] - run[0])
    return (first + last) // 2


def _opened_at(row: Row, segment: int, t: float, crumb: float) -> Row:
    """The same closed curve, begun in a segment at a parameter; crumbs of parts that this cuts off are dropped."""
    pieces = segments_of(row.points)
    length = [arc_length(row.points[: 3 * segment + 1]) if segment else 0.0, arc_length(row.points)]
    if t <= _EDGE or t >= 1 - _EDGE:
        begin = (segment + round(t)) % len(pieces)
        turned = np.roll(pieces, -begin, axis=0)
        widths = np.roll(row.half_width[:-1], -begin)
        half_width = np.append(widths, widths[0])
        length[0] = arc_length(row.points[: 3 * begin + 1]) if begin else 0.0
    else:
        before, after = split(pieces[segment], t)
        turned = np.concatenate([after[None], pieces[segment + 1 :], pieces[:segment], before[None]])
        joint = (1 - t) * row.half_width[segment] + t * row.half_width[segment + 1]
        half_width = np.concatenate([[joint], row.half_width[segment + 1 : -1], row.half_width[: segment + 1], [joint]])
        length[0] += arc_length(before)
    points = np.concatenate([turned[0, :1], turned[:, 1:].reshape(-1, 2)])
    shift = length[0] / max(length[1], 1e-9)
    return replace(row, points=points, half_width=half_width).showing(_shifted(row.parts, shift, crumb))


def _shifted(parts: tuple[Interval, ...], shift: float, crumb: float) -> list[Interval]:
    """Parts of a closed stroke, in fractions from another seam."""
    if not parts or parts == ((0.0, 1.0),):
        return list(parts)
    is_round = parts[0][0] <= 0 and parts[-1][1] >= 1
    ring = [*parts[1:-1], (parts[-1][0], 1.0 + parts[0][1])] if is_round and len(parts) > 1 else list(parts)
    moved: list[Interval] = []
    for begin, end in ring:
        start = (begin - shift) % 1.0
        stop = start + end - begin
        cut = [(start, stop)] if stop <= 1.0 else [(start, 1.0), (0.0, stop - 1.0)]
        moved += [part for part in cut if part[1] - part[0] > crumb or len(cut) == 1]
    return sorted(moved)
