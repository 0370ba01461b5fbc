"""Where the hidden parts of strokes are: carried along by what they moved with since they were last seen whole."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from videovec.curves import arc_length
from videovec.propagate.nodes import Nodes
from videovec.propagate.record import Interval, Life
from videovec.propagate.support import Support

__all__ = ["Hold", "predict_hidden"]

Floats = NDArray[np.float64]
Complexes = NDArray[np.complex128]

_WHOLE = 0.95
"""Share of the most that was ever seen of a stroke from which on it was seen whole."""
_LESS = 4.0
"""Length that is missing of a stroke that is partly hidden. working px"""
_RANGE = 40.0
"""Distance at which other strokes have half of their say. working px"""
_TOLERANCES = (24.0, 12.0, 6.0, 4.0)
"""Misfits, one after the other, at which a node has a quarter of its say. working px"""
_AGREES = 4.0
"""Distance within which a prediction agrees with what is seen of the stroke. working px"""
_LEAP = 16.0
"""Motion between two drawings, or change of it, up to which a prediction is believed. working px"""
_OWN = 0.5
"""Say of a stroke's own seen nodes, which may have slid along it."""
_RATHER = 4.0
"""Say of all of them against that of all others, if the stroke is seen whole."""
_STEPS = 3
"""Steps before a stroke was hidden in which what moved otherwise is told from what moved alike."""
_OTHERWISE = 6.0
"""Motion against a stroke, in one step, at which another has a quarter of its say. px"""
_STEADY = 0.05
"""Say of its turn so far, and of no change of size, in the spread of its nodes when all of them have a say of 1."""
_FEWEST = 4.0
"""Sum of says below which nothing is known."""
_FIRM = 10.0
"""Stiffness of what stays where it is, against 1 of the ink's."""
_SEEN, _UNSEEN = 0.1, 0.4
"""Stiffness of the pull of a prediction on seen and on hidden nodes of a stroke, against 1 of the ink's."""


@dataclass(frozen=True, slots=True, eq=False)
class Hold:
    """Where some nodes are expected.

    Args:
        goal: The places. [N, 2] working px
        stiffness: How much each is pulled there; 0 where nothing is expected. [N]
    """

    goal: Floats
    stiffness: Floats

    def staying(self, positions: Floats, which: NDArray[np.bool_]) -> Hold:
        """The same, with some nodes held firmly where they are."""
        stiffness = np.where(which, _FIRM, self.stiffness)
        return Hold(np.where(which[:, None], positions, self.goal), stiffness)

    def resting(self, positions: Floats, seen: NDArray[np.bool_]) -> Hold:
        """The same, with nodes of which nothing is expected drawn to where they are."""
        free = self.stiffness == 0
        stiffness = np.where(free, np.where(seen, _SEEN, _UNSEEN), self.stiffness)
        return Hold(np.where(free[:, None], positions, self.goal), stiffness)


def predict_hidden(
    lives: list[Life],
    nodes: Nodes,
    positions: Floats,
    support: Support,
    step: tuple[int, int, float],
    front: NDArray[np.bool_],
) -> Hold:
    """Predict the strokes of which less is seen than before.

    Their neighbours' motion since then, as far as it agrees with their own so far, is fitted by a similarity. What
    hides them moves otherwise, and has no say.

    Args:
        lives: S lives.
        nodes: Their nodes.
        positions: Where those are on the drawing. [N, 2] working px
        support: What is seen of them there.
        step: The drawing that they come from, the drawing, and working px for each px.
        front: Strokes that hide others, which have no say. bool [S]

    Returns:
        Where the nodes of these strokes are expected.
    """
    before, after, scale = step
    goal, stiffness = positions.copy(), np.zeros(len(nodes))
    follows = support.shown
    for s, life in enumerate(lives):
        home = _home(life, before)
        own = slice(int(nodes.starts[s]), int(nodes.starts[s + 1]))
        if home is None or not _is_less(life, home, support.visible[s], scale):
            continue
        then = _nodes_at(lives, nodes, home, scale)
        guess = scale * nodes.bases[s].weights @ life.rows[before].points
        alike = (_moved_alike(lives, s, home) * ~front)[nodes.stroke]
        motion = _common_motion(then, positions, (follows & support.node, own), (guess, alike))
        if motion is None:
            continue
        z = motion[0] * _complex(then[own]) + motion[1]
        own_misfit = np.abs(z - _complex(positions[own]))[follows[own]]
        earlier = life.rows.get(2 * before - after, life.rows[before]).points
        onward = guess + scale * nodes.bases[s].weights @ (life.rows[before].points - earlier)
        leap = min(np.mean(np.abs(z - _complex(place))) for place in (guess, onward))
        if leap <= _LEAP and (not len(own_misfit) or np.median(own_misfit) <= _AGREES):
            goal[own] = np.stack([z.real, z.imag], axis=1)
            stiffness[own] = np.where(follows[own], _SEEN, _UNSEEN)
    return Hold(goal, stiffness)


