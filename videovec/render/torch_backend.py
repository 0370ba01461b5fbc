"""The torch back end: the same pairs, any device, gradients by autograd.

The nearest point is found without gradient and attached again by one Newton step whose numerator alone carries
gradients: by the implicit function theorem that step's derivative is the derivative of the solution.
"""

from __future__ import annotations

from dataclasses import dataclass

import torch
from torch import Tensor

from videovec.render.limits import BENT, NARROWEST, NEAREST, SLOWEST, THINNEST
from videovec.render.pairs import PairList
from videovec.render.scene import Scene

__all__ = ["composite_pairs", "pair_coverage"]


def composite_pairs(scene: Scene, pairs: PairList, scale: float) -> tuple[Tensor, Tensor]:
    """Composite the rows on every active pixel; see `videovec.render.composite`."""
    coverage = pair_coverage(scene, pairs, scale)
    stacks = _stack(pairs, coverage.detach())
    alpha = scene.opacity[stacks.row] * coverage[stacks.pair]
    ink = scene.color[stacks.row]
    color = coverage.new_zeros(len(pairs.active), ink.shape[1])
    clear = coverage.new_ones(len(pairs.active))
    for depth in range(stacks.depths):
        at = (stacks.depth == depth).nonzero().squeeze(1)
        pixel, over = stacks.pixel[at], alpha[at]
        kept = 1 - over
        color = color.index_put((pixel,), color[pixel] * kept[:, None] + ink[at] * over[:, None])
        clear = clear.index_put((pixel,), clear[pixel] * kept)
    return color, 1 - clear


@dataclass(frozen=True, slots=True, eq=False)
class _Stacks:
    """The rows on every active pixel, one entry for each (pixel, row), lower rows first."""

    pixel: Tensor
    row: Tensor
    pair: Tensor
    """The pair that covers most."""
    depth: Tensor
    """How many rows lie below."""
    depths: int


def _stack(pairs: PairList, coverage: Tensor) -> _Stacks:
    order, row = pairs.order.long(), pairs.order_row.long()
    pixel = torch.repeat_interleave(torch.arange(len(pairs.active), device=order.device), pairs.start.diff())
    is_first = torch.ones_like(pixel, dtype=torch.bool)
    is_first[1:] = (pixel[1:] != pixel[:-1]) | (row[1:] != row[:-1])
    entry = is_first.cumsum(0) - 1
    heads = is_first.nonzero().squeeze(1)
    covered = coverage[order]
    most = covered.new_full((len(heads),), -torch.inf).scatter_reduce(0, entry, covered, "amax")
    place = torch.arange(len(order), device=order.device).masked_fill(covered < most[entry], len(order))
    winner = torch.full_like(heads, len(order)).scatter_reduce(0, entry, place, "amin")
    pixel_of = pixel[heads]
    below = torch.zeros(len(pairs.active) + 1, dtype=torch.long, device=order.device)
    below[1:] = torch.bincount(pixel_of, minlength=len(pairs.active)).cumsum(0)
    depth = torch.arange(len(heads), device=order.device) - below[pixel_of]
    depths = int(depth.max()) + 1 if len(depth) else 0
    return _Stacks(pixel_of, row[heads], order[winner], depth, depths)


def pair_coverage(scene: Scene, pairs: PairList, scale: float) -> Tensor:
    """Coverage of every pair by its chunk alone; improves ``pairs.t`` by one Newton step. [N]"""
    real = scene.control.dtype
    chunk = torch.repeat_interleave(
        torch.arange(len(pairs.chunks.segment), device=pairs.t.device), pairs.chunk_pairs.diff()
    )
    segment = pairs.chunks.segment[chunk]
    bounds, interval = pairs.chunks.bounds.to(real)[chunk], scene.interval[segment]
    # Not torch.maximum: it would give half of the gradient to the constant where both are equal.
    lo = torch.where(interval[:, 0] >= bounds[:, 0], interval[:, 0], bounds[:, 0])
    hi = torch.where(interval[:, 1] <= bounds[:, 1], interval[:, 1], bounds[:, 1])
    control, half_width = scene.control[segment], scene.half_width[segment]
    is_dot = (control.detach() - control.detach()[:, :1]).abs().amax(dim=(1, 2)) < SLOWEST
    middle = (lo + hi).detach() / 2
    is_visible, lo, hi = hi > lo, torch.where(is_dot, middle, lo), torch.where(is_dot, middle, hi)
    point = torch.stack([pairs.x, pairs.y], dim=-1).to(real) + 0.5

    with torch.no_grad():
        cubic = _coefficients(control)
        r, b, a = _relative(cubic, point - control[:, 0], torch.clamp(pairs.t, lo, hi))
        speed2, towards = (b * b).sum(-1), (r * b).sum(-1)
        bend = torch.maximum(speed2 - (r * a).sum(-1), 0.25 * speed2 + 1e-12)
        t = torch.clamp(torch.clamp(pairs.t, lo, hi) + towards / bend, lo, hi)
        pairs.t.copy_(t)
    return _coverage((control, half_width, is_dot), (lo, hi), point, t, scale) * is_visible


