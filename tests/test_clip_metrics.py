from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from videovec.clip_metrics import TrueStroke, score_clip
from videovec.strokes import Layout, Strokes

D = 6


def curve(number: int, drawing: int) -> np.ndarray:
    start = np.array([10.0 + 2.0 * drawing, 20.0 * number + 10 + 0.5 * drawing**2])
    return start + np.linspace(0, 1, 4)[:, None] * (60.0, 8.0)


def truth(count: int = 3) -> list[list[TrueStroke]]:
    return [[TrueStroke(k, curve(k, t)) for k in range(count)] for t in range(D)]


def strokes(count: int = 3, lives: list[tuple[int, int]] | None = None) -> Strokes:
    spans = lives or [(0, D - 1)] * count
    first, last = (np.array(ends) for ends in zip(*spans, strict=True))
    rows = [(k, t) for k, (a, b) in enumerate(spans) for t in range(a, b + 1)]
    return Strokes(
        ids=np.arange(1, len(spans) + 1),
        layout=Layout(np.ones(len(spans), np.intp), first, last),
        is_closed=np.zeros(len(spans), bool),
        layer=np.arange(len(spans)),
        color=np.zeros((len(spans), 3)),
        points=np.concatenate([curve(k % count, t) for k, t in rows]),
        half_width=np.ones(2 * len(rows)),
        opacity=np.ones(len(rows)),
        visible=np.tile([0.0, 1.0], (len(rows), 1)),
    )


def test_the_truth_itself_is_perfect() -> None:
    score = score_clip(truth(), strokes())
    assert (score.idf1, score.persistence, score.full_life, score.occlusion) == pytest.approx((1, 1, 1, 1))
    assert score.error == pytest.approx(0, abs=0.01)
    assert score.jitter == pytest.approx(0, abs=0.01)
    assert score.flicker == 0
    assert score.position == (1.0,) * 5
    assert np.isnan(score.births)


def test_strokes_that_are_elsewhere_score_nothing() -> None:
    far = strokes()
    score = score_clip(truth(), replace(far, points=far.points + 500.0))
    assert score.idf1 == 0
    assert score.persistence == 0
    assert score.position == (0.0,) * 5


def test_a_shift_is_the_error_and_no_jitter() -> None:
    moved = strokes()
    points = moved.points.copy()
    points[moved.layout.row_drawing[moved.layout.point_row] > 0] += (0.0, 1.5)
    score = score_clip(truth(), replace(moved, points=points))
    assert score.error == pytest.approx(1.5, abs=0.02)
    assert score.position[:2] == (0.0, 1.0)
    assert score.jitter < 0.5  # one kink, where the shift begins


def test_an_identity_that_changes_halfway_counts_half() -> None:
    broken = strokes(3, [(0, 5), (0, 5), (0, 2), (0, 0), (0, 0), (3, 5)])
    hidden = broken.visible.copy()
    for row in (broken.layout.stroke_rows[3], broken.layout.stroke_rows[4]):
        hidden[row] = 0.0
    score = score_clip(truth(), replace(broken, visible=hidden))
    assert score.full_life == pytest.approx(2 / 3)
    assert score.persistence == pytest.approx((1 + 1 + 0.5) / 3)
    assert score.idf1 == pytest.approx((1 + 1 + 0.5) / 3, abs=0.01)


def test_a_stroke_is_worth_no_more_than_its_length() -> None:
    short = strokes()
    score = score_clip(truth(), replace(short, visible=np.tile([0.02, 0.98], (len(short.visible), 1))))
    assert score.persistence == 1  # its ends are within tolerance
    assert score.idf1 == pytest.approx(2 * 0.96 / (1 + 0.96), abs=0.01)


def test_one_outline_around_everything_cannot_game_identity() -> None:
    score = score_clip([[s for s in drawing if s.id == 0] for drawing in truth()], strokes())
    assert score.persistence == 1.0
    assert score.idf1 == pytest.approx(2 / (1 + 3), abs=0.01)


def test_births_and_deaths_are_found_within_one_drawing() -> None:
    true = [[s for s in drawing if s.id < 2 or 2 <= t < 4] for t, drawing in enumerate(truth())]
    late = score_clip(true, strokes(3, [(0, 5), (0, 5), (3, 4)]))
    assert (late.births, late.deaths) == (1.0, 1.0)
    never = score_clip(true, strokes(3, [(0, 5), (0, 5), (0, 5)]))
    assert (never.births, never.deaths) == (0.0, 0.0)


def test_occlusion_counts_drawings_on_which_visibility_is_right() -> None:
    hidden = [[replace(s, visible=()) if t in (2, 3) else s for s in drawing] for t, drawing in enumerate(truth(1))]
    assert score_clip(hidden, strokes(1)).occlusion == pytest.approx(3 / 5)


def test_flicker_is_the_change_of_count_that_the_truth_has_not() -> None:
    blinking = strokes(1)
    visible = blinking.visible.copy()
    visible[1::2] = 0.0
    assert score_clip(truth(1), replace(blinking, visible=visible)).flicker == 1.0


def test_true_strokes_without_ink_do_not_count() -> None:
    blank = np.zeros((D, 100, 200), np.uint8)
    assert np.isnan(score_clip(truth(), strokes(), blank).persistence)


def test_no_strokes_at_all_are_scored() -> None:
    score = score_clip(truth(), Strokes.empty())
    assert score.idf1 == 0
    assert score.occlusion == 0
