"""Following points: TAP-Vid's figures point by point as its paper states them, and answers known in closed form."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from videovec.point_metrics import THRESHOLDS, FollowedPoints, follow_points, score_points
from videovec.strokes import Layout, Strokes
from videovec.true_strokes import TrueStroke

D = 7
LINE = np.linspace([10.0, 20.0], [70.0, 20.0], 4)


def random_points(seed: int) -> FollowedPoints:
    rng = np.random.default_rng(seed)
    truth = rng.uniform(0, 100, (30, D, 2))
    found = truth + rng.normal(0, 1, truth.shape) * rng.choice([0.3, 3, 30], (30, D, 1))
    found[rng.random((30, D)) < 0.1] = np.nan
    is_found = (rng.random((30, D)) < 0.7) & np.isfinite(found[..., 0])
    return FollowedPoints(
        query=rng.integers(0, D, 30),
        truth=truth,
        is_seen=rng.random((30, D)) < 0.8,
        is_known=np.ones((30, D), bool),
        found=found,
        is_found=is_found,
    )


def tapvid_by_hand(points: FollowedPoints) -> tuple[list[float], list[float], float]:
    """Position accuracy and Jaccard at each threshold, and occlusion accuracy, counted one point after the other."""
    right_occlusion = asked = 0
    shares, jaccards = [], []
    for limit in THRESHOLDS:
        visible = near = hits = alarms = misses = 0
        for q, start in enumerate(points.query):
            for d in range(start + 1, D):
                offset = points.found[q, d] - points.truth[q, d]
                is_near = bool(offset[0] ** 2 + offset[1] ** 2 < limit**2)
                seen, said = bool(points.is_seen[q, d]), bool(points.is_found[q, d])
                visible += seen
                near += seen and is_near
                hits += seen and said and is_near
                alarms += said and not (seen and is_near)
                misses += seen and not (said and is_near)
                if limit == THRESHOLDS[0]:
                    asked += 1
                    right_occlusion += seen == said
        shares.append(near / visible)
        jaccards.append(hits / (hits + alarms + misses))
    return shares, jaccards, right_occlusion / asked


@pytest.mark.parametrize("seed", range(3))
def test_figures_are_those_of_tap_vid(seed: int) -> None:
    points = random_points(seed)
    shares, jaccards, occlusion = tapvid_by_hand(points)
    score = score_points(points)
    assert score.position == pytest.approx(shares)
    assert score.jaccard == pytest.approx(np.mean(jaccards))
    assert score.occlusion == pytest.approx(occlusion)


def test_what_the_truth_does_not_know_is_not_asked() -> None:
    points = random_points(0)
    unknown = replace(points, is_known=np.zeros_like(points.is_known))
    assert np.isnan(score_points(unknown).occlusion)
    assert np.isnan(score_points(unknown).error)


def test_an_error_that_grows_evenly_is_no_jitter_and_one_that_alternates_is() -> None:
    points = replace(random_points(0), query=np.zeros(30, np.intp), is_seen=np.ones((30, D), bool))
    drift = replace(points, found=points.truth + np.arange(D)[:, None] * [0.3, 0.4])
    assert score_points(drift).jitter == pytest.approx(0, abs=1e-9)
    assert score_points(drift).error_over_time[1:] == pytest.approx([0.5 * d for d in range(1, D)])
    shaken = replace(points, found=points.truth + (np.arange(D) % 2)[:, None] * [0.3, 0.4])
    assert score_points(shaken).jitter == pytest.approx(1.0)  # 0 .5 0: second difference of twice the step


def moved(by: np.ndarray) -> Strokes:
    """A line on D drawings, moved along itself by a number of px on each."""
    points = np.concatenate([LINE + np.array([offset, 0.0]) for offset in by])
    one = np.ones(1, np.intp)
    return Strokes(
        ids=one,
        layout=Layout(one, 0 * one, (D - 1) * one),
        is_closed=np.zeros(1, bool),
        layer=0 * one,
        color=np.zeros((1, 3)),
        points=points,
        half_width=np.ones(2 * D),
        opacity=np.ones(D),
        visible=np.tile([0.0, 1.0], (D, 1)),
    )


def test_a_line_that_slides_along_itself_is_off_by_the_slide() -> None:
    slide = 0.5 * np.arange(D)
    score = score_points(follow_points([[TrueStroke(1, LINE)]] * D, moved(slide)))
    assert score.error == pytest.approx(slide[1:].mean(), abs=0.02)
    assert score.error_over_time[1:] == pytest.approx(slide[1:], abs=0.02)
    assert np.isnan(score.error_over_time[0])
    assert score.occlusion == 1.0


def test_points_are_seen_where_the_truth_says_and_where_there_is_ink() -> None:
    truth = [[TrueStroke(1, LINE)]] * 3 + [[TrueStroke(1, LINE, ((0.0, 0.4),))]] * (D - 3)
    points = follow_points(truth, moved(np.zeros(D)))
    assert points.is_seen.sum(axis=0).tolist() == [5, 5, 5, 2, 2, 2, 2]
    ink = np.zeros((D, 40, 80), np.uint8)
    ink[:, 18:22, :30] = 255  # as far as x = 30: points at 16 and 28 of 16, 28, 40, 52, 64
    assert follow_points(truth, moved(np.zeros(D)), ink).is_seen.sum(axis=0).tolist() == [2] * D


def test_a_point_of_a_stroke_with_other_segments_is_not_known() -> None:
    longer = np.linspace([10.0, 20.0], [70.0, 20.0], 7)
    points = follow_points([[TrueStroke(1, LINE)]] * 3 + [[TrueStroke(1, longer)]] * (D - 3), moved(np.zeros(D)))
    assert points.is_known.sum(axis=0).tolist() == [5, 5, 5, 0, 0, 0, 0]


def test_points_of_linked_strokes_keep_their_arc_fraction() -> None:
    """The same line, with another parametrisation on every other drawing."""
    line = moved(np.zeros(D))
    points = line.points.copy().reshape(D, 4, 2)
    points[1::2, 1:3] = LINE[0] + np.array([[2.0, 0.0], [6.0, 0.0]])
    uneven = replace(line, points=points.reshape(-1, 2))
    truth = [[TrueStroke(1, LINE)]] * D
    assert score_points(follow_points(truth, uneven, by_arc=True)).error < 0.05
    assert score_points(follow_points(truth, uneven)).error > 3.0
