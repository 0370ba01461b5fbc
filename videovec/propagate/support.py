"""Which part of every stroke the ink supports: what is seen of it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from videovec.propagate.ends import find_ends, widened
from videovec.propagate.gaps import Piece, find_pieces, find_ring_pieces, nodes_of
from videovec.propagate.kernels import nearest
from videovec.propagate.nodes import Nodes
from videovec.propagate.record import Interval
from videovec.propagate.registration import doubled
from videovec.propagate.target import Target, sample

__all__ = ["SEEN", "Inks", "Past", "Support", "find_support"]

Floats = NDArray[np.float64]
Bools = NDArray[np.bool_]

_NEAR = 2.5
"""Distance up to which ink supports a node, if its line is thin. px"""
_OWN = 0.3
"""Share of the seen nodes that must have ink of their own."""
_DIRECTION = 6.0
"""Weight of direction when ink chooses its stroke. px"""
_IN_PART = 6.0
"""How much farther ink is from a stroke without ink, when it chooses, than from one that lies on ink all along. px"""
_STRAYED = 0.3
"""And for each px from where a node was expected,"""
_STRAY_MOST = 6.0
"""but no more than this. px"""
_REACH = 2
"""Nodes on either side of the one that ink has chosen that it claims too."""
_RUN = 3
"""Nodes of the shortest run that is seen, of strokes that have twice as many; of shorter ones half of them."""
_WHOLE = 0.8
"""Share of a closed stroke that must lie on ink for it to be seen whole."""
SEEN = 0.2
"""Share of a stroke that must be seen for it to be there."""


@dataclass(frozen=True, slots=True, eq=False)
class Support:
    """What the ink says of strokes that were placed on it.

    Args:
        node: Which nodes lie on ink. bool [N]
        shown: Which nodes lie in a seen part of their stroke. bool [N]
        visible: The seen parts of each stroke as arc fractions, in their order. S of them
        share: Share of nodes that lie on ink. [S]
        claimed: Which nodes have ink that has no better stroke, or their neighbours do. bool [N]
    """

    node: Bools
    shown: Bools
    visible: tuple[tuple[Interval, ...], ...]
    share: Floats
    claimed: Bools

    def seen(self, nodes: Nodes) -> Bools:
        """Strokes of which something is seen. bool [S]"""
        return np.bincount(nodes.stroke, self.shown, minlength=len(nodes.bases)) > 0

    def follows(self) -> Floats:
        """1 for nodes in a seen part of their stroke with ink of their own, else 0. [N]"""
        return (self.shown & self.claimed).astype(np.float64)

    def explains(self, nodes: Nodes) -> Floats:
        """1 for nodes of seen strokes in their seen parts, or on ink beyond a gap that hides their middle. [N]"""
        beyond = self.node & (self.node[nodes.before] & self.node[nodes.after]) & self.seen(nodes)[nodes.stroke]
        return (self.shown | beyond).astype(np.float64)


@dataclass(frozen=True, slots=True, eq=False)
class Past:
    """What is known of strokes before their ink is looked for.

    Args:
        most_seen: The most that was ever seen of each stroke, as arc fractions. [S, 2]
        least: Share of each stroke that must lie on ink for it to be there. [S]
        merged: Nodes that run together with others, of which any ink is as good as a centre line. bool [N]
        expected: Where nodes would be, had they moved as in the last step. [N, 2] working px
    """

    most_seen: Floats
    least: Floats
    merged: Bools
    expected: Floats


@dataclass(frozen=True, slots=True, eq=False)
class Inks:
    """A drawing's ink, and what of it may be whose.

    Args:
        whole: All of it.
        own: What is not of strokes in front.
        front: Strokes in front, to which all of it is open. bool [S]
    """

    whole: Target
    own: Target
    front: Bools

    @staticmethod
    def of(target: Target, strokes: int) -> Inks:
        """The ink of a drawing on which no stroke is in front."""
        return Inks(target, target, np.zeros(strokes, bool))

    def distance_at(self, nodes: Nodes, positions: Floats) -> Floats:
        """Distance of nodes from ink that may be theirs. [N] working px"""
        whole = self.whole.distance_at(positions)
        if not self.front.any():
            return whole
        own = self.own.distance_at(positions) if len(self.own) else np.full(len(positions), np.inf)
        return np.where(self.front[nodes.stroke], whole, own)


def find_support(nodes: Nodes, positions: Floats, half_width: Floats, ink: Inks, past: Past) -> Support:
    """Look for the ink of every stroke.

    A part of a stroke is seen where there is ink; the stroke is there if some of that ink has no better stroke. A
    stroke that has vanished finds its neighbours' ink, but cannot claim it.

    Args:
        nodes: N nodes.
        positions: Where they are. [N, 2] working px
        half_width: Half-width of each stroke. [S] working px
        ink: The drawing's ink.
        past: What was known before.

    Returns:
        The support of each node and the seen parts of each stroke.
    """
    target, reach = ink.whole, np.maximum(_NEAR, 0.8 * half_width)[nodes.stroke]
    supported, chosen, bare = (np.zeros(len(nodes), bool) for _ in range(3))
    if len(target) and len(nodes):
        supported = ink.distance_at(nodes, positions) <= reach
        stray = np.linalg.norm(positions - past.expected, axis=1)
        chosen = _chosen(nodes, positions, (reach, _lacks(nodes, supported, stray)), target)
        bare = sample(widened(target), positions) <= target.threshold
        supported |= past.merged & ~bare
        chosen |= past.merged & ~bare
    claimed = _spread(chosen, nodes)
    count = len(nodes.bases)
    share = np.zeros(count)
    pieces: list[list[Piece]] = []
    for s, basis in enumerate(nodes.bases):
        own = slice(int(nodes.starts[s]), int(nodes.starts[s + 1]))
        share[s] = supported[own].mean()
        main = _interval(supported[own], basis.is_closed, float(past.least[s]))
        if claimed[own][main[0] : main[1] + 1].sum() < _OWN * (main[1] + 1 - main[0]):
            main = 0, -1
        width = 2.0 * float(half_width[s]) / _spacing(positions[own])
        find = find_ring_pieces if basis.is_closed else find_pieces
        pieces.append(find(main, supported[own], bare[own], chosen[own], width))
    visible = find_ends(nodes, positions, half_width, (pieces, past.most_seen), target)
    return Support(supported, shown_nodes(nodes, pieces, visible), tuple(visible), share, claimed)


def shown_nodes(nodes: Nodes, pieces: list[list[Piece]], visible: list[tuple[Interval, ...]]) -> Bools:
    """Which nodes lie in seen parts: what lies under another line must not follow that line's ink. bool [N]"""
    shown = np.zeros(len(nodes), bool)
    for s, basis in enumerate(nodes.bases):
        own = shown[nodes.starts[s] : nodes.starts[s + 1]]
        for begin, end in visible[s]:
            own |= (basis.u >= begin - 1e-9) & (basis.u <= end + 1e-9)
        if visible[s] and not own.any():
            for piece in pieces[s]:
                own[nodes_of(piece, len(own))] = True
    return shown


