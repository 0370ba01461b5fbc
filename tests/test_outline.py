"""Outlines fill exactly the ink of their stroke, judged by discs along it and by other people's rasterisers."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from drawn import by_skia, coverage, psnr, resvg, stroke
from hypothesis import example, given, settings
from hypothesis import strategies as st

from videovec.stroke_shape import StrokeShape
from videovec.write.outline import outline, plan_outline
from videovec.write.svg import path_data

Floats = np.typing.NDArray[np.float64]

SIZE = 64
ARC = 0.5522847498 * 20
CIRCLE = np.array(
    [
        *([52, 32], [52, 32 + ARC], [32 + ARC, 52], [32, 52], [32 - ARC, 52], [12, 32 + ARC], [12, 32]),
        *([12, 32 - ARC], [32 - ARC, 12], [32, 12], [32 + ARC, 12], [52, 32 - ARC], [52, 32]),
    ]
)

STROKES = {
    "tapered line": stroke([[10, 10], [20, 20], [30, 30], [50, 50]], [2, 4]),
    "u-turn narrower than its pen": stroke([[10, 28], [60, 28], [60, 36], [10, 36]], [6, 6]),
    "hook smaller than its pen": stroke([[30, 30], [36, 30], [36, 34], [30, 34]], [6, 6]),
    "loop across itself": stroke([[10, 50], [70, 0], [-10, 0], [54, 50]], [3, 4]),
    "sharp corner": stroke([[10, 50], [20, 40], [25, 20], [32, 10], [33, 30], [40, 40], [50, 50]], [4, 3, 4]),
    "straight back": stroke([[10, 30], [20, 30], [40, 30], [50, 30], [40, 30], [30, 30], [20, 30]], [4, 4, 4]),
    "cusp": stroke([[10, 50], [54, 10], [10, 10], [54, 50]], [4, 4]),
    "near cusp": stroke([[10, 50], [54.1, 10], [9.9, 10], [54, 50]], [4, 4]),
    "dot": stroke([[30, 30]] * 4, [5, 5]),
    "handles on the joints": stroke([[10, 10], [10, 10], [50, 50], [50, 50]], [2, 4]),
    "ring": stroke(CIRCLE, [3, 3.5, 3, 3.5, 3], is_closed=True),
    "part of a ring": stroke(CIRCLE, [3, 4, 3, 4, 3], is_closed=True, visible=(0.3, 0.8)),
    "ring smaller than its pen": stroke((CIRCLE - 32) / 10 + 32, [5] * 5, is_closed=True),
    "middle of a line": stroke([[10, 10], [20, 20], [30, 30], [50, 50]], [3, 4], visible=(0.25, 0.6)),
}


def filled(loops: tuple[Floats, ...], rule: str = "nonzero") -> str:
    data = " ".join(path_data(loop[0], is_closed=True) for loop in loops)
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{SIZE}" height="{SIZE}">'
        f'<path d="{data}" fill="#000" fill-rule="{rule}"/></svg>'
    )


def drawn_by_skia(document: str) -> Floats:
    return by_skia(document, (SIZE, SIZE), 8)


def drawn_by_resvg(document: str) -> Floats:
    return resvg(document, 4)


@pytest.mark.parametrize("draw", [drawn_by_resvg, drawn_by_skia])
@pytest.mark.parametrize("shape", [pytest.param(shape, id=name) for name, shape in STROKES.items()])
def test_an_outline_is_the_ink_of_its_stroke(shape: StrokeShape, draw: Callable[[str], Floats]) -> None:
    drawn = draw(filled(outline([shape], plan_outline([shape]))))
    truth = 1 - coverage([shape], SIZE)
    assert psnr(drawn, truth) > 45
    assert np.abs(drawn - truth).max() < 0.12


@pytest.mark.xfail(reason="proves that the comparison can fail: a stroke across itself needs the nonzero rule")
def test_the_even_odd_rule_leaves_holes() -> None:
    shape = STROKES["loop across itself"]
    drawn = resvg(filled(outline([shape], plan_outline([shape])), "evenodd"), 4)
    assert psnr(drawn, 1 - coverage([shape], SIZE)) > 45


@settings(max_examples=20, deadline=None)
@given(seed=st.integers(0, 10_000), count=st.integers(1, 3), width=st.floats(0.4, 6))
@example(seed=222, count=2, width=2.0)  # a corner whose fan ends where the next segment bends more than its pen
def test_no_stroke_has_holes_or_spills(seed: int, count: int, width: float) -> None:
    rng = np.random.default_rng(seed)
    shape = stroke(rng.uniform(10, 54, (3 * count + 1, 2)), np.full(count + 1, width))
    drawn = resvg(filled(outline([shape], plan_outline([shape]))), 4)
    assert np.abs(drawn - (1 - coverage([shape], SIZE))).max() < 0.2


def test_one_plan_draws_a_stroke_on_all_of_its_drawings() -> None:
    moved = [
        stroke(np.array([[10, 50], [70 - 3 * k, 2 * k], [-10 + 4 * k, 0], [54, 50 - k]]), [3, 4]) for k in range(6)
    ]
    moved.append(stroke(moved[0].points, [3, 4], visible=(0.2, 0.7)))
    plan = plan_outline(moved)
    (loops,) = outline(moved, plan)
    assert loops.shape[0] == len(moved)
    np.testing.assert_array_equal(loops[:, 0], loops[:, -1])
    for shape, loop in zip(moved, loops, strict=True):
        assert psnr(resvg(filled((loop[None],)), 4), 1 - coverage([shape], SIZE)) > 45


def test_the_sides_of_a_circle_are_circles() -> None:
    shape = stroke(CIRCLE, [3] * 5, is_closed=True)
    outer, inner = sorted(outline([shape], plan_outline([shape])), key=lambda loop: -np.ptp(loop))
    for loop, radius in ((outer, 23), (inner, 17)):
        middle = (loop[0, :-1:3] + 3 * loop[0, 1::3] + 3 * loop[0, 2::3] + loop[0, 3::3]) / 8
        for places in (loop[0, ::3], middle):
            np.testing.assert_allclose(np.linalg.norm(places - 32, axis=1), radius, atol=0.02)


def test_a_simple_stroke_has_few_points() -> None:
    straight = STROKES["tapered line"]
    assert outline([straight], plan_outline([straight]))[0].shape == (1, 3 * 6 + 1, 2)  # two sides, two times two arcs
