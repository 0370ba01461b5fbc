"""Eased keyframes show moving curves within their tolerance, judged by distances between curves and by a player."""

from __future__ import annotations

import json
from dataclasses import replace

import numpy as np
import pytest
from drawn import coverage, psnr
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.distance import cdist
from small_tracks import SIZE, WAVE, life, tracks_of
from test_lottie import played

from videovec.curves import evaluate, segments_of
from videovec.settings import ExportSettings
from videovec.write.easing import reduce_paths
from videovec.write.keyframes import EVEN, Animated, ease, reduce_keyframes
from videovec.write.lottie import lottie_text

Floats = np.typing.NDArray[np.float64]

CURVE = np.array([[0, 0], [20, 30], [40, 30], [60, 5], [80, -20], [90, -10], [120, 10.0]])
NONE = np.zeros(24, bool)
TIMES = np.arange(24.0)
SWING = 0.5 - 0.5 * np.cos(np.pi * TIMES / 23)  # starts slowly, ends slowly


def polyline(points: Floats) -> Floats:
    return np.asarray(evaluate(segments_of(points)[:, None], np.linspace(0, 1, 200)[None]).reshape(-1, 2))


def apart(one: Floats, two: Floats) -> float:
    """The largest distance of a point of either curve from the other, and of their ends from each other. px"""
    a, b = polyline(one), polyline(two)
    distance = cdist(a, b)
    ends = np.linalg.norm((one - two)[[0, -1]], axis=1)
    return float(max(distance.min(0).max(), distance.min(1).max(), ends.max()))


def eased_by_bisection(x: tuple[float, ...], y: tuple[float, ...], share: float) -> float:
    """Where the Bézier curve (0, 0), (x0, y0), (x1, y1), (1, 1) is at x = share: how players read an easing."""
    low, high = 0.0, 1.0
    for _ in range(50):
        t = (low + high) / 2
        at = 3 * (1 - t) ** 2 * t * x[0] + 3 * (1 - t) * t**2 * x[1] + t**3
        low, high = (t, high) if at < share else (low, t)
    return 3 * (1 - t) ** 2 * t * y[0] + 3 * (1 - t) * t**2 * y[1] + t**3


@settings(max_examples=40, deadline=None)
@given(
    seed=st.integers(0, 10_000),
    count=st.integers(1, 24),
    tolerance=st.floats(0.05, 1.0),
    held=st.sampled_from([0.0, 0.3, 1.0]),
    noise=st.sampled_from([0.0, 0.2]),
)
def test_every_sample_is_met_within_the_tolerance(
    seed: int, count: int, tolerance: float, held: float, noise: float
) -> None:
    rng = np.random.default_rng(seed)
    times = np.cumsum(rng.integers(1, 4, count)).astype(float)
    drift = np.cumsum(rng.normal(0, 1.0, (count, 1, 2)), axis=0)
    turn = np.cumsum(rng.normal(0, 0.02, count))[:, None, None] * (CURVE - CURVE.mean(0))[:, ::-1] * [-1, 1]
    path = CURVE + drift + turn + rng.normal(0, noise, (count, *CURVE.shape))
    is_held = rng.random(count) < held
    (animated,) = reduce_paths(times, [path], is_held, tolerance, is_open=True)
    for k, time in enumerate(times):
        assert apart(animated.at(time), path[k]) <= 1.25 * tolerance  # the distance is measured to second order
        if is_held[k] and k + 1 < count:  # and a held sample stays until the next
            np.testing.assert_array_equal(animated.at(times[k + 1] - 1e-6), animated.at(time))
    assert animated.times[0] == times[0]


def test_a_move_that_starts_and_ends_slowly_is_two_keyframes() -> None:
    path = CURVE + SWING[:, None, None] * [100.0, 40.0]
    (animated,) = reduce_paths(TIMES, [path], NONE, 0.25, is_open=True)
    assert len(animated.times) <= 3
    assert len(reduce_keyframes(TIMES, path, 0.25, NONE).times) > 6


