"""Cross-sections of a stroke, and where along it they are best taken."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from videovec.curves import derivative, evaluate, split

__all__ = ["Stations", "angle_between", "cut_at_cusps", "even_grid", "find_cusps", "shared_out"]

Floats = NDArray[np.float64]

_HALT = 0.003  # speed, in lengths of the control polygon, under which a segment turns about on the spot
_LENGTH_COST = 0.2  # of a pixel of length, against a pixel swept by the half-width in a turn
_GRID = 32  # steps of a segment over which its pieces are shared out
_ROUNDS = 3  # how often that grid is refined where the curve turns


@dataclass(frozen=True, slots=True, eq=False)
class Stations:
    """Cross-sections of a stroke.

    Args:
        center: [..., 2] px
        tangent: Unit vectors. [..., 2]
        curvature: Positive where the curve bends to the left, the side of (-y, x) of the tangent. [...] 1/px
        half_width: [...] px
    """

    center: Floats
    tangent: Floats
    curvature: Floats
    half_width: Floats

    @staticmethod
    def at(control: Floats, half_width: Floats, t: Floats) -> Stations:
        """Cross-sections of segments [Q, 4, 2] at parameters [Q, M]."""
        each = control[..., None, :, :]
        scale = np.abs(np.diff(control, axis=-2)).sum((-1, -2))[..., None]
        velocity = derivative(each, t)
        speed = np.linalg.norm(velocity, axis=-1)
        is_slow = speed <= 1e-4 * scale  # a handle on its joint: the direction is that of a point close by
        nudged = np.where(is_slow, t + (0.5 - t) * 1e-3, t)
        velocity = np.where(is_slow[..., None], derivative(each, nudged), velocity)
        speed = np.linalg.norm(velocity, axis=-1)
        is_point = speed <= 1e-12 + 1e-9 * scale
        velocity = np.where(is_point[..., None], (1.0, 0.0), velocity)
        speed = np.where(is_point, 1.0, speed)
        legs = np.diff(control, n=2, axis=-2)[..., None, :, :]
        bend = 6 * ((1 - nudged)[..., None] * legs[..., 0, :] + nudged[..., None] * legs[..., 1, :])
        cross = velocity[..., 0] * bend[..., 1] - velocity[..., 1] * bend[..., 0]
        curvature = np.where(is_point, 0.0, cross / speed**3)
        return Stations(evaluate(each, t), velocity / speed[..., None], curvature, half_width)

    @property
    def normal(self) -> Floats:
        """Unit normals to the left. [..., 2]"""
        return np.stack([-self.tangent[..., 1], self.tangent[..., 0]], -1)

    def is_tight(self, sign: float) -> NDArray[np.bool_]:
        """Where the side bends more tightly than it is wide. [...]"""
        return np.asarray(sign * self.curvature * self.half_width > 1, dtype=np.bool_)

    def side(self, sign: float) -> Floats:
        """Points of the left (+1) or right (-1) side. [..., 2] px"""
        inward = np.maximum(sign * self.curvature, 0)
        reach = np.where(self.is_tight(sign), 1 / np.where(inward > 0, inward, 1), self.half_width)
        return self.center + (sign * reach)[..., None] * self.normal


def even_grid(control: Floats, widths: Floats) -> tuple[Floats, Floats]:
    """Parameters that share each segment out evenly, by length and by turn times half-width.

    Args:
        control: Control points of each segment. [G, 4, 2] px
        widths: Half-width at both of its ends. [G, 2] px

    Returns:
        Parameters [G, steps + 1], and how long the longer side of each segment is about. [G] px
    """
    t = np.tile(np.linspace(0, 1, _GRID + 1), (len(control), 1))
    for _ in range(_ROUNDS):
        stations = Stations.at(control, widths[:, :1] + (widths[:, 1:] - widths[:, :1]) * t, t)
        length = np.linalg.norm(np.diff(stations.center, axis=1), axis=-1)
        turn = np.abs(angle_between(stations.tangent[:, :-1], stations.tangent[:, 1:]))
        swept = turn * (stations.half_width[:, 1:] + stations.half_width[:, :-1]) / 2
        cost = _LENGTH_COST * length + swept
        cost += 0.1 * cost.mean(1, keepdims=True) + 1e-9
        share = np.concatenate([np.zeros((len(cost), 1)), np.cumsum(cost, axis=1)], axis=1)
        share /= share[:, -1:]
        offset = 2.0 * np.arange(len(t))[:, None]  # one interpolation for all segments, each in a range of its own
        wanted = np.linspace(0, 1, _GRID + 1) + offset
        t = np.interp(wanted, (share + offset).ravel(), t.ravel())
    return t, (length + swept).sum(1)


def shared_out(grid: Floats, count: int) -> Floats:
    """Parameters at which ``count`` pieces of each segment meet. [G, steps + 1] -> [G, count + 1]"""
    place = np.linspace(0, _GRID, count + 1)
    low = np.minimum(place.astype(np.intp), _GRID - 1)
    return np.asarray(grid[:, low] + (place - low) * (grid[:, low + 1] - grid[:, low]))


def find_cusps(control: Floats) -> tuple[NDArray[np.bool_], Floats]:
    """Whether each segment comes to a halt within, to turn about on the spot, and where it is slowest.

    Args:
        control: Control points of each segment. [..., 4, 2] px

    Returns:
        bool [...], and t in (0, 1). [...]
    """
    scale = np.linalg.norm(np.diff(control, axis=-2), axis=-1).sum(-1)
    t = np.broadcast_to(np.linspace(0, 1, 65)[1:-1], (*scale.shape, 63))
    step = 1 / 64
    for _ in range(4):  # look again around the slowest, ever closer
        speed = np.linalg.norm(derivative(control[..., None, :, :], t), axis=-1)
        slowest = np.take_along_axis(t, speed.argmin(-1)[..., None], -1)
        t = np.clip(slowest + step * np.linspace(-1, 1, 33), 1e-3, 1 - 1e-3)
        step /= 16
    return np.asarray(speed.min(-1) < _HALT * scale), np.asarray(slowest[..., 0])


def cut_at_cusps(control: Floats, widths: Floats, is_cut: NDArray[np.bool_]) -> tuple[Floats, Floats]:
    """Splines with some of their segments cut where they are slowest; where they halt, the cut becomes a corner.

    Args:
        control: Segments of K splines. [K, n, 4, 2] px
        widths: Half-width at their joints. [K, n+1] px
        is_cut: Which segments are cut. bool [n]

    Returns:
        The same with m segments. [K, m, 4, 2], [K, m+1]
    """
    is_cusp, slowest = find_cusps(control)
    segments, joints = [], [widths[:, :1]]
    for k, cut in enumerate(is_cut):
        if cut:
            t = slowest[:, k]
            before, after = split(control[:, k], t)
            joint = before[:, 3]
            for handle in (before[:, 2], after[:, 1]):  # none at a cusp: both sides come straight in
                handle[is_cusp[:, k]] = joint[is_cusp[:, k]]
            segments += [before, after]
            joints.append(((1 - t) * widths[:, k] + t * widths[:, k + 1])[:, None])
        else:
            segments.append(control[:, k])
        joints.append(widths[:, k + 1 : k + 2])
    return np.stack(segments, axis=1), np.concatenate(joints, axis=1)


def angle_between(a: Floats, b: Floats) -> Floats:
    """Turn from one direction to another, positive to the left. [...] in (-pi, pi]"""
    cross = a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0]
    return np.asarray(np.arctan2(cross, (a * b).sum(-1)))
