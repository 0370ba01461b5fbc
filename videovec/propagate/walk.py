"""The whole clip: a walk forwards and one backwards from the drawing on which the strokes of each shot are known."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from videovec.errors import FitError
from videovec.events import Event
from videovec.ink import Ink, amount_of_ink, first_full
from videovec.progress import Progress, Silent
from videovec.propagate.births import Nursery, Trace
from videovec.propagate.follower import Follower, follow
from videovec.propagate.grown import join_grown
from videovec.propagate.happenings import events_of
from videovec.propagate.record import Life, bind, open_lives
from videovec.propagate.residual import Residual, find_residual
from videovec.propagate.returning import join_returning
from videovec.propagate.reveal import reveal
from videovec.propagate.revive import revive
from videovec.propagate.seam import move_seam
from videovec.propagate.split import split_at_gaps
from videovec.propagate.step import Placement, carry
from videovec.propagate.target import Target, make_target, sample
from videovec.propagate.tucked import hold_tucked
from videovec.propagate.unhide import unhide
from videovec.settings import PropagateSettings
from videovec.strokes import Strokes

__all__ = ["Propagated", "walk"]

_CUT = 0.5
"""Mean of the shares of ink without strokes and of strokes without ink from which on a new shot has begun."""
_LOST = 0.15
"""Share of strokes that must be without ink then: a drawing that only gains ink is the same shot."""

_SAME = 0.5
"""Share of one drawing's lines on the other's ink from which on lines were only erased or drawn on."""
_BLANK = 0.002
"""Share of the most ink of any drawing up to which a page is blank."""


@dataclass(frozen=True, slots=True, eq=False)
class Propagated:
    """Strokes over all drawings.

    Args:
        strokes: S strokes with their lives.
        events: Births, deaths and other turns, by drawing.
        confidence: How well each row's ink supports it, in [0, 1]. [R]
    """

    strokes: Strokes
    events: tuple[Event, ...]
    confidence: NDArray[np.float64]


def walk(
    ink: Ink,
    strokes: Strokes,
    settings: PropagateSettings,
    trace: Trace,
    progress: Progress | None = None,
    cuts: frozenset[int] | None = None,
) -> Propagated:
    """Carry strokes of one ink over all drawings; see `propagate`. New shots begin at ``cuts``, if they are known."""
    progress = progress or Silent()
    progress.stage("propagate", ink.drawing_count - 1)
    lives = open_lives(strokes if len(strokes) else trace(ink, 0))
    seed = lives[0].first if lives else 0
    if any(life.first != seed or life.last != seed for life in lives):
        raise FitError("propagate needs strokes of one drawing, got some that live longer")
    book = _Book(lives, sorted(cuts or ()), max((life.id for life in lives), default=0) + 1)
    amount = amount_of_ink(ink)
    to_do = [(seed, range(seed + 1, ink.drawing_count)), (seed, range(seed - 1, -1, -1))]
    while to_do:
        seed, ahead = to_do.pop(0)
        left = _Walk(ink, settings, trace, ahead.step, book, cuts).run(seed, ahead, progress)
        if left:
            run = _without_blanks(amount, left)
            seed = run[first_full(amount[run])]
            for life in open_lives(trace(ink, seed)):
                book.add(life)
            to_do += [(seed, range(seed + left.step, left.stop, left.step))]
            to_do += [(seed, range(seed - left.step, left.start - left.step, -left.step))]
    book.lives = join_returning(join_grown(book.lives, ink), book.blanks, settings.memory)
    reveal(book.lives, ink)
    hold_tucked(book.lives)
    for life in book.lives if settings.move_seams else ():
        move_seam(life)
    bound, confidence = bind(split_at_gaps(sorted(book.lives, key=lambda life: life.id), book.next_id))
    bound = unhide(bound, ink)
    return Propagated(bound, events_of(bound, confidence, book.cuts, ink.drawing_count), confidence)


@dataclass(slots=True, eq=False)
class _Book:
    """What all walks write to.

    Args:
        lives: All lives.
        cuts: First drawings of new shots.
        next_id: The next free identity.
        blanks: First drawings after a blank page of which the strokes before it explain nothing.
    """

    lives: list[Life]
    cuts: list[int]
    next_id: int
    blanks: list[int] = field(default_factory=list)

    def add(self, life: Life) -> Life:
        """Enter a life under a new identity."""
        named = replace(life, id=self.next_id)
        self.next_id += 1
        self.lives.append(named)
        return named


class _Walk:
    """One direction."""

    def __init__(
        self,
        ink: Ink,
        settings: PropagateSettings,
        trace: Trace,
        direction: int,
        book: _Book,
        cuts: frozenset[int] | None,
    ) -> None:
        self._ink = ink
        self._settings = settings
        self._trace = trace
        self._direction = direction
        self._book = book
        self._cuts = cuts
        self._nursery = Nursery(ink, settings, trace, direction)
        self._followers: list[Follower] = []

    def run(self, seed: int, ahead: range, progress: Progress) -> range:
        """Walk from the seed over the drawings ahead.

        Args:
            seed: A drawing on which strokes are known.
            ahead: The drawings after it, in the direction of the walk.
            progress: Told of each drawing.

        Returns:
            The drawings, in that order, that show something else altogether: strokes of their own must be found there.
        """
        self._followers = [self._follow(life, seed) for life in self._book.lives if seed in life.rows]
        previous = self._target(seed)
        for drawing in ahead:
            target = self._target(drawing)
            step = drawing - self._direction, drawing
            placed = carry(self._followers, self._ink.coverage[drawing], step, (previous, target), self._settings)
            self._followers, placed = revive(self._followers, placed, target, drawing)
            residual = self._left(placed, target)
            if self._begins_anew(drawing, (placed, residual), (previous, target)):
                for follower in self._followers:
                    follower.life.rows.pop(drawing, None)
                self._end()
                progress.advance()
                return ahead[ahead.index(drawing) :]
            for life in self._nursery.observe(drawing, residual, self._followers, drawing == ahead[-1]):
                known = self._book.add(life)
                if drawing in known.rows:  # else it was there for a moment
                    self._followers.append(self._follow(known, drawing))
            self._retire(drawing)
            previous = target
            progress.advance()
        self._end()
        return ahead[:0]

    def _begins_anew(self, drawing: int, found: tuple[Placement, Residual], targets: tuple[Target, Target]) -> bool:
        """Whether nothing of what was drawn before is there: after a cut, or a page without ink."""
        shot = drawing if self._direction > 0 else drawing + 1
        if len(targets[1]) and not len(targets[0]):
            is_new = not self._followers or _is_cut(*found)
            if is_new:
                self._book.blanks.append(shot)
            return is_new
        if self._cuts is not None:
            is_cut = shot in self._cuts
        else:
            is_cut = _is_cut(*found) and max(_share_on(*targets), _share_on(*targets[::-1])) < _SAME
        if is_cut:
            self._book.cuts.append(shot)
        return is_cut

    def _end(self) -> None:
        """Drop what is hidden at the end of the walk."""
        for follower in self._followers:
            _trim(follower.life, self._direction)

    def _target(self, drawing: int) -> Target:
        return make_target(self._ink.coverage[drawing], self._settings.working_size)

    def _follow(self, life: Life, drawing: int) -> Follower:
        scale = min(1.0, self._settings.working_size / max(self._ink.size))
        return follow(life, drawing, self._settings.node_spacing / scale, scale, drawing - self._direction)

    def _left(self, placed: Placement, target: Target) -> Residual:
        seen = placed.support.explains(placed.nodes)
        return find_residual(placed.nodes, placed.positions, seen, placed.half_width, target)

    def _retire(self, drawing: int) -> None:
        """Close lives that were not seen for too long."""
        for follower in self._followers:
            if follower.unseen > self._settings.memory:
                _trim(follower.life, self._direction)
        self._followers = [f for f in self._followers if f.unseen <= self._settings.memory and drawing in f.life.rows]


def _without_blanks(amount: NDArray[np.int64], drawings: range) -> range:
    """The drawings up to the first with next to no ink."""
    blank = np.flatnonzero(amount[drawings] <= _BLANK * amount.max())
    return drawings[: max(int(blank[0]), 1)] if len(blank) else drawings


def _is_cut(placed: Placement, residual: Residual) -> bool:
    """Whether hardly anything of the drawing before is left."""
    count = len(placed.nodes)
    if not count or not len(residual.point):
        return False
    lost = 1.0 - placed.support.shown.mean()
    return bool(0.5 * (residual.point.mean() + lost) > _CUT and lost > _LOST)


def _share_on(one: Target, other: Target) -> float:
    """Share of a drawing's lines that lie on the ink of another: 1 if it is the other, or what is left of it."""
    return float(np.mean(sample(other.ink, one.points) > other.threshold)) if len(one) else 0.0


def _trim(life: Life, direction: int) -> None:
    """Drop the rows at the end of a walk on which nothing is seen."""
    while len(life.rows) > 1:
        end = life.last if direction > 0 else life.first
        if life.rows[end].visible[1] > life.rows[end].visible[0]:
            return
        del life.rows[end]