def test_noise_within_the_tolerance_is_no_motion_and_sliding_along_a_line_is_hardly_any() -> None:
    rng = np.random.default_rng(0)
    (still,) = reduce_paths(TIMES, [CURVE + rng.uniform(-0.1, 0.1, (24, *CURVE.shape))], NONE, 0.25, is_open=True)
    assert still.is_static
    line = np.linspace([0.0, 0.0], [90.0, 0.0], 7)
    slide = rng.uniform(-0.8, 0.8, (24, 7, 1)) * [1.0, 0.0]
    slide[:, [0, -1]] = 0.0
    assert reduce_paths(TIMES, [line + slide], NONE, 0.25, is_open=True)[0].is_static
    assert len(reduce_paths(TIMES, [line + slide[..., ::-1]], NONE, 0.25, is_open=True)[0].times) > 10


def test_paths_that_move_together_share_their_keyframes() -> None:
    both = [CURVE + SWING[:, None, None] * [50.0, 0.0], -CURVE + np.sin(TIMES)[:, None, None] * [0.0, 3.0]]
    one, two = reduce_paths(TIMES, both, NONE, 0.25)
    np.testing.assert_array_equal(one.times, two.times)
    assert one.handles is two.handles
    assert len(one.times) > 6
    assert apart(two.at(5.0), both[1][5]) < 0.3


def test_an_easing_is_what_players_make_of_its_handles() -> None:
    for handles in ((0.4, 0.0, 0.6, 1.0), (0.1, 0.9, 0.9, 0.2), (0.9, 0.1, 0.1, 0.8), EVEN):
        for share in (0.0, 0.1, 0.35, 0.5, 0.8, 1.0):
            expected = eased_by_bisection(handles[::2], handles[1::2], share)
            assert float(ease(handles, np.asarray(share))) == pytest.approx(expected, abs=1e-6)


def test_before_and_after_an_eased_move_stands_its_keyframe() -> None:
    animated = Animated(
        np.array([2.0, 4.0]), np.array([1.0, 3.0]), np.array([False, False]), np.array([[1 / 3, 0, 2 / 3, 1], EVEN])
    )
    assert [float(animated.at(time)) for time in (0.0, 2.0, 3.0, 9.0)] == pytest.approx([1, 1, 2, 3])
    assert float(animated.at(2.5)) == pytest.approx(1 + 2 * (3 * 0.25**2 - 2 * 0.25**3))  # smoothstep


def test_lottie_shows_every_frame_within_its_tolerance_when_read_as_players_do() -> None:
    start = life(1, WAVE, [2.0] * 3)
    moved = np.stack([WAVE + share * np.array([18.0, -9.0]) for share in SWING])
    many = replace(
        start,
        points=moved,
        half_width=np.repeat(start.half_width[:1], 24, axis=0),
        opacity=np.ones(24),
        visible=np.tile([0.0, 1.0], (24, 1)),
    )
    tracks = tracks_of([many], exposures=(1,) * 24)
    document = lottie_text(tracks, ExportSettings())
    keys = json.loads(document)["layers"][0]["shapes"][0]["it"][0]["ks"]["k"]
    assert len(keys) <= 3
    for frame in range(24):
        at = max(k for k, key in enumerate(keys) if key["t"] <= frame)
        before, after = keys[at], keys[min(at + 1, len(keys) - 1)]
        share = 0.0
        if after is not before:
            time = (frame - before["t"]) / (after["t"] - before["t"])
            out, into = before["o"], before["i"]
            share = eased_by_bisection((out["x"], into["x"]), (out["y"], into["y"]), time)
        (v, i, o), (v1, i1, o1) = ([np.array(key["s"][0][part]) for part in "vio"] for key in (before, after))
        v, i, o = (a + share * (b - a) for a, b in ((v, v1), (i, i1), (o, o1)))
        spline = np.concatenate([v[:1], *([a + b, c + d, c] for a, b, c, d in zip(v, o, v[1:], i[1:], strict=False))])
        assert apart(spline, moved[frame]) <= 0.25
        assert psnr(played(document, frame)[..., 1], 1 - coverage(tracks.at_frame(frame), SIZE)) > 32
