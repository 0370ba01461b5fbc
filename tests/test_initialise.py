"""Tracing drawings whose strokes are known: rasters by supersampling, independent of videovec's renderer."""

from __future__ import annotations

import cv2
import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from videovec.curves import arc_length, evaluate, sample_by_arc, segments_of
from videovec.initialise import initialise, trace
from videovec.ink import Ink
from videovec.settings import InitialiseSettings
from videovec.strokes import Strokes

Floats = NDArray[np.float64]
SETTINGS = InitialiseSettings()
FINE = 8


def straight(start: tuple[float, float], stop: tuple[float, float]) -> Floats:
    return np.linspace(start, stop, 4)


def circle(x: float, y: float, radius: float) -> Floats:
    """Four cubics. [13, 2]"""
    k = 0.5522847498
    quarter = np.array([(1, 0), (1, k), (k, 1), (0, 1)], float)
    turn = np.array([[0.0, 1.0], [-1.0, 0.0]])
    parts = [quarter @ np.linalg.matrix_power(turn, i) for i in range(4)]
    points = np.concatenate([parts[0], *(part[1:] for part in parts[1:])])
    points[-1] = points[0]
    return np.asarray(radius * points + np.array([x, y]))


def paint(curves: list[Floats], width: float, size: tuple[int, int] = (128, 128)) -> NDArray[np.uint8]:
    """Coverage of round pens, from discs on a grid eight times as fine. uint8 [H, W]"""
    fine = np.zeros((size[0] * FINE, size[1] * FINE), np.uint8)
    row, column = np.mgrid[: fine.shape[0], : fine.shape[1]]
    for points in curves:
        samples = evaluate(segments_of(points)[:, None], np.linspace(0, 1, 800)[None]).reshape(-1, 2) * FINE
        low, high = (samples.min(0) - 8 * width - 8).astype(int), (samples.max(0) + 8 * width + 8).astype(int)
        window = np.s_[max(low[1], 0) : high[1], max(low[0], 0) : high[0]]
        centers = np.stack([column[window], row[window]], axis=-1) + 0.5
        fine[window] |= cKDTree(samples).query(centers)[0] <= 0.5 * width * FINE
    mean = fine.reshape(size[0], FINE, size[1], FINE).mean(axis=(1, 3))
    return np.asarray(np.rint(255 * mean), np.uint8)


def ink(coverage: NDArray[np.uint8], noise: float = 0.0) -> Ink:
    return Ink(coverage[None], np.zeros_like(coverage)[None], np.zeros((1, 3)), np.ones(3), noise)


def distance(one: Floats, two: Floats) -> float:
    """Mean distance of two splines, both ways. px"""
    a, b = sample_by_arc(one, 2000), sample_by_arc(two, 2000)
    return float(0.5 * cKDTree(b).query(a)[0].mean() + 0.5 * cKDTree(a).query(b)[0].mean())


def assert_same_strokes(strokes: Strokes, truth: list[Floats], tolerance: float) -> None:
    """Each true stroke is one stroke, and there is no other."""
    found = [strokes.points_of(row) for row in range(strokes.row_count)]
    assert len(found) == len(truth)
    for points in truth:
        best = min(found, key=lambda other, points=points: distance(points, other))  # type: ignore[misc]
        assert distance(points, best) < tolerance
        assert abs(arc_length(best) - arc_length(points)) < 1.0 + 0.03 * arc_length(points)


WAVE = np.array([(20, 60), (45, 10), (80, 110), (108, 64)], float)
GENTLE = np.array([(17, 66), (45, 40), (80, 85), (111, 60)], float)


def test_a_dot_of_one_ink_among_lines_of_another_is_a_dot() -> None:
    dot, line = paint([straight((40, 40), (40, 40))], 8.0), paint([straight((20, 90), (110, 90))], 4.0)
    label = (line > dot).astype(np.uint8)
    strokes = initialise(Ink((dot | line)[None], label[None], np.eye(3)[:2], np.ones(3), 0.0), 0, SETTINGS)
    assert len(strokes) == 2
    assert strokes.points_of(0).mean(0) == pytest.approx([40, 40], abs=0.1)


@pytest.mark.parametrize("width", [0.25, 0.6, 1.0, 1.5, 3.0, 6.0, 12.0, 24.0])
def test_a_line_of_any_width_is_one_stroke_of_that_width(width: float) -> None:
    strokes = initialise(ink(paint([GENTLE], width)), 0, SETTINGS)
    assert_same_strokes(strokes, [GENTLE], 0.2 + 0.03 * width)
    assert np.median(2.0 * strokes.half_width) == pytest.approx(width, rel=0.08, abs=0.03)


