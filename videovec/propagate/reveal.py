"""What is seen of strokes behind others, once all strokes are known: the ink on them that no other explains."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from videovec.curves import arc_length
from videovec.ink import Ink
from videovec.propagate.gaps import runs
from videovec.propagate.record import STEP, Interval, Life, Row, within
from videovec.propagate.target import ink_threshold, sample

__all__ = ["reveal"]

Floats = NDArray[np.float64]
Bools = NDArray[np.bool_]

_WHOLE = 0.98
"""Share of a stroke from which on nothing of it is hidden."""
_LEAST = 2.0
"""Length of ink of its own by which a stroke is seen. px"""
_BEYOND = 8.0
"""The same for a part beyond a gap. px"""
_GAP = 3.0
"""Length of bare paper, or of ink of others beyond which nothing is seen, that is a gap. px"""
_TIP = 2.0
"""Length up to which the end of a stroke is seen that lies beyond the middle of a line under which it ends. px"""
_BESIDE = 0.3
"""How far beyond the half-width of a line its ink may still be its own alone. px"""


def reveal(lives: list[Life], ink: Ink) -> None:
    """Measure what is seen of every row that is hidden in part or meets a stroke that hides others.

    Args:
        lives: All lives of one ink; their rows are written anew.
        ink: The drawings.
    """
    for drawing in range(ink.drawing_count):
        here = [life for life in lives if drawing in life.rows]
        if not any(life.covers and life.rows[drawing].parts for life in here):
            continue
        picture = (ink.coverage[drawing] / np.float32(255.0)).astype(np.float32)
        threshold = ink_threshold(picture)
        along = [life.rows[drawing].along() for life in here]
        shown = [_shown(life.rows[drawing], places) for life, places in zip(here, along, strict=True)]
        edges = np.concatenate([places for life, places in zip(here, shown, strict=True) if life.covers])
        for k, life in enumerate(here):
            row = life.rows[drawing]
            if life.covers or arc_length(row.points) < 2 * _LEAST:
                continue
            places = along[k]
            if row.seen >= _WHOLE and not _near(places, edges)[0].any():
                continue
            others = np.concatenate([np.zeros((0, 3)), *(shown[j] for j in range(len(here)) if j != k)])
            inked = sample(picture, places) > threshold
            under = _Under(inked, *_near(places, others), _near(places, edges)[0])
            life.rows[drawing] = row.showing(_parts(under, row.parts, life.most_seen))


def _shown(row: Row, places: Floats) -> Floats:
    """Those of the places along a stroke that are seen, and its half-width. [K, 3] px"""
    is_seen = within(row.parts, len(places))
    half_width = np.full((len(places), 1), float(row.half_width.mean()))
    return np.concatenate([places, half_width], axis=1)[is_seen]


def _near(places: Floats, others: Floats) -> tuple[Bools, Floats]:
    """Places whose ink may be that of other strokes [M], and how far they are from those [M] px."""
    if not len(others):
        return np.zeros(len(places), bool), np.full(len(places), np.inf)
    gap, which = cKDTree(others[:, :2]).query(places)
    return gap <= others[which, 2] + _BESIDE, np.asarray(gap)


@dataclass(frozen=True, slots=True, eq=False)
class _Under:
    """What lies at M places along a stroke.

    Args:
        inked: Which are on ink. bool [M]
        shared: Which may be on ink of others. bool [M]
        gap: How far each is from others. [M] px
        edge: Which may be on ink of a stroke that hides others. bool [M]
    """

    inked: Bools
    shared: Bools
    gap: Floats
    edge: Bools


def _parts(under: _Under, said: tuple[Interval, ...], most_seen: Interval) -> list[Interval]:
    """The seen parts of a stroke, in their order.

    Args:
        under: What lies along it.
        said: The parts that were seen by what was known before; there are no others beyond gaps.
        most_seen: The most that was ever seen, as arc fractions.
    """
    last = len(under.inked) - 1
    u = np.arange(last + 1) / last
    own = under.inked & ~under.shared & (u >= most_seen[0] - 0.01) & (u <= most_seen[1] + 0.01)
    pieces: list[list[int]] = []
    for first, stop in runs(own):
        before = pieces[-1][1] if pieces else first
        if pieces and (~under.inked[before:first]).sum() * STEP < _GAP:
            pieces[-1][1] = stop
        else:
            pieces.append([first, stop])
    length = [own[a : b + 1].sum() * STEP for a, b in pieces]
    if not pieces or max(length) < _LEAST:
        return []
    was = within(said, last + 1)
    main = int(np.argmax(length))
    kept = [
        (a, b) for k, (a, b) in enumerate(pieces) if k == main or (length[k] >= _BEYOND and was[a : b + 1].mean() > 0.5)
    ]
    known = (0, last) if most_seen == (0.0, 1.0) else (round(most_seen[0] * last), round(most_seen[1] * last))
    return [(max(_end(under, a, -1), known[0]) / last, min(_end(under, b, 1), known[1]) / last) for a, b in kept]


def _end(under: _Under, place: int, step: int) -> int:
    """Where a seen part ends: in the middle of the line that it goes under, or at its own end if that is under it."""
    stop = len(under.inked) if step > 0 else -1
    at, below = place + step, []
    while at != stop and under.inked[at] and under.shared[at]:
        below.append(at)
        at += step
    if not below:
        return place
    middle = below[int(np.argmin(under.gap[below]))]
    is_tip = abs(stop - middle) * STEP <= _TIP or not under.edge[middle]
    return stop - step if at == stop and is_tip else middle
