"""Textures on drawings of a clip whose strokes begin elsewhere, against the painter of the tests of brush fits."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray
from test_brush_fit import arcs, draw, grain

from videovec.brush.refine import Laid
from videovec.brush.settle import settle
from videovec.brushwork import SUPPORT, Brush, BrushModel, Laying
from videovec.strokes import Layout, Strokes

Floats = NDArray[np.float64]
REPEAT, WIDTH = 9.0, 8.0
PHASE = np.array([0.5, 3.0, 6.2])


def begun_earlier(curve: Floats, px: float) -> Floats:
    """The same line from a point that lies further back along its first tangent. [4, 2]"""
    back = curve[1] - curve[0]
    return np.concatenate([curve[:1] - px * back / np.linalg.norm(back), curve[1:]])


def laid_on(drawings: int, early: dict[tuple[int, int], float], seed: int) -> tuple[Laid, NDArray[np.uint8]]:
    """Three strokes drawn alike on every drawing, and begun earlier by some px where (stroke, drawing) says so."""
    rng, still = np.random.default_rng(seed), arcs(3)
    strip = grain(round(12 * REPEAT), 24, rng)
    page = np.round(255 * draw(still, strip, PHASE, REPEAT)).astype(np.uint8)
    rows = [(s, k) for s in range(3) for k in range(drawings)]
    points = [begun_earlier(still.points_of(s), early.get((s, k), 0.0)) for s, k in rows]
    layout = Layout(still.layout.segments, np.zeros(3, np.intp), np.full(3, drawings - 1))
    strokes = Strokes(
        ids=still.ids, layout=layout, is_closed=still.is_closed, layer=still.layer, color=still.color,
        points=np.concatenate(points), half_width=np.full(2 * len(rows), WIDTH / 2), opacity=np.ones(len(rows)),
        visible=np.tile([0.0, 1.0], (len(rows), 1)),
    )  # fmt: skip
    across = ((np.arange(24) + 0.5) / 24 * 2 - 1) * SUPPORT
    known = ((np.arange(24) + 0.5) / 24) * 2 - 1
    wide = np.stack([np.interp(across, known, row) * (abs(across) < 1) for row in strip])
    brush = Brush("b", BrushModel.TEXTURE, wide, WIDTH, REPEAT)
    return Laid(strokes, Laying.plain(layout, PHASE), brush), np.repeat(page[None], drawings, axis=0)


def test_a_drawing_that_begins_earlier_is_shifted_by_as_much_and_no_other_is() -> None:
    early = {(0, 1): 3.0, (2, 3): 5.0}
    laid, pages = laid_on(4, early, seed=3)
    shift = settle(laid, pages).laying.shift.reshape(3, 4, 2)[..., 1] * laid.brush.width  # the other end is off the ink
    for stroke in range(3):
        for drawing in range(4):
            assert shift[stroke, drawing] == pytest.approx(-early.get((stroke, drawing), 0.0), abs=0.7)


def test_one_drawing_has_none_to_agree_with_and_stays() -> None:
    laid, pages = laid_on(1, {(0, 0): 3.0}, seed=3)
    assert not settle(laid, pages).laying.shift.any()


def test_the_shift_of_a_stroke_goes_with_it() -> None:
    laid, pages = laid_on(4, {(2, 3): 5.0}, seed=3)
    settled = settle(laid, pages)
    last = settled.laying.at_drawing(settled.strokes.layout, 3)
    assert last.shift.shape == (6,)
    np.testing.assert_allclose(last.shift[4:], settled.laying.shift[-2:])
    alone = settled.laying.select(settled.strokes.layout, np.array([False, False, True]))
    np.testing.assert_allclose(alone.shift, settled.laying.shift[-8:])
    assert alone.shift.any()
