"""The terms of one drawing pull the fit the way their name says."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import torch

from videovec.fit import draw_coverage, fit
from videovec.ink import Ink
from videovec.losses import continuity, self_intersection
from videovec.render import resolve_backend
from videovec.settings import EditSettings, FitSettings, RenderSettings, Weights
from videovec.strokes import Strokes

SIZE = 96
ROOF = np.array([[10.0, 60.0], [24.0, 45.0], [36.0, 39.0], [48.0, 36.0], [60.0, 39.0], [72.0, 45.0], [86.0, 60.0]])
CROSSED = np.array([[20.0, 50.0], [70.0, 30.0], [26.0, 30.0], [76.0, 50.0]])


def _strokes(curve: np.ndarray[tuple[int, ...], np.dtype[np.float64]]) -> Strokes:
    return Strokes.from_curves([curve], [np.full((len(curve) - 1) // 3 + 1, 1.5)])


def _fitted(strokes: Strokes, weights: Weights, **settings: int) -> torch.Tensor:
    coverage = draw_coverage(strokes, (1, SIZE, SIZE), resolve_backend(RenderSettings()))
    ink = Ink(coverage, np.zeros_like(coverage), np.zeros((1, 3)), np.ones(3), 0.0)
    told = replace(FitSettings(steps=60, weights=weights, edits=EditSettings(every=0)), **settings)  # type: ignore[arg-type]
    return torch.as_tensor(fit(ink, strokes, told).strokes.segments())


def test_continuity_smooths_joints_that_are_no_corners() -> None:
    joints = torch.tensor([0]), torch.tensor([1])
    free, smooth = (_fitted(_strokes(ROOF), Weights(continuity=weight)) for weight in (0.0, 100.0))
    assert continuity(smooth, *joints) < 0.3 * continuity(free, *joints)


def test_self_intersection_draws_crossed_handles_apart_against_the_ink() -> None:
    free, open_ = (_fitted(_strokes(CROSSED), Weights(self_intersection=weight)) for weight in (0.0, 300.0))
    assert self_intersection(open_) < 0.95 * self_intersection(free)


def test_corners_are_left_out_of_continuity() -> None:
    corner = np.concatenate(
        [np.linspace([10.0, 10.0], [50.0, 80.0], 4), np.linspace([50.0, 80.0], [85.0, 15.0], 4)[1:]]
    )
    fitted = _fitted(_strokes(corner), Weights(continuity=100.0))
    np.testing.assert_allclose(fitted[0, 3], [50.0, 80.0], atol=0.2)


@pytest.mark.parametrize("every", [1, 5])
def test_a_perceptual_weight_moves_the_fit(every: int) -> None:
    start = replace(_strokes(ROOF), points=ROOF + 0.7)
    free, seen = (_fitted(start, Weights(perceptual=weight), steps=10, perceptual_every=every) for weight in (0.0, 0.1))
    assert not torch.equal(free, seen)