def _home(life: Life, before: int) -> int | None:
    """The drawing nearest to the last one on which the stroke was seen whole."""
    seen = {d: row.seen for d, row in life.rows.items()}
    most = max(seen.values())
    whole = [d for d, part in seen.items() if part >= _WHOLE * most] if most > 0 else []
    return min(whole, key=lambda d: abs(d - before), default=None)


def _is_less(life: Life, home: int, parts: tuple[Interval, ...], scale: float) -> bool:
    row = life.rows[home]
    missing = row.seen - sum(end - begin for begin, end in parts)
    return missing * scale * arc_length(row.points) > _LESS or (missing > 0 and not parts)


def _nodes_at(lives: list[Life], nodes: Nodes, drawing: int, scale: float) -> Floats:
    """Where the nodes of all strokes were; NaN for those that were not seen. [N, 2] working px"""
    then = np.full((len(nodes), 2), np.nan)
    for s, life in enumerate(lives):
        row = life.rows.get(drawing)
        if row is not None and row.visible[1] > row.visible[0]:
            then[nodes.starts[s] : nodes.starts[s + 1]] = scale * nodes.bases[s].weights @ row.points
    return then


def _moved_alike(lives: list[Life], stroke: int, home: int) -> Floats:
    """How far strokes moved as one of them did in the steps before it was hidden: 1 as it did, 0 otherwise. [S]"""
    alike = np.ones(len(lives))
    rows = lives[stroke].rows
    for step in (-1, 1):
        for k in range(_STEPS):
            a, b = home + step * (k + 1), home + step * k
            if a not in rows or b not in rows or min(rows[a].seen, rows[b].seen) < _WHOLE * rows[home].seen:
                break
            own = rows[b].points.mean(0) - rows[a].points.mean(0)
            for t, other in enumerate(lives):
                if a in other.rows and b in other.rows and other.rows[a].parts and other.rows[b].parts:
                    gap = np.linalg.norm(other.rows[b].points.mean(0) - other.rows[a].points.mean(0) - own)
                    alike[t] = min(alike[t], 1.0 / (1.0 + (float(gap) / _OTHERWISE) ** 2) ** 2)
    return alike


def _common_motion(
    then: Floats, now: Floats, who: tuple[NDArray[np.bool_], slice], hints: tuple[Floats, Floats]
) -> tuple[complex, complex] | None:
    """Factor and shift of the similarity by which a stroke and what agrees with it have moved.

    Args:
        then: Where all nodes were; NaN if that is not known. [N, 2] working px
        now: Where they are. [N, 2] working px
        who: Nodes that are seen [N], and those of the stroke.
        hints: A guess at where the stroke is [n, 2] working px, and how much each node has a say [N].
    """
    (seen, own), (guess, alike) = who, hints
    known = seen & np.isfinite(then[:, 0])
    is_own = np.zeros(len(then), bool)
    is_own[own] = True
    target = then[own]
    low, high = target.min(axis=0), target.max(axis=0)
    gap = np.linalg.norm(np.maximum(0.0, np.maximum(low - then[known], then[known] - high)), axis=1)
    say = np.where(is_own[known], 0.0, alike[known] / (1.0 + (gap / _RANGE) ** 2))
    share = float(is_own[known].sum() / max(len(target), 1))
    say[is_own[known]] = max(_OWN, _RATHER * share * float(say.sum()) / max(int(is_own[known].sum()), 1))
    a, b = _complex(then[known]), _complex(now[known])
    factor, shift = _similarity(_complex(target), _complex(guess), np.ones(len(target)))
    spread = float(np.square(target - target.mean(axis=0)).sum()) if share > 0 else 0.0
    steady = _STEADY * spread, factor / max(abs(factor), 1e-9)
    for tolerance in _TOLERANCES:
        misfit = np.abs(factor * a + shift - b)
        weight = say / (1.0 + (misfit / tolerance) ** 2) ** 2
        if weight.sum() < _FEWEST:
            return None
        factor, shift = _similarity(a, b, weight, steady)
    return factor, shift


def _similarity(
    a: Complexes, b: Complexes, weight: Floats, steady: tuple[float, complex] = (0.0, 1.0)
) -> tuple[complex, complex]:
    """Factor and shift that best take points to others; ``steady`` is a factor to rather keep to, and how much."""
    total = weight.sum()
    middle_a, middle_b = (weight @ a) / total, (weight @ b) / total
    spread = float(weight @ np.abs(a - middle_a) ** 2) + steady[0]
    turned = complex((weight * np.conj(a - middle_a)) @ (b - middle_b)) + steady[0] * steady[1]
    factor = turned / spread if spread > 1e-9 else 1.0 + 0.0j
    return factor, complex(middle_b - factor * middle_a)


def _complex(points: Floats) -> Complexes:
    return np.asarray(points[:, 0] + 1j * points[:, 1])
