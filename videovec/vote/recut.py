"""Strokes cut and joined at junctions on all of their drawings at once, so that identities stay whole."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from videovec.curves import arc_length
from videovec.life_edits import cut_at, join_ends
from videovec.stroke_life import StrokeLife
from videovec.strokes import Strokes
from videovec.vote.contacts import Arm, Contacts

__all__ = ["recut"]

Floats = NDArray[np.float64]
Link = tuple[Arm, Arm]

_BRIDGED = 2.5  # widths between two ends that are drawn together; a wider gap gets a straight segment


@dataclass(frozen=True, slots=True, eq=False)
class _Piece:
    """A run of branches of one stroke that stay together, and the confidence of its rows."""

    life: StrokeLife
    confidence: Floats
    arms: tuple[Arm, Arm]

    def reversed(self) -> _Piece:
        return replace(self, life=self.life.reversed(), arms=self.arms[::-1])


def recut(strokes: Strokes, confidence: Floats, contacts: Contacts, links: frozenset[Link]) -> tuple[Strokes, Floats]:
    """Cut and join strokes such that exactly the linked arms run on into each other.

    Args:
        strokes: S strokes over D drawings.
        confidence: Of every row. [R]
        contacts: The branches of those that may be cut, all with one life.
        links: The pairs of arms that are one stroke.

    Returns:
        The strokes, each with the identity of the stroke that most of it came from where that is free, and the
        confidence of their rows.
    """
    concerned = {branch.stroke for branch in contacts.branches}
    whole = [_whole(strokes, confidence, s) for s in range(len(strokes)) if s not in concerned]
    pieces = [piece for stroke in sorted(concerned) for piece in _pieces(strokes, confidence, contacts, stroke, links)]
    made = _named(_strung(pieces, links, _BRIDGED * contacts.width), {life.id for life, _ in whole}, strokes)
    every = sorted(whole + made, key=lambda entry: entry[0].id)
    return (
        Strokes.concatenate([life.as_strokes() for life, _ in every]),
        np.concatenate([np.zeros(0), *(sure for _, sure in every)]),
    )


def _whole(strokes: Strokes, confidence: Floats, stroke: int) -> tuple[StrokeLife, Floats]:
    rows = slice(*strokes.layout.stroke_rows[stroke : stroke + 2].tolist())
    return StrokeLife.of(strokes, stroke), confidence[rows]


def _pieces(
    strokes: Strokes, confidence: Floats, contacts: Contacts, stroke: int, links: frozenset[Link]
) -> list[_Piece]:
    """A stroke, cut wherever two of its branches are no longer linked; last piece first."""
    rest, sure = _whole(strokes, confidence, stroke)
    own = [number for number, branch in enumerate(contacts.branches) if branch.stroke == stroke]
    pieces = []
    last = own[-1]
    for number in reversed(own[1:]):
        if ((number - 1, 1), (number, 0)) in links:
            continue
        rest, tail = cut_at(rest, contacts.branches[number].start, rest.id)
        pieces.append(_Piece(tail, sure, ((number, 0), (last, 1))))
        last = number - 1
    return [*pieces, _Piece(rest, sure, ((own[0], 0), (last, 1)))]


def _strung(pieces: list[_Piece], links: frozenset[Link], touching: float) -> list[list[_Piece]]:
    """Chains of pieces, each piece once and turned as the chain runs; `_joined` makes one of each."""
    partner = {arm: other for link in links for arm, other in (link, link[::-1])}
    owner = {arm: piece for piece in pieces for arm in piece.arms}
    used: set[int] = set()
    chains = []
    free = [p for p in pieces if p.arms[0] not in partner or p.arms[1] not in partner]
    for start in (*free, *pieces):  # rings last, opened anywhere
        if id(start) in used:
            continue
        here = start if partner.get(start.arms[0]) not in owner else start.reversed()
        chain = []
        while True:
            used.add(id(owner[here.arms[0]]))
            chain.append(here)
            entered = partner.get(here.arms[1])
            if entered is None or entered not in owner or id(owner[entered]) in used:
                break
            following = owner[entered]
            here = following if following.arms[0] == entered else following.reversed()
        chains.append(_joined(chain, touching))
    return chains


def _joined(chain: list[_Piece], touching: float) -> list[_Piece]:
    """The chain as one piece, followed by what it was made of."""
    life, sure = chain[0].life, chain[0].confidence
    for piece in chain[1:]:
        life, sure = join_ends(life, piece.life, touching), np.minimum(sure, piece.confidence)
    return [_Piece(life, sure, (chain[0].arms[0], chain[-1].arms[1])), *chain]


def _named(chains: Iterable[list[_Piece]], taken: set[int], strokes: Strokes) -> list[tuple[StrokeLife, Floats]]:
    """The joined strokes, longest part first, under the identity and layer of that part."""
    layer = dict(zip(strokes.ids.tolist(), strokes.layer.tolist(), strict=True))
    following = int(strokes.ids.max(initial=0)) + 1
    sized = []
    for joined, *parts in chains:
        length: dict[int, float] = {}
        for part in parts:
            length[part.life.id] = length.get(part.life.id, 0.0) + arc_length(part.life.points[0])
        sized.append((length, joined))
    named = []
    for length, joined in sorted(sized, key=lambda entry: -max(entry[0].values())):
        first = max(length, key=lambda one: (length[one], -one))
        free = [one for one in sorted(length, key=lambda one: -length[one]) if one not in taken]
        identity = free[0] if free else following
        following += not free
        taken.add(identity)
        named.append((replace(joined.life, id=identity, layer=layer[first]), joined.confidence))
    return named
