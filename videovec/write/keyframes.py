"""As few keyframes as keep every sample within a tolerance."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from videovec.compiling import compiled

__all__ = ["EVEN", "Animated", "ease", "parameter_of", "reduce_keyframes"]

Floats = NDArray[np.float64]

EVEN = (1 / 3, 1 / 3, 2 / 3, 2 / 3)
"""Handles of an easing that moves evenly."""
_NEWTON = 12  # steps, enough for handles that are not nearly upright
_STILL = 1e-14  # how near to the value is near enough
_REACH = 128  # samples over which one keyframe may reach; bounds the cost of long clips


@dataclass(frozen=True, slots=True, eq=False)
class Animated:
    """A value over time, by K keyframes.

    Args:
        times: When each keyframe is, increasing. [K] ticks
        values: The value at each. [K, ...]
        is_hold: Whether the value stays until the next keyframe; otherwise it moves there. bool [K]
        handles: How it moves there, see `ease`; evenly where there are none. [K, 4]
    """

    times: Floats
    values: Floats
    is_hold: NDArray[np.bool_]
    handles: Floats | None = None

    @property
    def is_static(self) -> bool:
        """Whether one value serves for all time."""
        return len(self.times) == 1

    def at(self, time: float) -> Floats:
        """The value at a time; before the first keyframe its value, after the last its value. [...]"""
        k = int(np.clip(np.searchsorted(self.times, time, side="right") - 1, 0, len(self.times) - 1))
        if k == len(self.times) - 1 or self.is_hold[k] or time <= self.times[k]:
            return np.asarray(self.values[k])
        share = (time - self.times[k]) / (self.times[k + 1] - self.times[k])
        if self.handles is not None:
            share = float(ease(self.handles[k], np.asarray(share)))
        return np.asarray(self.values[k] + share * (self.values[k + 1] - self.values[k]))


def ease(handles: ArrayLike, share: Floats) -> Floats:
    """How far a move has come at shares of its time, as Lottie, SVG and CSS have it.

    Args:
        handles: x and y of both handles of a cubic Bézier curve from (0, 0) to (1, 1), x in (0, 1). [4]
        share: Of the time between two keyframes: x. [...]

    Returns:
        y. [...]
    """
    x1, y1, x2, y2 = np.asarray(handles, dtype=np.float64)
    return _cubic(y1, y2, parameter_of(x1, x2, share))


def parameter_of(x1: float, x2: float, share: Floats) -> Floats:
    """Where on a cubic Bézier curve from 0 to 1 with handles at x1 and x2 in (0, 1) a value is. [...]"""
    flat = np.ascontiguousarray(share, dtype=np.float64).ravel()
    return parameters_of(float(x1), float(x2), flat, _NEWTON).reshape(np.shape(share))


@compiled()
def parameters_of(x1: float, x2: float, share: Floats, steps: int) -> Floats:
    """`parameter_of` by Newton's steps. [n]"""
    result = np.empty(len(share))
    for i in range(len(share)):
        t = share[i]
        for _ in range(steps):
            r = 1 - t
            slope = 3 * (r * r * x1 + 2 * r * t * (x2 - x1) + t * t * (1 - x2))
            off = 3 * r * r * t * x1 + 3 * r * t * t * x2 + t * t * t - share[i]
            t = min(max(t - off / max(slope, 0.05), 0.0), 1.0)
            if abs(off) < _STILL:
                break
        result[i] = t
    return result


def _cubic(first: float, second: float, t: Floats) -> Floats:
    return np.asarray(3 * (1 - t) ** 2 * t * first + 3 * (1 - t) * t**2 * second + t**3)


def reduce_keyframes(times: Floats, values: Floats, tolerance: ArrayLike, is_held: NDArray[np.bool_]) -> Animated:
    """Choose the fewest samples from which all others follow.

    A shortest path over the samples: one leads to a later one if the straight line between the two, or the first
    one's value held, passes every sample between within the tolerance. (The line passes if its slope lies in the cone
    that each sample opens from the first: a running intersection.)

    Args:
        times: When each sample is, increasing. [N] ticks
        values: The samples. [N, ...]
        tolerance: Largest deviation of each number; one for all, or of the shape of a sample.
        is_held: Whether each sample stays as it is until the next, so that none may move between them. bool [N]

    Returns:
        Keyframes whose values are samples; the first is the first sample.
    """
    count = len(times)
    flat = values.reshape(count, -1)
    slack = np.broadcast_to(np.asarray(tolerance, dtype=np.float64), values.shape[1:]).reshape(-1)
    cost = np.zeros(count + 1, dtype=np.intp)
    following = np.zeros(count, dtype=np.intp)
    holds = np.zeros(count, dtype=bool)
    for k in range(count - 1, -1, -1):
        span = slice(k, min(k + _REACH, count))
        is_constant, is_line = _reachable(times[span], flat[span], slack, is_held[span])
        is_constant[-1] &= span.stop == count  # the end itself needs no keyframe, an arbitrary sample does
        is_reached = np.flatnonzero(is_constant | is_line)
        best = is_reached[::-1][np.argmin(cost[k + 1 + is_reached][::-1])]
        following[k], holds[k], cost[k] = k + 1 + best, not is_line[best], 1 + cost[k + 1 + best]
    keys = [0]
    while following[keys[-1]] < count:
        keys.append(int(following[keys[-1]]))
    return Animated(times[keys], values[keys], holds[keys])


def _reachable(
    times: Floats, values: Floats, slack: Floats, is_held: NDArray[np.bool_]
) -> tuple[NDArray[np.bool_], NDArray[np.bool_]]:
    """Whether the first of n samples can hold until, or move in a line to, each later one and the end. Two bool [n]"""
    step = values[1:] - values[0]
    is_same = np.concatenate([[True], np.logical_and.accumulate((np.abs(step) <= slack).all(1))])
    may_jump = is_held.copy()
    may_jump[-1] = True
    elapsed = (times[1:] - times[0])[:, None]
    low = np.maximum.accumulate((step - slack) / elapsed)
    high = np.minimum.accumulate((step + slack) / elapsed)
    slope = step[1:] / elapsed[1:]
    is_inside = ((slope >= low[:-1] - 1e-12) & (slope <= high[:-1] + 1e-12)).all(1)
    is_line = np.concatenate([[True], is_inside]) & ~np.logical_or.accumulate(is_held[:-1])
    return is_same & may_jump, np.concatenate([is_line, [False]])[: len(times)]
