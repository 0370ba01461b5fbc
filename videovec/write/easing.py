"""As few eased keyframes as keep moving curves within a tolerance of where they were.

Between two keyframes all control points move along straight lines by one and the same easing, a cubic of time, as every
Lottie player and SVG's ``keySplines`` can play. Where a keyframe is and what it holds is chosen such that all samples
are met at once, so that noise is smoothed and not followed. What must be met is the curve that is seen: a point may lie
elsewhere along it.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from videovec.curves import derivative, evaluate
from videovec.write.keyframes import EVEN, Animated, ease, parameter_of

__all__ = ["reduce_paths"]

Floats = NDArray[np.float64]
Bools = NDArray[np.bool_]

_SAMPLES = np.linspace(0.0, 1.0, 5)  # parameters on every segment at which curves are compared
_SLIDE = 4.0  # times the tolerance by which a point may move along its curve
_LEAST, _MOST = (0.1, 0.0, 0.1, 0.0), (0.9, 1.0, 0.9, 1.0)  # where handles may be: never back in time
_ROUNDS, _STEPS = 2, 3  # of alternating between the easing and the values, and of the easing in each
_TIE = 1e-4  # pull of an easing towards an even one, against samples of weight one
_REACH = 128  # samples over which one keyframe may reach; bounds the cost of long clips


@dataclass(frozen=True, slots=True, eq=False)
class _Seen:
    """Curves on N samples of time, at M places on each of G segments.

    Args:
        points: px [N, G, M, 2]
        tangent: Unit vectors. [N, G, M, 2]
        bend: Curvature. 1/px [N, G, M]
        is_end: Places whose position is seen along the curve too: where open curves end. bool [G, M]
        tolerance: px
    """

    points: Floats
    tangent: Floats
    bend: Floats
    is_end: Bools
    tolerance: float

    @staticmethod
    def of(paths: Sequence[Floats], is_open: bool, tolerance: float) -> _Seen:
        """Of several paths [N, 3n+1, 2]."""
        control = _segments(paths)[..., None, :, :]
        points = evaluate(control, _SAMPLES)
        velocity = derivative(control, _SAMPLES)
        speed = np.linalg.norm(velocity, axis=-1)
        chord = control[..., 3, :] - control[..., 0, :]
        is_slow = speed <= 1e-3 * np.abs(np.diff(control, axis=-2)).sum((-1, -2))  # a handle on its joint
        velocity = np.where(is_slow[..., None], chord, velocity)
        tangent = velocity / np.maximum(np.linalg.norm(velocity, axis=-1, keepdims=True), 1e-9)
        legs = np.diff(control, n=2, axis=-2)
        turn = 6 * ((1 - _SAMPLES)[:, None] * legs[..., 0, :] + _SAMPLES[:, None] * legs[..., 1, :])
        cross = np.abs(velocity[..., 0] * turn[..., 1] - velocity[..., 1] * turn[..., 0])
        bend = np.where(is_slow, 0.0, cross / np.maximum(speed, 1e-9) ** 3)
        is_end = np.zeros(points.shape[1:3], bool)
        if is_open:
            is_end[0, 0] = is_end[-1, -1] = True
        return _Seen(points, tangent, bend, is_end, tolerance)

    def is_met(self, first: int, control: Floats) -> bool:
        """Whether segments [n, G, 4, 2] show the curves of n samples from one on.

        The distance from a curve is that along its normal, and what the curve bends away over the slide along it.
        """
        rows = slice(first, first + len(control))
        off = evaluate(control[..., None, :, :], _SAMPLES) - self.points[rows]
        along = (off * self.tangent[rows]).sum(-1)
        across = off[..., 0] * self.tangent[rows][..., 1] - off[..., 1] * self.tangent[rows][..., 0]
        distance = np.maximum(np.abs(across) + 0.5 * self.bend[rows] * along**2, np.abs(along) / _SLIDE)
        distance[:, self.is_end] = np.hypot(along, across)[:, self.is_end]
        return bool(distance.max() <= self.tolerance)


@dataclass(frozen=True, slots=True, eq=False)
class _Span:
    """What control points do from one keyframe on: from, to (flat) and the heights of the easing's handles."""

    start: Floats
    end: Floats
    handles: Floats


def reduce_paths(
    times: Floats, paths: Sequence[Floats], is_held: Bools, tolerance: float, *, is_open: bool = False
) -> tuple[Animated, ...]:
    """Choose few keyframes that show moving paths.

    Args:
        times: When each sample is, increasing. [N] ticks
        paths: Splines that move together. [N, 3n+1, 2] px each
        is_held: Whether each sample stays as it is until the next, so that none may move between them. bool [N]
        tolerance: How far a curve may lie from where it was. px
        is_open: Whether the ends of the paths are seen.

    Returns:
        One for each path, with the same times, holds and easings.
    """
    flat = np.concatenate([path.reshape(len(times), -1) for path in paths], axis=1)
    shapes = [path.shape[1:] for path in paths]
    seen = _Seen.of(paths, is_open, tolerance)
    search = _Search(times, flat, is_held, lambda first, drawn: seen.is_met(first, _segments(_split(drawn, shapes))))
    keys = search.keyframes()
    return tuple(Animated(keys.times, values, keys.is_hold, keys.handles) for values in _split(keys.values, shapes))


def _split(flat: Floats, shapes: Sequence[tuple[int, ...]]) -> list[Floats]:
    """Flat samples [n, Q] as paths [n, P, 2]."""
    ends = np.cumsum([int(np.prod(shape)) for shape in shapes])[:-1]
    return [part.reshape(-1, *shape) for part, shape in zip(np.split(flat, ends, axis=1), shapes, strict=True)]


