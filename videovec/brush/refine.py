"""The joint optimisation of strokes and brush: control points, half-widths, density, phases and texels together."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor

from videovec.brush.paint import BrushTensors, Pairs, find_pair_groups, paint
from videovec.brush.shape import Shape
from videovec.brushwork import Brush, Laying
from videovec.progress import Progress
from videovec.strokes import Layout, Strokes

__all__ = ["Laid", "RefineSchedule", "refine"]

Floats = NDArray[np.float64]

_DRAWINGS_AT_ONCE = 4


@dataclass(frozen=True, slots=True, eq=False)
class Laid:
    """Strokes, the brush that draws them, and how it was laid."""

    strokes: Strokes
    laying: Laying
    brush: Brush


@dataclass(frozen=True, slots=True)
class RefineSchedule:
    """How the steps are taken; a rate of 0 keeps what it moves.

    Args:
        steps: Number of optimiser updates.
        points: Step of control points. px
        half_width: Step of the logarithm of half-widths.
        density: Step of the logit of density.
        phase: Step of phases. widths
        shift: Step of the shifts of single drawings. widths
        strip: Step of the logit of texels.
        rebuild: Steps between two searches for the pixels near each stroke.
        prior: Pull of every texel to the strip's profile, in pixels that agree with it.
    """

    steps: int
    points: float = 0.1
    half_width: float = 0.015
    density: float = 0.05
    phase: float = 0.0
    shift: float = 0.0
    strip: float = 0.08
    rebuild: int = 15
    prior: float = 0.1


@dataclass(frozen=True, slots=True, eq=False)
class _Leaves:
    """The unconstrained tensors behind `BrushTensors`."""

    points: Tensor
    log_half_width: Tensor
    logit_density: Tensor
    phase: Tensor
    shift: Tensor
    logit_strip: Tensor

    @staticmethod
    def of(laid: Laid) -> _Leaves:
        start = BrushTensors.of(laid.strokes, laid.laying, laid.brush)
        leaves = (
            start.points.clone(),
            start.half_width.clamp(min=0.05).log(),
            torch.logit(start.density, eps=1e-3),
            start.phase.clone(),
            start.shift.clone(),
            torch.logit(start.strip, eps=2e-3),
        )
        return _Leaves(*(leaf.requires_grad_() for leaf in leaves))

    def tensors(self, brush: Brush) -> BrushTensors:
        return BrushTensors(
            self.points,
            self.log_half_width.exp(),
            torch.sigmoid(self.logit_density),
            self.phase,
            self.shift,
            torch.sigmoid(self.logit_strip),
            brush.width,
            brush.repeat,
        )


def refine(laid: Laid, coverage: NDArray[np.uint8], schedule: RefineSchedule, progress: Progress) -> Laid:
    """Move strokes and brush until together they draw the ink.

    Args:
        laid: Where to start.
        coverage: Ink fraction, 255 is full. uint8 [D, H, W]
        schedule: What moves, and how far.
        progress: Advanced at every step.

    Returns:
        Strokes, laying and brush of the same topology, repeat and number of texels.
    """
    leaves = _Leaves.of(laid)
    rates = (schedule.points, schedule.half_width, schedule.density, schedule.phase, schedule.shift, schedule.strip)
    moving = [(leaf, rate) for leaf, rate in zip(_all(leaves), rates, strict=True) if rate > 0]
    optimiser = torch.optim.Adam([{"params": [leaf]} for leaf, _ in moving], betas=(0.9, 0.99))
    shape = Shape.of(laid.strokes, float(max(coverage.shape[1:])))
    groups: list[Pairs] = []
    for step in range(schedule.steps):
        if step % schedule.rebuild == 0:
            now = _laid(leaves, laid)
            groups = find_pair_groups(now.strokes, now.laying, coverage.shape, _DRAWINGS_AT_ONCE)
        optimiser.zero_grad(set_to_none=True)
        for pairs in groups:
            target = torch.as_tensor(coverage.reshape(-1)[pairs.pixels.numpy()], dtype=torch.float32) / 255
            error = (paint(pairs, leaves.tensors(laid.brush)) - target).square().sum()
            error.backward()  # type: ignore[no-untyped-call]
        strip = torch.sigmoid(leaves.logit_strip)
        loss = schedule.prior * (strip - strip.detach().mean(0)).square().sum()
        loss = loss + shape.loss(leaves.points)
        loss.backward()  # type: ignore[no-untyped-call]
        decay = 0.1 + 0.45 * (1 + float(np.cos(np.pi * step / schedule.steps)))
        for group, (_, rate) in zip(optimiser.param_groups, moving, strict=True):
            group["lr"] = rate * decay
        optimiser.step()
        with torch.no_grad():
            _close(leaves, laid.strokes)
        progress.advance()
    return _laid(leaves, laid)


def _all(leaves: _Leaves) -> tuple[Tensor, ...]:
    return (leaves.points, leaves.log_half_width, leaves.logit_density, leaves.phase, leaves.shift, leaves.logit_strip)


def _close(leaves: _Leaves, strokes: Strokes) -> None:
    """Let closed rows end where they begin."""
    layout = strokes.layout
    rows = np.flatnonzero(strokes.is_closed[layout.row_stroke])
    if not len(rows):
        return
    for leaf, starts in (
        (leaves.points, layout.row_points),
        (leaves.log_half_width, layout.row_joints),
        (leaves.logit_density, layout.row_joints),
    ):
        first, last = torch.as_tensor(starts[rows]), torch.as_tensor(starts[rows + 1] - 1)
        middle = 0.5 * (leaf[first] + leaf[last])
        leaf[first], leaf[last] = middle, middle


def _laid(leaves: _Leaves, start: Laid) -> Laid:
    def array(tensor: Tensor) -> Floats:
        return tensor.detach().numpy().astype(np.float64)

    tensors = leaves.tensors(start.brush)
    opacity, density = split_density(array(tensors.density), start.strokes.layout)
    strokes = replace(
        start.strokes, points=array(tensors.points), half_width=array(tensors.half_width), opacity=opacity
    )
    laying = replace(start.laying, phase=array(tensors.phase), density=density, shift=array(tensors.shift))
    return Laid(strokes, laying, replace(start.brush, strip=array(tensors.strip)))


def split_density(ink: Floats, layout: Layout) -> tuple[Floats, Floats]:
    """Ink at joints [J] as the opacity of its row, its maximum [R], and the density against it [J]."""
    opacity = np.maximum(np.maximum.reduceat(ink, layout.row_joints[:-1]), 1e-6)
    return opacity, ink / opacity[layout.joint_row]
