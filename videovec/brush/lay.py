"""Strokes laid along a texture: from the offsets of their texels to the phases of their joints, and back."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from videovec.brush.align import Alignment, Folded
from videovec.brush.drift import explained_at, lie_along
from videovec.brush.gauge import full_scale
from videovec.brush.refine import Laid
from videovec.brush.strips import TEXELS_PER_WIDTH, Strip, joint_arcs, unroll
from videovec.brushwork import Brush, BrushModel, stroke_joints

__all__ = ["grain_begins", "lay_again", "lay_texture", "offsets_at", "phases_at"]

Floats = NDArray[np.float64]

_BETTER = 0.05  # of a stroke's grain that another place must explain more before the stroke is moved there


def lay_texture(laid: Laid, found: Alignment) -> Laid:
    """Strokes that a profile explains, laid with the texture that their strips made."""
    strip = np.maximum(laid.brush.profile + found.texture, 0.0)
    brush = Brush(laid.brush.name, BrushModel.TEXTURE, strip, laid.brush.width, found.repeat)
    phase = [
        phases_at(arc / laid.brush.width, offset)
        for arc, offset in zip(joint_arcs(laid.strokes), found.offset, strict=True)
    ]
    laying = replace(laid.laying, sign=found.sign, phase=np.concatenate(phase))
    return full_scale(brush, replace(laid, laying=laying))


def lay_again(laid: Laid, coverage: NDArray[np.uint8]) -> Laid:
    """Move strokes along the texture where another place explains clearly more of their grain."""
    texture = laid.brush.strip - laid.brush.profile
    starts = stroke_joints(laid.strokes.layout)
    phase, sign = laid.laying.phase.copy(), laid.laying.sign.copy()
    arcs = joint_arcs(laid.strokes)
    for stroke, strip in enumerate(unroll(laid, coverage)):
        part = slice(starts[stroke], starts[stroke + 1])
        at = arcs[stroke] / laid.brush.width
        now = offsets_at(strip, at, phase[part])
        share = explained_at(strip, texture, laid.brush.repeat, sign[stroke], now)
        other_sign, offset, other_share = lie_along(strip, texture, laid.brush.repeat)
        if other_share > share + _BETTER:
            sign[stroke], phase[part] = other_sign, phases_at(at, offset)
    return replace(laid, laying=replace(laid.laying, sign=sign, phase=phase))


def grain_begins(strips: list[Strip], sign: Floats, texture: Floats, repeat: float) -> Floats:
    """Where each stroke begins along grain that was synthesised, so that it looks most like its own.

    Grain of chance is nowhere in a strip that only shares its statistics, but some places are liker than others. It is
    one number for a stroke. Directions stay, and nothing drifts: with more freedom a strip is marks to copy from.

    Args:
        strips: S strips.
        sign: Direction of each stroke.
        texture: Grain, profile removed. [U, V]
        repeat: Its length. Widths

    Returns:
        Phase at the beginning of each stroke. [S] widths
    """
    begins = []
    for strip, forth in zip(strips, sign > 0, strict=True):
        _, phase, _ = Folded.of(strip, repeat, len(texture)).best(texture, (0,) if forth else (1,))
        begins.append(phase * repeat / len(texture) + (0.0 if forth else len(strip.grain) / TEXELS_PER_WIDTH))
    return np.array(begins)


def _texel_arcs(count: int) -> Floats:
    return (np.arange(count) + 0.5) / TEXELS_PER_WIDTH


def phases_at(joints: Floats, offset: Floats) -> Floats:
    """Phase at joints [n+1] of the offsets of texels [L]; joints at arcs in widths."""
    return np.interp(joints, _texel_arcs(len(offset)), offset)


def offsets_at(strip: Strip, joints: Floats, phase: Floats) -> Floats:
    """Offset of each texel [L] of a strip from the phases of joints at arcs in widths."""
    return np.interp(_texel_arcs(len(strip.grain)), joints, phase)
