"""The benchmarks' reader of Lottie against figures that can be worked out by hand."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from benchmarks.lottie_strokes import UnreadableError, strokes_at

LINE = {
    "ty": "sh",
    "ks": {"a": 0, "k": {"v": [[0, 0], [10, 0]], "i": [[0, 0], [0, 0]], "o": [[0, 0], [0, 0]], "c": False}},
}
STEADY = {"i": {"x": [0.667], "y": [0.667]}, "o": {"x": [0.333], "y": [0.333]}}


def fixed(value: Any) -> dict[str, Any]:
    return {"a": 0, "k": value}


def moving(*keys: tuple[float, Any]) -> dict[str, Any]:
    return {"a": 1, "k": [{"t": t, "s": value, **STEADY} for t, value in keys]}


def transform(**parts: Any) -> dict[str, Any]:
    whole = {"a": fixed([0, 0]), "p": fixed([0, 0]), "s": fixed([100, 100]), "r": fixed(0), "o": fixed(100)}
    return {**whole, **parts}


def pen(**parts: Any) -> dict[str, Any]:
    return {"ty": "st", "c": fixed([0, 0, 0, 1]), "o": fixed(100), "w": fixed(2), "lc": 2, "lj": 2, **parts}


def animation(*items: dict[str, Any], **layer: Any) -> dict[str, Any]:
    one = {"ty": 4, "ind": 1, "ip": 0, "op": 20, "ks": transform(), "shapes": list(items), **layer}
    return {"ip": 0, "op": 20, "w": 32, "h": 32, "layers": [one]}


def test_a_layer_is_scaled_then_turned_then_moved() -> None:
    ks = transform(p=moving((0, [5, 5]), (10, [25, 5])), s=fixed([200, 200]), r=fixed(90), a=fixed([10, 0]))
    [stroke] = strokes_at(animation(LINE, pen(), ks=ks), 5.0)
    np.testing.assert_allclose(stroke.points[[0, -1]], [[15, -15], [15, 5]], atol=1e-6)
    assert stroke.width == pytest.approx(4.0)
    assert (stroke.cap, stroke.join) == ("round", "round")


def test_a_trim_keeps_a_part_of_the_length() -> None:
    trim = {"ty": "tm", "s": fixed(20), "e": moving((0, [20]), (10, [100])), "o": fixed(0)}
    [stroke] = strokes_at(animation(LINE, trim, pen()), 5.0)
    np.testing.assert_allclose(stroke.points[[0, -1]], [[2, 0], [6, 0]], atol=1e-6)
    assert strokes_at(animation(LINE, trim, pen()), 0.0) == []


def test_a_trim_over_the_beginning_of_a_ring_is_one_stroke() -> None:
    ring = {"ty": "el", "p": fixed([0, 0]), "s": fixed([20, 20])}
    trim = {"ty": "tm", "s": fixed(0), "e": fixed(50), "o": fixed(-90)}
    [stroke] = strokes_at(animation(ring, trim, pen()), 0.0)
    np.testing.assert_allclose(stroke.points[[0, -1]], [[-10, 0], [10, 0]], atol=0.02)
    assert np.linalg.norm(stroke.points[::3], axis=1) == pytest.approx(10.0, abs=0.02)


def test_a_pen_draws_only_the_paths_of_its_group() -> None:
    group = {"ty": "gr", "it": [LINE, pen(w=fixed(3)), {"ty": "tr", **transform(p=fixed([0, 7]))}]}
    inner, outer = strokes_at(animation(group, LINE, pen()), 0.0)[::-1]
    assert (inner.width, outer.width) == (3.0, 2.0)
    assert inner.points[0].tolist() == [0.0, 7.0]
    assert inner.name != outer.name


@pytest.mark.parametrize(
    "item",
    [{"ty": "fl"}, {"ty": "tm", "m": 2, "s": fixed(0), "e": fixed(50), "o": fixed(0)}, pen(o=fixed(40)), pen(d=[1])],
)
def test_what_cannot_be_read_whole_is_not_read(item: dict[str, Any]) -> None:
    with pytest.raises(UnreadableError):
        strokes_at(animation(LINE, item, pen()), 1.0)
