"""Which model explains a brush: a test on strokes that were held out, never a measure of pictures.

Grain that the template of the other strokes predicts comes back with the stroke: a texture. Ink that leans to one side,
the same side on every stroke once each is turned the right way, is an asymmetric profile. What neither explains is
grain of which only the statistics are the brush's.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from videovec.brush.align import Alignment, shuffled
from videovec.brush.drift import learn_texture, texture_of
from videovec.brush.period import find_repeat
from videovec.brush.strips import TEXELS_PER_WIDTH, Strip
from videovec.brushwork import SUPPORT, BrushModel
from videovec.settings import BrushSettings

__all__ = ["Evidence", "Lean", "find_lean", "grain_level", "learn_shared", "surest", "weigh"]

Floats = NDArray[np.float64]

_RIDGE = 10.0  # texel rows that say "symmetric"
_SURE = 0.65  # half-widths from the centre line in which grain is compared
_OUTLIER = 2.5  # standard deviations of grain beyond which it is none
_CORE = 0.6  # half-widths from the centre line in which no edge disturbs the grain


@dataclass(frozen=True, slots=True)
class Evidence:
    """Why a model was chosen.

    Args:
        model: The model.
        width: Mean width of the strokes. px
        grain: Standard deviation of ink against density in the core of the strokes.
        repeat: Best repeat of a shared texture. Widths
        explained: Share of the grain that a texture learned from the other strokes explains.
        null: The same for strips that were shuffled along the stroke.
        lean: Share of the grain that a one-sided profile learned from the other strokes explains.
        agreement: Over drawings, correlation of a stroke's grain with itself; nan for a still.
    """

    model: BrushModel
    width: float
    grain: float
    repeat: float
    explained: float
    null: float
    lean: float
    agreement: float


@dataclass(frozen=True, slots=True, eq=False)
class Lean:
    """The mean grain across a stroke, every stroke turned to agree with the others.

    Args:
        profile: Mean grain. [V]
        sign: Direction of each stroke, 1 or -1. [S]
        explained: Share of all grain that the profile of the other strokes explains.
    """

    profile: Floats
    sign: Floats
    explained: float


def weigh(
    strips: list[Strip], width: float, settings: BrushSettings, rng: np.random.Generator
) -> tuple[Evidence, Alignment, Lean]:
    """Test the models on strips of strokes that a symmetric profile was taken from.

    Args:
        strips: S strips.
        width: Mean width of the strokes. px
        settings: Thresholds, the range of repeats, and a model that was asked for.
        rng: For shuffling.

    Returns:
        The evidence, the texture as learned, and the one-sided profile.
    """
    sure = surest(strips)
    found = learn_shared(sure, settings)
    repeat = found.repeat
    null = float(np.mean([learn_texture(shuffled(sure, rng), repeat).score for _ in range(2)]))
    lean = find_lean(strips)
    known = [strip for strip in strips if np.isfinite(strip.agreement)]
    weights = [float(strip.weight.sum()) for strip in known]
    agreement = float(np.average([strip.agreement for strip in known], weights=weights)) if known else float("nan")
    model = BrushModel.PROFILE
    evidence = Evidence(model, width, grain_level(strips), repeat, found.score, null, lean.explained, agreement)
    return replace(evidence, model=_choose(evidence, settings)), texture_of(strips, found), lean


def learn_shared(strips: list[Strip], settings: BrushSettings) -> Alignment:
    """The texture that strips share, at the repeat that is best for them."""
    longest = max(len(strip.grain) for strip in strips) / TEXELS_PER_WIDTH
    highest = max(min(settings.longest_repeat, longest), 1.05 * settings.shortest_repeat)
    return learn_texture(strips, find_repeat(strips, settings.shortest_repeat, highest))


def surest(strips: list[Strip]) -> list[Strip]:
    """What of strips is surely grain, and not an edge that is off."""
    level = grain_level(strips)
    return [_surest(strip, level) for strip in strips]


def _surest(strip: Strip, level: float) -> Strip:
    """The core of a strip without outliers: an edge that is off by half a pixel outweighs all grain beside it."""
    v = ((np.arange(strip.grain.shape[1]) + 0.5) / strip.grain.shape[1] * 2 - 1) * SUPPORT
    grain = np.clip(strip.grain, -_OUTLIER * level, _OUTLIER * level)
    return replace(strip, grain=grain, weight=strip.weight * (np.abs(v) < _SURE))


def _choose(evidence: Evidence, settings: BrushSettings) -> BrushModel:
    if settings.model != "auto":
        return BrushModel(settings.model)
    if evidence.grain < settings.least_grain:
        return BrushModel.PROFILE
    if evidence.explained - evidence.null > settings.texture_margin:
        return BrushModel.TEXTURE
    is_plain = evidence.lean > settings.lean_share or evidence.width < settings.least_width
    return BrushModel.PROFILE if is_plain else BrushModel.GRAIN


def grain_level(strips: list[Strip]) -> float:
    """Standard deviation of ink against density in the core of the strokes."""
    across = strips[0].grain.shape[1]
    v = ((np.arange(across) + 0.5) / across * 2 - 1) * SUPPORT
    core = np.abs(v) < _CORE
    energy = sum(float((strip.weight * strip.grain**2)[:, core].sum()) for strip in strips)
    weight = sum(float(strip.weight[:, core].sum()) for strip in strips)
    return float(np.sqrt(energy / max(weight, 1e-9)))


def find_lean(strips: list[Strip], sweeps: int = 10) -> Lean:
    """Turn every stroke so that its mean grain across agrees with the others'."""
    seen = np.array([strip.weight.sum(0) for strip in strips])
    total = np.array([(strip.grain * strip.weight).sum(0) for strip in strips])
    energy = sum(float((strip.weight * strip.grain**2).sum()) for strip in strips)
    sign = np.ones(len(strips))
    drop = np.zeros(len(strips))
    for _ in range(sweeps):
        before = sign.copy()
        for k in range(len(strips)):
            others = _mean_profile(total, seen, sign, without=k)
            drops = [_drop(total[k], seen[k], turned) for turned in (others, others[::-1])]
            sign[k] = 1.0 if drops[0] >= drops[1] else -1.0
            drop[k] = max(drops)
        if np.array_equal(before, sign):
            break
    return Lean(_mean_profile(total, seen, sign, without=-1), sign, float(drop.sum()) / max(energy, 1e-12))


def _mean_profile(total: Floats, seen: Floats, sign: Floats, without: int) -> Floats:
    keep = np.arange(len(total)) != without
    turned = [np.where(sign[keep, None] > 0, part[keep], part[keep][:, ::-1]).sum(0) for part in (total, seen)]
    return np.asarray(turned[0] / (turned[1] + _RIDGE))


def _drop(total: Floats, seen: Floats, profile: Floats) -> float:
    """By how much a profile lowers the squared grain."""
    return float((2 * total * profile - seen * profile**2).sum())
