"""From solid strokes to a brush: one brush for all strokes of a clip, and how it was laid along each."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from videovec.brush.align import Alignment
from videovec.brush.boil import apart, lay_boiling
from videovec.brush.choose import Evidence, Lean, find_lean, grain_level, learn_shared, surest, weigh
from videovec.brush.drift import texture_of
from videovec.brush.gauge import centre_support, full_scale
from videovec.brush.grain import measure_grain, synthesise_grain
from videovec.brush.known import lay_known
from videovec.brush.lay import grain_begins, lay_again, lay_texture
from videovec.brush.lifts import find_lifts, part_strokes
from videovec.brush.prepare import fit_profile, mean_width, shorten_segments
from videovec.brush.refine import Laid, RefineSchedule, refine
from videovec.brush.settle import settle
from videovec.brush.storage import load_brush
from videovec.brush.strips import TEXELS_PER_WIDTH, Strip, unroll
from videovec.brushwork import Brush, BrushModel, Laying
from videovec.errors import FitError
from videovec.ink import Ink
from videovec.progress import Progress, Silent
from videovec.settings import BrushSettings
from videovec.strokes import Strokes

__all__ = ["BrushFit", "fit_brush"]

_INK = 12  # coverage, of 255, from which a pixel holds ink
GRAIN_WIDTHS = 48  # length of a strip of synthesised grain; strokes begin anywhere in it


@dataclass(frozen=True, slots=True, eq=False)
class BrushFit:
    """A learned brush and the strokes that are drawn with it.

    Args:
        brush: The brush.
        strokes: The strokes, refined with the brush; identities and lives are those given, long segments are halved,
            and strokes are parted where their texture begins anew.
        laying: Phase, direction and density of the brush along each stroke.
        evidence: Why the brush's model was chosen.
        ink_pixels: Pixels that hold ink, over all drawings: a brush with more texels than this is a bitmap.
    """

    brush: Brush
    strokes: Strokes
    laying: Laying
    evidence: Evidence
    ink_pixels: int

    @property
    def texels(self) -> int:
        """How many numbers the brush is."""
        return int(self.brush.strip.size)


def fit_brush(
    ink: Ink, strokes: Strokes, settings: BrushSettings, progress: Progress | None = None, seed: int = 0
) -> BrushFit:
    """Learn the one brush that draws all strokes, and how it lies along each.

    Args:
        ink: D drawings.
        strokes: A solid fit of them.
        settings: How the brush is learned.
        progress: Told of the steps.
        seed: Of shuffling and grain.

    Returns:
        Brush, refined strokes, their laying, and the evidence for the model.

    Raises:
        FitError: There are no strokes.
    """
    if not len(strokes):
        raise FitError("a brush needs at least one stroke, got none")
    progress = progress or Silent()
    rng = np.random.default_rng(seed)
    progress.stage("brush", settings.profile_steps + settings.texture_steps)
    strokes = shorten_segments(strokes, settings.longest_segment * mean_width(strokes))
    laid = fit_profile(strokes, ink.coverage, settings.profile_steps, progress)
    boils = settings.boil and ink.drawing_count > 1 and not settings.brush
    strips = unroll(apart(laid) if boils else laid, ink.coverage)
    if settings.brush:
        return _with_known(laid, strips, ink.coverage, settings, progress)
    evidence, texture, lean = weigh(strips, laid.brush.width, settings, rng)
    progress.note(describe(evidence))
    if evidence.model is BrushModel.TEXTURE and boils:
        laid = _with_boiling_texture(lay_boiling(laid, strips, texture), ink.coverage, settings, progress)
    elif evidence.model is BrushModel.TEXTURE:
        laid, texture = _parted(laid, strips, texture, ink.coverage, settings)
        laid = _with_texture(laid, texture, ink.coverage, settings, progress)
    else:
        lean = find_lean(unroll(laid, ink.coverage)) if boils else lean
        if lean.explained > settings.lean_share:
            laid = _with_lean(laid, lean, ink.coverage, settings, progress)
        if evidence.model is BrushModel.GRAIN:
            laid = _with_grain(laid, ink.coverage, rng)
            if boils:
                layout = laid.strokes.layout
                shift = rng.uniform(0, GRAIN_WIDTHS, len(layout.row_stroke))[layout.joint_row]
                laid = replace(laid, laying=replace(laid.laying, shift=shift))
    return BrushFit(laid.brush, laid.strokes, laid.laying, evidence, _ink_pixels(ink.coverage))


def _ink_pixels(coverage: NDArray[np.uint8]) -> int:
    return int((coverage > _INK).sum())


def _with_known(
    laid: Laid,
    strips: list[Strip],
    coverage: NDArray[np.uint8],
    settings: BrushSettings,
    progress: Progress,
) -> BrushFit:
    """Lay the brush of a file, and fit all but its texels."""
    brush = load_brush(Path(settings.brush))
    grain = grain_level(strips)
    laid, explained = lay_known(laid, strips, brush)
    if brush.model is not BrushModel.GRAIN:
        phase_rate = 0.01 if brush.model is BrushModel.TEXTURE else 0.0
        schedule = RefineSchedule(settings.texture_steps, 0.08, 0.01, phase=phase_rate, strip=0.0)
        laid = replace(refine(laid, coverage, schedule, progress), brush=laid.brush)
    nothing = float("nan")
    evidence = Evidence(brush.model, laid.brush.width, grain, brush.repeat, explained, nothing, nothing, nothing)
    return BrushFit(laid.brush, laid.strokes, laid.laying, evidence, _ink_pixels(coverage))


def describe(evidence: Evidence) -> str:
    """The choice and its evidence as one line."""
    return (
        f"brush: {evidence.model}; a shared texture explains {evidence.explained:.2f} of held-out strokes, "
        f"{evidence.null:.2f} of shuffled ones; a one-sided profile {evidence.lean:.2f}; pen {evidence.width:.1f} px"
    )


def _parted(
    laid: Laid, strips: list[Strip], found: Alignment, coverage: NDArray[np.uint8], settings: BrushSettings
) -> tuple[Laid, Alignment]:
    """Strokes that begin where the brush did, and the texture learned again from them."""
    for only_turned in (True, False):  # strokes of two hide the repeat, and a wrong one makes strokes jump
        parted = part_strokes(laid, find_lifts(surest(strips), found, only_turned))
        if len(parted.strokes) > len(laid.strokes):
            laid, strips = parted, unroll(parted, coverage)
            found = texture_of(strips, learn_shared(surest(strips), settings))
    return laid, found


def _with_texture(
    laid: Laid, found: Alignment, coverage: NDArray[np.uint8], settings: BrushSettings, progress: Progress
) -> Laid:
    """Fit texels, phases and strokes together; strokes that then lie better elsewhere are moved, once."""
    last = settings.texture_steps // 3
    shift = 0.003 if len(coverage) > 1 else 0.0  # less than phases move: a short stroke says little of one drawing
    laid = settle(lay_texture(laid, found), coverage)
    for steps in (settings.texture_steps - last, last):
        laid = refine(laid, coverage, RefineSchedule(steps, 0.08, 0.01, phase=0.01, shift=shift), progress)
        if steps != last:
            laid = settle(lay_again(laid, coverage), coverage)
    return full_scale(laid.brush, laid)


def _with_boiling_texture(laid: Laid, coverage: NDArray[np.uint8], settings: BrushSettings, progress: Progress) -> Laid:
    """Fit texels, phases, the shifts of single drawings and strokes together."""
    schedule = RefineSchedule(settings.texture_steps, 0.08, 0.01, phase=0.01, shift=0.01)
    laid = refine(laid, coverage, schedule, progress)
    return full_scale(laid.brush, laid)


def _with_lean(
    laid: Laid, lean: Lean, coverage: NDArray[np.uint8], settings: BrushSettings, progress: Progress
) -> Laid:
    """Fit a one-sided profile, every stroke turned its own way."""
    brush = replace(laid.brush, strip=np.maximum(laid.brush.strip + lean.profile, 0.0))
    laid = full_scale(brush, replace(laid, laying=replace(laid.laying, sign=lean.sign)))
    for steps in (settings.profile_steps * 2 // 3, settings.profile_steps // 3):
        laid = centre_support(refine(laid, coverage, RefineSchedule(steps), progress))
    return full_scale(laid.brush, laid)


def _with_grain(laid: Laid, coverage: NDArray[np.uint8], rng: np.random.Generator) -> Laid:
    """Grain of the same statistics, begun on every stroke where it looks most like that stroke's own."""
    strips, sign = unroll(laid, coverage), laid.laying.sign
    turned = [strip if forth else strip.turned() for strip, forth in zip(strips, sign > 0, strict=True)]
    statistics = measure_grain(turned, laid.brush.profile)
    strip = synthesise_grain(statistics, GRAIN_WIDTHS * TEXELS_PER_WIDTH, rng)
    brush = Brush(laid.brush.name, BrushModel.GRAIN, strip, laid.brush.width, GRAIN_WIDTHS)
    begins = grain_begins(strips, sign, strip - brush.profile, GRAIN_WIDTHS)
    phase = np.repeat(begins, laid.strokes.layout.segments + 1)
    return full_scale(brush, replace(laid, laying=replace(laid.laying, phase=phase)))
