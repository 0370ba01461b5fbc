"""What each term asks for, its units, and its gradients."""

from __future__ import annotations

from collections.abc import Callable

import cv2
import numpy as np
import pytest
import torch
from torch import Tensor

from videovec.losses import StructuralTerm, continuity, curvature, self_intersection
from videovec.render import PairList, Scene, list_pairs

OPEN = torch.tensor([[[0.0, 0.0], [3.0, 1.0], [6.0, 1.0], [9.0, 0.0]]])
CROSSED = torch.tensor([[[0.0, 0.0], [9.0, 4.0], [0.0, 4.0], [9.0, 0.0]]])
HAIRPIN = torch.tensor([[[0.0, 0.0], [9.0, 0.01], [9.0, 0.02], [0.0, 0.03]]])


@pytest.mark.parametrize("scale", [1e-2, 1.0, 1e3])
def test_crossed_handles_cost_more_than_open_ones_at_any_size(scale: float) -> None:
    assert float(self_intersection(CROSSED * scale)) > 0.5
    assert float(self_intersection(OPEN * scale)) < 0.3
    assert float(self_intersection(CROSSED * scale)) == pytest.approx(float(self_intersection(CROSSED)), abs=1e-4)


def test_descending_the_self_intersection_uncrosses_a_segment() -> None:
    segment = CROSSED.clone().requires_grad_()
    first = float(self_intersection(segment).detach())
    for _ in range(60):
        (gradient,) = torch.autograd.grad(self_intersection(segment), segment)
        assert float(gradient.norm()) > 1e-3 or float(self_intersection(segment).detach()) < 0.3
        segment = (segment - 0.2 * gradient / gradient.norm()).detach().requires_grad_()
    assert float(self_intersection(segment).detach()) < 0.3 < first


def test_a_hairpin_costs_and_a_circle_does_not() -> None:
    k = 0.5523
    quarter = torch.tensor([[[1.0, 0.0], [1.0, k], [k, 1.0], [0.0, 1.0]]]) * 20
    assert float(curvature(quarter, side=512)) == 0
    assert float(curvature(HAIRPIN, side=512)) > 0.9


def test_descending_the_curvature_opens_a_cusp() -> None:
    cusp = torch.tensor([[[0.0, 0.0], [9.0, 9.1], [0.0, 9.0], [9.0, 0.0]]], dtype=torch.float64)
    first = float(curvature(cusp, side=512, tightest=500))
    for _ in range(50):
        free = cusp.clone().requires_grad_()
        (gradient,) = torch.autograd.grad(curvature(free, side=512, tightest=500), free)
        cusp = cusp - 0.1 * gradient / gradient.norm().clamp(min=1e-9)
    assert float(curvature(cusp, side=512, tightest=500)) < first / 2


def test_curvature_is_measured_against_the_page() -> None:
    k = 0.5523
    arc = torch.tensor([[[1.0, 0.0], [1.0, k], [k, 1.0], [0.0, 1.0]]], dtype=torch.float64)
    assert float(curvature(arc, side=100, tightest=50)) == pytest.approx(0.5, abs=0.015)
    assert float(curvature(arc * 7, side=700, tightest=50)) == pytest.approx(0.5, abs=0.015)
    assert float(curvature(arc, side=100, tightest=120)) == 0


@pytest.mark.parametrize("turn", [0, 30, 90, 180])
def test_continuity_is_one_minus_the_cosine_of_the_turn(turn: float) -> None:
    angle = np.deg2rad(turn)
    heading = torch.tensor([np.cos(angle), np.sin(angle)])
    before = torch.tensor([[-9.0, 0.0], [-6.0, 0.0], [-3.0, 0.0], [0.0, 0.0]], dtype=torch.float64)
    after = torch.arange(4)[:, None] * 2.5 * heading
    both = torch.stack([before, after])
    assert float(continuity(both, torch.tensor([0]), torch.tensor([1]))) == pytest.approx(1 - np.cos(angle), abs=1e-6)


