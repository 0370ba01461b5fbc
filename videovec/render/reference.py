"""The definition of the renderer: dense, every chunk against every pixel, gradients by autograd.

For tests. It shares the chunks and the limits with the fast back ends, and nothing else: the nearest point is searched
on a grid of parameters, and the kernel is written as the second difference of a parabola.
"""

from __future__ import annotations

import torch
from torch import Tensor

from videovec.render.limits import BENT, NARROWEST, NEAREST, SLOWEST, THINNEST
from videovec.render.pairs import Chunks
from videovec.render.scene import Scene

__all__ = ["composite_dense"]

SAMPLES = 33
"""Parameters among which the nearest point is sought before Newton's steps."""
NEWTON_STEPS = 10


def composite_dense(scene: Scene, chunks: Chunks, pixels: Tensor, scale: float) -> tuple[Tensor, Tensor]:
    """Composite the rows on some pixels; see `videovec.render.composite`.

    Args:
        scene: The strokes.
        chunks: Their chunks.
        pixels: Where, as drawing * H * W + y * W + x. int64 [A]
        scale: Width of the kernel in pixels.

    Returns:
        Premultiplied colour [A, C] and coverage [A].
    """
    _, height, width = scene.size
    center = torch.stack([pixels % width, pixels // width % height], dim=-1).to(scene.control) + 0.5
    drawing = pixels // (height * width)
    chunk_row = scene.row[chunks.segment]
    color = center.new_zeros(len(pixels), scene.color.shape[1])
    clear = center.new_ones(len(pixels))
    for row in range(len(scene.opacity)):
        own = (chunk_row == row).nonzero().squeeze(1)
        if not len(own):
            continue
        covered = torch.stack([_chunk_coverage(scene, chunks, int(chunk), center, scale) for chunk in own])
        alpha = scene.opacity[row] * covered.max(dim=0).values * (drawing == scene.drawing[row])
        color = color * (1 - alpha)[:, None] + scene.color[row] * alpha[:, None]
        clear = clear * (1 - alpha)
    return color, 1 - clear


def _chunk_coverage(scene: Scene, chunks: Chunks, chunk: int, center: Tensor, scale: float) -> Tensor:
    """Coverage of every pixel by one chunk. [A]"""
    segment = int(chunks.segment[chunk])
    control, bounds, interval = scene.control[segment], chunks.bounds[chunk], scene.interval[segment]
    lo = interval[0] if interval[0] >= bounds[0] else bounds[0]
    hi = interval[1] if interval[1] <= bounds[1] else bounds[1]
    if not bool(hi > lo):
        return torch.zeros_like(center[:, 0])
    is_dot = bool((control.detach() - control.detach()[0]).abs().max() < SLOWEST)
    if is_dot:
        lo = hi = (lo + hi).detach() / 2
    t = _nearest_parameter(control.detach(), lo.detach(), hi.detach(), center)
    speed2 = _curve(control.detach(), t)[1].square().sum(-1)
    is_inside = (t > lo) & (t < hi) & (speed2 > SLOWEST**2)
    t = torch.where(is_inside, _attach(control, center, t), torch.where(t <= lo, lo, torch.where(t >= hi, hi, t)))

    on_curve, velocity, _ = _curve(control, t)
    half_width = scene.half_width[segment]
    h = (1 - t) * half_width[0] + t * half_width[1]
    speed = velocity.square().sum(-1).clamp(min=SLOWEST**2).sqrt()
    r = center - on_curve
    if is_dot:
        r = _excess_mass(h, scale).sqrt()[:, None] * r
    else:
        tangent = velocity / speed[:, None]
        more = (_excess_mass(h, scale) - 1) * (r * tangent).sum(-1)
        r = r + torch.where(is_inside | (speed <= SLOWEST), 0, more)[:, None] * tangent
    d = (r.square().sum(-1) + 1e-24).sqrt()
    has_tangent = (is_inside | (d < NEAREST)) & (speed > SLOWEST)
    across = torch.stack([-velocity[:, 1], velocity[:, 0]], dim=-1) / speed[:, None]
    towards = r / d.clamp(min=NEAREST)[:, None]
    anyhow = torch.where((d < NEAREST)[:, None], towards.new_tensor([1.0, 0.0]), towards)
    n = torch.where(has_tangent[:, None], across, anyhow).abs()
    return _cumulative(h - d, n, scale) - _cumulative(-h - d, n, scale)


def _curve(control: Tensor, t: Tensor) -> tuple[Tensor, Tensor, Tensor]:
    """Point, first and second derivative at each t. 3 x [n, 2]"""
    p0, p1, p2, p3 = control.unbind(-2)
    t = t[..., None]
    s = 1 - t
    point = s**3 * p0 + 3 * s**2 * t * p1 + 3 * s * t**2 * p2 + t**3 * p3
    first = 3 * (s**2 * (p1 - p0) + 2 * s * t * (p2 - p1) + t**2 * (p3 - p2))
    return point, first, 6 * (s * (p2 - 2 * p1 + p0) + t * (p3 - 2 * p2 + p1))


@torch.no_grad()
def _nearest_parameter(control: Tensor, lo: Tensor, hi: Tensor, center: Tensor) -> Tensor:
    samples = lo + (hi - lo) * torch.linspace(0, 1, SAMPLES, dtype=control.dtype)
    t = samples[torch.cdist(center, _curve(control, samples)[0]).argmin(dim=1)]
    for _ in range(NEWTON_STEPS):
        point, first, second = _curve(control, t)
        r = center - point
        speed2 = first.square().sum(-1)
        bend = torch.maximum(speed2 - (r * second).sum(-1), 0.25 * speed2 + 1e-12)
        t = (t + (r * first).sum(-1) / bend).clamp(lo, hi)
    return t


def _attach(control: Tensor, center: Tensor, t: Tensor) -> Tensor:
    """The same t with the gradient of the nearest point's parameter: one Newton step with a fixed denominator."""
    point, first, second = _curve(control, t)
    r = center - point
    speed2 = first.square().sum(-1)
    bend = torch.maximum(speed2 - (r * second).sum(-1), BENT * speed2).clamp(min=BENT * SLOWEST**2).detach()
    towards = (r * first).sum(-1)
    return t + (towards - towards.detach()) / bend


def _excess_mass(h: Tensor, scale: float) -> Tensor:
    """What the profile across a line would have around its end, in terms of half a disc: m in `limits`."""
    q = (h / scale).clamp(min=THINNEST)
    return torch.where(q < 0.5, 2 * q / 3 + 1 / (2 * q), 1 + 1 / (12 * q * q))


def _cumulative(z: Tensor, n: Tensor, scale: float) -> Tensor:
    """Integral up to z of the pixel's square projected on n: two boxes convolved, less a constant."""
    nx, ny = n.unbind(-1)
    wide, thin = scale * torch.maximum(nx, ny), scale * torch.minimum(nx, ny).clamp(min=NARROWEST)

    def parabola(x: Tensor) -> Tensor:
        return 0.5 * x.clamp(min=0).square()

    outer, inner = (wide + thin) / 2, (wide - thin) / 2
    return (parabola(z + outer) - parabola(z + inner) - parabola(z - inner) + parabola(z - outer)) / (wide * thin)
