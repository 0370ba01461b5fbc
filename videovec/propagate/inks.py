"""Every ink on its own: a red stroke never follows black ink."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from videovec.events import Event
from videovec.ink import Ink, ink_alone
from videovec.progress import Progress
from videovec.propagate.births import Trace
from videovec.propagate.walk import Propagated, walk
from videovec.settings import PropagateSettings
from videovec.strokes import Strokes

__all__ = ["propagate"]

_SEEN = 32
"""Coverage from which on a pixel shows an ink, of 255."""


def propagate(
    ink: Ink, strokes: Strokes, settings: PropagateSettings, trace: Trace, progress: Progress | None = None
) -> Propagated:
    """Carry strokes from the drawing on which they are known to all drawings, those of each ink over that ink alone.

    Strokes whose ink vanishes end, or are hidden if it comes back within ``settings.memory`` drawings; ink that no
    stroke explains is traced and followed both ways; a cut ends all lives, and the drawing after it is traced anew.

    Args:
        ink: D drawings.
        strokes: Strokes that live on one drawing alone. Without any, the first drawing is traced.
        settings: How.
        trace: Traces strokes on the ink of one drawing.
        progress: Told of every drawing of every ink.

    Returns:
        The strokes with their lives, what happened to them, and how sure that is.

    Raises:
        FitError: The strokes live on more than one drawing.
    """
    if len(ink.palette) == 1:
        return walk(ink, strokes, settings, trace, progress)
    nearest = np.linalg.norm(strokes.color[:, None] - ink.palette, axis=2).argmin(1) if len(strokes) else np.zeros(0)
    parts = []
    next_id = int(strokes.ids.max(initial=0)) + 1
    for label in range(len(ink.palette)):
        alone, mine = ink_alone(ink, label), strokes.select(nearest == label)
        if not len(mine) and not (alone.coverage > _SEEN).any():
            continue
        part = _renumbered(walk(alone, mine, settings, trace, progress), mine.ids, next_id)
        next_id = max(next_id, int(part.strokes.ids.max(initial=0)) + 1)
        parts.append(part)
    together = Strokes.concatenate([part.strokes for part in parts])
    order = np.argsort(together.ids)
    begin = together.layout.stroke_rows
    rows = [np.arange(begin[s], begin[s + 1]) for s in order]
    confidence = np.concatenate([np.zeros(0), *(part.confidence for part in parts)])
    events = dict.fromkeys(event for part in parts for event in part.events)
    return Propagated(
        together.select(order),
        tuple(sorted(events, key=lambda event: event.drawing)),
        confidence[np.concatenate([np.zeros(0, np.intp), *rows])],
    )


def _renumbered(part: Propagated, known: NDArray[np.intp], next_id: int) -> Propagated:
    """The part with new identities, from ``next_id``, for all strokes that were not known before."""
    is_new = ~np.isin(part.strokes.ids, known)
    ids = part.strokes.ids.copy()
    ids[is_new] = next_id + np.arange(int(is_new.sum()))
    new = dict(zip(part.strokes.ids.tolist(), ids.tolist(), strict=True))

    def renamed(event: Event) -> Event:
        return replace(
            event,
            ids=tuple(new.get(i, i) for i in event.ids),
            parents=tuple(new.get(i, i) for i in event.parents),
        )

    parent = np.array([new.get(i, i) for i in part.strokes.parent.tolist()], np.intp)
    return replace(part, strokes=replace(part.strokes, ids=ids, parent=parent), events=tuple(map(renamed, part.events)))
