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

_PLACES = 256
"""Places along a stroke that are looked at."""
_EDGE = 1e-3
"""Of a segment; a seam so near to a joint is one at the joint."""


def move_seam(life: Life) -> None:
    """Move the seam of a closed life to the place that is hidden most often, if its own is hidden less often.

    Args:
        life: A life; one that is open, or never hidden away from its seam, stays as it is.
    """
    if not life.is_closed or not any(row.gaps for row in life.rows.values()):
        return
    u = (np.arange(_PLACES) + 0.5) / _PLACES
    seen = [row for row in life.rows.values() if row.parts]
    hidden = np.sum([~_is_shown(row, u) for row in seen], axis=0)
    if hidden.max() <= min(hidden[0], hidden[-1]):
        return
    home = min((row for row in seen if row.gaps), key=lambda row: row.seen)
    segment, t = parameter_at(home.points, np.array([u[_middle(hidden == hidden.max())]]))
    for drawing, row in life.rows.items():
        life.rows[drawing] = _opened_at(row, int(segment[0]), float(t[0]))


def _is_shown(row: Row, u: Floats) -> NDArray[np.bool_]:
    return np.asarray(np.any([(u >= begin) & (u <= end) for begin, end in row.parts], axis=0))


def _middle(values: NDArray[np.bool_]) -> int:
    """The middle of the longest run."""
    first, last = max(runs(values), key=lambda run: run[1] - run[0])
    return (first + last) // 2


def _opened_at(row: Row, segment: int, t: float) -> Row:
    """The same closed curve, begun in a segment at a parameter."""
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
    return replace(row, points=points, half_width=half_width).showing(_shifted(row.parts, shift))


def _shifted(parts: tuple[Interval, ...], shift: float) -> list[Interval]:
    """Parts of a closed stroke, in fractions from another seam."""
    if not parts or parts == ((0.0, 1.0),):
        return list(parts)
    is_round = parts[0][0] <= 0 and parts[-1][1] >= 1
    ring = [*parts[1:-1], (parts[-1][0], 1.0 + parts[0][1])] if is_round and len(parts) > 1 else list(parts)
    moved: list[Interval] = []
    for begin, end in ring:
        start = (begin - shift) % 1.0
        stop = start + end - begin
        moved += [(start, stop)] if stop <= 1.0 else [(start, 1.0), (0.0, stop - 1.0)]
    return sorted(moved)
