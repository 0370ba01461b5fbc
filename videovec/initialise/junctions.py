"""Which branches of a junction are one stroke."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from videovec.initialise.graph import Graph
from videovec.initialise.polyline import angle_between, direction, end_tangent
from videovec.initialise.prune import Widths

__all__ = ["Pairing", "pair_branches"]

Floats = NDArray[np.float64]
End = tuple[int, int]
Pairs = tuple[tuple[int, int], ...]

_SKIP = 0.45  # widths next to a junction in which thinning bends a line
_LEAST_SKIP = 1.0  # px
_REACH = 3.0  # widths over which its direction is told
_LEAST_REACH = 6.0  # px
_MOST_ARMS = 7  # beyond so many branches all matchings are too many to try


@dataclass(frozen=True, slots=True)
class Pairing:
    """The decision taken at a node.

    Args:
        node: The node.
        ends: Its branch ends, as (branch, 0 for start or 1 for stop).
        links: Pairs of positions in ``ends`` that are one stroke each.
        runner_up: The next best decision.
        margin: By how much the decision is better, as a turn. degrees
    """

    node: int
    ends: tuple[End, ...]
    links: Pairs
    runner_up: Pairs
    margin: float


def _matchings(arms: tuple[int, ...]) -> Iterator[Pairs]:
    """All ways to pair some of the arms, every arm at most once."""
    if len(arms) < 2:
        yield ()
        return
    head, rest = arms[0], arms[1:]
    yield from _matchings(rest)
    for other in rest:
        for pairs in _matchings(tuple(arm for arm in rest if arm != other)):
            yield ((head, other), *pairs)


def turns(lines: list[Floats], width: float) -> Floats:
    """How much a stroke turns that comes along one line and leaves along another.

    The larger of two readings: the turn between the tangents at the junction, and its mean with the angles between each
    tangent and the chord of the other, which grow when a line curves away behind a good tangent.

    Args:
        lines: Samples of each branch from the junction outwards. K times [M, 2] px
        width: Width of the lines. px

    Returns:
        Turn for each pair, degrees, 180 on the diagonal. [K, K]
    """
    skip, reach = max(_SKIP * width, _LEAST_SKIP), max(_REACH * width, _LEAST_REACH)
    tangents = [end_tangent(line, skip, reach) for line in lines]
    chords = [direction(line, skip, skip + reach) for line in lines]
    cost = np.full((len(lines), len(lines)), 180.0)
    for i in range(len(lines)):
        for j in range(i):
            turn = angle_between(tangents[i], -tangents[j])
            one, two = angle_between(chords[i], -tangents[j]), angle_between(tangents[i], -chords[j])
            cost[i, j] = cost[j, i] = max(turn, (turn + one + two) / 3.0)
    return cost


def _decide(cost: Floats, max_turn: float) -> tuple[Pairs, Pairs, float]:
    """Best and second best matching and the margin between them, as a difference of turns in degrees."""
    count = len(cost)
    gain = np.cos(np.radians(cost)) - np.cos(np.radians(max_turn))
    if count > _MOST_ARMS:
        pairs: list[tuple[int, int]] = []
        free = set(range(count))
        for flat in np.argsort(-gain, axis=None, kind="stable"):
            i, j = divmod(int(flat), count)
            if i < j and i in free and j in free and gain[i, j] > 0.0:
                pairs.append((i, j))
                free -= {i, j}
        return tuple(pairs), (), 0.0
    ranked = sorted(
        (pairs for pairs in _matchings(tuple(range(count)))), key=lambda pairs: -sum(gain[i, j] for i, j in pairs)
    )
    best, second = ranked[0], ranked[1] if len(ranked) > 1 else ()
    worst = [
        max((cost[i, j] for i, j in set(a) - set(b)), default=max_turn) for a, b in ((best, second), (second, best))
    ]
    return best, second, max(0.0, float(worst[1] - worst[0]))


def pair_branches(graph: Graph, widths: Widths, max_turn: float) -> list[Pairing]:
    """Decide at every junction which branches run on into which.

    Args:
        graph: A clean skeleton graph.
        widths: How wide lines are.
        max_turn: Largest turn within a stroke. degrees

    Returns:
        One decision for each node with two or more branch ends.
    """
    pairings = []
    for node in graph.nodes():
        ends = tuple(graph.ends_at(node))
        if len(ends) < 2:
            continue
        lines = [graph.outward(*end).line for end in ends]
        best, second, margin = _decide(turns(lines, widths.at(graph, node)), max_turn)
        pairings.append(Pairing(node, ends, best, second, margin))
    return pairings
