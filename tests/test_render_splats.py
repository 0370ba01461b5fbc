"""The splats renderer: opacity, width, order, gradients, and the closed form as its neighbour."""

from __future__ import annotations

from dataclasses import replace

import pytest
import torch
from torch import Tensor

from videovec.errors import FitError
from videovec.render import Scene, render_image
from videovec.render.splats import draw_splats, place_splats

SIDE = 40


def line(half_width: float, opacity: float, y: float = 20.5) -> Scene:
    """A straight stroke across the page, black."""
    x = torch.tensor([-10.0, 10.0, 30.0, 50.0])
    return Scene(
        control=torch.stack([x, torch.full((4,), y)], dim=-1)[None].double(),
        half_width=torch.full((1, 2), half_width).double(),
        interval=torch.tensor([[0.0, 1.0]]).double(),
        row=torch.tensor([0]),
        opacity=torch.tensor([opacity]).double(),
        color=torch.ones(1, 1).double(),
        drawing=torch.tensor([0]),
        size=(1, SIDE, SIDE),
    )


def draw(scene: Scene, spacing: float) -> Tensor:
    return draw_splats(place_splats(scene, spacing), (SIDE, SIDE), torch.zeros(scene.color.shape[1]).double())


@pytest.mark.parametrize("spacing", [0.25, 0.5, 1.0])
@pytest.mark.parametrize("opacity", [0.1, 0.5, 0.9])
def test_overlapping_splats_have_the_opacity_of_their_stroke(opacity: float, spacing: float) -> None:
    assert draw(line(3.0, opacity), spacing)[20, 10:30, 0].tolist() == pytest.approx([opacity] * 20, abs=0.025)


@pytest.mark.parametrize("opacity", [0.3, 0.9])
@pytest.mark.parametrize("half_width", [2.0, 4.0])
def test_half_of_the_opacity_is_left_at_the_edge(half_width: float, opacity: float) -> None:
    row = 20 + int(half_width)  # this row's centres lie on the edge
    assert float(draw(line(half_width, opacity), 0.5)[row, 20, 0]) == pytest.approx(opacity / 2, abs=0.06)


def test_the_closed_form_is_near() -> None:
    soft, sharp = draw(line(1.5, 0.5), 0.25), render_image(line(1.5, 0.5), torch.zeros(1).double())[0]
    assert float(soft.sum() / sharp.sum()) == pytest.approx(1, abs=0.1)
    assert float((soft - sharp).abs().max()) < 0.15


def test_later_rows_lie_above() -> None:
    under, over = line(3.0, 0.99), line(3.0, 0.99)
    both = replace(
        under,
        control=torch.cat([under.control, over.control.flip(-1)]),
        half_width=under.half_width.repeat(2, 1),
        interval=under.interval.repeat(2, 1),
        row=torch.tensor([0, 1]),
        opacity=under.opacity.repeat(2),
        color=torch.eye(2).double(),
        drawing=torch.zeros(2, dtype=torch.long),
    )
    assert draw(both, 0.5)[20, 20].tolist() == pytest.approx([0, 1], abs=0.05)


def test_what_is_hidden_is_not_drawn() -> None:
    half = replace(line(2.0, 0.9), interval=torch.tensor([[0.0, 0.5]]).double())
    image = draw(half, 0.5)[20, :, 0]
    assert float(image[5]) > 0.8
    assert float(image[30]) < 1e-6


def test_gradients_match_finite_differences() -> None:
    scene = line(2.0, 0.6, y=19.3)
    weights = torch.randn(SIDE, SIDE, 1, generator=torch.Generator().manual_seed(0), dtype=torch.float64)

    def loss(control: Tensor, half_width: Tensor, opacity: Tensor, color: Tensor) -> Tensor:
        free = replace(scene, control=control, half_width=half_width, opacity=opacity, color=color)
        return (draw_splats(place_splats(free, 2.0), (SIDE, SIDE), torch.zeros(1).double()) * weights).sum()

    curved = scene.control + torch.tensor([[0.3, 0.0], [1.0, 4.0], [-2.0, -3.0], [0.1, 0.4]])
    leaves = (curved, scene.half_width, scene.opacity, scene.color)
    free = [leaf.clone().requires_grad_() for leaf in leaves]
    for n, gradient in enumerate(torch.autograd.grad(loss(*free), free)):
        direction = torch.randn(leaves[n].shape, generator=torch.Generator().manual_seed(n), dtype=torch.float64)
        ends = []
        for step in (1e-6, -1e-6):
            moved = list(leaves)
            moved[n] = leaves[n] + step * direction
            ends.append(float(loss(*moved)))
        numeric = (ends[0] - ends[1]) / 2e-6
        assert float((gradient * direction).sum()) == pytest.approx(numeric, rel=1e-3, abs=1e-4), n


def test_several_drawings_are_refused() -> None:
    with pytest.raises(FitError, match="one drawing"):
        place_splats(replace(line(1.0, 1.0), size=(2, SIDE, SIDE)), 1.0)
