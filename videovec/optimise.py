"""The loop that moves strokes until their rendering is the drawing: the one optimiser of all stages.

Strokes become free tensors, the renderer gives the photometric loss and its gradients at active pixels, other terms are
added by whoever calls, and Adam takes the steps. Where the photometric loss is all there is, Gauss-Newton does, which
ends one to two decibels higher in the same time. The kernel's scale falls to 1 on the way: coarse to fine.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor

from videovec.adam import Adam
from videovec.gauss_newton import GaussNewton
from videovec.parameters import Parameters
from videovec.progress import Progress, Silent
from videovec.render import (
    Backend,
    PairList,
    coverage_loss_and_gradients,
    coverage_normal_equations,
    list_pairs,
    resolve_backend,
)
from videovec.settings import RenderSettings
from videovec.strokes import Strokes

__all__ = ["Held", "Interrupted", "Optimised", "PixelTerm", "Schedule", "Term", "optimise"]

STALL, GAIN = 5, 0.01
"""Gauss-Newton ends when this many steps have lowered the loss by no more than this share of it."""

Losses = NDArray[np.float64]

Term = Callable[[Parameters], Tensor]
"""A weighted scalar that autograd can follow to the parameters."""


@dataclass(frozen=True, slots=True)
class PixelTerm:
    """A loss of the rendered drawings that brings its own gradient.

    Args:
        gradient: Loss of each drawing [D], and the derivative of their sum by each active pixel's value [A].
        weight: Its weight.
        every: Steps between two evaluations; one counts for all of them.
    """

    gradient: Callable[[PairList, Tensor], tuple[Tensor, Tensor]]
    weight: float
    every: int = 1


@dataclass(frozen=True, slots=True, eq=False)
class Held:
    """Rows that stay as they are, whatever the loss says.

    Args:
        rows: Which rows of the strokes. int [K]
    """

    rows: NDArray[np.intp]


@dataclass(frozen=True, slots=True)
class Schedule:
    """How the steps are taken.

    Args:
        steps: Number of optimiser updates.
        rate: Step of control points at the start; it falls to a tenth along a cosine. px
        width_rate: Step of the logarithm of half-widths; 0 keeps them.
        opacity_rate: Step of the logit of opacities; 0 keeps them.
        scale: Kernel scale at the start.
        coarse: Share of the steps over which the scale falls to 1.
        rebuild: Steps between two builds of the pair lists.
        floor: Gradient below which a parameter moves less than its rate: along a line nothing pulls, and a rate that
            does not fall with the pull would fold the line onto itself.
        is_newton: Take Gauss-Newton steps where that is possible: on the CPU, with no other terms, opacities kept. They
            find their own rate, and take fewer steps where more would gain nothing.
        begin: First of the steps to take now; those before it were taken by earlier calls.
        end: The step to stop before; none for all.
    """

    steps: int = 200
    rate: float = 0.3
    width_rate: float = 0.03
    opacity_rate: float = 0.0
    scale: float = 2.0
    coarse: float = 0.3
    rebuild: int = 10
    floor: float = 1e-8
    is_newton: bool = False
    begin: int = 0
    end: int | None = None

    @property
    def span(self) -> range:
        """The steps to take now."""
        return range(self.begin, self.steps if self.end is None else self.end)

    def scale_at(self, step: int) -> float:
        """Kernel scale of a step: geometric from ``scale`` to 1, kept between two builds of the lists."""
        fall = self.coarse * self.steps
        begin = step - step % self.rebuild
        return float(self.scale ** max(0.0, 1 - begin / fall)) if fall > 0 else 1.0

    def decay_at(self, step: int) -> float:
        """Share of the rates that a step has."""
        return 0.1 + 0.45 * (1 + float(np.cos(np.pi * step / max(self.steps, 1))))


class Interrupted(KeyboardInterrupt):
    """Ctrl-C while strokes were moved.

    Args:
        strokes: As they were then.
    """

    def __init__(self, strokes: Strokes) -> None:
        super().__init__()
        self.strokes = strokes


class Optimised(NamedTuple):
    """The moved strokes, and the sum of squared coverage errors at active pixels of every step that was taken."""

    strokes: Strokes
    losses: Losses


def optimise(
    strokes: Strokes,
    target: NDArray[np.uint8],
    schedule: Schedule,
    terms: Sequence[Term | PixelTerm | Held] = (),
    backend: Backend | None = None,
    progress: Progress | None = None,
) -> Optimised:
    """Move strokes until they draw the target.

    Args:
        strokes: S strokes over D drawings.
        target: Ink coverage, 255 is full. uint8 [D, H, W]
        schedule: How the steps are taken.
        terms: What else is to be small, beside the sum over pixels of the squared coverage error, and what is to stay.
        backend: Which renderer, on which device; chosen by what there is unless told.
        progress: Advanced at every step.

    Returns:
        The strokes of the same topology and lives, and the course of the loss.

    Raises:
        Interrupted: The user wants it to end; with the strokes as they are.
    """
    progress = progress or Silent()
    if not len(strokes) or not schedule.span:
        return Optimised(strokes, np.zeros(0))
    backend = backend or resolve_backend(RenderSettings())
    parameters = Parameters.of(strokes, backend.device)
    try:
        if schedule.is_newton and backend.name == "numba" and not terms and schedule.opacity_rate == 0:
            losses = _approach(parameters, target, schedule, progress)
        else:
            losses = _descend(parameters, torch.as_tensor(target, device=backend.device), schedule, terms, progress)
    except KeyboardInterrupt as stop:
        raise Interrupted(parameters.to_strokes()) from stop
    return Optimised(parameters.to_strokes(), losses)


def _descend(
    parameters: Parameters,
    seen: Tensor,
    schedule: Schedule,
    terms: Sequence[Term | PixelTerm | Held],
    progress: Progress,
) -> Losses:
    """Steps of Adam."""
    size = (seen.shape[0], seen.shape[1], seen.shape[2])
    adam = Adam(*_free(parameters, schedule), schedule.floor)
    pixel_terms = [term for term in terms if isinstance(term, PixelTerm)]
    smooth_terms = [term for term in terms if not isinstance(term, PixelTerm | Held)]
    holds = [_Hold(parameters, term.rows) for term in terms if isinstance(term, Held)]
    losses: list[Tensor] = []
    for step in schedule.span:
        scale = schedule.scale_at(step)
        with torch.no_grad():
            if step == schedule.begin or step % schedule.rebuild == 0:
                intervals = parameters.intervals()
                pairs = list_pairs(parameters.scene(size, intervals), scale)
            scene = parameters.scene(size, intervals)
            match = coverage_loss_and_gradients(scene, pairs, scale, seen)
        due = [term for term in pixel_terms if step % term.every == 0]
        if due:
            slopes = [term.weight * term.every * term.gradient(pairs, match.value)[1] for term in due]
            match = coverage_loss_and_gradients(scene, pairs, scale, seen, torch.stack(slopes).sum(0))
        adam.forget_gradients()
        if smooth_terms:
            torch.stack([term(parameters) for term in smooth_terms]).sum().backward()  # type: ignore[no-untyped-call]
        parameters.accumulate(match)
        for hold in holds:
            hold.release()
        adam.step(schedule.decay_at(step))
        losses.append(match.loss.sum())  # read at the end: reading makes the device wait
        progress.advance()
    return torch.stack(losses).cpu().numpy()


def _approach(parameters: Parameters, target: NDArray[np.uint8], schedule: Schedule, progress: Progress) -> Losses:
    """Gauss-Newton steps until they gain no more; ends with the best strokes that it saw at the last scale.

    Half as many steps as Adam takes are enough for each scale, and for each pair list.
    """
    seen, size = torch.from_numpy(target), (target.shape[0], target.shape[1], target.shape[2])
    schedule = replace(schedule, coarse=schedule.coarse / 2, rebuild=max(schedule.rebuild // 2, 1))
    newton = GaussNewton(parameters, size[0])
    course, losses, last = _Course(parameters), [], 0.0
    try:
        for step in schedule.span:
            scale = schedule.scale_at(step)
            with torch.no_grad():
                if step == schedule.begin or step % schedule.rebuild == 0:
                    intervals = parameters.intervals()
                    pairs = list_pairs(parameters.scene(size, intervals), scale)
                equations = coverage_normal_equations(parameters.scene(size, intervals), pairs, scale, seen)
            if scale != last:
                newton.forget()
                course = _Course(parameters)
            losses.append(float(equations.loss.sum()))
            course.see(losses[-1])
            if step == schedule.span[-1] or (scale == 1.0 and course.is_over):
                break
            newton.step(equations)
            last = scale
            progress.advance()
    finally:
        course.go_back()
    progress.advance(len(schedule.span) - len(losses) + 1)
    return np.array(losses)


class _Hold:
    """Keeps rows from being moved.

    Args:
        parameters: What is moved.
        rows: What is not. int [K]
    """

    def __init__(self, parameters: Parameters, rows: NDArray[np.intp]) -> None:
        layout = parameters.strokes.layout
        of_rows = (
            (parameters.points, layout.point_row),
            (parameters.log_half_width, layout.joint_row),
            (parameters.logit_opacity, np.arange(len(parameters.logit_opacity))),
        )
        self._held = [(tensor, torch.from_numpy(np.isin(row, rows)).to(tensor.device)) for tensor, row in of_rows]

    def release(self) -> None:
        """Let nothing pull at the rows; a step of Adam without a pull, ever, is none."""
        for tensor, is_held in self._held:
            if tensor.grad is not None:
                tensor.grad[is_held] = 0


class _Course:
    """The best that was seen of some parameters while they are moved.

    Args:
        parameters: What is moved.
    """

    def __init__(self, parameters: Parameters) -> None:
        self._free = [parameters.points.detach(), parameters.log_half_width.detach()]
        self._best: list[Tensor] = []
        self._least: list[float] = []

    def see(self, loss: float) -> None:
        """Take note of the loss of the parameters as they are."""
        if not self._least or loss < self._least[-1]:
            self._best = [values.clone() for values in self._free]
        self._least.append(min([loss, *self._least[-1:]]))

    @property
    def is_over(self) -> bool:
        """Whether the last steps have gained next to nothing."""
        return len(self._least) > STALL and self._least[-1] >= (1 - GAIN) * self._least[-1 - STALL]

    def go_back(self) -> None:
        """Put the parameters where they were best."""
        for values, found in zip(self._free, self._best, strict=False):  # none was seen yet: stay
            values.copy_(found)


def _free(parameters: Parameters, schedule: Schedule) -> tuple[list[Tensor], list[float]]:
    """The tensors that are moved, and their rates."""
    tensors = [parameters.points, parameters.log_half_width, parameters.logit_opacity]
    return tensors, [schedule.rate, schedule.width_rate, schedule.opacity_rate]
