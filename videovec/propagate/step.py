"""One walk over the drawings, forwards or backwards, with all lives that are open."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from videovec.propagate.follower import Follower
from videovec.propagate.front import covering, ends_missing
from videovec.propagate.momentum import PATIENCE, Momentum, momentum_of
from videovec.propagate.nodes import Nodes, gather
from videovec.propagate.placing import Found, emerging, find, settled
from videovec.propagate.predict import Hold, predict_hidden
from videovec.propagate.record import Row, bind
from videovec.propagate.refine import refine
from videovec.propagate.registration import Source, recall, source_of
from videovec.propagate.split import split_at_gaps
from videovec.propagate.squeezed import opened, squeezed
from videovec.propagate.stretch import stretched
from videovec.propagate.support import SEEN, Inks, Past, Support, find_support
from videovec.propagate.target import Target
from videovec.settings import PropagateSettings
from videovec.strokes import Strokes

__all__ = ["Placement", "carry"]

Floats = NDArray[np.float64]
Bools = NDArray[np.bool_]

_SHORT = 0.5
"""Share of a stroke up to which it may be seen on one drawing for any less of it to be the stroke on the next."""
_MOST = 0.7
"""Share of a stroke that must be seen for it to be squeezed on the next drawing; else it is hidden by something."""

_FAR = 12.0
"""How far the fastest tenth of nodes must go for strokes to be looked at again once they are refined. working px"""
_REACHED = 3
"""Nodes by which more must be seen of a refined stroke, unless a gap has closed."""


@dataclass(frozen=True, slots=True, eq=False)
class Placement:
    """Strokes after a step: N nodes, where they are [N, 2], what is seen, and each stroke's half-width [S]."""

    nodes: Nodes
    positions: Floats
    support: Support
    half_width: Floats


def carry(
    followers: list[Follower],
    coverage: NDArray[np.uint8],
    step: tuple[int, int],
    targets: tuple[Target, Target],
    settings: PropagateSettings,
    grows: bool = False,
) -> Placement:
    """Take all lives from one drawing to the next and write their rows.

    Args:
        followers: The lives; each has a row on the drawing that it comes from.
        coverage: Ink of the drawing that they go to. uint8 [H, W]
        step: The drawing that the strokes come from, and the one that they go to.
        targets: Both drawings, prepared.
        settings: How.
        grows: Whether less of the strokes may be drawn there.

    Returns:
        Where the strokes are now.
    """
    before, after = step
    scale = targets[1].scale
    nodes = gather([follower.basis for follower in followers])
    rows = [follower.life.rows[before] for follower in followers]
    points = _stacked([row.points for row in rows])
    half_width = scale * np.array([follower.half_width(before) for follower in followers])
    here = source_of(nodes, scale * nodes.positions(points), targets[0], _seen(nodes, rows))
    front = np.array([follower.life.covers for follower in followers], bool)
    momentum = _momentum(followers, _others(here, front), half_width, grows)
    source = here if grows else _at_rest(followers, here, momentum, scale)
    velocity = _stacked([follower.velocity for follower in followers])
    onward = momentum.goal, source.rest + velocity
    found = find(source, (here.rest, *onward), (front, half_width), targets, velocity, grows)
    past = _past(followers, rows, (momentum, onward[1]), grows | found.little)
    support = find_support(nodes, found.positions, half_width, found.ink, past)
    hold = predict_hidden([f.life for f in followers], nodes, found.positions, support, (before, after, scale), front)
    hold = hold.resting(source.rest, support.shown) if found.positions is source.rest else hold
    rest, positions, stays = source.rest, found.positions, grows and found.positions is source.rest
    ink, squeezes = found.ink, dict[int, Floats]()
    if not stays:
        if not grows:
            rest = stretched(nodes, rest, positions, support.follows(), momentum.merged)
        ink, positions, support = _settled(found, rest, half_width, support, (_held(hold, momentum), past))
        whole = _whole(followers, rows, front | found.little | grows, scale)
        squeezes = squeezed(nodes, positions, support, half_width, ink.own, whole)
    if squeezes:
        rest, positions = (_replaced(nodes, places, squeezes) for places in (rest, positions))
        support = find_support(nodes, positions, half_width, ink, past)
    strokes = _placed(followers, rows, nodes.moved(points, positions / scale), support)
    if not stays:
        strokes = _refined(strokes, nodes.moved(points, rest / scale), coverage, settings)
    positions = scale * nodes.positions(strokes.points[: len(points)])
    went = np.linalg.norm(positions - here.rest, axis=1)
    if not (stays or support.shown.all()) and np.percentile(went, 90.0) > _FAR:
        support = _fuller(nodes, support, find_support(nodes, positions, half_width, ink, past))
    missing = ends_missing(nodes, positions, support.shown, past.most_seen)
    covers = covering(nodes, positions, half_width, support.shown, missing) & (not grows)
    for s, (follower, row) in enumerate(zip(followers, rows, strict=True)):
        own = slice(int(nodes.starts[s]), int(nodes.starts[s + 1]))
        now = replace(row, points=strokes.points_of(s), confidence=float(support.share[s]))
        follower.life.rows[after] = now.showing(support.visible[s])
        follower.shape = rest[own] / scale
        follower.velocity = positions[own] - source.rest[own]
        follower.unseen = 0 if support.visible[s] else follower.unseen + 1
        follower.go_on(positions[own], here.rest[own], momentum.is_blind(own))
        follower.drift = np.zeros_like(follower.drift) if s in squeezes else follower.drift
        follower.open = None if follower.open is None else opened(follower.open, positions[own] / scale)
        follower.waited = int(momentum.waits[s])
        follower.life.covers |= bool(covers[s])
    return Placement(nodes, positions, support, half_width)


