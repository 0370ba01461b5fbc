"""Where a group of nodes may have gone: all rotations and translations at once, by correlation with the ink."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import fft

from videovec.propagate.registration import doubled
from videovec.propagate.target import Target

__all__ = ["Motion", "Scene", "find_motions", "scene_of"]

Floats = NDArray[np.float64]

_CELL = 4
"""Side of a cell of the correlation. px"""
_REACH = 4.0
"""Standard deviation of the reward around the ink. px"""
_FAR_PRICE = 0.1
"""What a translation by the whole page costs, against 1 for a perfect match."""
_TURN_PRICE = 0.05
"""What half a turn costs."""


@dataclass(frozen=True, slots=True)
class Motion:
    """A rotation about a centre, then a translation.

    Args:
        angle: Counted from x to y. Radians
        centre: What is turned about. px
        shift: The translation. px
        score: How much of the group then lies on ink of its direction, in [0, 1], less the price of the motion.
    """

    angle: float
    centre: tuple[float, float]
    shift: tuple[float, float]
    score: float

    def apply(self, positions: Floats) -> Floats:
        """Move positions [N, 2]."""
        cos, sin = np.cos(self.angle), np.sin(self.angle)
        turned = (positions - self.centre) @ np.array([[cos, sin], [-sin, cos]])
        return np.asarray(turned + self.centre + self.shift)


@dataclass(frozen=True, slots=True, eq=False)
class Scene:
    """The ink's reward in the frequency domain, for any direction. complex [3, h, w/2+1], and the size of the grid."""

    spectrum: NDArray[np.complex64]
    size: tuple[int, int]


def scene_of(target: Target, weight: Floats) -> Scene:
    """Prepare a drawing to be searched.

    Args:
        target: The drawing.
        weight: Worth of each centre-line point, such as less for ink that is explained already. [M]

    Returns:
        A reward that falls off around the ink as a Gaussian, times 1, cos 2θ and sin 2θ of the nearest ink.
    """
    distance = target.distance[_CELL // 2 :: _CELL, _CELL // 2 :: _CELL]
    nearest = target.nearest[_CELL // 2 :: _CELL, _CELL // 2 :: _CELL]
    reward = np.exp(-0.5 * (distance / _REACH) ** 2) * weight[nearest]
    direction = doubled(target.direction)[nearest]
    maps = np.stack([reward, reward * direction[..., 0], reward * direction[..., 1]])
    size = tuple(fft.next_fast_len(2 * n, real=True) for n in distance.shape)
    return Scene(fft.rfft2(maps.astype(np.float32), s=size), (size[0], size[1]))


def find_motions(scene: Scene, positions: Floats, tangents: Floats, turns: int, keep: int) -> list[Motion]:
    """The best rigid motions of a group.

    Args:
        scene: Where to look.
        positions: Nodes of the group. [N, 2] px
        tangents: Their directions. [N, 2]
        turns: How many rotations are tried around the circle.
        keep: How many motions are wanted.

    Returns:
        At most ``keep`` motions that differ, best first.
    """
    centre = positions.mean(axis=0)
    page = _CELL * max(scene.size) / 2
    found = []
    for k in range(turns):
        angle = 2 * np.pi * k / turns
        turn = Motion(angle, (float(centre[0]), float(centre[1])), (0.0, 0.0), 0.0)
        double = doubled(tangents) @ _rotation(2 * angle)
        score = _correlate(scene, turn.apply(positions), double)
        row, column = (_signed(n) for n in scene.size)
        away = _CELL * np.hypot(row[:, None], column)
        score = score - _FAR_PRICE * away / page - _TURN_PRICE * (1 - np.cos(angle)) / 2
        for _ in range(2):
            at = np.unravel_index(int(np.argmax(score)), score.shape)
            shift = (float(_CELL * column[at[1]]), float(_CELL * row[at[0]]))
            found.append(Motion(angle, turn.centre, shift, float(score[at])))
            around = np.ix_(*(np.arange(i - 3, i + 4) % n for i, n in zip(at, score.shape, strict=True)))
            score[around] = -np.inf
    return _distinct(sorted(found, key=lambda motion: -motion.score), 2 * np.pi / turns, keep)


def _rotation(angle: float) -> Floats:
    """Turns row vectors."""
    return np.array([[np.cos(angle), np.sin(angle)], [-np.sin(angle), np.cos(angle)]])


def _signed(count: int) -> Floats:
    """Shifts that the entries of a correlation stand for."""
    return np.asarray(fft.fftfreq(count, 1 / count))


def _correlate(scene: Scene, positions: Floats, double: Floats) -> Floats:
    """Mean reward of the nodes for every translation. [h, w]"""
    height, width = scene.size
    at = positions / _CELL - 0.5
    base = np.floor(at).astype(np.intp)
    part = at - base
    template = np.zeros((3, height, width), np.float32)
    for dy in (0, 1):
        for dx in (0, 1):
            share = np.abs(1 - dx - part[:, 0]) * np.abs(1 - dy - part[:, 1])
            place = (base[:, 1] + dy) % height, (base[:, 0] + dx) % width
            for channel, value in enumerate((np.ones(len(at)), double[:, 0], double[:, 1])):
                np.add.at(template[channel], place, share * value)
    product = (np.conj(fft.rfft2(template)) * scene.spectrum).sum(axis=0)
    return np.asarray(fft.irfft2(product, s=scene.size), np.float64) / (2 * len(at))


def _distinct(motions: list[Motion], step: float, keep: int) -> list[Motion]:
    chosen: list[Motion] = []
    for motion in motions:
        if len(chosen) == keep:
            break
        if all(_differ(motion, other, step) for other in chosen):
            chosen.append(motion)
    return chosen


def _differ(a: Motion, b: Motion, step: float) -> bool:
    turn = abs((a.angle - b.angle + np.pi) % (2 * np.pi) - np.pi)
    return turn > 1.5 * step or float(np.hypot(a.shift[0] - b.shift[0], a.shift[1] - b.shift[1])) > 4 * _CELL