def _segments(paths: Sequence[Floats]) -> Floats:
    """The segments of all paths. [N, G, 4, 2]"""
    return np.concatenate(
        [path[:, 3 * np.arange((path.shape[1] - 1) // 3)[:, None] + np.arange(4)] for path in paths], axis=1
    )


@dataclass(frozen=True, slots=True, eq=False)
class _Search:
    """From each keyframe the farthest one that may follow.

    Args:
        times: [N] ticks
        samples: [N, Q]
        is_held: bool [N]
        is_met: Whether values [n, Q] will do for the samples from one on.
    """

    times: Floats
    samples: Floats
    is_held: Bools
    is_met: Callable[[int, Floats], bool]

    def keyframes(self) -> Animated:
        """The keyframes of all samples, flat."""
        count = len(self.times)
        chosen: list[tuple[int, Floats, bool, Floats]] = []
        at, value = 0, None
        while at < count:
            rest, value_of_rest = self._rest(at, value)
            to, span = self._move(at, value) if rest < count else (at, None)
            if span is None or rest >= to:
                chosen.append((at, value_of_rest, True, np.array(EVEN)))
                at, value = rest, None
            else:
                chosen.append((at, span.start, False, span.handles))
                at, value = to, span.end
                if at == count - 1:
                    chosen.append((at, span.end, True, np.array(EVEN)))
                    break
        index, values, holds, handles = zip(*chosen, strict=True)
        return Animated(self.times[list(index)], np.stack(values), np.array(holds), np.stack(handles))

    def _rest(self, at: int, value: Floats | None) -> tuple[int, Floats]:
        """Until when a value may be held, exclusive, and the value; ``at`` itself where it may not."""
        found = at, self.samples[at] if value is None else value

        def is_good(stop: int) -> bool:
            nonlocal found
            mean = self.samples[at:stop].mean(0) if value is None else value
            is_met = self.is_met(at, np.broadcast_to(mean, (stop - at, len(mean))))
            if is_met and (stop == len(self.times) or self.is_held[stop - 1]):
                found = max(found, (stop, mean), key=lambda pair: pair[0])
            return is_met

        _farthest(at + 1, min(at + _REACH, len(self.times)), is_good)
        return found

    def _move(self, at: int, value: Floats | None) -> tuple[int, _Span | None]:
        """The farthest sample to which one move leads, and the move."""
        held = np.flatnonzero(self.is_held[at : at + _REACH])
        last = min(at + _REACH, len(self.times) - 1, at + int(held[0]) if len(held) else len(self.times))
        if last <= at:
            return at, None
        start = self.samples[at] if value is None else value
        found = at + 1, _Span(start, self.samples[at + 1], np.array(EVEN))

        def is_good(to: int) -> bool:
            nonlocal found
            share = (self.times[at : to + 1] - self.times[at]) / (self.times[to] - self.times[at])
            span = _fitted(self.samples[at : to + 1], share, value)
            drawn = span.start + ease(span.handles, share)[:, None] * (span.end - span.start)
            if self.is_met(at, drawn):
                found = max(found, (to, span), key=lambda pair: pair[0])
                return True
            return False

        _farthest(at + 2, last, is_good)
        return found


def _farthest(first: int, last: int, is_good: Callable[[int], bool]) -> None:
    """Try numbers from the first on, in strides that double while they are good, then between the best and the next."""
    good, stride = first - 1, 1
    while good < last:
        at = min(good + stride, last)
        if is_good(at):
            good, stride = at, 2 * stride
        elif stride == 1:
            return
        else:
            last, stride = at - 1, 1


def _fitted(samples: Floats, share: Floats, start: Floats | None) -> _Span:
    """The move that lies nearest to samples [n, Q] at shares of its time, from a value or from any. Least squares."""
    handles = np.array(EVEN)
    begin, end = samples[0] if start is None else start, samples[-1]
    for _ in range(_ROUNDS if len(samples) > 2 else 1):
        step = end - begin
        size = float(step @ step)
        for _ in range(_STEPS if len(samples) > 2 and size > 1e-9 else 0):
            handles = _better(handles, share[1:-1], (samples[1:-1] - begin) @ step / size)
        begin, end = _ends(samples, ease(handles, share), start)
    return _Span(begin, end, handles)


def _better(handles: Floats, share: Floats, way: Floats) -> Floats:
    """Handles [4] after a Gauss-Newton step towards an easing that has come a way [n] at shares of the time [n]."""
    x1, y1, x2, y2 = handles
    t = parameter_of(x1, x2, share)
    before, after = 3 * (1 - t) ** 2 * t, 3 * (1 - t) * t**2
    rise, run = ((1 - t) ** 2 * a + 2 * (1 - t) * t * (b - a) + t**2 * (1 - b) for a, b in ((y1, y2), (x1, x2)))
    slope = rise / np.maximum(run, 0.02)
    jacobian = np.stack([-slope * before, before, -slope * after, after], axis=1)
    normal = jacobian.T @ jacobian + _TIE * np.eye(4)
    pull = jacobian.T @ (way - before * y1 - after * y2 - t**3) + _TIE * (np.array(EVEN) - handles)
    return np.clip(handles + np.linalg.solve(normal, pull), _LEAST, _MOST)


def _ends(samples: Floats, eased: Floats, start: Floats | None) -> tuple[Floats, Floats]:
    """Both ends of the move nearest to samples."""
    if start is not None:
        return start, start + eased @ (samples - start) / (eased @ eased)
    design = np.stack([1 - eased, eased], axis=1)
    both = np.linalg.solve(design.T @ design, design.T @ samples)
    return both[0], both[1]
