"""Edits do their work and cost no more than they say."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from videovec.edits import edit, finish
from videovec.fit import draw_coverage, fit
from videovec.ink import Ink
from videovec.render import resolve_backend
from videovec.settings import EditSettings, FitSettings, RenderSettings
from videovec.strokes import Strokes

Floats = NDArray[np.float64]

SIZE = 96
LINE = np.linspace([12.0, 20.0], [84.0, 60.0], 4)
BOW = np.array([[10.0, 80.0], [30.0, 40.0], [60.0, 40.0], [86.0, 84.0]])


def _strokes(*curves: Floats, half_width: float = 1.5, opacity: float = 1.0) -> Strokes:
    strokes = Strokes.from_curves(list(curves), [np.full((len(c) - 1) // 3 + 1, half_width) for c in curves])
    return replace(strokes, opacity=np.full(len(curves), opacity))


def _drawn(strokes: Strokes) -> NDArray[np.uint8]:
    return draw_coverage(strokes, (1, SIZE, SIZE), resolve_backend(RenderSettings()))


def _ink(strokes: Strokes, noise: float = 0.0) -> Ink:
    coverage = _drawn(strokes)
    return Ink(coverage, np.zeros_like(coverage), np.zeros((1, 3)), np.ones(3), noise)


def _loss(strokes: Strokes, ink: Ink) -> float:
    return float(np.square((_drawn(strokes).astype(float) - ink.coverage) / 255).sum())


def _halved(curve: Floats, times: int) -> Floats:
    """The same curve in 2**times segments, by de Casteljau's midpoints."""
    segments = [curve]
    for _ in range(times):
        parts = []
        for p in segments:
            q = (p[:-1] + p[1:]) / 2
            r = (q[:-1] + q[1:]) / 2
            m = (r[0] + r[1]) / 2
            parts += [np.array([p[0], q[0], r[0], m]), np.array([m, r[1], q[2], p[3]])]
        segments = parts
    return np.concatenate([segments[0][:1], *(s[1:] for s in segments)])


def test_strokes_that_draw_the_ink_stay_as_they_are() -> None:
    strokes = _strokes(LINE, BOW)
    edited = edit(strokes, _ink(strokes), EditSettings())
    assert edited.ids.tolist() == strokes.ids.tolist()
    np.testing.assert_array_equal(edited.points, strokes.points)


def test_a_stroke_without_ink_goes() -> None:
    edited = edit(_strokes(LINE, BOW), _ink(_strokes(LINE)), EditSettings())
    assert edited.ids.tolist() == [1]


def test_of_two_strokes_on_one_line_one_goes() -> None:
    edited = edit(_strokes(LINE, LINE + 0.05), _ink(_strokes(LINE)), EditSettings())
    assert len(edited) == 1


@pytest.mark.parametrize(("half_width", "opacity"), [(0.004, 1.0), (1.5, 0.004)])
def test_sigma_min_is_the_width_and_the_opacity_that_a_stroke_must_have(half_width: float, opacity: float) -> None:
    strokes, ink = _strokes(LINE, half_width=half_width, opacity=opacity), _ink(_strokes(BOW))
    kept = EditSettings(delta_max=1.0, price=0.0)
    no_ink = replace(ink, coverage=np.zeros_like(ink.coverage))
    faint_ink = replace(ink, coverage=_drawn(_strokes(LINE, half_width=0.5)))
    assert len(edit(strokes, faint_ink, kept)) == 0
    assert len(edit(strokes, faint_ink, replace(kept, sigma_min=0.0))) == 1
    assert len(edit(strokes, no_ink, replace(kept, sigma_min=0.0))) == 0


def test_d_min_is_the_length_under_which_a_stroke_that_others_draw_is_dropped() -> None:
    stub = np.linspace(LINE[1], LINE[1] + np.array([-0.35, 0.63]), 4)  # leaves the line by little more than its edge
    strokes = _strokes(LINE, stub)
    ink = _ink(strokes)
    rise = _loss(strokes.select([0]), ink)
    price = rise / 4 / 2  # too dear for a stroke, cheap for a stub
    assert edit(strokes, ink, EditSettings(price=price)).ids.tolist() == [1]
    assert edit(strokes, ink, EditSettings(price=price, d_min=0.5)).ids.tolist() == [1, 2]


def test_ink_that_is_left_over_gets_a_stroke_where_it_is() -> None:
    edited = edit(_strokes(LINE), _ink(_strokes(LINE, BOW)), EditSettings())
    assert edited.ids.tolist() == [1, 2]
    ends = edited.points_of(1)[[0, -1]]
    gaps = [np.abs(ends - BOW[[0, -1]]).max(), np.abs(ends - BOW[[-1, 0]]).max()]
    assert min(gaps) < 1.0