@pytest.mark.parametrize("width", [0.5, 2.0, 3.0, 8.0])
def test_strokes_run_through_a_crossing(width: float) -> None:
    truth = [straight((15, 20), (110, 105)), np.array([(15, 100), (50, 80), (80, 50), (112, 22)], float)]
    assert_same_strokes(initialise(ink(paint(truth, width)), 0, SETTINGS), truth, 0.3 + 0.05 * width)


def test_the_bar_of_a_t_goes_on_and_its_stem_ends_there() -> None:
    truth = [straight((12, 60), (116, 66)), straight((60, 63), (66, 115))]
    assert_same_strokes(initialise(ink(paint(truth, 3.0)), 0, SETTINGS), truth, 0.4)


@pytest.mark.parametrize("gap", [2.0, 3.0])
def test_close_parallel_lines_stay_apart(gap: float) -> None:
    truth = [straight((15.3, 50.2 + offset), (112.1, 61.4 + offset)) for offset in (0.0, 2.0 + gap)]
    assert_same_strokes(initialise(ink(paint(truth, 2.0)), 0, SETTINGS), truth, 0.3)


@pytest.mark.parametrize("radius", [6.0, 30.0])
def test_a_circle_is_one_closed_stroke(radius: float) -> None:
    truth = circle(64.3, 63.8, radius)
    strokes = initialise(ink(paint([truth], 3.0)), 0, SETTINGS)
    assert_same_strokes(strokes, [truth], 0.25)
    assert strokes.is_closed.tolist() == [True]
    np.testing.assert_array_equal(strokes.points[0], strokes.points[-1])


def test_a_dot_is_a_stroke_without_length() -> None:
    dot = np.tile([[40.4, 70.7]], (4, 1))
    strokes = initialise(ink(paint([dot, straight((60, 20), (100, 100))], 4.0)), 0, SETTINGS)
    assert len(strokes) == 2
    shortest = min(range(2), key=lambda row: arc_length(strokes.points_of(row)))
    np.testing.assert_allclose(strokes.points_of(shortest).mean(axis=0), dot[0], atol=0.6)
    assert arc_length(strokes.points_of(shortest)) < 2.0
    assert strokes.half_width_of(shortest).mean() == pytest.approx(2.0, rel=0.3)


def test_a_sharp_corner_stays_inside_its_stroke_and_sharp() -> None:
    corner = np.concatenate([straight((20, 20), (100, 60)), straight((100, 60), (25, 90))[1:]])
    strokes = initialise(ink(paint([corner], 3.0)), 0, SETTINGS)
    assert_same_strokes(strokes, [corner], 0.4)
    joints = strokes.points_of(0)[::3]
    assert np.linalg.norm(joints - np.array([100.0, 60.0]), axis=1).min() < 1.2


@pytest.mark.parametrize("opening", [25.0, 40.0, 60.0])
@pytest.mark.parametrize("width", [4.0, 10.0])
def test_a_sharp_corner_of_a_thick_line_alone_on_the_page_reaches_its_tip(opening: float, width: float) -> None:
    """Thinning makes a Y of it, of which all three branches lead nowhere."""
    tip, half = np.array([64.0, 22.0]), np.radians(opening) / 2
    ends = tip + 88 * np.array([[-np.sin(half), np.cos(half)], [np.sin(half), np.cos(half)]])
    corner = np.concatenate([np.linspace(ends[0], tip, 4), np.linspace(tip, ends[1], 4)[1:]])
    strokes = initialise(ink(paint([corner], width)), 0, SETTINGS)
    assert_same_strokes(strokes, [corner], 0.3 + 0.06 * width)
    joints = strokes.points_of(0)[::3]
    assert np.linalg.norm(joints - tip, axis=1).min() < 0.5 + 0.12 * width


def test_a_tapering_line_has_a_half_width_that_grows() -> None:
    row, column = np.mgrid[:1024, :1024] / 8.0
    half = np.clip(1.0 + (column - 15.0) / 98.0 * 5.0, 0.0, 6.0)
    fine = (np.abs(row - 64.0) <= half) & (column >= 15.0) & (column <= 113.0)
    coverage = np.rint(255 * fine.reshape(128, 8, 128, 8).mean(axis=(1, 3))).astype(np.uint8)
    strokes = initialise(ink(coverage), 0, SETTINGS)
    longest = max(range(len(strokes)), key=lambda row: arc_length(strokes.points_of(row)))
    points, half_width = strokes.points_of(longest), strokes.half_width_of(longest)
    thin, thick = np.argmin(points[::3, 0]), np.argmax(points[::3, 0])
    assert half_width[thin] < 2.2
    assert half_width[thick] > 4.2


