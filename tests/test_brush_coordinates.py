"""Stroke coordinates of pixels against distances that are known in closed form."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from videovec.brush.coordinates import find_coordinates, sample_rows
from videovec.strokes import Strokes

KAPPA = 4 / 3 * (np.sqrt(2) - 1)


def line(x0: float, x1: float, y: float) -> NDArray[np.float64]:
    return np.stack([np.linspace(x0, x1, 4), np.full(4, y)], axis=1)


def circle(centre: float, radius: float) -> NDArray[np.float64]:
    quarter = np.array([[1, 0], [1, KAPPA], [KAPPA, 1], [0, 1]])
    turn = np.array([[0, 1], [-1, 0]])
    points = [quarter[:1]]
    for _ in range(4):
        points.append(quarter[1:])
        quarter = quarter @ turn
    return centre + radius * np.concatenate(points)


def centres(pixel: NDArray[np.intp], width: int) -> NDArray[np.float64]:
    return np.stack([pixel % width + 0.5, pixel // width + 0.5], axis=1)


def test_a_line_gives_arc_and_signed_distance() -> None:
    strokes = Strokes.from_curves([line(10, 50, 20.3)], [np.array([3.0, 3.0])])
    found = find_coordinates(strokes, (1, 40, 64), 1.3)
    where = centres(found.pixel, 64)
    inside = (where[:, 0] > 10) & (where[:, 0] < 50)
    assert inside.sum() > 200
    assert found.distance[inside] == pytest.approx(where[inside, 1] - 20.3, abs=1e-6)
    assert found.arc[inside] == pytest.approx(where[inside, 0] - 10, abs=1e-6)


def test_beyond_an_end_distance_is_to_the_end_point_and_arc_goes_on() -> None:
    strokes = Strokes.from_curves([line(10, 50, 20.0)], [np.array([6.0, 6.0])])
    found = find_coordinates(strokes, (1, 40, 64), 1.3)
    where = centres(found.pixel, 64)
    beyond = where[:, 0] > 51
    assert beyond.any()
    offset = where[beyond] - [50, 20]
    assert np.abs(found.distance[beyond]) == pytest.approx(np.hypot(*offset.T), abs=1e-6)
    assert found.arc[beyond] == pytest.approx(40 + offset[:, 0], abs=1e-6)


def test_a_closed_circle_has_one_pair_for_each_pixel_across_its_seam() -> None:
    strokes = Strokes.from_curves([circle(40, 20)], [np.full(5, 3.0)], is_closed=[True])
    found = find_coordinates(strokes, (1, 80, 80), 1.3)
    assert len(np.unique(found.pixel)) == len(found.pixel)
    radius = np.hypot(*(centres(found.pixel, 80) - 40).T)
    assert np.abs(found.distance) == pytest.approx(np.abs(radius - 20), abs=0.02)
    assert len(np.unique(np.sign(found.distance * (radius - 20)))) == 1


def test_a_stroke_that_crosses_itself_passes_a_pixel_twice() -> None:
    loop = np.array([[10.0, 60], [110, -20], [-30, -20], [70, 60]])
    strokes = Strokes.from_curves([loop], [np.array([2.0, 2.0])])
    found = find_coordinates(strokes, (1, 80, 80), 1.3)
    _, counts = np.unique(found.pixel, return_counts=True)
    assert set(counts) == {1, 2}
    assert 4 < (counts == 2).sum() < 150


def test_pages_do_not_share_pixels() -> None:
    one = Strokes.from_curves([line(10, 50, 20.0)], [np.array([3.0, 3.0])])
    other = Strokes.from_curves([line(10, 50, 20.0)], [np.array([3.0, 3.0])], drawing=1, first_id=2)
    found = find_coordinates(Strokes.concatenate([one, other]), (2, 40, 64), 1.3)
    first, second = found.pixel[found.pixel < 40 * 64], found.pixel[found.pixel >= 40 * 64]
    assert np.array_equal(np.sort(first), np.sort(second - 40 * 64))


def test_a_hidden_part_has_no_pixels_and_keeps_its_arc() -> None:
    strokes = Strokes.from_curves([line(10, 50, 20.0)], [np.array([3.0, 3.0])])
    half = Strokes(
        strokes.ids, strokes.layout, strokes.is_closed, strokes.layer, strokes.color, strokes.points,
        strokes.half_width, strokes.opacity, np.array([[0.5, 1.0]]),
    )  # fmt: skip
    found = find_coordinates(half, (1, 40, 64), 1.0, 0.5)
    assert centres(found.pixel, 64)[:, 0].min() > 30 - 4
    assert found.arc.min() > 20 - 4


def test_samples_measure_the_length_of_a_circle() -> None:
    strokes = Strokes.from_curves([circle(40, 20)], [np.full(5, 3.0)], is_closed=[True])
    assert sample_rows(strokes).lengths == pytest.approx([2 * np.pi * 20], rel=1e-3)
