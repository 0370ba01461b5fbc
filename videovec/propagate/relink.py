"""Strokes that come back: traced ink that has the shape of a hidden stroke is that stroke."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from videovec.curves import sample_by_arc, sub_curve
from videovec.propagate.follower import Follower
from videovec.propagate.record import Life, Row

__all__ = ["relink", "same_shape"]

Floats = NDArray[np.float64]
Complexes = NDArray[np.complex128]

_SAMPLES = 32
_MISFIT = 0.025
"""Root mean square distance of two shapes that are one stroke, as a share of its length."""
_SCALE = 1.25
"""Factor by which a stroke may have grown or shrunk."""
_REACH = 0.75
"""How far a hidden stroke may have gone, in its own lengths."""


def relink(lives: list[Life], drawing: int, followers: list[Follower]) -> list[Life]:
    """Give traced strokes to the hidden strokes that they are.

    Args:
        lives: Newly traced, with a row on the drawing.
        drawing: Where.
        followers: All lives that are followed, with rows on the drawing; those that are found again get a new row.

    Returns:
        The traced strokes that are new.
    """
    hidden = [f for f in followers if f.unseen > 0 and drawing in f.life.rows]
    pairs = []
    for a, life in enumerate(lives):
        for b, follower in enumerate(hidden):
            if life.is_closed == follower.life.is_closed and np.abs(life.color - follower.life.color).max() < 0.25:
                match = same_shape(_seen_part(follower.life, drawing), life.rows[drawing].points, life.is_closed)
                if match is not None:
                    pairs.append((match[0], a, b, match[1]))
    taken: set[int] = set()
    found: set[int] = set()
    for _, a, b, samples in sorted(pairs, key=lambda pair: pair[0]):
        if a in taken or b in found:
            continue
        taken.add(a)
        found.add(b)
        _resume(hidden[b], drawing, samples)
    return [life for a, life in enumerate(lives) if a not in taken]


def _seen_part(life: Life, drawing: int) -> Floats:
    """The part of a hidden stroke that was seen before. Control points [3n+1, 2] px"""
    row = life.rows[drawing]
    return sub_curve(row.points, row.half_width, *life.most_seen)[0]


def same_shape(old: Floats, new: Floats, is_closed: bool) -> tuple[float, Complexes] | None:
    """How far a stroke is from another up to a similarity, and the other's samples in the order of the first."""
    a = _samples(old, is_closed)
    best: tuple[float, Complexes] | None = None
    length = float(np.abs(np.diff(a)).sum())
    b = _samples(new, is_closed)
    if length < 1e-6 or np.abs((b - a).mean()) > _REACH * length:
        return None
    shifts = range(len(b)) if is_closed else range(1)
    for candidate in (b, b[::-1]):
        for shift in shifts:
            rolled = np.roll(candidate, shift)
            centred, target = a - a.mean(), rolled - rolled.mean()
            ratio = np.vdot(centred, target) / max(float(np.vdot(centred, centred).real), 1e-9)
            misfit = float(np.sqrt(np.mean(np.abs(target - ratio * centred) ** 2))) / length
            turn = abs(float(np.angle(ratio))) / np.pi if abs(ratio) > 0 else 1.0
            cost = misfit + 0.02 * turn + 0.02 * float(np.abs((b - a).mean())) / length
            fits = misfit < _MISFIT and 1 / _SCALE < abs(ratio) < _SCALE
            if fits and (best is None or cost < best[0]):
                best = cost, rolled
    return best


def _samples(points: Floats, is_closed: bool) -> Complexes:
    places = sample_by_arc(points, _SAMPLES + 1 if is_closed else _SAMPLES)[:_SAMPLES]
    return np.asarray(places[:, 0] + 1j * places[:, 1])


def _resume(follower: Follower, drawing: int, samples: Complexes) -> None:
    """Put a hidden stroke where it was found."""
    row, (begin, end) = follower.life.rows[drawing], follower.life.most_seen
    old = _samples(_seen_part(follower.life, drawing), follower.life.is_closed)
    ratio = np.vdot(old - old.mean(), samples - samples.mean()) / np.vdot(old - old.mean(), old - old.mean()).real
    z = ratio * (row.points @ np.array([1, 1j]) - old.mean()) + samples.mean()
    points = np.stack([z.real, z.imag], axis=1)
    ring = np.append(samples, samples[0]) if follower.life.is_closed else samples
    u = np.linspace(begin, end, len(ring))
    goal = follower.basis.weights @ points
    seen = (follower.basis.u >= begin) & (follower.basis.u <= end)
    goal[seen] = np.stack([np.interp(follower.basis.u[seen], u, x) for x in (ring.real, ring.imag)], axis=1)
    points = points + follower.basis.inverse @ (goal - follower.basis.weights @ points)
    follower.life.rows[drawing] = Row(points, row.half_width, row.opacity, (begin, end), 1.0)
    follower.velocity = np.zeros_like(follower.velocity)
    follower.unseen = 0
