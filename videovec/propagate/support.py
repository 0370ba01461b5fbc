"""Which part of every stroke the ink supports: what is seen of it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from videovec.propagate.ends import find_ends
from videovec.propagate.kernels import nearest
from videovec.propagate.nodes import Nodes
from videovec.propagate.registration import doubled
from videovec.propagate.target import Target

__all__ = ["Support", "find_support"]

Floats = NDArray[np.float64]
Bools = NDArray[np.bool_]

_NEAR = 2.5
"""Distance up to which ink supports a node, if its line is thin. px"""
_OWN = 0.3
"""Share of the seen nodes that must have ink of their own."""
_DIRECTION = 6.0
"""Weight of direction when ink chooses its stroke. px"""
_REACH = 2
"""Nodes on either side of the one that ink has chosen that it claims too."""
_RUN = 3
"""Nodes of the shortest run that is seen."""
_WHOLE = 0.8
"""Share of a closed stroke that must lie on ink for it to be seen whole."""
_SEEN = 0.2
"""Share of a stroke that must be seen for it to be there."""


@dataclass(frozen=True, slots=True, eq=False)
class Support:
    """What the ink says of strokes that were placed on it.

    Args:
        node: Which nodes lie on ink. bool [N]
        first: First node that is seen of each stroke, counted within it. int [S]
        last: Last node that is seen; before the first if nothing is. int [S]
        visible: The same as arc fractions. [S, 2]
        share: Share of nodes that lie on ink. [S]
    """

    node: Bools
    first: NDArray[np.intp]
    last: NDArray[np.intp]
    visible: Floats
    share: Floats

    def seen(self) -> Bools:
        """Strokes of which something is seen. bool [S]"""
        return np.asarray(self.last >= self.first)

    def follows(self, nodes: Nodes) -> Floats:
        """1 for nodes in the seen part of their stroke, else 0. [N]"""
        local = np.arange(len(nodes)) - nodes.starts[nodes.stroke]
        inside = (local >= self.first[nodes.stroke]) & (local <= self.last[nodes.stroke])
        return inside.astype(np.float64)

    def explains(self, nodes: Nodes) -> Floats:
        """1 for nodes of seen strokes in their seen part, or on ink beyond a gap that hides their middle. [N]"""
        beyond = self.node & (self.node[nodes.before] & self.node[nodes.after]) & self.seen()[nodes.stroke]
        return np.maximum(self.follows(nodes), beyond)


def find_support(
    nodes: Nodes, positions: Floats, half_width: Floats, target: Target, most_seen: Floats | None = None
) -> Support:
    """Look for the ink of every stroke.

    A part of a stroke is seen where there is ink; the stroke is there if some of that ink has no better stroke. A
    stroke that has vanished finds its neighbours' ink, but cannot claim it.

    Args:
        nodes: N nodes.
        positions: Where they are. [N, 2] working px
        half_width: Half-width of each stroke. [S] working px
        target: The drawing's ink.
        most_seen: The most that was ever seen of each stroke, as arc fractions; all of it unless told. [S, 2]

    Returns:
        The support of each node and the seen part of each stroke.
    """
    reach = np.maximum(_NEAR, 0.8 * half_width)[nodes.stroke]
    supported, claimed = np.zeros(len(nodes), bool), np.zeros(len(nodes), bool)
    if len(target) and len(nodes):
        supported = target.distance_at(positions) <= reach
        claimed = _claimed(nodes, positions, reach, target)
    count = len(nodes.bases)
    first, last = np.zeros(count, np.intp), np.full(count, -1, np.intp)
    share = np.zeros(count)
    for s, basis in enumerate(nodes.bases):
        part = supported[nodes.starts[s] : nodes.starts[s + 1]]
        own = claimed[nodes.starts[s] : nodes.starts[s + 1]]
        share[s] = part.mean()
        first[s], last[s] = _interval(part, basis.is_closed)
        if own[first[s] : last[s] + 1].sum() < _OWN * (last[s] + 1 - first[s]):
            first[s], last[s] = 0, -1
    known = np.tile([0.0, 1.0], (count, 1)) if most_seen is None else most_seen
    visible = find_ends(nodes, positions, half_width, (first, last, known), target)
    for s in np.flatnonzero(last >= first):
        first[s], last[s] = _within(nodes.bases[s].u, visible[s], (int(first[s]), int(last[s])))
    return Support(supported, first, last, visible, share)


def _within(u: Floats, visible: Floats, otherwise: tuple[int, int]) -> tuple[int, int]:
    """First and last node in the seen part: what lies under another line must not follow that line's ink."""
    first, last = np.searchsorted(u, [visible[0] - 1e-9, visible[1] + 1e-9])
    return (int(first), int(last) - 1) if last > first else otherwise


def _claimed(nodes: Nodes, positions: Floats, reach: Floats, target: Target) -> Bools:
    """Nodes that are the nearest of some ink, or neighbours of such. bool [N]"""
    tangent = nodes.tangents(positions)
    features = np.concatenate([positions, _DIRECTION * doubled(tangent)], axis=1)
    ink = np.concatenate([target.points, _DIRECTION * doubled(target.direction)], axis=1)
    owner, squared = nearest(ink, features, np.zeros(len(ink), np.int64))
    claimed = np.zeros(len(nodes), bool)
    claimed[owner[squared <= (reach[owner] + 2.0) ** 2 + _DIRECTION**2]] = True
    for _ in range(_REACH):
        claimed = claimed | claimed[nodes.before] | claimed[nodes.after]
    return claimed


def _interval(supported: Bools, is_closed: bool) -> tuple[int, int]:
    """First and last seen node of a stroke: the interval that is wrong at the fewest nodes.

    Of a closed stroke, what is seen does not go through its beginning.
    """
    count = len(supported)
    edges = np.flatnonzero(np.diff(np.concatenate([[0], supported.astype(np.int8), [0]])))
    begins, ends = edges[::2], edges[1::2]
    long = ends - begins >= min(_RUN, count)
    begins, ends = begins[long], ends[long]
    if not len(begins) or supported.mean() < _SEEN:
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