def test_noise_adds_no_strokes() -> None:
    truth = [WAVE, straight((20, 100), (100, 115))]
    rng = np.random.default_rng(4)
    clean = paint(truth, 2.0).astype(float)
    noisy = np.clip(clean + rng.normal(0.0, 6.0, clean.shape), 0, 255).astype(np.uint8)
    assert_same_strokes(initialise(ink(noisy, noise=6.0 / 255.0), 0, SETTINGS), truth, 0.4)


def test_jpeg_adds_no_strokes() -> None:
    truth = [WAVE, straight((20, 100), (100, 115))]
    encoded = cv2.imencode(".jpg", 255 - paint(truth, 2.0), [cv2.IMWRITE_JPEG_QUALITY, 50])[1]
    decoded = np.asarray(cv2.imdecode(encoded, cv2.IMREAD_GRAYSCALE), np.uint8)
    coverage = np.where(decoded > 243, 0, 255 - decoded).astype(np.uint8)
    assert_same_strokes(initialise(ink(coverage, noise=0.012), 0, SETTINGS), truth, 0.4)


def test_colours_stay_apart_and_run_under_each_other() -> None:
    under, over = straight((15, 30), (113, 95)), straight((20, 100), (105, 25))
    below, above = paint([under], 3.0), paint([over], 4.0)
    coverage = np.maximum(below, above)
    both = Ink(
        coverage[None], (above > 127).astype(np.uint8)[None], np.array([[1.0, 0, 0], [0, 0, 1.0]]), np.ones(3), 0.0
    )
    strokes = initialise(both, 0, SETTINGS)
    assert len(strokes) == 2
    for color, truth in (((1.0, 0.0, 0.0), under), ((0.0, 0.0, 1.0), over)):
        row = int(np.flatnonzero(np.all(strokes.color == color, axis=1))[0])
        assert distance(strokes.points_of(row), truth) < 0.5


def test_an_empty_page_has_no_strokes() -> None:
    traced = trace(ink(np.zeros((40, 50), np.uint8)), 0, SETTINGS)
    assert len(traced.strokes) == 0
    assert traced.junctions == ()


def test_strokes_belong_to_the_drawing_that_was_asked_for() -> None:
    pages = np.stack([paint([WAVE], 3.0), paint([circle(60, 60, 20)], 3.0)])
    both = Ink(pages, np.zeros_like(pages), np.zeros((1, 3)), np.ones(3), 0.0)
    strokes = initialise(both, 1, SETTINGS)
    assert strokes.layout.first.tolist() == strokes.layout.last.tolist() == [1]
    assert strokes.is_closed.all()


@pytest.mark.parametrize("junctions", ["learned", "geometry"])
def test_a_clear_junction_is_surer_than_one_of_three_equal_arms(junctions: str) -> None:
    settings = InitialiseSettings(junctions=junctions)
    bar = straight((12, 64), (116, 64))
    clear = trace(ink(paint([bar, straight((64, 64), (64, 115))], 3.0)), 0, settings).junctions
    star = [straight((64, 64), (64, 114)), straight((64, 64), (20.7, 39)), straight((64, 64), (107.3, 39))]
    doubtful = trace(ink(paint(star, 3.0)), 0, settings).junctions
    assert len(clear) == len(doubtful) == 1
    np.testing.assert_allclose(clear[0].position, (64.0, 64.0), atol=1.5)
    assert clear[0].log_odds > 2.0 > 0.6 > doubtful[0].log_odds


def test_geometry_doubts_a_fork() -> None:
    fork = [straight((64, 64), (64, 12)), straight((64, 64), (34, 112)), straight((64, 64), (94, 112))]
    (doubtful,) = trace(ink(paint(fork, 3.0)), 0, InitialiseSettings(junctions="geometry")).junctions
    assert doubtful.log_odds < 0.6


def test_every_curve_lies_within_the_tolerance_of_its_ink() -> None:
    coverage = paint([WAVE, circle(64, 64, 30)], 3.0)
    strokes = initialise(ink(coverage), 0, SETTINGS)
    for row in range(strokes.row_count):
        x, y = np.floor(sample_by_arc(strokes.points_of(row), 300)).astype(int).T
        assert coverage[y, x].min() > 100
