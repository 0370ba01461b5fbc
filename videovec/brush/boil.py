"""Lines that boil: drawn anew for every drawing, so that the texture begins anywhere on each.

The brush is still one. Every drawing of a stroke is unrolled and placed along the texture on its own; what its places
have in common along the stroke are the stroke's phases, and where each drawing begins is its shift.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from videovec.brush.align import Alignment
from videovec.brush.drift import lie_along
from videovec.brush.lay import lay_texture, phases_at
from videovec.brush.refine import Laid
from videovec.brush.strips import Strip, joint_arcs
from videovec.brushwork import Laying, stroke_joints
from videovec.strokes import Layout

__all__ = ["apart", "lay_boiling"]

Floats = NDArray[np.float64]


def apart(laid: Laid) -> Laid:
    """Every drawing of every stroke as a stroke of its own, in the order of the rows."""
    strokes, layout = laid.strokes, laid.strokes.layout
    of = layout.row_stroke
    single = replace(
        strokes,
        ids=np.arange(1, len(of) + 1),
        layout=Layout(layout.segments[of], layout.row_drawing, layout.row_drawing),
        is_closed=strokes.is_closed[of],
        layer=strokes.layer[of],
        color=strokes.color[of],
        parent=np.zeros(len(of), np.intp),
    )
    starts = stroke_joints(layout)
    phase = [laid.laying.phase[starts[stroke] : starts[stroke + 1]] for stroke in of]
    return Laid(
        single, Laying(laid.laying.sign[of], np.concatenate(phase), laid.laying.density, laid.laying.shift), laid.brush
    )


def lay_boiling(laid: Laid, strips: list[Strip], found: Alignment) -> Laid:
    """Lay strokes with the texture that the strips of their single drawings made.

    Args:
        laid: S strokes over R rows.
        strips: Those of `apart`. R
        found: How each of them lies.

    Returns:
        The strokes laid: one direction and one run of phases for each, and one shift for each row.
    """
    layout, width = laid.strokes.layout, laid.brush.width
    arcs = [arc / width for arc in joint_arcs(apart(laid).strokes)]
    sign, phase = np.ones(len(layout.segments)), []
    shift = np.zeros(len(strips))
    for stroke in range(len(sign)):
        rows = np.arange(layout.stroke_rows[stroke], layout.stroke_rows[stroke + 1])
        sign[stroke] = 1.0 if float(found.sign[rows] @ found.energy[rows]) >= 0 else -1.0
        placed = [_place(strips[row], found, int(row), sign[stroke]) for row in rows]
        at_joints = np.array([phases_at(arcs[row], offset) for row, offset in zip(rows, placed, strict=True)])
        shift[rows] = at_joints.mean(axis=1)
        phase.append((at_joints - shift[rows, None]).mean(axis=0))
    plain = lay_texture(laid, replace(found, sign=sign, offset=tuple(np.zeros(1) for _ in sign)))
    return replace(plain, laying=replace(plain.laying, phase=np.concatenate(phase), shift=shift[layout.joint_row]))


def _place(strip: Strip, found: Alignment, row: int, sign: float) -> Floats:
    """Offset of each texel of a strip [L] in the direction of its stroke. Widths"""
    if found.sign[row] == sign:
        return found.offset[row]
    return lie_along(strip, found.texture, found.repeat, (0,) if sign > 0 else (1,))[1]