def test_no_joints_cost_nothing() -> None:
    none = torch.zeros(0, dtype=torch.long)
    assert float(continuity(OPEN, none, none)) == 0


@pytest.mark.parametrize(
    "term",
    [
        self_intersection,
        lambda s: curvature(s, 40.0, 60.0),
        lambda s: continuity(s, torch.tensor([0, 1]), torch.tensor([1, 2])),
    ],
)
def test_gradients_match_finite_differences(term: Callable[[Tensor], Tensor]) -> None:
    segments = torch.randn(4, 4, 2, generator=torch.Generator().manual_seed(2), dtype=torch.float64) * 3
    assert torch.autograd.gradcheck(term, (segments.requires_grad_(),))


@pytest.mark.parametrize("term", [self_intersection, lambda s: curvature(s, 512.0)])
def test_segments_without_length_have_finite_gradients(term: Callable[[Tensor], Tensor]) -> None:
    dot = torch.full((1, 4, 2), 7.0, requires_grad=True)
    term(dot).backward()  # type: ignore[no-untyped-call]
    assert dot.grad is not None
    assert bool(dot.grad.isfinite().all())


def pairs_on(side: int) -> PairList:
    """Pairs that make every pixel of two pages active."""
    line = torch.tensor([[0.0, side / 2], [side / 3, side / 2], [side / 1.5, side / 2], [side, side / 2]])
    scene = Scene(
        control=line.expand(2, 4, 2).double(),
        half_width=torch.full((2, 2), float(side)).double(),
        interval=torch.tensor([[0.0, 1.0]]).repeat(2, 1).double(),
        row=torch.arange(2),
        opacity=torch.ones(2).double(),
        color=torch.zeros(2, 0).double(),
        drawing=torch.arange(2),
        size=(2, side, side),
    )
    return list_pairs(scene, 1.0)


def slow_similarity(x: Tensor, y: Tensor) -> Tensor:
    """Mean SSIM, straight from its definition. [D]"""
    taps = torch.from_numpy(cv2.getGaussianKernel(11, 1.5)).double()
    window = (taps @ taps.T)[None, None]

    def mean(image: Tensor) -> Tensor:
        return torch.nn.functional.conv2d(image[:, None], window, padding=5)[:, 0]

    mx, my = mean(x), mean(y)
    vx, vy, vxy = mean(x * x) - mx**2, mean(y * y) - my**2, mean(x * y) - mx * my
    top, bottom = (2 * mx * my + 1e-4) * (2 * vxy + 9e-4), (mx**2 + my**2 + 1e-4) * (vx + vy + 9e-4)
    return (top / bottom).mean(dim=(1, 2))


def test_structural_similarity_and_its_gradient_are_those_of_the_definition() -> None:
    side = 24
    pairs = pairs_on(side)
    generator = torch.Generator().manual_seed(0)
    target = torch.randint(0, 256, (2, side, side), generator=generator, dtype=torch.uint8)
    value = torch.rand(2 * side * side, generator=generator, dtype=torch.float64)
    loss, slope = StructuralTerm(target).gradient(pairs, value)
    free = value.clone().requires_grad_()
    truth = 1 - slow_similarity(free.view(2, side, side), target.double() / 255)
    (gradient,) = torch.autograd.grad(truth.sum(), free)
    torch.testing.assert_close(loss, truth.detach(), rtol=0, atol=1e-5)
    assert float((slope - gradient).norm() / gradient.norm()) < 1e-4


def test_a_drawing_is_like_itself() -> None:
    side = 24
    pairs = pairs_on(side)
    target = torch.randint(0, 256, (2, side, side), generator=torch.Generator().manual_seed(1), dtype=torch.uint8)
    loss, slope = StructuralTerm(target).gradient(pairs, target.reshape(-1).double() / 255)
    assert loss.tolist() == pytest.approx([0, 0], abs=1e-5)
    assert float(slope.abs().max()) < 1e-6
