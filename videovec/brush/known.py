"""A brush that is known laid along strokes: nothing of it is learned but where it lies, and how densely."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from videovec.brush.align import Folded
from videovec.brush.drift import lie_along
from videovec.brush.gauge import full_scale
from videovec.brush.lay import grain_begins, phases_at
from videovec.brush.refine import Laid
from videovec.brush.strips import TEXELS_ACROSS, TEXELS_PER_WIDTH, Strip, joint_arcs
from videovec.brushwork import Brush, BrushModel, Laying

__all__ = ["lay_known"]

Floats = NDArray[np.float64]

_SCALES = np.exp(np.arange(-60, 61) * 0.005)  # of the strokes' width against the brush's own


def lay_known(laid: Laid, strips: list[Strip], brush: Brush) -> tuple[Laid, float]:
    """Lay a known brush along strokes that a profile explains.

    Args:
        laid: The strokes.
        strips: The same unrolled.
        brush: The known brush.

    Returns:
        The strokes laid with the brush, at the pen width that fits them, and the share of grain that it explains.
    """
    width = laid.brush.width
    here = replace(brush, width=width)
    texture = _of_rows(brush.strip - brush.profile, TEXELS_ACROSS)
    if brush.model is not BrushModel.TEXTURE:
        is_grain = brush.model is BrushModel.GRAIN
        begins = (
            grain_begins(strips, np.ones(len(strips)), texture, brush.repeat) if is_grain else np.zeros(len(strips))
        )
        laying = replace(Laying.plain(laid.strokes.layout, begins), density=laid.laying.density)
        return full_scale(here, replace(laid, laying=laying)), 0.0
    scores = [sum(_drop(strip, texture, brush.repeat * scale) for strip in strips) for scale in _SCALES]
    scale = float(_SCALES[int(np.argmax(scores))])
    found = [lie_along(strip, texture, brush.repeat * scale) for strip in strips]
    arcs = joint_arcs(laid.strokes)
    phase = np.concatenate(
        [phases_at(arc / width, offset) / scale for arc, (_, offset, _) in zip(arcs, found, strict=True)]
    )
    laying = replace(laid.laying, sign=np.array([sign for sign, _, _ in found]), phase=phase)
    energy = np.array([float((strip.weight * strip.grain**2).sum()) for strip in strips])
    explained = float(np.average([share for _, _, share in found], weights=energy))
    return full_scale(replace(here, width=width * scale), replace(laid, laying=laying)), explained


def _of_rows(strip: Floats, rows: int) -> Floats:
    """A strip with another number of texels across. [U, rows]"""
    here, wanted = ((np.arange(count) + 0.5) / count for count in (strip.shape[1], rows))
    return np.stack([np.interp(wanted, here, column) for column in strip])


def _drop(strip: Strip, texture: Floats, repeat: float) -> float:
    """By how much the best place in a texture lowers the squared grain of a stroke."""
    columns = max(round(repeat * TEXELS_PER_WIDTH), 4)
    at = (np.arange(columns) + 0.5) / columns * len(texture) - 0.5
    left = np.floor(at).astype(np.intp)
    share = (at - left)[:, None]
    resampled = (1 - share) * texture[left % len(texture)] + share * texture[(left + 1) % len(texture)]
    return Folded.of(strip, repeat, columns).best(resampled)[2]
