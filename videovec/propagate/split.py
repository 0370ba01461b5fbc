"""Strokes with gaps become several: the longest part keeps the identity, those beyond gaps are strokes of their own.

A part has its parent's control points, so that an arc fraction is the same material on both; it lives while the gap is
open, and when the gap closes the parent is seen whole again under its own identity.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

from videovec.propagate.record import Interval, Life

__all__ = ["split_at_gaps"]

_LASTS = 2
"""Drawings for which a gap is open; a shorter one is filled."""


@dataclass(slots=True, eq=False)
class _Thread:
    """The same part on successive drawings, by drawing."""

    parts: dict[int, Interval]

    @property
    def last(self) -> int:
        return max(self.parts)

    @property
    def length(self) -> float:
        return sum(end - begin for begin, end in self.parts.values())


def split_at_gaps(lives: list[Life], next_id: int, lasts: int = _LASTS) -> list[Life]:
    """Make strokes of one seen interval on every drawing out of strokes with gaps.

    Args:
        lives: Lives; where they have gaps, rows are written anew.
        next_id: The first free identity.
        lasts: For how many drawings a part must be seen beyond a gap, unless the clip or the stroke ends first.

    Returns:
        The same lives without gaps, then their parts.
    """
    parts: list[Life] = []
    for life in lives:
        if any(row.gaps for row in life.rows.values()):
            parts += _parts_of(life, next_id + len(parts), lasts)
    return [*lives, *parts]


def _parts_of(life: Life, next_id: int, lasts: int) -> list[Life]:
    """Take the parts beyond gaps from a life, as lives."""
    threads = _threads(life)
    own = _own_parts(life, threads)
    made: list[Life] = []
    for thread in threads:
        drawings = sorted(d for d in thread.parts if own[d] != thread.parts[d])
        for run in _consecutive(drawings):
            if len(run) >= lasts:
                rows = {d: life.rows[d].showing([thread.parts[d]]) for d in run}
                made.append(replace(life, id=next_id + len(made), rows=rows, parent=life.id))
            else:
                _fill(life, own, thread, run)
    for drawing, part in own.items():
        life.rows[drawing] = life.rows[drawing].showing([part])
    return made


def _threads(life: Life) -> list[_Thread]:
    """Follow parts from drawing to drawing by how much of them is the same."""
    threads: list[_Thread] = []
    for drawing in range(life.first, life.last + 1):
        free = [t for t in threads if t.last == drawing - 1]
        pairs = [
            (_overlap(t.parts[drawing - 1], part), k, t)
            for k, part in enumerate(life.rows[drawing].parts)
            for t in free
        ]
        taken: dict[int, _Thread] = {}
        for shared, k, thread in sorted(pairs, key=lambda pair: -pair[0]):
            if shared > 0 and k not in taken and thread not in taken.values():
                taken[k] = thread
        for k, part in enumerate(life.rows[drawing].parts):
            if k in taken:
                taken[k].parts[drawing] = part
            else:
                threads.append(_Thread({drawing: part}))
    return threads


def _own_parts(life: Life, threads: list[_Thread]) -> dict[int, Interval]:
    """The part of every drawing that keeps the identity: that of the thread that is longest while there are several."""
    own: dict[int, Interval] = {}
    for drawing in range(life.first, life.last + 1):
        here = [thread for thread in threads if drawing in thread.parts]
        if here:
            own[drawing] = max(here, key=lambda thread: thread.length).parts[drawing]
    return own


def _fill(life: Life, own: dict[int, Interval], thread: _Thread, run: list[int]) -> None:
    """Show the life over a gap that does not last, up to the part beyond it."""
    for drawing in run:
        part = thread.parts[drawing]
        own[drawing] = min(own[drawing][0], part[0]), max(own[drawing][1], part[1])


def _overlap(a: Interval, b: Interval) -> float:
    return min(a[1], b[1]) - max(a[0], b[0])


def _consecutive(drawings: list[int]) -> list[list[int]]:
    runs: list[list[int]] = []
    for drawing in drawings:
        if runs and runs[-1][-1] == drawing - 1:
            runs[-1].append(drawing)
        else:
            runs.append([drawing])
    return runs
