"""The joint fit: all drawings of a clip at once, with shared identities and temporal terms."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor

from videovec.drawing_terms import drawing_terms
from videovec.edits import edit, finish
from videovec.evidence import Evidence, gather_evidence
from videovec.ink import Ink
from videovec.material import Marks, sliding
from videovec.optimise import Held, Interrupted, Schedule, Term, optimise
from videovec.parameters import Parameters
from videovec.progress import Progress, Silent
from videovec.render import Backend, render_image, resolve_backend
from videovec.seen_ends import measure_ends
from videovec.settings import FitSettings, RenderSettings, Weights
from videovec.strokes import Strokes
from videovec.temporal import Neighbours, acceleration, anchor, moves_far, rigidity, width_change

__all__ = ["FitResult", "Pin", "compare", "draw_coverage", "fit", "judge"]

Pin = tuple[int, int]
"""The identity of a stroke, and a drawing."""

_FAR = 2
"""Times the steps that a joint fit takes of strokes that move far between drawings and have not reached their ink:"""
_OFF = 0.15
"""from this difference between what they draw and the ink on, as a share of all ink."""


@dataclass(frozen=True, slots=True, eq=False)
class FitResult:
    """Fitted strokes and what the ink says of them.

    Args:
        strokes: S strokes over D drawings.
        evidence: Error and support of each row.
        psnr: Of the rendered coverage against the seen one, for each drawing. dB [D]
        is_finished: Whether the fit came to its end, and was not interrupted by Ctrl-C.
    """

    strokes: Strokes
    evidence: Evidence
    psnr: NDArray[np.float64]
    is_finished: bool = True

    def finished(self) -> FitResult:
        """Itself.

        Raises:
            KeyboardInterrupt: The fit was interrupted, and this is no stage to end with.
        """
        if not self.is_finished:
            raise KeyboardInterrupt
        return self


def fit(
    ink: Ink,
    strokes: Strokes,
    settings: FitSettings,
    render: RenderSettings | None = None,
    progress: Progress | None = None,
    pins: frozenset[Pin] = frozenset(),
) -> FitResult:
    """Optimise strokes over all the drawings of their lives.

    A long clip is taken in windows that overlap: each window is fitted together with its surroundings, so that the
    temporal terms see across its edges, and memory does not grow with the clip. Ctrl-C ends the fit with the strokes as
    they are.

    Args:
        ink: What is drawn. D drawings
        strokes: Where the fit starts; topology and lives stay.
        settings: Steps, weights and windows.
        render: Which renderer.
        progress: Told of every step.
        pins: Strokes, by identity, and drawings on which they stay as they are; with any, no stroke is edited.

    Returns:
        The fitted strokes, their evidence and the error of every drawing.
    """
    progress = progress or Silent()
    backend = resolve_backend(render or RenderSettings())
    if ink.drawing_count == 1 and not pins:
        progress.stage("fit", settings.steps)
        fitted, is_finished = _fit_drawing(ink, strokes, settings, backend, progress)
    else:
        windows = list(_windows(ink.drawing_count, settings))
        schedules = [_schedule(settings, ink.drawing_count, _are_far(ink, strokes, w, backend)) for w in windows]
        progress.stage("fit", sum(schedule.steps for schedule in schedules))
        fitted, is_finished = strokes, True
        for window, schedule in zip(windows, schedules, strict=True):
            fitted, is_finished = _fit_window(ink, fitted, window, (settings, schedule, pins), (backend, progress))
            if not is_finished:
                break
        fitted = measure_ends(_restored(fitted, strokes, pins), ink.size)
    return replace(judge(ink, fitted, backend), is_finished=is_finished)


def _fit_window(
    ink: Ink,
    strokes: Strokes,
    window: tuple[int, int],
    how: tuple[FitSettings, Schedule, frozenset[Pin]],
    tools: tuple[Backend, Progress],
) -> tuple[Strokes, bool]:
    """Fit the drawings of a window together with those around it; whether that came to its end."""
    (first, last), (settings, schedule, pins), (backend, progress) = window, how, tools
    around = max(0, first - settings.overlap), min(ink.drawing_count - 1, last + settings.overlap)
    part = strokes.within(*around).shifted(-around[0])
    held = Held(_pinned_rows(part, around[0], pins))
    if len(held.rows) == part.row_count:
        progress.advance(schedule.steps)
        return strokes, True
    terms: list[Term | Held] = [*_terms(part, settings.weights, held.rows, backend.device)]
    if len(held.rows):
        terms.append(held)
    try:
        fitted = optimise(part, ink.shown[around[0] : around[1] + 1], schedule, terms, backend, progress).strokes
        is_finished = True
    except Interrupted as stop:
        fitted, is_finished = stop.strokes, False
    return strokes.with_rows_of(fitted.shifted(around[0]).within(first, last)), is_finished


def _fit_drawing(
    ink: Ink, strokes: Strokes, settings: FitSettings, backend: Backend, progress: Progress
) -> tuple[Strokes, bool]:
    """Fit one drawing, and edit its strokes every so many steps; whether that came to its end."""
    every = settings.edits.every or settings.steps
    schedule = _schedule(settings, 1)
    try:
        for begin in range(0, settings.steps, max(every, 1)):
            if begin > 0:
                strokes = edit(strokes, ink, settings.edits)
            part = replace(schedule, begin=begin, end=min(begin + every, settings.steps))
            terms = drawing_terms(strokes, ink.coverage, settings, backend.device)
            strokes = optimise(strokes, ink.coverage, part, terms, backend, progress).strokes
        return finish(strokes, ink, settings.edits) if settings.edits.every else strokes, True
    except Interrupted as stop:
        return stop.strokes, False
    except KeyboardInterrupt:
        return strokes, False


def judge(ink: Ink, strokes: Strokes, backend: Backend) -> FitResult:
    """Compare strokes with the ink, drawing by drawing.

    Args:
        ink: What is drawn.
        strokes: What is said to be drawn.
        backend: Which renderer, on which device.

    Returns:
        The strokes as they are, their evidence, and the error of every drawing.
    """
    return compare(ink, strokes, draw_coverage(strokes, ink.coverage.shape, backend))


def compare(ink: Ink, strokes: Strokes, drawn: NDArray[np.uint8]) -> FitResult:
    """Compare what strokes draw with the ink, drawing by drawing.

    Args:
        ink: What is drawn.
        strokes: What is said to be drawn.
        drawn: What they draw: coverage, 255 is full. uint8 [D, H, W]
    """
    squared = [
        np.mean((a.astype(np.float32) - b.astype(np.float32)) ** 2) / 255**2
        for a, b in zip(ink.shown, drawn, strict=True)
    ]
    psnr = -10 * np.log10(np.maximum(squared, 1e-10))
    return FitResult(strokes, gather_evidence(strokes, ink.shown, drawn), psnr)


def draw_coverage(strokes: Strokes, size: tuple[int, ...], backend: Backend) -> NDArray[np.uint8]:
    """Render the coverage of strokes, one drawing after the other.

    Args:
        strokes: S strokes over D drawings.
        size: D, H and W.
        backend: Which renderer, on which device.

    Returns:
        Coverage, 255 is full. uint8 [D, H, W]
    """
    drawn = np.zeros(size, np.uint8)
    for drawing in range(size[0]):
        part = Parameters.of(strokes.at_drawing(drawing, as_drawing=0), backend.device)
        with torch.no_grad():
            scene = part.scene((1, size[1], size[2]), part.intervals())
            scene = replace(scene, color=scene.opacity.new_ones((len(scene.opacity), 1)))
            image = render_image(scene, scene.opacity.new_zeros(1), backend=backend.name)
        drawn[drawing] = (image[0, :, :, 0].clamp(0, 1) * 255).round().byte().cpu().numpy()
    return drawn


def _schedule(settings: FitSettings, drawings: int, are_far: bool = False) -> Schedule:
    """How strokes are fitted: to the drawing of a clip of one, or to those of a window together."""
    if drawings == 1:
        return Schedule(
            settings.steps,
            scale=settings.scale,
            opacity_rate=settings.opacity_rate,
            floor=0.01,
            is_newton=True,
        )
    return Schedule(steps=settings.joint_steps * (_FAR if are_far else 1), rate=0.15, scale=1.5)


def _are_far(ink: Ink, strokes: Strokes, window: tuple[int, int], backend: Backend) -> bool:
    """Whether strokes of a window move far from drawing to drawing, and have not reached their ink yet."""
    part = strokes.within(*window).shifted(-window[0])
    if not moves_far(part):
        return False
    shown = ink.shown[window[0] : window[1] + 1]
    drawn = draw_coverage(part, shown.shape, backend)
    off = (np.maximum(shown, drawn) - np.minimum(shown, drawn)).sum(dtype=np.int64)
    return bool(off > _OFF * shown.sum(dtype=np.int64))


def _windows(drawings: int, settings: FitSettings) -> Iterator[tuple[int, int]]:
    """First and last drawing of each window, of nearly equal lengths."""
    count = -(-drawings // settings.window)
    edges = np.linspace(0, drawings, count + 1).round().astype(int).tolist()
    return ((a, b - 1) for a, b in pairwise(edges))


def _terms(strokes: Strokes, weights: Weights, known: NDArray[np.intp], device: torch.device) -> list[Term]:
    """The terms beside the photometric one that have a weight; ``known`` are rows that say where material is."""
    neighbours = Neighbours.of(strokes.layout, device)
    start = torch.as_tensor(strokes.points, device=device)
    terms: list[tuple[float, Term]] = []
    if len(neighbours.points):
        terms += [
            (weights.acceleration, lambda p: acceleration(p.points, neighbours)),
            (weights.rigidity, lambda p: rigidity(p.points, neighbours)),
            (weights.anchor, lambda p: anchor(p.points, start.to(p.points), neighbours)),
            (weights.width_change, lambda p: width_change(p.log_half_width, neighbours)),
        ]
    if len(neighbours.points) and weights.sliding > 0:
        marks = Marks.of(strokes, known, device)
        terms.append((weights.sliding, lambda p: sliding(p.points, marks)))
    return [_weighted(weight, term) for weight, term in terms if weight > 0]


def _pinned_rows(strokes: Strokes, shift: int, pins: frozenset[Pin]) -> NDArray[np.intp]:
    """Rows that are pinned, of strokes whose first drawing is number ``shift`` of the clip. int [K]"""
    layout = strokes.layout
    rows = zip(strokes.ids[layout.row_stroke].tolist(), (layout.row_drawing + shift).tolist(), strict=True)
    return np.flatnonzero([row in pins for row in rows])


def _restored(strokes: Strokes, given: Strokes, pins: frozenset[Pin]) -> Strokes:
    """The strokes with the points and widths that pinned rows had, to the last digit."""
    rows, layout = _pinned_rows(strokes, 0, pins), strokes.layout
    points, joints = np.isin(layout.point_row, rows), np.isin(layout.joint_row, rows)
    return replace(
        strokes,
        points=np.where(points[:, None], given.points, strokes.points),
        half_width=np.where(joints, given.half_width, strokes.half_width),
    )


def _weighted(weight: float, term: Term) -> Term:
    def weighted(parameters: Parameters) -> Tensor:
        return weight * term(parameters)

    return weighted
