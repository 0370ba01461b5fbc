"""What happened, read from the lives of finished strokes."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from videovec.events import Event, EventKind
from videovec.strokes import Strokes

__all__ = ["events_of"]

_HIDDEN = 0.85
"""A stroke of which less than this is seen is occluded, or still being drawn."""


def events_of(
    strokes: Strokes, confidence: NDArray[np.float64], cuts: list[int], drawing_count: int
) -> tuple[Event, ...]:
    """Births, deaths, occlusions and reappearances, and the cuts.

    Args:
        strokes: S strokes with their lives.
        confidence: How well the ink supports each row. [R]
        cuts: First drawings of new shots.
        drawing_count: D.

    Returns:
        Events by drawing. The beginnings and ends of shots are no births and deaths.
    """
    events = [Event(EventKind.CUT, cut, ()) for cut in sorted(set(cuts))]
    borders = {0, drawing_count, *cuts}
    layout = strokes.layout
    for s in range(len(strokes)):
        if strokes.parent[s]:
            events += _of_part(strokes, s, confidence, borders)
            continue
        identity = (int(strokes.ids[s]),)
        rows = slice(int(layout.stroke_rows[s]), int(layout.stroke_rows[s + 1]))
        first, last, sure = int(layout.first[s]), int(layout.last[s]), confidence[rows]
        if first not in borders:
            events.append(Event(EventKind.BIRTH, first, identity, score=_score(sure[:3])))
        if last + 1 not in borders:
            events.append(Event(EventKind.DEATH, last + 1, identity, score=_score(sure[-3:])))
        events += _turns(_seen(strokes, s), first, identity, sure)
    return tuple(sorted(events, key=lambda event: (event.drawing, event.kind, event.ids)))


def _of_part(strokes: Strokes, part: int, confidence: NDArray[np.float64], borders: set[int]) -> list[Event]:
    """A gap that opens, and if that is seen, how it closes: the parent is seen where the part was, or neither is."""
    layout, parent = strokes.layout, int(strokes.parent[part])
    identity, both = int(strokes.ids[part]), (parent, int(strokes.ids[part]))
    rows = slice(int(layout.stroke_rows[part]), int(layout.stroke_rows[part + 1]))
    first, last, sure = int(layout.first[part]), int(layout.last[part]), confidence[rows]
    events = []
    if first not in borders:
        events.append(Event(EventKind.SPLIT, first, both, (parent,), _score(sure[:3])))
    if last + 1 not in borders:
        begin, end = strokes.visible[rows][-1]
        position = int(np.flatnonzero(strokes.ids == parent)[0])
        after = (0.0, 0.0) if last == layout.last[position] else strokes.visible[strokes.row(position, last + 1)]
        if after[0] <= (begin + end) / 2 <= after[1]:
            events.append(Event(EventKind.MERGE, last + 1, (parent,), both, _score(sure[-3:])))
        else:
            events.append(Event(EventKind.DEATH, last + 1, (identity,), score=_score(sure[-3:])))
    return events


def _seen(strokes: Strokes, stroke: int) -> NDArray[np.float64]:
    """Share of a stroke that is seen on each of its drawings, with its parts beyond gaps. [K]"""
    layout = strokes.layout
    own = [stroke, *np.flatnonzero(strokes.parent == strokes.ids[stroke]).tolist()]
    seen = np.zeros(int(layout.last[stroke] - layout.first[stroke]) + 1)
    for s in own:
        rows = slice(int(layout.stroke_rows[s]), int(layout.stroke_rows[s + 1]))
        begin = int(layout.first[s] - layout.first[stroke])
        shares = np.ptp(strokes.visible[rows], axis=1)
        seen[begin : begin + len(shares)] += shares
    return seen


def _turns(seen: NDArray[np.float64], first: int, identity: tuple[int, ...], sure: NDArray[np.float64]) -> list[Event]:
    """Changes between seen whole and seen in part; a stroke that was never whole before is being drawn."""
    events = []
    is_whole = seen >= _HIDDEN
    was_whole = False
    for k in range(len(seen)):
        if was_whole and not is_whole[k] and is_whole[k - 1]:
            events.append(Event(EventKind.OCCLUSION, first + k, identity, score=1 - float(seen[k])))
        if was_whole and is_whole[k] and not is_whole[k - 1]:
            events.append(Event(EventKind.REAPPEARANCE, first + k, identity, score=_score(sure[k : k + 1])))
        was_whole = was_whole or bool(is_whole[k])
    return events


def _score(values: NDArray[np.float64]) -> float:
    return float(np.clip(values.mean(), 0.0, 1.0))
