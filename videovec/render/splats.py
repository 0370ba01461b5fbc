"""The renderer of the supplement: oriented 2D Gaussians sampled along each stroke, alpha-composited.

For comparison with the closed form of `videovec.render`, which is its limit for ever more splats. One drawing, plain
torch, gradients by autograd.

From stroke to splat. Opacity is not alpha: splats overlap, and what lies under many of them is covered by the product.
An opacity o is an optical depth D = -log(1 - o) on the centre line. Splats of standard deviation sigma_along at spacing
s pile up to sqrt(2 pi) sigma_along / s of their peaks everywhere on it, so that each has

    alpha = 1 - (1 - o)^(s / (sqrt(2 pi) sigma_along)).

The edge is where coverage falls to o / 2, hence D exp(-h^2 / (2 sigma_across^2)) = -log(1 - o / 2), h the half-width.
Ends are softer and shorter than round caps.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import torch
from torch import Tensor

from videovec.errors import FitError
from videovec.render.scene import Scene

__all__ = ["Splats", "draw_splats", "place_splats"]

REACH = 3.5
"""Standard deviations to which a splat is drawn."""
MOST_OPAQUE = 0.995
"""Opacity above which optical depth is not told apart."""
ALONG = 1.0
"""Least standard deviation along the stroke, in spacings: fewer overlapping splats make no smooth line."""
NARROWEST = 0.3
"""Least standard deviation: narrower splats fall between the pixels' centres. px"""


@dataclass(frozen=True, slots=True, eq=False)
class Splats:
    """N Gaussians of one drawing, lower rows first.

    Args:
        mean: Centres. [N, 2] px
        axis: Unit tangents. [N, 2]
        sigma: Standard deviation along and across. [N, 2] px
        alpha: Coverage at the centre of each. [N]
        color: Ink of each. [N, C]
    """

    mean: Tensor
    axis: Tensor
    sigma: Tensor
    alpha: Tensor
    color: Tensor


def place_splats(scene: Scene, spacing: float) -> Splats:
    """Cover every visible segment with Gaussians at nearly equal steps.

    Args:
        scene: Strokes of one drawing; differentiable by all of its leaves.
        spacing: Distance between neighbouring means along the curve. px

    Returns:
        N splats, segment by segment.

    Raises:
        FitError: The scene has several drawings.
    """
    if scene.size[0] != 1:
        raise FitError(f"splats take a scene of one drawing, got {scene.size[0]}")
    with torch.no_grad():
        length = scene.control.diff(dim=1).norm(dim=-1).sum(-1) * scene.interval.diff(dim=1).squeeze(1).clamp(min=0)
        count = (length / spacing).ceil().long().clamp(min=1) * (scene.interval[:, 1] > scene.interval[:, 0])
        segment = torch.repeat_interleave(torch.arange(len(count), device=count.device), count)
        place = torch.arange(len(segment), device=count.device) - (count.cumsum(0) - count)[segment]
        part = (place + 0.5) / count[segment]
    t = torch.lerp(scene.interval[segment, 0], scene.interval[segment, 1], part.to(scene.control))[:, None]
    p0, p1, p2, p3 = scene.control[segment].unbind(1)
    s = 1 - t
    mean = s**3 * p0 + 3 * s**2 * t * p1 + 3 * s * t**2 * p2 + t**3 * p3
    velocity = 3 * (s * s * (p1 - p0) + 2 * s * t * (p2 - p1) + t * t * (p3 - p2))
    speed = (velocity.square().sum(-1) + 1e-12).sqrt()
    step = speed * scene.interval[segment].diff(dim=1).squeeze(1) / count[segment]
    opacity = scene.opacity[scene.row[segment]].clamp(0, MOST_OPAQUE)
    half_width = torch.lerp(scene.half_width[segment, 0], scene.half_width[segment, 1], t[:, 0])
    across = _sigma_across(half_width, opacity)
    along = torch.maximum(ALONG * step, torch.minimum(across, half_width).clamp(min=NARROWEST))
    return Splats(
        mean=mean,
        axis=velocity / speed[:, None],
        sigma=torch.stack([along, across], dim=-1),
        alpha=1 - torch.exp(torch.log1p(-opacity) * step / (math.sqrt(2 * math.pi) * along)),
        color=scene.color[scene.row[segment]],
    )


def _sigma_across(half_width: Tensor, opacity: Tensor) -> Tensor:
    """Standard deviation at which a stroke's coverage is half of its plateau at its edge. px"""
    falls = torch.log(torch.log1p(-opacity.clamp(min=1e-3)) / torch.log1p(-opacity.clamp(min=1e-3) / 2))
    return (half_width / (2 * falls).sqrt()).clamp(min=NARROWEST)


def draw_splats(splats: Splats, size: tuple[int, int], page: Tensor) -> Tensor:
    """Composite splats, "over", each above the ones before it.

    Args:
        splats: N splats.
        size: Height and width. px
        page: Colour of the page. [C]

    Returns:
        The drawing. [H, W, C]
    """
    height, width = size
    splat, pixel = _touched(splats, size)
    order = torch.argsort(pixel, stable=True)
    splat, pixel = splat[order], pixel[order]
    center = torch.stack([pixel % width, pixel // width], dim=-1) + 0.5
    r = center - splats.mean[splat]
    axis, sigma = splats.axis[splat], splats.sigma[splat]
    u = (r * axis).sum(-1) / sigma[:, 0]
    v = (r[:, 1] * axis[:, 0] - r[:, 0] * axis[:, 1]) / sigma[:, 1]
    alpha = splats.alpha[splat] * torch.exp(-0.5 * (u * u + v * v))

    # Of each entry, what the splats above it let through: sums of logarithms from the end of its pixel.
    clear = torch.log1p(-alpha.clamp(max=1 - 1e-6)).double()
    total = clear.cumsum(0)
    last = torch.searchsorted(pixel, pixel, right=True) - 1
    weight = alpha * torch.exp(total[last] - total).to(alpha)
    color = page.new_zeros(height * width, len(page)).index_add(0, pixel, weight[:, None] * splats.color[splat])
    through = torch.exp(torch.zeros(height * width, dtype=torch.float64, device=page.device).index_add(0, pixel, clear))
    return (color + through.to(page)[:, None] * page).view(height, width, -1)


@torch.no_grad()
def _touched(splats: Splats, size: tuple[int, int]) -> tuple[Tensor, Tensor]:
    """Splat and pixel of every pair within reach. int64, int64"""
    height, width = size
    # Half extents of the ellipse's box.
    squares = (splats.sigma[:, None, :] * torch.stack([splats.axis, splats.axis.flip(-1)], dim=-1)).square().sum(-1)
    extent = REACH * squares.sqrt()
    low = (splats.mean - extent - 0.5).ceil().long().clamp(min=0)
    limit = torch.tensor([width, height], device=low.device)
    box = ((splats.mean + extent - 0.5).floor().long() + 1).minimum(limit).sub(low).clamp(min=0)
    count = box.prod(dim=-1)
    splat = torch.repeat_interleave(torch.arange(len(count), device=count.device), count)
    within = torch.arange(len(splat), device=count.device) - (count.cumsum(0) - count)[splat]
    x, y = low[splat, 0] + within % box[splat, 0], low[splat, 1] + within // box[splat, 0]
    return splat, y * width + x
