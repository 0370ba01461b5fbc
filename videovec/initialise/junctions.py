"""Which branches of a junction are one stroke, and how sure that is."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache

import numpy as np
from numpy.typing import NDArray

from videovec.initialise.arrangement import arrange
from videovec.initialise.graph import Graph
from videovec.initialise.junction_features import describe
from videovec.initialise.junction_net import load_nets, score_pairs
from videovec.initialise.polyline import angle_between, direction, end_tangent
from videovec.initialise.prune import Widths

__all__ = ["Pairing", "Pairs", "choose", "decisions", "matchings", "pair_branches", "pair_by_net", "turns"]

Floats = NDArray[np.float64]
End = tuple[int, int]
Pairs = tuple[tuple[int, int], ...]

_SKIP = 0.45  # widths next to a junction in which thinning bends a line
_LEAST_SKIP = 1.0  # px
_REACH = 3.0  # widths over which its direction is told
_LEAST_REACH = 6.0  # px
_MOST_ARMS = 7  # beyond so many branches all matchings are too many to try
_DEGREES_PER_LOGIT = 25.0  # by which a decision by turns is e times likelier to be right


@dataclass(frozen=True, slots=True)
class Pairing:
    """The decision taken at a node.

    Args:
        node: The node.
        ends: Its branch ends, as (branch, 0 for start or 1 for stop).
        links: Pairs of positions in ``ends`` that are one stroke each.
        runner_up: The next best decision.
        log_odds: Logarithm of the odds that the decision is right; 0 where it is as likely wrong.
    """

    node: int
    ends: tuple[End, ...]
    links: Pairs
    runner_up: Pairs
    log_odds: float


def _pairings_of(arms: tuple[int, ...]) -> Iterator[Pairs]:
    """All ways to pair some of the arms, every arm at most once."""
    if len(arms) < 2:
        yield ()
        return
    head, rest = arms[0], arms[1:]
    yield from _pairings_of(rest)
    for other in rest:
        for pairs in _pairings_of(tuple(arm for arm in rest if arm != other)):
            yield ((head, other), *pairs)


@cache
def matchings(count: int) -> tuple[Pairs, ...]:
    """All ways to pair some of so many arms."""
    return tuple(_pairings_of(tuple(range(count))))


@cache
def decisions(count: int) -> tuple[Pairs, ...]:
    """What the network chooses from: all matchings, but where three or more arms meet at least one line runs on.

    A hundredth of the junctions of drawings are ends of all their arms, and far more of those that are taken for it are
    not.
    """
    return matchings(count) if count < 3 else tuple(pairs for pairs in matchings(count) if pairs)


@cache
def _incidence(count: int) -> Floats:
    """Which pairs each decision about so many arms has. [M, count^2]"""
    which = np.zeros((len(decisions(count)), count, count))
    for row, pairs in zip(which, decisions(count), strict=True):
        for i, j in pairs:
            row[i, j] = 1.0
    return which.reshape(len(which), -1)


def _greedy(gain: Floats) -> Pairs:
    """The pairs of largest gain, one after the other."""
    count = len(gain)
    pairs: list[tuple[int, int]] = []
    free = set(range(count))
    for flat in np.argsort(-gain, axis=None, kind="stable"):
        i, j = divmod(int(flat), count)
        if i < j and i in free and j in free and gain[i, j] > 0.0:
            pairs.append((i, j))
            free -= {i, j}
    return tuple(pairs)


def _ranked(gain: Floats) -> tuple[Pairs, ...]:
    """All matchings, those of the largest sum of gains first."""
    every = matchings(len(gain))
    total = np.array([sum(gain[i, j] for i, j in pairs) for pairs in every])
    return tuple(every[k] for k in np.argsort(-total, kind="stable"))


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


def _by_turn(cost: Floats, max_turn: float) -> tuple[Pairs, Pairs, float]:
    """Best and second best matching, and how much less the best one turns. degrees"""
    gain = np.cos(np.radians(cost)) - np.cos(np.radians(max_turn))
    if len(cost) > _MOST_ARMS:
        return _greedy(gain), (), 0.0
    ranked = _ranked(gain)
    best, second = ranked[0], ranked[1] if len(ranked) > 1 else ()
    worst = [
        max((cost[i, j] for i, j in set(a) - set(b)), default=max_turn) for a, b in ((best, second), (second, best))
    ]
    return best, second, max(0.0, float(worst[1] - worst[0]))


def pair_branches(graph: Graph, widths: Widths, max_turn: float, taken: frozenset[int] = frozenset()) -> list[Pairing]:
    """Decide at every junction which branches run on into which, by how much they would turn.

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
        best, second, margin = _by_turn(turns(lines, widths.at(graph, node)), max_turn)
        pairings.append(Pairing(node, ends, best, second, margin / _DEGREES_PER_LOGIT))
    return pairings


def _free_ends(graph: Graph, node: int, taken: frozenset[int]) -> tuple[End, ...]:
    """The branch ends at a node, without those of branches that are taken."""
    return tuple(end for end in graph.ends_at(node) if end[0] not in taken)


def choose(score: Floats) -> tuple[Pairs, Pairs, float]:
    """The likeliest decision about K arms, the second, and the log-odds of the first, if the log-probability of each is
    the sum of its pairs' scores up to a constant.

    Args:
        score: Of each pair. [K, K]
    """
    if len(score) > _MOST_ARMS:
        return _greedy(score), (), 0.0
    every, total = decisions(len(score)), _incidence(len(score)) @ score.reshape(-1)
    first, second = np.argsort(-total, kind="stable")[:2].tolist()
    rivals = np.delete(total, first) - total[first]
    return every[first], every[second], -float(np.logaddexp.reduce(rivals))


def pair_by_net(graph: Graph, widths: Widths, taken: frozenset[int] = frozenset()) -> list[Pairing]:
    """Decide at every junction which branches run on into which, as networks learned it from drawings.

    Args:
        graph: A clean skeleton graph.
        widths: How wide lines are.
        taken: Branches of which it is known already.

    Returns:
        One decision for each node with two or more branch ends that are not taken.
    """
    if not graph.branches:
        return []
    drawn = arrange(graph, widths)
    scores = score_pairs(load_nets(), drawn, describe(drawn))
    index = {end: number for number, end in enumerate(drawn.ends)}
    of_pair = dict(zip(map(tuple, drawn.pairs.tolist()), scores.tolist(), strict=True))
    pairings = []
    for node in graph.nodes():
        ends = _free_ends(graph, node, taken)
        if len(ends) < 2:
            continue
        score = np.zeros((len(ends), len(ends)))
        for i, one in enumerate(ends):
            for j in range(i):
                pair = index[one], index[ends[j]]
                score[i, j] = score[j, i] = of_pair[pair] if pair in of_pair else of_pair[pair[::-1]]
        pairings.append(Pairing(node, ends, *choose(score)))
    return pairings
