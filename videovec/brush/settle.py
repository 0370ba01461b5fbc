"""Drawings of a clip whose arc length is off settled on the texture where the others lie.

Drawings are started one by one, so that the first point of one may lie further along the ink, or a corner be cut
shorter, than on the others: from there on the arc of that drawing is wrong, and the texture lies elsewhere on it.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from videovec.brush.boil import apart
from videovec.brush.drift import explained_at, follow
from videovec.brush.lay import offsets_at, phases_at
from videovec.brush.refine import Laid
from videovec.brush.strips import joint_arcs, unroll
from videovec.brushwork import stroke_joints

__all__ = ["settle"]

_PAYS = 150.0  # texels' worth of the grain of one drawing of a stroke that shifts must explain more to be believed


def settle(laid: Laid, coverage: NDArray[np.uint8]) -> Laid:
    """Shift the texture on drawings, and parts of them, whose own ink says that it lies elsewhere.

    Args:
        laid: Strokes laid with a texture that their drawings share.
        coverage: Ink fraction, 255 is full. uint8 [D, H, W]

    Returns:
        The same with other shifts, of strokes that live for several drawings.
    """
    layout = laid.strokes.layout
    texture = laid.brush.strip - laid.brush.profile
    single = apart(laid)
    starts = stroke_joints(single.strokes.layout)
    shift = laid.laying.shift.copy()
    arcs = joint_arcs(single.strokes)
    for row, strip in enumerate(unroll(single, coverage)):
        stroke = layout.row_stroke[row]
        if layout.first[stroke] == layout.last[stroke]:
            continue
        joints = slice(layout.row_joints[row], layout.row_joints[row + 1])
        at, sign = arcs[row] / laid.brush.width, laid.laying.sign[stroke]
        now = offsets_at(strip, at, single.laying.phase[starts[row] : starts[row + 1]] + shift[joints])
        offset, share = follow(strip, sign, now, texture, laid.brush.repeat)
        gain = share - explained_at(strip, texture, laid.brush.repeat, sign, now)
        if gain * strip.weight.sum() > _PAYS:
            shift[joints] += phases_at(at, offset - now)
    return replace(laid, laying=replace(laid.laying, shift=shift))
