"""The inner loop of the fit: squared residual and gradients in one call, without autograd where numba runs."""

from __future__ import annotations

import importlib.util
from dataclasses import dataclass, replace
from functools import cache

import torch
from torch import Tensor

from videovec.render.pairs import PairList
from videovec.render.scene import Scene
from videovec.threads import over_ranges

__all__ = [
    "CoverageMatch",
    "NormalEquations",
    "coverage_loss_and_gradients",
    "coverage_normal_equations",
    "has_triton",
    "match_with_torch",
]


@dataclass(frozen=True, slots=True, eq=False)
class CoverageMatch:
    """How well the union of all rows matches ink coverage at the active pixels, and how to improve it.

    Args:
        loss: Sum of squared residuals of each drawing's active pixels; the other pixels add a constant. float64 [D]
        value: Coverage of each active pixel. [A]
        control: Gradient of the whole loss. [G, 4, 2]
        half_width: Likewise. [G, 2]
        interval: Likewise. [G, 2]
        opacity: Likewise. [R]
    """

    loss: Tensor
    value: Tensor
    control: Tensor
    half_width: Tensor
    interval: Tensor
    opacity: Tensor


@dataclass(frozen=True, slots=True, eq=False)
class NormalEquations:
    """How well the union of all rows matches ink coverage, and how that bends with the unknowns of each segment.

    A segment's unknowns: x, y and half-width of its first joint; x, y of both handles; x, y, half-width of its last.

    Args:
        loss: Sum of squared residuals of each drawing's active pixels. float64 [D]
        gradient: Of the whole loss. [G, 10]
        matrix: Its second derivative as Gauss and Newton have it, without what couples segments; the upper triangle.
            [G, 10, 10]
    """

    loss: Tensor
    gradient: Tensor
    matrix: Tensor


def coverage_normal_equations(scene: Scene, pairs: PairList, scale: float, target: Tensor) -> NormalEquations:
    """Set up the least-squares problem that a fit is, around where the strokes are; on the CPU alone.

    Args:
        scene: The strokes; its colours are not read.
        pairs: Its pair list, whose ``t`` is improved in place.
        scale: Width of the kernel in pixels.
        target: Ink coverage, 255 is full. uint8 [D, H, W]
    """
    from videovec.render.numba_backend import arrays_of
    from videovec.render.numba_normal import UNKNOWNS, normal_drawings

    segments, real = len(scene.control), scene.control.dtype
    loss = torch.zeros(scene.size[0], dtype=torch.float64)
    gradient = torch.zeros(segments, UNKNOWNS, dtype=real)
    matrix = torch.zeros(segments, UNKNOWNS, UNKNOWNS, dtype=real)
    arrays, wanted = arrays_of(scene, pairs), target.reshape(-1).numpy()
    out = loss.numpy(), gradient.numpy(), matrix.numpy()
    over_ranges(lambda drawings: normal_drawings(arrays, drawings, scale, wanted, out), scene.size[0])
    return NormalEquations(loss, gradient, matrix)


def coverage_loss_and_gradients(
    scene: Scene, pairs: PairList, scale: float, target: Tensor, extra: Tensor | None = None
) -> CoverageMatch:
    """Compare the strokes' coverage with ink coverage, forward and backward.

    Args:
        scene: The strokes; gradients are not recorded on it and its colours are not read.
        pairs: Its pair list, whose ``t`` is improved in place.
        scale: Width of the kernel in pixels.
        target: Ink coverage, 255 is full. uint8 [D, H, W]
        extra: Derivative of other losses by each active pixel's value, added to the residual's. [A]

    Returns:
        Loss, values and gradients, on the device of the scene. Numba on the CPU, Triton on CUDA, torch elsewhere.
    """
    if scene.control.device.type == "cpu":
        return _with_numba(scene, pairs, scale, target, extra)
    if scene.control.device.type == "cuda" and has_triton():
        from videovec.render.triton_match import match_with_triton

        return CoverageMatch(*match_with_triton(scene, pairs, scale, target, extra))
    return match_with_torch(scene, pairs, scale, target, extra)


@cache
def has_triton() -> bool:
    """Whether kernels can be compiled for the GPU: torch brings Triton along on Linux."""
    return importlib.util.find_spec("triton") is not None


def _with_numba(scene: Scene, pairs: PairList, scale: float, target: Tensor, extra: Tensor | None) -> CoverageMatch:
    from videovec.render.numba_backend import arrays_of
    from videovec.render.numba_match import match_drawings

    real = scene.control.dtype
    like = (scene.control, scene.half_width, scene.interval, scene.opacity)
    control, half_width, interval, opacity = (torch.zeros(v.shape, dtype=real) for v in like)
    loss, value = torch.zeros(scene.size[0], dtype=torch.float64), torch.empty(len(pairs.active), dtype=real)
    added = torch.empty(0, dtype=real) if extra is None else extra.detach().to(real).contiguous()
    arrays, wanted = arrays_of(scene, pairs), target.reshape(-1).numpy()
    out = tuple(v.numpy() for v in (loss, value, control, half_width, interval, opacity))
    over_ranges(lambda drawings: match_drawings(arrays, drawings, scale, wanted, added.numpy(), out), scene.size[0])
    return CoverageMatch(loss, value, control, half_width, interval, opacity)


def match_with_torch(
    scene: Scene, pairs: PairList, scale: float, target: Tensor, extra: Tensor | None = None
) -> CoverageMatch:
    """`coverage_loss_and_gradients` by autograd, on any device."""
    from videovec.render.torch_backend import composite_pairs

    leaves = [v.detach().requires_grad_() for v in (scene.control, scene.half_width, scene.interval, scene.opacity)]
    control, half_width, interval, opacity = leaves
    inkless = scene.color.new_zeros(len(scene.color), 0)
    bare = replace(scene, control=control, half_width=half_width, interval=interval, opacity=opacity, color=inkless)
    _, value = composite_pairs(bare, pairs, scale)
    residual = value - target.reshape(-1)[pairs.active].to(value.dtype) / 255
    whole = residual.square().sum() + (0 if extra is None else (extra.detach() * value).sum())
    grads = torch.autograd.grad(whole, leaves)
    drawing = torch.repeat_interleave(
        torch.arange(scene.size[0], device=value.device), pairs.drawing_pixels.diff(), output_size=len(value)
    )
    loss = torch.zeros(scene.size[0], dtype=torch.float64, device=value.device)
    loss.index_add_(0, drawing, residual.detach().double().square())
    return CoverageMatch(loss, value.detach(), *grads)