def test_delta_max_is_the_share_of_the_page_that_may_stay_uncovered() -> None:
    dot = np.tile([[70.0, 20.0]], (4, 1))
    ink = _ink(_strokes(LINE, dot))
    missing = _loss(_strokes(LINE), ink) / SIZE**2
    assert len(edit(_strokes(LINE), ink, EditSettings(delta_max=0.7 * missing))) == 2
    assert len(edit(_strokes(LINE), ink, EditSettings(delta_max=1.3 * missing))) == 1


def test_the_edge_of_a_misplaced_line_is_no_uncovered_ink() -> None:
    assert len(edit(_strokes(LINE + np.array([0.5, -0.5])), _ink(_strokes(LINE)), EditSettings())) == 1


def test_page_noise_gets_no_strokes() -> None:
    ink = _ink(_strokes(LINE))
    noise = np.random.default_rng(1).normal(0, 12, ink.coverage.shape)
    noisy = np.clip(ink.coverage + noise, 0, 255).astype(np.uint8)
    assert len(edit(_strokes(LINE), replace(ink, coverage=noisy, noise=12 / 255), EditSettings())) == 1


def test_joints_that_change_nothing_go() -> None:
    strokes = _strokes(_halved(BOW, 3))
    edited = edit(strokes, _ink(strokes), EditSettings())
    assert edited.layout.segments.tolist() == [1]
    np.testing.assert_allclose(edited.points, BOW, atol=0.3)


def test_corners_stay() -> None:
    corner = np.concatenate(
        [np.linspace([10.0, 10.0], [50.0, 80.0], 4), np.linspace([50.0, 80.0], [85.0, 15.0], 4)[1:]]
    )
    strokes = _strokes(corner)
    edited = edit(strokes, _ink(strokes), EditSettings(price=1.0, tolerance=50.0))
    assert edited.layout.segments.tolist() == [2]


@pytest.mark.parametrize("price", [0.001, 0.01, 0.1])
def test_no_edit_costs_more_than_its_price(price: float) -> None:
    rng = np.random.default_rng(5)
    true = _strokes(_halved(BOW, 2), LINE)
    strokes = replace(true, points=true.points + rng.normal(0, 0.12, true.points.shape))
    ink = _ink(true)
    edited = edit(strokes, ink, EditSettings(price=price))
    saved = len(strokes.points) - len(edited.points)
    rounding = 0.01  # of pixels to 8 bits
    assert _loss(edited, ink) <= _loss(strokes, ink) + price * saved + rounding


def test_dearer_control_points_make_fewer() -> None:
    true = _strokes(_halved(BOW, 4))
    points = true.points + np.random.default_rng(3).normal(0, 0.03, true.points.shape)
    counts = [
        len(edit(replace(true, points=points), _ink(true), EditSettings(price=price)).points)
        for price in (0.0, 0.003, 0.03)
    ]
    assert counts[0] > counts[1] > counts[2]


def _cut(gap: float) -> tuple[Floats, Floats]:
    """A line in two parts with a gap between them. px"""
    span = LINE[-1] - LINE[0]
    half = 0.5 * gap / np.linalg.norm(span)
    return (
        np.linspace(LINE[0], LINE[0] + span * (0.5 - half), 4),
        np.linspace(LINE[0] + span * (0.5 + half), LINE[-1], 4),
    )


@pytest.mark.parametrize("turned", [(), (0,), (1,), (0, 1)])
def test_strokes_that_continue_one_another_become_one(turned: tuple[int, ...]) -> None:
    parts = [part[::-1] if i in turned else part for i, part in enumerate(_cut(2.0))]
    edited = edit(_strokes(*parts), _ink(_strokes(LINE)), EditSettings())
    assert len(edited) == 1
    ends = edited.points[[0, -1]]
    np.testing.assert_allclose(ends[np.argsort(ends[:, 0])], LINE[[0, -1]], atol=0.01)


def test_d_min_is_the_gap_over_which_strokes_are_joined() -> None:
    ink = _ink(_strokes(LINE))
    assert len(edit(_strokes(*_cut(4.0)), ink, EditSettings(delta_max=1.0))) == 1
    assert len(edit(_strokes(*_cut(4.0)), ink, EditSettings(delta_max=1.0, d_min=3.0))) == 2


def test_strokes_with_paper_between_them_stay_two() -> None:
    strokes = _strokes(*_cut(4.0), half_width=0.75)
    assert len(edit(strokes, _ink(strokes), EditSettings())) == 2


def test_strokes_that_meet_at_a_corner_stay_two() -> None:
    strokes = _strokes(np.linspace([10.0, 10.0], [50.0, 80.0], 4), np.linspace([50.0, 80.0], [85.0, 15.0], 4))
    assert len(edit(strokes, _ink(strokes), EditSettings())) == 2


