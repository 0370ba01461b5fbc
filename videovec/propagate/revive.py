"""Hidden strokes whose ink is back where they wait for it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from videovec.propagate.follower import Follower
from videovec.propagate.step import Placement
from videovec.propagate.target import Target

__all__ = ["revive"]

_BACK = 0.75
"""Share of a hidden stroke's nodes that must lie on ink."""
_NEAR = 3.0
"""Distance within which a stroke stands in the place of another. px"""


def revive(
    followers: list[Follower], placed: Placement, target: Target, drawing: int
) -> tuple[list[Follower], Placement]:
    """Give ink back to hidden strokes from strokes that were born to explain it meanwhile.

    Args:
        followers: All lives, as they were placed.
        placed: Where they are.
        target: The drawing's ink.
        drawing: Its number.

    Returns:
        The lives that go on, and what is seen of all of them now. Lives that a revived stroke replaces end before the
        drawing.
    """
    nodes, positions = placed.nodes, placed.positions
    reach = np.maximum(_NEAR, placed.half_width)
    gap = target.distance_at(positions) if len(target) else np.full(len(nodes), np.inf)
    ended: set[int] = set()
    shown = placed.support.shown.copy()
    for s, follower in enumerate(followers):
        seen = follower.life.most_seen
        begin, end = np.searchsorted(follower.basis.u, [seen[0], seen[1] + 1e-9])
        own = slice(int(nodes.starts[s] + begin), int(nodes.starts[s] + end))
        share = float(np.mean(gap[own] <= reach[s])) if end > begin else 0.0
        if not follower.unseen or share < _BACK:
            continue
        young = [k for k, other in enumerate(followers) if _is_younger(other, follower)]
        usurpers = [k for k in young if _covers(positions[own], _of(placed, k), reach[s])]
        if not usurpers:
            continue
        ended.update(usurpers)
        row = follower.life.rows[drawing]
        follower.life.rows[drawing] = replace(row, visible=seen, gaps=(), confidence=share)
        follower.unseen = 0
        shown[own] = True
    for k in ended:
        del followers[k].life.rows[drawing]
        shown[nodes.starts[k] : nodes.starts[k + 1]] = False
    go_on = [follower for k, follower in enumerate(followers) if k not in ended]
    return go_on, replace(placed, support=replace(placed.support, shown=shown))


def _is_younger(other: Follower, follower: Follower) -> bool:
    """Whether a seen stroke was born since another went into hiding."""
    born_since = other.life.id > follower.life.id and len(other.life.rows) - 1 <= follower.unseen
    return born_since and not other.unseen


def _of(placed: Placement, stroke: int) -> NDArray[np.float64]:
    return placed.positions[placed.nodes.starts[stroke] : placed.nodes.starts[stroke + 1]]


def _covers(wide: NDArray[np.float64], narrow: NDArray[np.float64], reach: float) -> bool:
    """Whether most of some nodes lie at others, which are two or four px apart."""
    gap = np.linalg.norm(narrow[:, None] - wide, axis=2).min(axis=1)
    return bool(np.mean(gap <= reach + 2.0) > 0.7)
