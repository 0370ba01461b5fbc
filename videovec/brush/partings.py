"""Strokes that were parted where their brush begins anew: identities for the parts, and the events that say so."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from videovec.events import Event, EventKind
from videovec.strokes import Strokes

__all__ = ["number_parts", "parting_events", "wholes_of"]

_FIRST = 3  # drawings whose support says how sure a split is


def number_parts(strokes: Strokes, given: Strokes, highest: int) -> Strokes:
    """Strokes of which those that were not given are numbered from the next number on."""
    is_new = ~np.isin(strokes.ids, given.ids)
    return replace(strokes, ids=np.where(is_new, highest + np.cumsum(is_new), strokes.ids))


def wholes_of(strokes: Strokes, given: Strokes) -> NDArray[np.intp]:
    """Identity of the given stroke that each is, or is a part of: parts follow the one that kept its identity. [S]"""
    is_given = np.isin(strokes.ids, given.ids)
    return np.asarray(strokes.ids[np.maximum.accumulate(np.where(is_given, np.arange(len(strokes)), 0))])


def parting_events(
    strokes: Strokes, whole: NDArray[np.intp], support: NDArray[np.float64], events: tuple[Event, ...]
) -> tuple[Event, ...]:
    """The events of a clip with a split for every stroke that was parted; its parts end as it does.

    Args:
        strokes: S strokes over R rows, parts beside one another.
        whole: Identity of the stroke that each was a part of. [S]
        support: How well the ink supports each row. [R]
        events: What happened to the strokes before they were parted.
    """
    layout = strokes.layout
    found = []
    for one in np.unique(whole[strokes.ids != whole]).tolist():
        parts = np.flatnonzero(whole == one)
        ids = tuple(strokes.ids[parts].tolist())
        rows = layout.stroke_rows[parts][:, None] + np.arange(_FIRST)
        sure = support[np.minimum(rows, layout.stroke_rows[parts + 1][:, None] - 1)].mean()
        score = float(np.clip(sure, 0.0, 1.0))
        found.append(Event(EventKind.SPLIT, int(layout.first[parts[0]]), ids, (one,), score))
        found += [
            replace(event, ids=(part,))
            for event in events
            if event.kind is EventKind.DEATH and event.ids == (one,)
            for part in ids[1:]
        ]
    return tuple(sorted([*events, *found], key=lambda event: (event.drawing, event.kind, event.ids)))
