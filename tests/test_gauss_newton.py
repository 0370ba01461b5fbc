"""The normal equations against those of the dense definition; that their steps draw what Adam's cannot as fast."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import torch

from videovec.fit import draw_coverage
from videovec.gauss_newton import GaussNewton
from videovec.optimise import Schedule, optimise
from videovec.parameters import Parameters
from videovec.render import Backend, coverage_loss_and_gradients, coverage_normal_equations, list_pairs
from videovec.strokes import Strokes

SIDE = 48
NUMBA = Backend("numba", torch.device("cpu"))


def drawn() -> Strokes:
    """An open stroke of two segments, a closed one and a line across."""
    wave = np.array([[6, 10], [14, 2], [18, 18], [24, 12], [30, 6], [36, 4], [42, 11.0]])
    turn = np.array([0, 2, 4, 6, 8, 10, 12]) * np.pi / 6
    ring = 28 + 11 * np.stack([np.cos(turn), np.sin(turn)], axis=1)
    ring[-1] = ring[0]
    line = np.array([[5, 40], [18, 36], [30, 30], [44, 25.0]])
    widths = [np.array([1.0, 1.6, 1.2]), np.full(3, 1.3), np.array([0.8, 1.4])]
    return Strokes.from_curves([wave, ring, line], widths, is_closed=np.array([False, True, False]))


def moved(strokes: Strokes, distance: float) -> Strokes:
    noise = np.random.default_rng(0).normal(0, distance, strokes.points.shape)
    points = strokes.points + noise
    ends = strokes.layout.row_points
    points[ends[2] - 1] = points[ends[1]]
    return replace(strokes, points=points)


def test_the_gradient_of_the_equations_is_that_of_the_fused_loss() -> None:
    parameters = Parameters.of(moved(drawn(), 0.5))
    target = torch.from_numpy(draw_coverage(drawn(), (1, SIDE, SIDE), NUMBA))
    with torch.no_grad():
        scene = parameters.scene((1, SIDE, SIDE), parameters.intervals())
        pairs = list_pairs(scene, 1.0)
        for _ in range(6):
            match = coverage_loss_and_gradients(scene, pairs, 1.0, target)
        equations = coverage_normal_equations(scene, pairs, 1.0, target)
    ours = equations.gradient
    points = torch.stack([ours[:, [0, 1]], ours[:, [3, 4]], ours[:, [5, 6]], ours[:, [7, 8]]], dim=1)
    assert float(equations.loss[0]) > 0.1
    torch.testing.assert_close(equations.loss, match.loss, rtol=1e-4, atol=1e-4)
    torch.testing.assert_close(points, match.control, rtol=1e-3, atol=1e-3)
    torch.testing.assert_close(ours[:, [2, 9]], match.half_width, rtol=1e-3, atol=1e-3)


def test_the_matrix_says_how_the_gradient_of_a_perfect_fit_changes() -> None:
    parameters = Parameters.of(drawn().select(np.array([True, False, False])))
    size = (1, SIDE, SIDE)
    with torch.no_grad():
        scene = parameters.scene(size, parameters.intervals())
    target = torch.from_numpy(draw_coverage(parameters.to_strokes(), size, NUMBA))
    direction = torch.tensor([0.5, -1.0, 0.7, 0.3])
    changed = []
    for step in (0.02, -0.02):
        with torch.no_grad():
            parameters.points[3] += step * direction[:2]  # the joint in the middle, of both segments
            parameters.points[2] += step * direction[2:]
            near = parameters.scene(size, parameters.intervals())
            pairs = list_pairs(near, 1.0)
            for _ in range(6):
                found = coverage_normal_equations(near, pairs, 1.0, target)
            changed.append(found.gradient[0])
            parameters.points[3] -= step * direction[:2]
            parameters.points[2] -= step * direction[2:]
    pairs = list_pairs(scene, 1.0)
    for _ in range(6):
        matrix = coverage_normal_equations(scene, pairs, 1.0, target).matrix[0]
    whole = matrix + matrix.T - torch.diag(matrix.diagonal())
    along = torch.zeros(10)
    along[[7, 8]], along[[5, 6]] = direction[:2], direction[2:]
    numeric = (changed[0] - changed[1]) / 0.04
    assert float((whole @ along - numeric).norm() / numeric.norm()) < 0.1  # the rest is the residual's curvature


def test_a_few_steps_find_the_strokes_again() -> None:
    size = (1, SIDE, SIDE)
    target, start = draw_coverage(drawn(), size, NUMBA), moved(drawn(), 0.7)
    ends = {
        name: optimise(start, target, Schedule(steps=25, floor=0.01, is_newton=name == "newton"), backend=NUMBA)
        for name in ("newton", "adam")
    }
    errors = {
        name: float(np.square(draw_coverage(found.strokes, size, NUMBA) / 255.0 - target / 255.0).sum())
        for name, found in ends.items()
    }
    before = float(np.square(draw_coverage(start, size, NUMBA) / 255.0 - target / 255.0).sum())
    assert errors["newton"] < 0.02 * before
    assert errors["newton"] < 0.5 * errors["adam"]
    closed = ends["newton"].strokes
    np.testing.assert_array_equal(
        closed.points[closed.layout.row_points[1]], closed.points[closed.layout.row_points[2] - 1]
    )


def test_no_step_is_longer_than_the_margin_of_the_lists() -> None:
    parameters = Parameters.of(moved(drawn(), 3.0))
    before = parameters.points.detach().clone()
    with torch.no_grad():
        scene = parameters.scene((1, SIDE, SIDE), parameters.intervals())
        equations = coverage_normal_equations(
            scene, list_pairs(scene, 1.0), 1.0, torch.zeros(1, SIDE, SIDE, dtype=torch.uint8)
        )
    GaussNewton(parameters, 1).step(equations)
    length = (parameters.points.detach() - before).norm(dim=1)
    assert 0 < float(length.max()) <= 1.0 + 1e-5
