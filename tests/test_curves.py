from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray
from scipy.integrate import quad
from scipy.interpolate import BPoly

from videovec import curves
from videovec.errors import FitError

Floats = NDArray[np.float64]


def spline(seed: int, segments: int) -> Floats:
    return np.random.default_rng(seed).uniform(0.0, 100.0, (3 * segments + 1, 2))


def scipy_curve(control: Floats) -> BPoly:
    return BPoly(control[:, None, :], [0.0, 1.0])


@pytest.mark.parametrize("seed", range(3))
def test_points_and_derivatives_agree_with_scipy(seed: int) -> None:
    control = spline(seed, 1)
    t = np.linspace(0.0, 1.0, 11)
    truth = scipy_curve(control)
    np.testing.assert_allclose(curves.evaluate(control, t), truth(t), atol=1e-10)
    np.testing.assert_allclose(curves.derivative(control, t), truth.derivative()(t), atol=1e-9)


def test_segments_are_evaluated_in_a_batch() -> None:
    control = curves.segments_of(spline(1, 3))
    points = curves.evaluate(control[:, None], np.linspace(0.0, 1.0, 5)[None])
    assert points.shape == (3, 5, 2)
    np.testing.assert_allclose(points[1, 4], points[2, 0])


@given(st.integers(0, 1000), st.floats(0.0, 1.0))
def test_split_halves_trace_the_same_curve(seed: int, cut: float) -> None:
    control = spline(seed, 1)
    before, after = curves.split(control, cut)
    t = np.linspace(0.0, 1.0, 7)
    np.testing.assert_allclose(curves.evaluate(before, t), curves.evaluate(control, cut * t), atol=1e-9)
    np.testing.assert_allclose(curves.evaluate(after, t), curves.evaluate(control, cut + (1 - cut) * t), atol=1e-9)


def test_arc_length_agrees_with_adaptive_quadrature() -> None:
    points = spline(5, 3)
    expected = 0.0
    for control in curves.segments_of(points):
        slope = scipy_curve(control).derivative()
        expected += quad(lambda t, slope=slope: float(np.hypot(*slope(t))), 0.0, 1.0, limit=500)[0]
    assert curves.arc_length(points) == pytest.approx(expected, rel=1e-4)


def test_a_straight_spline_is_as_long_as_the_distance_between_its_ends() -> None:
    points = np.linspace([10.0, 20.0], [40.0, 60.0], 7)
    assert curves.arc_length(points) == pytest.approx(50.0)
    np.testing.assert_allclose(curves.segment_lengths(points), [25.0, 25.0])


@pytest.mark.parametrize("seed", range(4))
def test_samples_by_arc_are_equally_far_apart_along_the_curve(seed: int) -> None:
    points = spline(seed, 2)
    dense = curves.evaluate(curves.segments_of(points)[:, None], np.linspace(0.0, 1.0, 20001)[None]).reshape(-1, 2)
    along = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(dense, axis=0), axis=1))])
    expected = np.linspace(0.0, along[-1], 50)
    truth = np.stack([np.interp(expected, along, dense[:, i]) for i in range(2)], axis=1)
    np.testing.assert_allclose(curves.sample_by_arc(points, 50), truth, atol=0.1)


@given(st.integers(0, 300), st.floats(0.0, 1.0), st.floats(0.0, 1.0))
def test_a_sub_curve_keeps_the_ends_the_length_and_the_width_of_its_part(seed: int, a: float, b: float) -> None:
    u0, u1 = min(a, b), max(a, b)
    points, widths = spline(seed, 3), np.array([1.0, 2.0, 4.0, 3.0])
    part, part_widths = curves.sub_curve(points, widths, u0, u1)
    segment, t = curves.parameter_at(points, [u0, u1])
    ends = curves.evaluate(curves.segments_of(points)[segment], t)
    np.testing.assert_allclose(part[[0, -1]], ends, atol=1e-6)
    np.testing.assert_allclose(part_widths[[0, -1]], curves.width_at(widths, segment, t), atol=1e-6)
    assert len(part) == 3 * (len(part_widths) - 1) + 1
    assert curves.arc_length(part) == pytest.approx((u1 - u0) * curves.arc_length(points), abs=0.05, rel=1e-3)


def test_reversing_twice_changes_nothing() -> None:
    points, widths = spline(2, 2), np.array([1.0, 2.0, 3.0])
    again = curves.reverse(*curves.reverse(points, widths))
    np.testing.assert_array_equal(again[0], points)
    np.testing.assert_array_equal(again[1], widths)


def test_a_dot_has_no_length_and_is_sampled_where_it_is() -> None:
    dot = np.tile([[3.0, 4.0]], (4, 1))
    assert curves.arc_length(dot) == 0.0
    np.testing.assert_allclose(curves.sample_by_arc(dot, 5), np.tile([[3.0, 4.0]], (5, 1)))


@pytest.mark.parametrize("count", [1, 3, 6])
def test_a_wrong_number_of_control_points_is_an_error(count: int) -> None:
    with pytest.raises(FitError, match="3n\\+1"):
        curves.segments_of(np.zeros((count, 2)))


def test_a_ruler_measures_up_to_places_and_finds_them_again() -> None:
    points = np.array([[0, 0], [10, 30], [40, -20], [60, 10], [70, 25], [90, 40], [100, 0]], float)
    segments = curves.segments_of(points)
    ruler = curves.Ruler.of(segments)
    for place in (0.0, 0.3, 0.9999, 1.0, 1.01, 1.7, 2.0):
        k = min(int(place), 1)
        samples = curves.evaluate(segments[k], np.linspace(0.0, place - k, 20001))
        before = curves.arc_length(points[:4]) if k else 0.0
        expected = before + np.linalg.norm(np.diff(samples, axis=0), axis=1).sum()
        assert ruler.arc_at(np.array([place]))[0] == pytest.approx(expected, abs=1e-5)
        segment, t = ruler.place_at(np.array([expected]))
        assert segment[0] + t[0] == pytest.approx(place, abs=1e-6)


def test_a_ruler_measures_splines_that_do_not_touch_as_if_each_were_alone() -> None:
    one = np.array([[0, 0], [10, 30], [40, -20], [60, 10]], float)
    two = np.array([[500, 0], [510, 10], [520, 0], [530, 5]], float)
    ruler = curves.Ruler.of(np.stack([one, two]))
    np.testing.assert_allclose(np.diff(ruler.ends), [curves.arc_length(one), curves.arc_length(two)])
    segment, t = ruler.place_at(ruler.ends[1] + np.array([0.25, 0.5]) * curves.arc_length(two))
    assert segment.tolist() == [1, 1]
    np.testing.assert_allclose(t, curves.parameter_at(two, [0.25, 0.5])[1], atol=1e-9)
