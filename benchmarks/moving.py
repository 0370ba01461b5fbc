"""Clips of our own with strokes that are known on every drawing: nothing was chosen on them."""

from __future__ import annotations

from collections.abc import Callable
from fractions import Fraction

import numpy as np
from numpy.typing import NDArray

from samples.scene import Line, paint, spline
from videovec.clip import Clip, Timeline
from videovec.clip_metrics import TrueStroke

__all__ = ["MOTIONS", "moving_clip"]

Floats = NDArray[np.float64]
Motion = Callable[[Floats, Floats, float], Floats]

SIDE, WIDTH, STROKES = 384, 3.0, 12


def _turned(points: Floats, centre: Floats, degrees: float) -> Floats:
    angle = np.radians(degrees)
    turn = np.array([[np.cos(angle), np.sin(angle)], [-np.sin(angle), np.cos(angle)]])
    return np.asarray((points - centre) @ turn + centre)


def _swing(points: Floats, centre: Floats, time: float) -> Floats:
    """To and fro about a point, fastest in the middle."""
    return _turned(points, centre, 15.0 * float(np.sin(2 * np.pi * time / 13)))


def _bounce(points: Floats, centre: Floats, time: float) -> Floats:
    """Up and down with a sudden turn at the bottom, flattened there."""
    phase = (time / 8 + 0.3) % 1.0
    squash = 1 + 0.08 * (min(phase, 1 - phase) < 0.12)
    return np.asarray((points - centre) * [squash, 1 / squash] + centre + [1.3 * time, -90 * phase * (1 - phase)])


def _curl(points: Floats, centre: Floats, time: float) -> Floats:
    """Turned the more, the farther from a point: every stroke bends."""
    reach = np.linalg.norm(points - centre, axis=1, keepdims=True) / 60
    angle = np.radians(12.0) * np.sin(2 * np.pi * time / 12) * reach
    x, y = (points - centre).T[:, :, None]
    return np.asarray(
        centre + np.hstack([x * np.cos(angle) - y * np.sin(angle), x * np.sin(angle) + y * np.cos(angle)])
    )


MOTIONS: dict[str, Motion] = {"swing": _swing, "bounce": _bounce, "curl": _curl}


def moving_clip(name: str, drawings: int = 16, seed: int = 0) -> tuple[Clip, list[list[TrueStroke]]]:
    """A clip of smooth strokes in three groups that move alike but not together.

    Args:
        name: One of `MOTIONS`.
        drawings: D.
        seed: Of the strokes.

    Returns:
        The clip, and the true strokes of every drawing.
    """
    rng = np.random.default_rng(seed)
    centres = SIDE * np.array([[0.28, 0.33], [0.72, 0.38], [0.46, 0.74]])
    curves = [_random_curve(rng, centres[k % 3]) for k in range(STROKES)]
    truth, images = [], []
    for drawing in range(drawings):
        moved = [MOTIONS[name](curve, centres[k % 3], drawing + 1.7 * (k % 3)) for k, curve in enumerate(curves)]
        images.append(paint(tuple(Line(str(k), p, WIDTH, (0, 0, 0)) for k, p in enumerate(moved)), (SIDE, SIDE)))
        truth.append([TrueStroke(k + 1, p) for k, p in enumerate(moved)])
    times = tuple(Fraction(drawing, 12) for drawing in range(drawings))
    timeline = Timeline(np.arange(drawings), times, Fraction(drawings, 12), np.arange(1, drawings + 1))
    return Clip(name, tuple(images), timeline), truth


def _random_curve(rng: np.random.Generator, centre: Floats) -> Floats:
    heading = rng.uniform(0, 2 * np.pi) + np.cumsum(rng.normal(0, 0.5, 5))
    steps = 24.0 * np.stack([np.cos(heading), np.sin(heading)], axis=1)
    line = np.concatenate([np.zeros((1, 2)), np.cumsum(steps, axis=0)])
    return spline(line - line.mean(0) + centre + rng.uniform(-36, 36, 2))
