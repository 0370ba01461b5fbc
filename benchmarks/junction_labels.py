"""Which branches of a junction truly are one stroke: those along which one true stroke passes through it."""

from __future__ import annotations

from dataclasses import dataclass

import numba
import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from videovec.initialise.graph import Graph
from videovec.initialise.junctions import Pairs, matchings
from videovec.initialise.polyline import arc, at_arc
from videovec.initialise.prune import Widths

__all__ = ["STEP", "Known", "label"]

Floats = NDArray[np.float64]
Ints = NDArray[np.intp]

STEP = 0.5
"""Between samples of true strokes. px"""
MOST_ARMS = 7
"""Of junctions that are learned from."""
DOUBTFUL = 0.6
"""How well a second matching may fit the truth, as a share of the best one's fit."""


@dataclass(frozen=True, slots=True, eq=False)
class Known:
    """A junction and its true matching.

    Args:
        node: The node.
        ends: Its branch ends.
        links: Pairs of positions in ``ends`` that are one true stroke.
        is_clear: Whether the truth tells: every arm lies on a stroke, and no other matching fits nearly as well.
    """

    node: int
    ends: tuple[tuple[int, int], ...]
    links: Pairs
    is_clear: bool


@dataclass(frozen=True, slots=True, eq=False)
class _Arm:
    """Samples of a branch away from its junction, and how far along it they are. [M, 2], [M] px"""

    points: Floats
    along: Floats


@dataclass(frozen=True, slots=True, eq=False)
class _Truth:
    """All true strokes: their samples [N, 2], the stroke of each [N], where each begins, and which are closed."""

    lines: list[Floats]
    tree: cKDTree
    owner: Ints
    first: Ints
    closed: list[bool]

    @staticmethod
    def of(lines: list[Floats]) -> _Truth:
        sizes = [len(line) for line in lines]
        closed = [len(line) > 8 and bool(np.linalg.norm(line[0] - line[-1]) < 0.75) for line in lines]
        owner = np.repeat(np.arange(len(lines)), sizes)
        return _Truth(lines, cKDTree(np.concatenate(lines)), owner, np.cumsum([0, *sizes]), closed)

    def passes(self, position: Floats, reach: float) -> list[tuple[int, int]]:
        """Strokes that come near a place, each time they do, and their nearest sample."""
        near = np.sort(np.array(self.tree.query_ball_point(position, reach), np.intp))
        found = []
        for stroke in np.unique(self.owner[near]).tolist():
            line = self.lines[stroke]
            own = near[self.owner[near] == stroke] - self.first[stroke]
            runs = np.split(own, np.flatnonzero(np.diff(own) > 1) + 1)
            if self.closed[stroke] and len(runs) > 1 and runs[0][0] == 0 and runs[-1][-1] == len(line) - 1:
                runs[0] = np.concatenate([runs[-1] - len(line) + 1, runs[0]])
                runs.pop()
            found += [(stroke, int(r[np.argmin(np.linalg.norm(line[r] - position, axis=1))])) for r in runs]
        return found

    def onward(self, stroke: int, start: int, sign: int, length: float) -> Floats:
        """Samples of a stroke from one of them on."""
        line = self.lines[stroke]
        where = start + sign * np.arange(int(length / STEP))
        if self.closed[stroke]:
            return line[where[: len(line) - 1] % (len(line) - 1)]
        return line[where[(where >= 0) & (where < len(line))]]


@numba.njit(cache=True)
def _followed(points: Floats, along: Floats, stroke: Floats, slack: float, tolerance: float) -> float:
    """How far along an arm a stroke stays on it, without a detour. px"""
    last = 0.0
    for k in range(len(along)):
        is_near = False
        for m in range(min(len(stroke), int((1.6 * along[k] + slack) / STEP) + 1)):
            if (points[k, 0] - stroke[m, 0]) ** 2 + (points[k, 1] - stroke[m, 1]) ** 2 <= tolerance**2:
                is_near = True
                break
        if not is_near:
            return last
        last = along[k]
    return last


def _arm(line: Floats, width: float) -> _Arm:
    total = float(arc(line)[-1])
    stop = min(total, max(7 * width, 14.0))
    along = np.linspace(min(0.7 * width, 0.5 * total), stop, max(4, int(stop)))
    return _Arm(at_arc(line, along), along)


def _support(truth: _Truth, position: Floats, arms: list[_Arm], reach: float, width: float) -> tuple[Floats, Floats]:
    """How far true strokes follow each pair of arms [K, K], and each arm [K]. px"""
    count = len(arms)
    pairs, single = np.zeros((count, count)), np.zeros(count)
    needed = np.array([min(0.9 * arm.along[-1], 2.2 * width) for arm in arms])
    longest = 1.6 * max(7 * width, 14.0) + 3 * width + reach
    for stroke, start in truth.passes(position, reach):
        extent = np.zeros((count, 2))
        for way, sign in enumerate((1, -1)):
            onward = truth.onward(stroke, start, sign, longest)
            if len(onward) < 2:
                continue
            for k, arm in enumerate(arms):
                extent[k, way] = _followed(arm.points, arm.along, onward, 2 * width + reach, 0.3 * width + 0.8)
        follows = extent >= needed[:, None]
        single = np.maximum(single, (extent * follows).max(axis=1))
        both = follows[:, None, 0] & follows[None, :, 1] & ~np.eye(count, dtype=bool)
        one, two = extent[:, None, 0], extent[None, :, 1]
        fit = np.where(both, np.minimum(one, two) + 0.25 * np.maximum(one, two), 0.0)
        pairs = np.maximum(pairs, np.maximum(fit, fit.T))
    return pairs, single


def _best(pairs: Floats) -> tuple[Pairs, float]:
    """The matching that fits the truth best, and how well another fits, as a share of that."""

    def total(matching: Pairs) -> float:
        return float(sum(pairs[i, j] for i, j in matching))

    ranked = sorted(matchings(len(pairs)), key=lambda matching: -total(matching))
    best = ranked[0]
    if total(best) <= 0.0:
        return best, 0.0
    real = [m for m in ranked[1:] if all(pairs[i, j] > 0 for i, j in m) and not set(m) < set(best)]
    return best, max((total(m) for m in real), default=0.0) / total(best)


def label(graph: Graph, widths: Widths, lines: list[Floats]) -> tuple[Known, ...]:
    """The true matching of every junction of two to seven arms.

    Args:
        graph: The traced drawing.
        widths: How wide its lines are.
        lines: Its true strokes, ``STEP`` between samples. px
    """
    truth = _Truth.of(lines)
    found = []
    for node in graph.nodes():
        ends = tuple(graph.ends_at(node))
        if not 2 <= len(ends) <= MOST_ARMS:
            continue
        width, position = widths.at(graph, node), graph.position[node]
        branches = [graph.outward(*end).line for end in ends]
        reach = max(1.3 * width, 2.0) + max(float(np.linalg.norm(line[0] - position)) for line in branches)
        pairs, single = _support(truth, position, [_arm(line, width) for line in branches], reach, width)
        best, rival = _best(pairs)
        found.append(Known(node, ends, best, bool(rival < DOUBTFUL and (single > 0).all())))
    return tuple(found)
