"""Reduced keyframes stay within their tolerance, and none of them is wasted."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from videovec.write.keyframes import Animated, reduce_keyframes

Floats = np.typing.NDArray[np.float64]


@settings(max_examples=60, deadline=None)
@given(
    seed=st.integers(0, 10_000),
    count=st.integers(1, 40),
    tolerance=st.floats(0.01, 2),
    held=st.sampled_from([0.0, 0.3, 1.0]),
)
def test_every_sample_is_met_within_the_tolerance(seed: int, count: int, tolerance: float, held: float) -> None:
    rng = np.random.default_rng(seed)
    times = np.cumsum(rng.integers(1, 4, count)).astype(float)
    values = np.cumsum(rng.normal(0, 0.5, (count, 3, 2)), axis=0)
    is_held = rng.random(count) < held
    animated = reduce_keyframes(times, values, tolerance, is_held)
    for k, time in enumerate(times):
        assert np.abs(animated.at(time) - values[k]).max() <= tolerance + 1e-9
        if is_held[k] and k + 1 < count:  # and a held sample stays until the next
            assert np.abs(animated.at(times[k + 1] - 1e-6) - values[k]).max() <= tolerance + 1e-6
    assert animated.times[0] == times[0]


def test_a_straight_even_motion_needs_two_keyframes_and_a_rest_one() -> None:
    times = np.arange(20.0)
    line = times[:, None] * [1.0, -2.0]
    none = np.zeros(20, bool)
    assert len(reduce_keyframes(times, line, 0.01, none).times) == 2
    assert len(reduce_keyframes(times, np.zeros((20, 2)), 0.01, none).times) == 1
    assert len(reduce_keyframes(times, line, 0.01, ~none).times) == 20


def test_the_fewest_keyframes_are_found() -> None:
    """Against every choice of samples, tried one by one."""
    rng = np.random.default_rng(3)
    times = np.arange(9.0)
    for _ in range(20):
        values = np.cumsum(rng.normal(0, 0.4, (9, 1)), axis=0)
        found = len(reduce_keyframes(times, values, 0.5, np.zeros(9, bool)).times)
        assert found == min(
            bits.bit_count() + 1
            for bits in range(256)
            if _is_good(times, values, [0, *(k + 1 for k in range(8) if bits >> k & 1)], 0.5)
        )


def _is_good(
    times: np.typing.NDArray[np.float64], values: np.typing.NDArray[np.float64], keys: list[int], e: float
) -> bool:
    return bool((np.abs(np.interp(times, times[keys], values[keys, 0]) - values[:, 0]) <= e).all())


def test_each_number_may_have_its_own_tolerance() -> None:
    times = np.arange(5.0)
    values = np.stack([np.array([0, 1, 0, 1, 0.0]), np.zeros(5)], axis=1)
    free = np.zeros(5, bool)
    assert len(reduce_keyframes(times, values, [1.0, 0.0], free).times) == 1
    assert len(reduce_keyframes(times, values, [0.1, 0.1], free).times) == 5


def test_a_long_rest_is_one_keyframe_however_far_one_may_reach() -> None:
    times = np.arange(1000.0)
    animated = reduce_keyframes(times, np.zeros((1000, 1)), 0.1, np.zeros(1000, bool))
    assert len(animated.times) <= 9
    assert animated.at(999.0) == pytest.approx(0)


def test_before_the_first_and_after_the_last_keyframe_nothing_moves() -> None:
    animated = Animated(np.array([2.0, 4.0]), np.array([1.0, 3.0]), np.array([False, False]))
    assert [float(animated.at(time)) for time in (0, 2, 3, 4, 9)] == [1, 1, 2, 3, 3]
