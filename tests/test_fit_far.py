"""The joint fit of strokes that move far from one drawing to the next."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray
from test_propagate import WIDTH, draw, ink_of

from samples.scene import spline
from videovec.curves import sample_by_arc
from videovec.fit import fit
from videovec.settings import FitSettings
from videovec.stroke_life import StrokeLife
from videovec.strokes import Strokes
from videovec.temporal import moves_far

Floats = NDArray[np.float64]

X = np.linspace(-50.0, 50.0, 7)
COUNT = 9


def waving(step: float) -> list[Floats]:
    """A curve that bends otherwise on every drawing, and goes to and fro."""
    bend = 1.2 * np.sin(2.1 * np.arange(COUNT))
    return [
        spline(np.stack([X + 80 + step * (k % 2 - 0.5), b * (25 * np.sin(X / 25) + 0.02 * X * X) + 80], axis=1))
        for k, b in enumerate(bend)
    ]


def life_of(points: Floats) -> Strokes:
    return StrokeLife(
        id=1,
        first=0,
        points=points,
        half_width=np.full((COUNT, len(X)), WIDTH / 2),
        opacity=np.ones(COUNT),
        visible=np.tile([0.0, 1.0], (COUNT, 1)),
        color=np.zeros(3),
        layer=0,
        is_closed=False,
    ).as_strokes()


@pytest.mark.parametrize("seed", [0, 1])
def test_strokes_that_move_far_reach_their_ink_however_many_drawings_there_are(seed: int) -> None:
    truth, rng = waving(30.0), np.random.default_rng(seed)
    off = [spline(np.stack([X, 3.5 * rng.normal(0, 1, len(X))], axis=1)) * (0.0, 1.0) for _ in truth]
    fitted = fit(ink_of([draw([curve]) for curve in truth]), life_of(np.stack(truth) + off), FitSettings()).strokes
    gaps = [
        np.linalg.norm(sample_by_arc(fitted.points_of(d), 60)[:, None] - sample_by_arc(curve, 400), axis=2).min(axis=1)
        for d, curve in enumerate(truth)
    ]
    assert np.mean(gaps) < 0.17


@pytest.mark.parametrize(("share", "expected"), [(0.08, False), (0.12, True)])
def test_strokes_move_far_if_a_tenth_of_them_does(share: float, expected: bool) -> None:
    lines = np.stack([np.linspace((0.0, k), (30.0, k), 4) for k in range(100)])
    shift = np.where(np.arange(100) < round(100 * share), 13.0, 3.0)
    lives = [
        StrokeLife(
            id=k + 1,
            first=0,
            points=np.stack([line, line + np.array([0.0, shift[k]])]),
            half_width=np.full((2, 2), WIDTH / 2),
            opacity=np.ones(2),
            visible=np.tile([0.0, 1.0], (2, 1)),
            color=np.zeros(3),
            layer=k,
            is_closed=False,
        ).as_strokes()
        for k, line in enumerate(lines)
    ]
    assert moves_far(Strokes.concatenate(lives)) == expected
