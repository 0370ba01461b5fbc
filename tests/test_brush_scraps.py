"""Scraps told from lines by where their middles lie: made-up strokes of known widths."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from videovec.brush import drop_scraps
from videovec.strokes import Strokes

Floats = NDArray[np.float64]
FAT = np.array([[20.0, 60.0], [60.0, 60.0], [100.0, 60.0], [140.0, 60.0]])  # 10 px wide


def beside(distance: float, begin: float = 50.0, end: float = 110.0) -> Floats:
    """A level line below the middle of the fat one, px."""
    return np.stack([np.linspace(begin, end, 4), np.full(4, 60.0 + distance)], axis=1)


def kept(*thin: tuple[Floats, float]) -> list[int]:
    """Which strokes stay beside a fat one, 0; the others have these half-widths."""
    curves, halves = [FAT, *(curve for curve, _ in thin)], [5.0, *(half for _, half in thin)]
    strokes = Strokes.from_curves(curves, [np.full(2, half) for half in halves])
    return [int(one) for one in drop_scraps(strokes).ids - strokes.ids[0]]


@pytest.mark.parametrize("distance", [-6.0, 0.0, 3.0, 6.0])
def test_what_runs_along_an_edge_or_under_it_is_a_scrap_however_long(distance: float) -> None:
    assert kept((beside(distance), 1.0)) == [0]


@pytest.mark.parametrize("half_width", [2.0, 3.0, 5.0])
def test_lines_that_touch_along_their_whole_length_stay(half_width: float) -> None:
    assert kept((beside(5.0 + half_width), half_width)) == [0, 1]


def test_lines_that_overlap_by_a_quarter_of_their_width_stay() -> None:
    assert kept((beside(7.6), 5.0)) == [0, 1]


def test_a_line_that_leaves_the_fat_one_or_crosses_it_stays() -> None:
    leaving = np.array([[60.0, 60.0], [70.0, 66.0], [80.0, 75.0], [90.0, 85.0]])
    crossing = np.array([[80.0, 45.0], [80.0, 55.0], [80.0, 65.0], [80.0, 75.0]])
    assert kept((leaving, 1.0)) == [0, 1]
    assert kept((crossing, 1.0)) == [0, 1]


def test_of_two_strokes_on_one_line_the_longer_one_stays() -> None:
    long, short = (np.stack([np.linspace(50, end, 4), np.full(4, 90.0)], axis=1) for end in (120.0, 90.0))
    assert kept((short, 2.0), (long, 2.0)) == [0, 2]


def test_two_dots_apart_and_nothing_stay() -> None:
    dots = Strokes.from_curves([beside(30.0, 40.0, 40.1), beside(30.0, 70.0, 70.1)], [np.full(2, 1.0)] * 2)
    assert len(drop_scraps(dots)) == 2
    assert len(drop_scraps(Strokes.empty())) == 0