def _settled(
    found: Found, rest: Floats, half_width: Floats, support: Support, known: tuple[Hold, Past]
) -> tuple[Inks, Floats, Support]:
    """Settle strokes, and hidden parts of them on ink around them if more is seen then.

    Args:
        found: Where they went.
        rest: Where they are at rest. [N, 2] working px
        half_width: Of each stroke. [S] working px
        support: What is seen of them.
        known: What holds nodes, and what was known of strokes before.

    Returns:
        The ink as it is divided now, where nodes are [N, 2], and what is seen of them.
    """
    nodes, (hold, past) = found.loose.nodes, known
    ink, positions = settled(found, rest, half_width, support, hold)
    support = find_support(nodes, positions, half_width, ink, past)
    out = emerging(nodes, positions, half_width, support, ink) if ink.front.any() else None
    if out is None:
        return ink, positions, support
    anew, moved = settled(replace(found, positions=positions), rest, half_width, out, hold)
    again = find_support(nodes, moved, half_width, anew, past)
    return (anew, moved, again) if again.shown.sum() > support.shown.sum() else (ink, positions, support)


def _whole(followers: list[Follower], rows: list[Row], apart: Bools, scale: float) -> list[Floats | None]:
    """The closed strokes that were seen, with nothing passing over them, as they are when they are open.

    Args:
        followers: All lives.
        rows: What they were.
        apart: Strokes that something passed over, or in front. bool [S]
        scale: Working px for each px.
    """
    may = [not out and row.seen >= _MOST for out, row in zip(apart, rows, strict=True)]
    return [scale * f.open if ok and f.open is not None else None for f, ok in zip(followers, may, strict=True)]


def _replaced(nodes: Nodes, positions: Floats, places: dict[int, Floats]) -> Floats:
    """Positions of nodes [N, 2] with those of some strokes instead."""
    positions = positions.copy()
    for s, place in places.items():
        positions[nodes.starts[s] : nodes.starts[s + 1]] = place
    return positions


def _stacked(parts: list[Floats]) -> Floats:
    """Arrays of points as one. [N, 2]"""
    return np.concatenate([np.zeros((0, 2)), *parts])


def _past(followers: list[Follower], rows: list[Row], onward: tuple[Momentum, Floats], little: Bools) -> Past:
    """What is known of strokes.

    ``onward`` are their momentum, and where nodes would be by the last step; ``little`` says of which strokes any bit
    may be all that is seen.
    """
    most_seen = np.array([follower.life.most_seen for follower in followers]).reshape(-1, 2)
    least = np.array([0.0 if 0.0 < row.seen <= _SHORT else SEEN for row in rows])
    least[little] = 0.0
    return Past(most_seen, least, onward[0].merged, onward[1])


