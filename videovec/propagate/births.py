"""Ink that appears: when it becomes a stroke, since when that stroke was there, and whether it is an old one."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from itertools import zip_longest

import numpy as np
from numpy.typing import NDArray

from videovec.curves import arc_length, sample_by_arc
from videovec.ink import Ink
from videovec.propagate.follower import Follower, follow
from videovec.propagate.record import Life, open_lives
from videovec.propagate.relink import relink
from videovec.propagate.residual import Patch, Residual, restricted, successor
from videovec.propagate.step import carry
from videovec.propagate.target import Target, distance_to, sample
from videovec.settings import PropagateSettings
from videovec.strokes import Strokes

__all__ = ["Nursery", "Trace"]

Trace = Callable[[Ink, int], Strokes]
"""Traces strokes on the ink of one drawing."""

_LEAST = 10.0
"""Length, with the width of its ends, of the smallest patch that may become a stroke. working px"""
_GROWTH = 3
"""A patch that is longer by more than this than on the drawing before still grows. working px"""
_BRIEF = 3.0
"""Length, in widths, below which a patch may be the beginning of a line that is drawn on slowly:"""
_HESITATION = 4
"""then this many drawings back are looked at."""
_BESIDE = 2.0
"""How far from unexplained centre lines, beyond its half-width, a new stroke may lie. working px"""
_FLASH = 6.0
"""A patch that is not where it was must be this many times the least to be looked for elsewhere,"""
_FAR = 16.0
"""unless the fastest tenth of all strokes move this far, so that no patch is where it was. working px"""
_GLIMPSE = 2.0
"""One that is nowhere any more must be this many times the least,"""
_ALONE = 8.0
"""and this far from all strokes, to be one all the same: what moved leaves ink beside them. working px"""


@dataclass(frozen=True, slots=True, eq=False)
class _Seed:
    """A patch that may become a stroke.

    Args:
        patch: It as it is now.
        since: The drawing on which it was seen first.
        lengths: How long it, or what it came from, was on each drawing since. working px
    """

    patch: Patch
    since: int
    lengths: tuple[float, ...]

    def grows(self) -> bool:
        """Whether it is longer than it was."""
        is_brief = self.patch.length < _BRIEF * 2.0 * self.patch.half_width
        back = _HESITATION if is_brief else 1
        return len(self.lengths) <= back or self.lengths[-1] > self.lengths[-1 - back] + _GROWTH


class Nursery:
    """Watches unexplained ink until it has stopped to grow."""

    def __init__(self, ink: Ink, settings: PropagateSettings, trace: Trace, direction: int) -> None:
        self._ink = ink
        self._settings = settings
        self._trace = trace
        self._direction = direction
        self._seeds: list[_Seed] = []
        self._residuals: dict[int, Residual] = {}

    def observe(self, drawing: int, residual: Residual, followers: list[Follower], is_last: bool) -> list[Life]:
        """Look at what is left of the next drawing.

        Args:
            drawing: Its number.
            residual: Its unexplained ink.
            followers: All lives that are followed; hidden ones may find their ink again.
            is_last: Whether no drawing follows.

        Returns:
            New lives, with rows from when their ink appeared up to this drawing, or to the one before if it is gone.
        """
        before = self._residuals.get(drawing - self._direction)
        heirs = {id(seed): successor(seed.patch, before, residual) if before else [] for seed in self._seeds}
        self._residuals[drawing] = residual
        born, seeds = [], []
        for patch in residual.patches:
            if patch.length + 2 * patch.half_width < _LEAST:
                continue
            ancestors = [seed for seed in self._seeds if patch in heirs[id(seed)]]
            since = min((seed.since for seed in ancestors), key=lambda d: d * self._direction, default=drawing)
            before_it = zip_longest(*(reversed(seed.lengths) for seed in ancestors), fillvalue=0.0)
            seed = _Seed(patch, since, (*reversed([sum(lengths) for lengths in before_it]), patch.length))
            if is_last or not seed.grows() or (drawing - since) * self._direction >= self._settings.patience:
                born += self._deliver([patch], drawing, since, followers)
            else:
                seeds.append(seed)
        flash = 1.0 if self._stride(followers, drawing) > _FAR else _FLASH
        for seed in self._seeds:
            if not heirs[id(seed)]:
                gone, taken = self._pursue(seed, drawing, flash)
                born += gone
                seeds = [other for other in seeds if other.patch.number not in taken]
        self._seeds = seeds
        self._forget(drawing)
        return born

    def _stride(self, followers: list[Follower], drawing: int) -> float:
        """How far at least the fastest tenth of all control points moved since the drawing before. working px"""
        scale, steps = self._residuals[drawing].target.scale, [np.zeros(1)]
        for follower in followers:
            now, before = (follower.life.rows.get(d) for d in (drawing, drawing - self._direction))
            if now is not None and before is not None:
                steps.append(np.linalg.norm(now.points - before.points, axis=1))
        return scale * float(np.quantile(np.concatenate(steps), 0.9))

    def _pursue(self, seed: _Seed, drawing: int, flash: float) -> tuple[list[Life], set[int]]:
        """Strokes of a patch that is not where it was, and the patches of this drawing that they explain."""
        before = drawing - self._direction
        size = seed.patch.length + 2 * seed.patch.half_width
        is_large = size >= flash * _LEAST
        is_alone = size >= _GLIMPSE * _LEAST and self._residuals[before].gap_to(seed.patch) > _ALONE
        if not is_large and not is_alone:
            return [], set()
        lives = self._deliver([seed.patch], before, seed.since, [])
        ahead = [follow(life, before, self._spacing(before)) for life in lives if is_large]
        everything = [list(self._residuals[d].patches) for d in (before, drawing)]
        seen = self._step(ahead, (before, drawing), (everything[0], everything[1])) if ahead else []
        label, scale = self._residuals[drawing].label, self._residuals[drawing].target.scale
        taken: set[int] = set()
        for follower in seen:
            column, row = (scale * sample_by_arc(follower.life.rows[drawing].points, 64)).astype(np.intp).T
            inside = (row >= 0) & (column >= 0) & (row < label.shape[0]) & (column < label.shape[1])
            taken |= set(np.unique(label[row[inside], column[inside]]).tolist()) - {0}
        return [follower.life for follower in seen] or (lives if is_alone else []), taken

    def _spacing(self, drawing: int) -> float:
        return self._settings.node_spacing / self._residuals[drawing].target.scale

    def _forget(self, drawing: int) -> None:
        oldest = min((seed.since * self._direction for seed in self._seeds), default=drawing * self._direction)
        self._residuals = {d: r for d, r in self._residuals.items() if d * self._direction >= oldest - 1}

    def _deliver(self, patches: list[Patch], drawing: int, since: int, followers: list[Follower]) -> list[Life]:
        """Trace patches and follow them back to their first drawing."""
        own = self._ink_of(drawing, [patch.number for patch in patches])
        traced = [life for life in open_lives(self._trace(own, 0)) if self._is_new(life, drawing)]
        lives = [replace(life, rows={drawing: life.rows[0]}, home=drawing) for life in traced]
        lives = relink(lives, drawing, followers)
        back = [follow(life, drawing, self._spacing(drawing)) for life in lives]
        for earlier in range(drawing - self._direction, since - self._direction, -self._direction):
            if not back or earlier not in self._residuals:
                break
            later = earlier + self._direction
            came_from = self._ancestors(patches, later, earlier)
            back = self._step(back, (later, earlier), (patches, came_from), grows=True)
            patches = came_from
        return lives

    def _ancestors(self, patches: list[Patch], later: int, earlier: int) -> list[Patch]:
        """The patches of an earlier drawing that some patches may have come from; all, if there are none such."""
        then, now = self._residuals[earlier], self._residuals[later]
        found = {one.number: one for patch in patches for one in successor(patch, now, then)}
        return list(found.values()) or list(then.patches)

    def _is_new(self, life: Life, drawing: int) -> bool:
        """Whether a traced stroke lies on unexplained ink, and not on what was cut out beside it or crosses it."""
        residual = self._residuals[drawing]
        scale = residual.target.scale
        points = scale * life.rows[0].points
        half_width = scale * float(life.rows[0].half_width.mean())
        if arc_length(points) + 2 * half_width < _LEAST:
            return False
        count = max(2, round(arc_length(points)))
        rows, columns = np.nonzero(residual.target.skeleton)
        left = np.zeros(residual.target.skeleton.shape, bool)
        left[rows[residual.point], columns[residual.point]] = True
        gap = sample(distance_to(left)[0], sample_by_arc(points, count))
        return bool(np.mean(gap <= _BESIDE + half_width) >= 0.5)

    def _step(
        self,
        followers: list[Follower],
        step: tuple[int, int],
        patches: tuple[list[Patch], list[Patch]],
        grows: bool = False,
    ) -> list[Follower]:
        """Take newborn lives to a neighbouring drawing, over some patches of both; those that are seen there."""
        numbers = [[patch.number for patch in own] for own in patches]
        before, after = (self._only(d, own) for d, own in zip(step, numbers, strict=True))
        coverage = self._ink_of(step[1], numbers[1]).coverage[0]
        carry(followers, coverage, step, (before, after), self._settings, grows=grows)
        seen = []
        for follower in followers:
            visible = follower.life.rows[step[1]].visible
            if visible[1] > visible[0]:
                seen.append(follower)
            else:
                del follower.life.rows[step[1]]
        return seen

    def _only(self, drawing: int, numbers: list[int]) -> Target:
        """The centre lines of some patches alone."""
        residual = self._residuals[drawing]
        rows, columns = np.nonzero(residual.target.skeleton)
        return restricted(residual.target, residual.point & np.isin(residual.label[rows, columns], numbers))

    def _ink_of(self, drawing: int, numbers: list[int]) -> Ink:
        """The ink of some patches alone."""
        ink = self._ink.at_drawing(drawing)
        mask: NDArray[np.bool_] = np.zeros(ink.size, bool)
        if numbers:
            mask = self._residuals[drawing].ink_mask(numbers, ink.size)
        return replace(ink, coverage=np.where(mask, ink.coverage, 0).astype(np.uint8))
