"""Every ink on its own: a red stroke never follows black ink."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from videovec.events import Event, EventKind
from videovec.ink import Ink, amount_of_ink, ink_alone
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
    stroke explains is traced and followed both ways; a cut ends all lives, and the drawing after it is traced anew. All
    inks together say what is a cut.

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
    walks = []
    for label in range(len(ink.palette)):
        alone, mine = ink_alone(ink, label), strokes.select(nearest == label)
        if len(mine) or (alone.coverage > _SEEN).any():
            walks.append(_Walked(label, mine, amount_of_ink(alone), walk(alone, mine, settings, trace, progress)))
    cuts = _agreed_cuts(walks)
    parts = []
    next_id = int(strokes.ids.max(initial=0)) + 1
    for walked in walks:
        part = walked.part
        if walked.cuts() != cuts:
            part = walk(ink_alone(ink, walked.label), walked.strokes, settings, trace, progress, cuts)
        part = _renumbered(part, walked.strokes.ids, next_id)
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


@dataclass(frozen=True, slots=True, eq=False)
class _Walked:
    """The strokes of one ink on the drawing where they are known, and what became of them.

    Args:
        label: Position of the ink in the palette.
        strokes: The strokes that were known.
        amount: Sum of coverage on each drawing. int [D]
        part: What became of them.
    """

    label: int
    strokes: Strokes
    amount: NDArray[np.int64]
    part: Propagated

    def cuts(self) -> frozenset[int]:
        """First drawings of what looks like new shots to this ink."""
        return frozenset(event.drawing for event in self.part.events if event.kind == EventKind.CUT)

    def say(self, cut: int) -> float:
        """How much there is of this ink on both sides of a cut."""
        return float(self.amount[cut - 1 : cut + 1].min())


def _agreed_cuts(walks: list[_Walked]) -> frozenset[int]:
    """The cuts that most of the ink has: where one ink alone changes altogether, the shot goes on."""
    agreed = set()
    for cut in {cut for walked in walks for cut in walked.cuts()}:
        votes = sum(walked.say(cut) for walked in walks if cut in walked.cuts())
        if 2 * votes > sum(walked.say(cut) for walked in walks):
            agreed.add(cut)
    return frozenset(agreed)


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
