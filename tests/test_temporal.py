from dataclasses import replace

import numpy as np
import pytest
import torch
from numpy.typing import NDArray

from videovec.strokes import Layout, Strokes
from videovec.temporal import Neighbours, acceleration, anchor, rigidity, width_change

SHAPE = np.array([[10, 10], [20, 30], [40, 35], [60, 20], [70, 10], [80, 12], [90, 30]], float)


def life(drawings: list[NDArray[np.float64]]) -> tuple[torch.Tensor, Neighbours]:
    """One stroke whose control points at each drawing are given, behind a one-drawing stroke that must not matter."""
    layout = Layout(np.array([1, (len(drawings[0]) - 1) // 3]), np.array([0, 0]), np.array([0, len(drawings) - 1]))
    other = np.random.default_rng(0).uniform(0, 100, (4, 2))
    return torch.tensor(np.concatenate([other, *drawings]), dtype=torch.float64), Neighbours.of(layout)


def moved(angle: float, scale: float, shift: tuple[float, float]) -> NDArray[np.float64]:
    c, s = scale * np.cos(angle), scale * np.sin(angle)
    return np.asarray(SHAPE @ np.array([[c, s], [-s, c]]) + shift)


def test_constant_velocity_has_no_acceleration() -> None:
    points, neighbours = life([SHAPE + k * np.array([3.0, -2.0]) for k in range(5)])
    assert acceleration(points, neighbours).item() == pytest.approx(0.0, abs=1e-18)


def test_a_small_tremble_costs_its_square_and_a_leap_little_more() -> None:
    small, large = (life([SHAPE, SHAPE + np.array([step, 0.0]), SHAPE]) for step in (0.01, 20.0))
    # 7 points whose second difference is twice the step
    assert acceleration(*small).item() == pytest.approx(7 * 0.02**2, rel=1e-3)
    assert acceleration(*large).item() == pytest.approx(7 * 0.25 * np.log1p(40.0**2 / 0.25), rel=1e-9)


@pytest.mark.parametrize("motion", [(0.0, 1.0, (9.0, -4.0)), (0.7, 1.0, (0.0, 0.0)), (-1.2, 1.3, (5.0, 5.0))])
def test_similarities_are_rigid(motion: tuple[float, float, tuple[float, float]]) -> None:
    points, neighbours = life([SHAPE, moved(*motion)])
    assert rigidity(points, neighbours).item() == pytest.approx(0.0, abs=1e-18)


def test_sliding_along_a_stroke_is_not_rigid() -> None:
    x = np.linspace(0, 60, 7)
    slid = x.copy()
    slid[1:-1] += 4.0
    still, moving = (life([np.stack([x, 0 * x], 1), np.stack([v, 0 * v], 1)]) for v in (x, slid))
    assert rigidity(*still).item() == pytest.approx(0.0, abs=1e-18)
    assert rigidity(*moving).item() > 1.0


def test_temporal_gradients_match_finite_differences() -> None:
    rng = np.random.default_rng(1)
    points, neighbours = life([SHAPE + rng.normal(0, 2, SHAPE.shape) for _ in range(3)])
    points.requires_grad_()
    assert torch.autograd.gradcheck(lambda x: acceleration(x, neighbours), (points,))
    assert torch.autograd.gradcheck(lambda x: rigidity(x, neighbours), (points,))


def test_width_change_sees_growth_and_not_thickness() -> None:
    strokes = Strokes.from_curves([SHAPE], [np.array([1.0, 2.0, 3.0])])
    layout = replace(strokes.layout, last=np.array([1]))
    neighbours = Neighbours.of(layout)
    same = torch.log(torch.tensor([1.0, 2.0, 3.0, 1.0, 2.0, 3.0]))
    assert width_change(same, neighbours).item() == pytest.approx(0.0)
    doubled = torch.log(torch.tensor([1.0, 2.0, 3.0, 2.0, 4.0, 6.0]))
    assert width_change(doubled, neighbours).item() == pytest.approx(3 * np.log(2) ** 2, rel=1e-5)


def test_a_stroke_of_one_drawing_has_no_temporal_terms() -> None:
    strokes = Strokes.from_curves([SHAPE], [np.ones(3)])
    neighbours = Neighbours.of(strokes.layout)
    points = torch.tensor(strokes.points)
    assert acceleration(points, neighbours).item() == 0.0
    assert rigidity(points, neighbours).item() == 0.0


def test_only_first_drawings_are_anchored() -> None:
    points, neighbours = life([SHAPE, SHAPE, SHAPE])
    moved = points.clone()
    moved[11:] += 5.0  # the one-drawing stroke has 4 points, the first drawing of the other 7
    assert anchor(moved, points, neighbours).item() == 0.0
    moved[4, 0] += 2.0
    assert anchor(moved, points, neighbours).item() == pytest.approx(4.0)


def test_a_shape_that_moves_far_may_change_more_than_one_that_stays() -> None:
    bent = SHAPE + np.array([0.0, 1.0]) * (np.arange(7) == 3)[:, None]
    near, far = (rigidity(*life([SHAPE, bent + np.array([step, 0.0])])).item() for step in (1.0, 40.0))
    assert 0.0 < far < 0.1 * near