def _others(here: Source, front: Bools) -> Source:
    """The strokes without those in front: ink that runs together with an edge is the edge's."""
    return replace(here, weight=np.where(front[here.nodes.stroke], 0.0, here.weight))


def _momentum(followers: list[Follower], here: Source, half_width: Floats, grows: bool) -> Momentum:
    """How strokes would go on; those that are followed back to their birth have nothing to go on from."""
    waited = np.array([PATIENCE if grows else follower.waited for follower in followers], np.intp)
    return momentum_of(here, _stacked([follower.drift for follower in followers]), half_width, waited)


def _at_rest(followers: list[Follower], here: Source, momentum: Momentum, scale: float) -> Source:
    """The strokes in their remembered shape; those that go on as they went are at rest where they are expected."""
    source = recall(here, scale * _stacked([follower.shape for follower in followers]))
    rest = np.where(momentum.moves[here.nodes.stroke][:, None], momentum.goal, source.rest)
    weight = np.where(momentum.merged, 0.0, source.weight)
    return replace(source, rest=rest, weight=weight, hold=momentum.hold(), goal=rest)


def _held(hold: Hold, momentum: Momentum) -> Hold:
    """What holds hidden nodes, and those that are not told apart."""
    goal = np.where(momentum.merged[:, None], momentum.goal, hold.goal)
    return Hold(goal, np.where(momentum.merged, momentum.hold(), hold.stiffness))


def _seen(nodes: Nodes, rows: list[Row]) -> Floats:
    """1 for nodes in a seen part of their stroke, else 0. [N]"""
    seen = np.zeros(len(nodes))
    for s, row in enumerate(rows):
        own = slice(int(nodes.starts[s]), int(nodes.starts[s + 1]))
        for begin, end in row.parts:
            seen[own] += (nodes.u[own] >= begin) & (nodes.u[own] <= end)
    return np.minimum(seen, 1.0)


def _fuller(nodes: Nodes, support: Support, again: Support) -> Support:
    """Of two looks at strokes, the second where it shows more: refined, it has reached its ink."""
    gained = np.bincount(nodes.stroke, again.shown.astype(float) - support.shown, minlength=len(nodes.bases))
    closed = np.array([0 < len(b) < len(a) for a, b in zip(support.visible, again.visible, strict=True)], bool)
    more = (gained >= _REACHED) | (closed & (gained > 0))
    of_node, pairs = more[nodes.stroke], zip(again.visible, support.visible, strict=True)
    return Support(
        node=np.where(of_node, again.node, support.node),
        shown=np.where(of_node, again.shown, support.shown),
        visible=tuple(pair[0] if is_more else pair[1] for pair, is_more in zip(pairs, more, strict=True)),
        share=np.where(more, again.share, support.share),
        claimed=np.where(of_node, again.claimed, support.claimed),
    )


def _placed(followers: list[Follower], rows: list[Row], points: Floats, support: Support) -> Strokes:
    """The strokes where they are now, as strokes of drawing 0; their parts beyond gaps come last."""
    ends = np.cumsum([0, *(len(row.points) for row in rows)])
    lives = []
    for s, (follower, row) in enumerate(zip(followers, rows, strict=True)):
        now = replace(row, points=points[ends[s] : ends[s + 1]]).showing(support.visible[s])
        lives.append(replace(follower.life, rows={0: now}))
    free = max((follower.life.id for follower in followers), default=0) + 1
    return bind(split_at_gaps(lives, free, lasts=1))[0]


def _refined(strokes: Strokes, rest: Floats, coverage: NDArray[np.uint8], settings: PropagateSettings) -> Strokes:
    """The strokes after the photometric refinement of what is seen; ``rest`` are the points of the first ones."""
    seen = np.flatnonzero(strokes.visible[:, 1] > strokes.visible[:, 0])
    before = strokes.points.copy()
    before[: len(rest)] = rest
    at_rest = replace(strokes, points=before).select(seen).points
    fitted = refine(strokes.select(seen), at_rest, coverage, settings.refine_steps, settings.refine_rigidity)
    moved = strokes.points.copy()
    moved[np.isin(strokes.layout.point_row, seen)] = fitted.points
    return replace(strokes, points=moved)
