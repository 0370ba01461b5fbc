from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from videovec import metrics
from videovec.errors import FitError
from videovec.strokes import Strokes

Floats = NDArray[np.float64]


def line(start: tuple[float, float], stop: tuple[float, float]) -> Floats:
    return np.linspace(start, stop, 4)


def drawing(*curves: Floats) -> Strokes:
    return Strokes.from_curves(list(curves), [np.ones((len(curve) - 1) // 3 + 1) for curve in curves])


ACROSS, DOWN = line((0, 0), (100, 0)), line((50, 10), (50, 90))


@pytest.mark.parametrize("offset", [0.0, 0.5, 3.0])
def test_chamfer_of_a_shifted_line_is_the_shift(offset: float) -> None:
    moved = drawing(ACROSS + np.array([0.0, offset]))
    assert metrics.chamfer(drawing(ACROSS), moved) == pytest.approx(offset)


def test_chamfer_counts_a_missing_stroke_one_way() -> None:
    truth = drawing(ACROSS, ACROSS + np.array([0.0, 10.0]))
    assert metrics.chamfer(truth, drawing(ACROSS)) == pytest.approx(0.5 * 5.0)


def test_length_difference_is_relative_to_the_truth() -> None:
    assert metrics.length_difference(drawing(ACROSS, DOWN), drawing(ACROSS)) == pytest.approx(80.0 / 180.0)
    assert metrics.length_difference(drawing(ACROSS), drawing(ACROSS, DOWN)) == pytest.approx(0.8)


def test_equal_drawings_match_fully() -> None:
    score = metrics.topology(drawing(ACROSS, DOWN), drawing(DOWN, ACROSS[::-1]), 2.0)
    assert (score.covered, score.matched, score.fragments, score.merges) == (1.0, 1.0, 0, 0)


def test_a_cut_stroke_is_fragments() -> None:
    halves = drawing(line((0, 0), (50, 0)), line((50, 0), (100, 0)), DOWN)
    score = metrics.topology(drawing(ACROSS, DOWN), halves, 2.0)
    assert (score.covered, score.matched, score.fragments, score.merges) == (0.5, 0.5, 2, 0)


def test_a_merged_stroke_covers_its_parts_but_matches_neither() -> None:
    corner = np.concatenate([line((0, 0), (100, 0)), line((100, 0), (100, 100))[1:]])
    truth = drawing(line((0, 0), (100, 0)), line((100, 0), (100, 100)))
    score = metrics.topology(truth, drawing(corner), 2.0)
    assert (score.covered, score.matched, score.fragments, score.merges) == (1.0, 0.0, 0, 1)


def test_a_stroke_too_far_away_covers_nothing() -> None:
    score = metrics.topology(drawing(ACROSS), drawing(ACROSS + np.array([0.0, 2.5])), 2.0)
    assert (score.covered, score.matched) == (0.0, 0.0)


def test_a_drawing_without_strokes_cannot_be_compared() -> None:
    with pytest.raises(FitError, match="got 1 true and 0 others"):
        metrics.chamfer(drawing(ACROSS), Strokes.empty())


def test_psnr_of_a_uniform_error() -> None:
    assert metrics.psnr(np.zeros((8, 8)), np.full((8, 8), 0.1)) == pytest.approx(20.0)
    assert metrics.psnr(np.ones((8, 8)), np.ones((8, 8))) == float("inf")


@pytest.mark.parametrize("noise", [0.0, 0.02, 0.3])
def test_ssim_is_what_its_definition_gives_window_by_window(noise: float) -> None:
    rng = np.random.default_rng(1)
    truth = rng.uniform(size=(16, 19))
    image = np.clip(truth + rng.normal(scale=noise, size=truth.shape), 0.0, 1.0)
    bell = np.exp(-0.5 * ((np.arange(11) - 5) / 1.5) ** 2)
    weight = np.outer(bell, bell) / bell.sum() ** 2
    values = []
    for row in range(6):
        for column in range(9):
            x, y = (part[row : row + 11, column : column + 11] for part in (truth, image))
            mx, my = (weight * x).sum(), (weight * y).sum()
            vx, vy = (weight * (x - mx) ** 2).sum(), (weight * (y - my) ** 2).sum()
            both = (weight * (x - mx) * (y - my)).sum()
            values.append((2 * mx * my + 1e-4) * (2 * both + 9e-4) / ((mx**2 + my**2 + 1e-4) * (vx + vy + 9e-4)))
    assert metrics.ssim(truth, image) == pytest.approx(np.mean(values), abs=1e-6)


def test_ssim_needs_equal_images() -> None:
    with pytest.raises(FitError, match="ssim needs two equal images"):
        metrics.ssim(np.zeros((20, 20)), np.zeros((20, 21)))
