"""The parts of initialisation against independent implementations and closed forms."""

from __future__ import annotations

import cv2
import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from videovec.curves import evaluate, sample_by_arc, segments_of
from videovec.initialise.cubics import fit_spline
from videovec.initialise.graph import skeleton_graph
from videovec.initialise.polyline import corners, end_tangent, resample, smooth
from videovec.initialise.thinning import thin

Floats = NDArray[np.float64]
NONE = np.zeros(0, np.intp)


@pytest.mark.parametrize("seed", range(4))
def test_thinning_agrees_with_opencv(seed: int) -> None:
    noise = np.random.default_rng(seed).normal(size=(90, 120)).astype(np.float32)
    mask = (cv2.GaussianBlur(noise, (0, 0), 3.0) > 0.05).astype(np.uint8) * np.uint8(255)
    padded = np.pad(mask, 2)
    expected = cv2.ximgproc.thinning(padded, thinningType=cv2.ximgproc.THINNING_GUOHALL)[2:-2, 2:-2] > 0
    np.testing.assert_array_equal(thin(mask) > 0, expected)


def graph_of(rows: list[str]) -> tuple[int, list[int], int, int]:
    """Branches, sorted node degrees, loops and dots of a skeleton drawn with letters."""
    skeleton = np.array([[letter == "#" for letter in row] for row in rows], np.uint8)
    graph = skeleton_graph(skeleton, np.ones(skeleton.shape, np.float32), 1)
    return len(graph.branches), sorted(graph.degree(n) for n in graph.nodes()), len(graph.loops), len(graph.dots)


def test_a_skeleton_is_read_as_the_graph_that_it_is() -> None:
    assert graph_of(["#####"]) == (1, [1, 1], 0, 0)
    assert graph_of(["..#..", "..#..", "#####", "..#..", "..#.."]) == (4, [1, 1, 1, 1, 4], 0, 0)
    assert graph_of([".##.", "#..#", "#..#", ".##."]) == (0, [], 1, 0)
    assert graph_of(["#..", "...", "..#"]) == (0, [], 0, 2)
    assert graph_of(["#...#", ".#.#.", "..#..", "..#.."]) == (3, [1, 1, 1, 3], 0, 0)


def test_a_graph_is_in_px_with_pixel_centres_at_a_half() -> None:
    skeleton = np.zeros((8, 40), np.uint8)
    skeleton[4, 4:36] = 1
    graph = skeleton_graph(skeleton, np.full(skeleton.shape, 8.0, np.float32), 4)
    line = graph.branches[0].line
    np.testing.assert_allclose(sorted(line[[0, -1], 0]), [4.5 / 4, 35.5 / 4])
    np.testing.assert_allclose(line[:, 1], 4.5 / 4)
    assert graph.branches[0].thickness == pytest.approx(2.0)


@pytest.mark.parametrize("radius", [8.0, 20.0])
def test_the_tangent_at_the_end_of_an_arc_is_extrapolated(radius: float) -> None:
    angle = np.linspace(0.0, 1.2, 200)
    line = radius * np.stack([np.sin(angle), 1.0 - np.cos(angle)], axis=1)
    disturbed = line.copy()
    disturbed[: int(0.1 * radius)] += (0.0, 0.3)
    tangent = end_tangent(disturbed, skip=0.15 * radius, reach=0.6 * radius)
    assert np.degrees(np.arctan2(tangent[1], tangent[0])) == pytest.approx(0.0, abs=2.0)


def test_corners_are_where_a_line_turns() -> None:
    line = np.concatenate([resample(np.array([(0.0, 0.0), (30.0, 0.0)]), 0.5), [(30.0, k / 2) for k in range(1, 60)]])
    assert corners(line, 6, 50.0, False).tolist() == [60]
    assert len(corners(line, 6, 100.0, False)) == 0


def test_smoothing_keeps_the_ends_and_removes_a_staircase() -> None:
    straight = np.linspace((0.0, 0.0), (99.0, 29.7), 100)
    stairs: Floats = np.rint(straight)
    smoothed = smooth(stairs, 3.0, False)
    np.testing.assert_allclose(smoothed[[0, -1]], stairs[[0, -1]])
    assert np.abs(smoothed - straight)[10:-10].max() < 0.25 < np.abs(stairs - straight).max()


@pytest.mark.parametrize("tolerance", [0.1, 0.35, 1.0])
def test_a_spline_is_within_its_tolerance_of_the_line(tolerance: float) -> None:
    x = np.linspace(0.0, 200.0, 500)
    line = np.stack([x, 100.0 + 30.0 * np.sin(x / 20.0)], axis=1)
    points = fit_spline(line, NONE, tolerance, False)
    np.testing.assert_allclose(points[[0, -1]], line[[0, -1]])
    dense = evaluate(segments_of(points)[:, None], np.linspace(0, 1, 9000)[None]).reshape(-1, 2)
    assert cKDTree(dense).query(line)[0].max() < 1.1 * tolerance


def test_one_cubic_is_found_again() -> None:
    truth = np.array([(10, 10), (60, 0), (90, 70), (40, 90)], float)
    points = fit_spline(sample_by_arc(truth, 200), NONE, 0.35, False)
    assert len(points) == 4
    assert cKDTree(sample_by_arc(truth, 2000)).query(sample_by_arc(points, 200))[0].max() < 0.3


def test_a_looser_tolerance_needs_fewer_cubics() -> None:
    angle = np.linspace(0.0, 6.0 * np.pi, 800)
    spiral = np.stack([(20 + 5 * angle) * np.cos(angle), (20 + 5 * angle) * np.sin(angle)], axis=1)
    counts = [len(fit_spline(spiral, NONE, tolerance, False)) for tolerance in (0.05, 0.35, 2.0)]
    assert counts == sorted(counts, reverse=True)
    assert counts[0] > counts[2]


def test_a_corner_is_a_joint() -> None:
    line = np.concatenate([np.linspace((0, 0), (40, 0), 81), np.linspace((40, 0.5), (40, 30), 60)])
    points = fit_spline(line, np.array([80]), 0.35, False)
    assert len(points) == 7
    np.testing.assert_allclose(points[3], (40.0, 0.0))


def test_a_closed_smooth_line_has_no_kink_at_its_seam() -> None:
    angle = np.linspace(0.0, 2.0 * np.pi, 300)
    ring = 30.0 * np.stack([np.cos(angle), np.sin(angle)], axis=1)
    ring[-1] = ring[0]
    points = fit_spline(ring, NONE, 0.2, True)
    leaving, arriving = points[1] - points[0], points[-1] - points[-2]
    cosine = leaving @ arriving / (np.linalg.norm(leaving) * np.linalg.norm(arriving))
    assert np.degrees(np.arccos(np.clip(cosine, -1, 1))) < 3.0
