"""The vote: every drawing is traced on its own, and says how strokes run through the junctions of the others.

A junction looks different on every drawing: lines cross at other angles, come apart, or touch where they did not.
Strokes that were carried through the clip say which of its places is which: each drawing has a voice on each junction.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from videovec.events import EventKind
from videovec.ink import Ink
from videovec.progress import Progress, Silent
from videovec.propagate import Propagated, Trace, events_of
from videovec.strokes import Strokes
from videovec.vote.ballot import Ballot, count, hear, traced_on
from videovec.vote.contacts import Arm, Contacts, find_contacts
from videovec.vote.hinges import cut_at_hinges
from videovec.vote.recut import recut

__all__ = ["vote"]

_VOTERS = 16  # drawings that are traced at most
_LEAST = 3  # drawings that must know two arms


def vote(ink: Ink, carried: Propagated, seed: int, trace: Trace, progress: Progress | None = None) -> Propagated:
    """Pair the branches of junctions anew where most drawings do.

    Args:
        ink: D drawings.
        carried: Strokes that were carried over them.
        seed: The drawing from which they came.
        trace: Traces strokes on the ink of one drawing.
        progress: Told of every drawing that is traced.

    Returns:
        The same ink in strokes that may be cut and joined differently, on all drawings alike. Strokes whose lives are
        not those of most others stay as they are, as do closed ones; but a stroke of which a part swings about
        another that does not is two strokes, however all drawings trace it, see `cut_at_hinges`.
    """
    voted = _elect(ink, carried, seed, trace, progress or Silent())
    strokes, confidence = cut_at_hinges(*(voted or (carried.strokes, carried.confidence)), max(ink.size))
    if voted is None and strokes is carried.strokes:
        return carried
    cuts = [event.drawing for event in carried.events if event.kind is EventKind.CUT]
    return Propagated(strokes, events_of(strokes, confidence, cuts, ink.drawing_count), confidence)


def _elect(
    ink: Ink, carried: Propagated, seed: int, trace: Trace, progress: Progress
) -> tuple[Strokes, NDArray[np.float64]] | None:
    """The strokes as most drawings pair them, and the confidence of their rows; nothing if they are so already."""
    strokes = carried.strokes
    common = _common_life(strokes, seed)
    drawings = _voters(strokes, common)
    if len(drawings) < _LEAST:
        return None
    progress.stage("vote", len(drawings))
    contacts = _of(find_contacts(strokes.select(common), seed), common)
    voices = []
    for drawing in drawings:
        traced = traced_on(trace(ink.at_drawing(drawing), 0))
        if traced is not None:
            voices.append(hear(strokes, contacts, drawing, traced))
        progress.advance()
    links: set[tuple[Arm, Arm]] = set()
    now: set[tuple[Arm, Arm]] = set()
    for junction in contacts.junctions:
        current = contacts.links(junction)
        ballot = count(contacts, junction, voices)
        links |= _elected(ballot, junction, current)
        now |= current
    return recut(strokes, carried.confidence, contacts, frozenset(links)) if links != now else None


def _common_life(strokes: Strokes, seed: int) -> NDArray[np.intp]:
    """The strokes with the life that most strokes of a drawing have. int [K]"""
    layout = strokes.layout
    has_gaps = (strokes.parent > 0) | np.isin(strokes.ids, strokes.parent)  # one cut would have to be that of its parts
    alive = np.flatnonzero((layout.first <= seed) & (layout.last >= seed) & ~has_gaps)
    lives = np.stack([layout.first[alive], layout.last[alive]], axis=1)
    if not len(alive):
        return alive
    _, which, counts = np.unique(lives, axis=0, return_inverse=True, return_counts=True)
    return np.asarray(alive[which.reshape(-1) == int(counts.argmax())])


def _voters(strokes: Strokes, common: NDArray[np.intp]) -> list[int]:
    """Drawings of a common life, evenly spread."""
    if not len(common):
        return []
    first, last = int(strokes.layout.first[common[0]]), int(strokes.layout.last[common[0]])
    picked = np.linspace(first, last, min(_VOTERS, last - first + 1)).round().astype(int)
    return sorted(set(picked.tolist()))


def _of(contacts: Contacts, common: NDArray[np.intp]) -> Contacts:
    """Contacts among some strokes, with the positions that these have among all."""
    branches = tuple(replace(branch, stroke=int(common[branch.stroke])) for branch in contacts.branches)
    return replace(contacts, branches=branches)


def _elected(ballot: Ballot, junction: tuple[Arm, ...], current: frozenset[tuple[Arm, Arm]]) -> set[tuple[Arm, Arm]]:
    """The links of a junction: those of a majority, the clearest first; without one, those that there are."""
    size = len(junction)
    lead = ballot.share - 0.5
    wanted = []
    for i in range(size):
        for j in range(i + 1, size):
            pair = (junction[i], junction[j])
            is_now = pair in current or pair[::-1] in current
            knows = ballot.known[i, j] >= _LEAST
            if (knows and lead[i, j] > 0) or (is_now and not knows):
                wanted.append((-lead[i, j] if knows else 0.0, i, j))
    taken: set[int] = set()
    links = set()
    for _, i, j in sorted(wanted):
        if not taken & {i, j}:
            taken |= {i, j}
            one, two = junction[i], junction[j]
            links.add((two, one) if two[1] > one[1] else (one, two))
    return links
