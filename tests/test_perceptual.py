"""LPIPS: a metric's properties, its gradient, and weights that are what they should be."""

from __future__ import annotations

import pytest
import torch
from torch import Tensor
from torch.nn import functional

from videovec import perceptual
from videovec.errors import FitError
from videovec.perceptual import Perceptual, PerceptualTerm
from videovec.render import Scene, list_pairs


@pytest.fixture(scope="module")
def network() -> Perceptual:
    return Perceptual.load()


def drawing(shift: float = 0.0, half_width: float = 1.5) -> Tensor:
    """A ring, black on white. [1, 3, 96, 96]"""
    at = torch.arange(96) + 0.5
    radius = ((at - 48 - shift) ** 2 + ((at - 48) ** 2)[:, None]).sqrt()
    return ((radius - 25).abs() - half_width + 0.5).clamp(0, 1).expand(1, 3, 96, 96)


def test_an_image_is_at_no_distance_from_itself(network: Perceptual) -> None:
    assert float(network.distance(drawing(), drawing())) == 0


def test_distance_is_symmetric_and_grows_with_the_change(network: Perceptual) -> None:
    near, far = network.distance(drawing(), drawing(0.3)), network.distance(drawing(), drawing(4.0))
    assert 0 < float(near) < float(far)
    torch.testing.assert_close(network.distance(drawing(0.3), drawing()), near)


def test_a_missing_stroke_costs_more_than_a_thin_one(network: Perceptual) -> None:
    whole = drawing()
    thinner, missing = drawing(half_width=1.3), whole.clone()
    missing[:, :, :, 48:] = 1
    assert float(network.distance(whole, thinner)) < float(network.distance(whole, missing)) / 3


def test_the_network_is_what_torch_computes_layer_by_layer(network: Perceptual) -> None:
    images = torch.cat([drawing(), drawing(2.0).roll(7, 3)])
    x = (2 * images - 1 - torch.tensor([-0.030, -0.088, -0.188]).view(3, 1, 1)) / torch.tensor(
        [0.458, 0.448, 0.450]
    ).view(3, 1, 1)
    shape = [(4, 2, False), (1, 2, True), (1, 1, True), (1, 1, False), (1, 1, False)]
    total = 0.0
    for n, (stride, padding, is_pooled) in enumerate(shape):
        x = functional.max_pool2d(x, kernel_size=3, stride=2) if is_pooled else x
        x = functional.relu(functional.conv2d(x, network.kernels[n], network.biases[n], stride, padding))
        unit = functional.normalize(x, dim=1, eps=1e-10)
        total += float(((unit[0] - unit[1]) ** 2 * network.heads[n][0]).sum(0).mean())
    assert float(network.distance(images[:1], images[1:])) == pytest.approx(total, rel=1e-4)


def test_small_images_have_a_distance(network: Perceptual) -> None:
    small = torch.zeros(1, 3, 20, 31)
    assert float(network.distance(small, small + 0.5)) > 0


def test_batches_are_images_side_by_side(network: Perceptual) -> None:
    a, b = torch.cat([drawing(), drawing(2.0)]), torch.cat([drawing(1.0), drawing()])
    one_by_one = torch.cat([network.distance(a[n : n + 1], b[n : n + 1]) for n in range(2)])
    torch.testing.assert_close(network.distance(a, b), one_by_one, rtol=1e-4, atol=1e-6)


def test_the_gradient_of_a_fit_is_that_of_the_image(network: Perceptual) -> None:
    side = 72
    line = torch.tensor([[[10.0, 20.0], [30.0, 50.0], [50.0, 20.0], [60.0, 60.0]]] * 2)
    scene = Scene(
        control=line,
        half_width=torch.full((2, 2), 2.0),
        interval=torch.tensor([[0.0, 1.0]]).repeat(2, 1),
        row=torch.arange(2),
        opacity=torch.ones(2),
        color=torch.zeros(2, 0),
        drawing=torch.arange(2),
        size=(2, side, side),
    )
    pairs = list_pairs(scene, 1.0)
    generator = torch.Generator().manual_seed(0)
    value = torch.rand(len(pairs.active), generator=generator)
    target = torch.randint(0, 256, (2, side, side), generator=generator, dtype=torch.uint8)
    losses, slopes = PerceptualTerm(target).gradient(pairs, value)
    with torch.no_grad():  # as the loop of a fit may be
        torch.testing.assert_close(PerceptualTerm(target).gradient(pairs, value), (losses, slopes))

    free = value.clone().requires_grad_()
    image = 1 - torch.zeros(2 * side * side).index_put((pairs.active,), free).view(2, 1, side, side).expand(
        -1, 3, -1, -1
    )
    seen = 1 - target[:, None].expand(-1, 3, -1, -1) / 255
    truth = network.distance(image, seen)
    (gradient,) = torch.autograd.grad(truth.sum(), free)
    torch.testing.assert_close(losses, truth.detach(), rtol=1e-4, atol=1e-6)
    assert float((slopes - gradient).norm() / gradient.norm()) < 1e-3


def test_other_weights_are_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(perceptual, "CHECKSUM", "0" * 64)
    with pytest.raises(FitError, match="sha256"):
        Perceptual.load()