def _spacing(positions: Floats) -> float:
    """Mean distance of neighbouring nodes of a stroke. working px"""
    steps = np.linalg.norm(np.diff(positions, axis=0), axis=1)
    return max(float(steps.mean()) if len(steps) else 0.0, 1e-6)


def _lacks(nodes: Nodes, supported: Bools, stray: Floats) -> Floats:
    """How much farther from ink than they are nodes count when it chooses. [N] px"""
    share = nodes.shares(supported)[nodes.stroke]
    return np.asarray(_IN_PART * (1.0 - share) + np.minimum(_STRAYED * stray, _STRAY_MOST))


def _chosen(nodes: Nodes, positions: Floats, near: tuple[Floats, Floats], target: Target) -> Bools:
    """Nodes that are the nearest of some ink. bool [N]

    Args:
        nodes: N nodes.
        positions: Where they are. [N, 2] working px
        near: How near ink must be to support each node, and how much farther than others it counts. [N] each
        target: The ink.
    """
    reach, lacks = near
    tangent = nodes.tangents(positions)
    features = np.concatenate([positions, _DIRECTION * doubled(tangent), lacks[:, None]], axis=1)
    ink = np.concatenate([target.points, _DIRECTION * doubled(target.direction), np.zeros((len(target), 1))], axis=1)
    owner, squared = nearest(ink, features, np.zeros(len(ink), np.int64))
    squared = squared - lacks[owner] ** 2
    chosen = np.zeros(len(nodes), bool)
    chosen[owner[squared <= (reach[owner] + 2.0) ** 2 + _DIRECTION**2]] = True
    return chosen


def _spread(chosen: Bools, nodes: Nodes) -> Bools:
    """Nodes that ink has chosen, and their neighbours. bool [N]"""
    for _ in range(_REACH):
        chosen = chosen | chosen[nodes.before] | chosen[nodes.after]
    return chosen


def _interval(supported: Bools, is_closed: bool, least: float) -> tuple[int, int]:
    """First and last seen node of a stroke: the interval that is wrong at the fewest nodes.

    Of a closed stroke, what is seen does not go through its beginning.
    """
    count = len(supported)
    edges = np.flatnonzero(np.diff(np.concatenate([[0], supported.astype(np.int8), [0]])))
    begins, ends = edges[::2], edges[1::2]
    long = ends - begins >= max(1, min(_RUN, count // 2))
    begins, ends = begins[long], ends[long]
    if not len(begins) or supported.mean() < least:
        return 0, -1
    if is_closed and supported.mean() >= _WHOLE:
        return 0, count - 1
    best, first, last = 0, 0, -1
    begin, total = int(begins[0]), 0
    for k in range(len(begins)):
        gap = int(begins[k] - ends[k - 1]) if k else 0
        if total < gap:
            begin, total = int(begins[k]), 0
        else:
            total -= gap
        total += int(ends[k] - begins[k])
        if total > best:
            best, first, last = total, begin, int(ends[k]) - 1
    return first, last