def test_strokes_that_a_third_one_meets_stay_apart() -> None:
    one, two = _cut(0.5)
    strokes = _strokes(one, two, np.linspace(one[-1], one[-1] + [-10.0, 20.0], 4))
    assert len(edit(strokes, _ink(strokes), EditSettings())) == 3


def test_strokes_of_other_inks_stay_apart() -> None:
    strokes = _strokes(*_cut(0.5))
    colored = replace(strokes, color=np.array([[0.0, 0, 0], [1.0, 0, 0]]))
    ink = replace(_ink(strokes), palette=colored.color)
    assert len(edit(colored, ink, EditSettings())) == 2


def test_a_segment_that_cannot_bend_like_the_ink_is_split() -> None:
    x = np.linspace(8.0, 86.0, 10)
    wave = np.stack([x, 48.0 + np.array([0, -3, -3, 0, 3, 3, 0, -3, -3, 0.0])], axis=1)
    stiff = wave[[0, 3, 6, 9]]
    edited = fit(_ink(_strokes(wave)), _strokes(stiff), FitSettings(steps=300))
    plain = fit(_ink(_strokes(wave)), _strokes(stiff), FitSettings(steps=300, edits=EditSettings(every=0)))
    assert len(edited.strokes) == 1
    assert edited.strokes.layout.segments[0] >= 2
    assert edited.psnr[0] > plain.psnr[0] + 6


def test_a_segment_that_the_optimiser_can_move_is_not_split() -> None:
    edited = edit(_strokes(BOW + np.array([0.3, -0.4])), _ink(_strokes(BOW)), EditSettings())
    assert edited.layout.segments.tolist() == [1]


def test_a_fit_edits_on_its_way() -> None:
    ink = _ink(_strokes(LINE, BOW))
    start = _strokes(LINE + 0.4, np.linspace([10.0, 10.0], [12.0, 40.0], 4))
    edited = fit(ink, start, FitSettings(steps=120))
    plain = fit(ink, start, FitSettings(steps=120, edits=EditSettings(every=0)))
    assert edited.psnr[0] > 40 > plain.psnr[0]
    assert edited.strokes.ids.tolist() == [1, 3]


@pytest.mark.parametrize("half_width", [0.2, 1.5])
@pytest.mark.parametrize("length", [-3.0, 2.0])
def test_ends_are_moved_to_where_their_ink_ends(half_width: float, length: float) -> None:
    ink = _ink(_strokes(LINE, BOW, half_width=half_width))
    way = (LINE[3] - LINE[0]) / np.linalg.norm(LINE[3] - LINE[0])
    start = _strokes(np.linspace(LINE[0], LINE[3] + length * way, 4), BOW, half_width=half_width)
    moved = finish(start, ink, EditSettings())
    assert moved.points_of(0)[-1] == pytest.approx(LINE[3], abs=0.3)
    assert moved.points_of(0)[0] == pytest.approx(LINE[0], abs=0.2)
    assert moved.points_of(1) == pytest.approx(BOW, abs=0.2)


def test_an_end_on_the_ink_of_another_stroke_stays_there() -> None:
    stem = np.linspace([40.0, 90.0], 0.5 * (LINE[1] + LINE[2]), 4)
    strokes = _strokes(LINE, stem)
    moved = finish(strokes, _ink(strokes), EditSettings())
    assert moved.points == pytest.approx(strokes.points, abs=0.01)


@pytest.mark.parametrize("is_last", [True, False])
@pytest.mark.parametrize("short", [0.4, 1.2, -0.8])
def test_an_end_under_another_line_goes_to_its_middle(short: float, is_last: bool) -> None:
    middle = 0.5 * (LINE[1] + LINE[2])
    foot = np.array([40.0, 90.0])
    stem = np.linspace(foot, middle, 4)
    begun = np.linspace(foot, middle - short * (middle - foot) / np.linalg.norm(middle - foot), 4)
    ink = _ink(_strokes(LINE, stem))
    moved = finish(_strokes(LINE, begun if is_last else begun[::-1]), ink, EditSettings())
    assert moved.points_of(1)[-1 if is_last else 0] == pytest.approx(middle, abs=0.25)
    assert moved.points_of(1)[0 if is_last else -1] == pytest.approx(foot, abs=0.25)
    assert moved.points_of(0) == pytest.approx(LINE, abs=0.01)


def test_an_end_beside_another_line_does_not_go_there() -> None:
    beside = np.linspace([22.0, 26.0], [72.0, 53.8], 4)  # all along the line, with paper between
    strokes = _strokes(LINE, beside)
    assert finish(strokes, _ink(strokes), EditSettings()).points == pytest.approx(strokes.points, abs=0.01)