def _coefficients(control: Tensor) -> tuple[Tensor, Tensor, Tensor]:
    """Coefficients of t, t², t³ relative to the first control point. 3 x [n, 2]"""
    p0, p1, p2, p3 = control.unbind(1)
    c1 = 3 * (p1 - p0)
    c2 = 3 * (p2 - p1) - c1
    return c1, c2, p3 - p0 - c1 - c2


def _relative(cubic: tuple[Tensor, Tensor, Tensor], offset: Tensor, t: Tensor) -> tuple[Tensor, Tensor, Tensor]:
    """From the curve to the point, and the curve's first and second derivatives. 3 x [n, 2]"""
    c1, c2, c3 = cubic
    u = t[:, None]
    return offset - ((c3 * u + c2) * u + c1) * u, (3 * c3 * u + 2 * c2) * u + c1, 6 * c3 * u + 2 * c2


def _coverage(
    strokes: tuple[Tensor, Tensor, Tensor], ends: tuple[Tensor, Tensor], point: Tensor, t: Tensor, scale: float
) -> Tensor:
    (control, half_width, is_dot), (lo, hi) = strokes, ends
    cubic, offset = _coefficients(control), point - control[:, 0]
    r, b, a = _relative(cubic, offset, t)
    speed2 = (b * b).sum(-1)
    is_inside = (t > lo) & (t < hi) & (speed2 > SLOWEST**2)
    bend = torch.maximum(speed2 - (r * a).sum(-1), BENT * speed2).clamp(min=BENT * SLOWEST**2).detach()
    towards = (r * b).sum(-1)
    attached = t + (towards - towards.detach()) / bend
    end = torch.where(t <= lo, lo, torch.where(t >= hi, hi, t))
    # Inside, the distance does not change with t, and says so even where Newton has not quite arrived.
    r, _, _ = _relative(cubic, offset, torch.where(is_inside, t, end))
    t = torch.where(is_inside, attached, end)
    _, b, _ = _relative(cubic, offset, t)
    speed2 = (b * b).sum(-1)
    h = torch.lerp(half_width[:, 0], half_width[:, 1], t)
    tangent = b / speed2.clamp(min=SLOWEST**2).sqrt()[:, None]
    excess = _excess_mass(h, scale)
    along = torch.where(is_inside | is_dot | (speed2 <= SLOWEST**2), 0, (excess - 1) * (r * tangent).sum(-1))
    r = torch.where(is_dot, excess.sqrt(), 1)[:, None] * r + along[:, None] * tangent
    d2 = (r * r).sum(-1)
    d = (d2 + 1e-24).sqrt() if d2.dtype == torch.float64 else (d2 + 1e-12).sqrt()
    has_tangent = (is_inside | (d < NEAREST)) & (speed2 > SLOWEST**2)
    has_direction = ~has_tangent & (d >= NEAREST)
    across = torch.stack([-tangent[:, 1], tangent[:, 0]], dim=-1)
    n = torch.where(has_tangent[:, None], across, r / d.clamp(min=NEAREST)[:, None])
    n = torch.where((has_tangent | has_direction)[:, None], n, n.new_tensor([1.0, 0.0]))

    nx, ny = n.abs().unbind(-1)
    # Not max(-1): where both are equal it would take the same one for both.
    wide, thin = torch.maximum(nx, ny), torch.minimum(nx, ny)
    wide, thin = scale * wide, scale * thin.clamp(min=NARROWEST)
    return _from_middle(h - d, wide, thin) + _from_middle(h + d, wide, thin)


def _excess_mass(h: Tensor, scale: float) -> Tensor:
    """What the profile across a line would have around its end, in terms of half a disc: m in `limits`."""
    q = (h / scale).clamp(min=THINNEST)
    return torch.where(q < 0.5, (2 / 3) * q + 0.5 / q, 1 + (1 / 12) / (q * q))


def _from_middle(z: Tensor, wide: Tensor, thin: Tensor) -> Tensor:
    """Integral from 0 to z of the trapezoid that two boxes of these widths make together; odd in z."""
    flat, outer = 0.5 * (wide - thin), 0.5 * (wide + thin)
    left = torch.minimum((outer - z.abs()).clamp(min=0), thin)
    return z.sign() * (torch.minimum(z.abs(), flat) / wide + (thin * thin - left * left) / (2 * wide * thin))
