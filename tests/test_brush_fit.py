"""Brushes learned from strokes that a known brush drew, by a painter of its own."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import torch
from numpy.typing import NDArray
from scipy.ndimage import gaussian_filter

from videovec.brush import (
    Brush,
    BrushModel,
    Laying,
    apply_brush,
    bridge,
    export_brush,
    fit_brush,
    looks_textured,
    mend,
    solidify,
)
from videovec.brush.align import align
from videovec.brush.paint import BrushTensors, find_pairs, paint
from videovec.brush.period import find_repeat
from videovec.brush.prepare import shorten_segments
from videovec.brush.strips import Strip
from videovec.curves import arc_length, sample_by_arc
from videovec.errors import FitError
from videovec.ink import Ink
from videovec.settings import BrushSettings, EditSettings
from videovec.strokes import Strokes

Floats = NDArray[np.float64]
SIZE = 176
QUICK = BrushSettings(profile_steps=50, texture_steps=75, shortest_repeat=7.0, longest_repeat=13.0)


def ink_of(pages: Floats) -> Ink:
    coverage = np.round(255 * pages).astype(np.uint8)
    return Ink(coverage, np.zeros_like(coverage), np.zeros((1, 3)), np.ones(3), 0.0)


def arcs(count: int, seed: int = 0) -> Strokes:
    """Gently bent strokes over the page, some drawn from the right."""
    rng = np.random.default_rng(seed)
    curves = []
    for k in range(count):
        y = 16 + k * (SIZE - 32) / (count - 1)
        x = np.linspace(12, SIZE - 12, 4)
        curve = np.stack([x, y + rng.uniform(-8, 8, 4)], axis=1)
        curves.append(curve[:: 1 if k % 2 else -1])
    return Strokes.from_curves(curves, [np.full(2, 4.0)] * count)


def grain(columns: int, rows: int, rng: np.random.Generator) -> Floats:
    """Rubbed ink, periodic in the first axis."""
    field = gaussian_filter(rng.normal(size=(columns, rows)), (2.0, 1.2), mode=("wrap", "nearest"))
    return np.asarray(np.clip(0.55 + 0.3 * field / field.std(), 0.0, 1.0))


def draw(strokes: Strokes, strip: Floats, phase: Floats, repeat: float, width: float = 8.0) -> Floats:
    """A page of strokes, each pixel read from the strip at its nearest sample; no code of the brush package."""
    fine = 3
    y, x = (np.mgrid[: SIZE * fine, : SIZE * fine] + 0.5) / fine
    clear = np.ones((SIZE * fine, SIZE * fine))
    for row in range(strokes.row_count):
        points = sample_by_arc(strokes.points_of(row), 1200)
        length = arc_length(strokes.points_of(row))
        tangent = np.gradient(points, axis=0)
        tangent /= np.linalg.norm(tangent, axis=1, keepdims=True)
        top, bottom = int((points[:, 1].min() - 6) * fine), int((points[:, 1].max() + 6) * fine)
        part = (slice(max(top, 0), bottom), slice(None))
        page = np.stack([x[part].ravel(), y[part].ravel()], axis=1)
        order = np.argsort(points[:, 0])
        near = order[np.clip(np.searchsorted(points[order, 0], page[:, 0]), 0, len(points) - 1)]
        for _ in range(3):  # the strokes are functions of x: project on the tangent a few times
            along = ((page - points[near]) * tangent[near]).sum(1)
            near = np.clip(near + np.round(along / length * 1199).astype(int), 0, 1199)
        offset = page - points[near]
        v = (tangent[near, 0] * offset[:, 1] - tangent[near, 1] * offset[:, 0]) / (width / 2)
        u = (near / 1199 * length / width + phase[row]) / repeat
        rows = np.floor((v + 1) / 2 * strip.shape[1]).astype(int)
        ends = np.abs((offset * tangent[near]).sum(1)) < 0.3
        inside = (rows >= 0) & (rows < strip.shape[1]) & ends
        columns = np.floor(u * strip.shape[0]).astype(int) % strip.shape[0]
        value = np.where(inside, strip[columns, np.clip(rows, 0, strip.shape[1] - 1)], 0)
        clear[part] *= 1 - value.reshape(clear[part].shape)
    return np.asarray(1 - clear.reshape(SIZE, fine, SIZE, fine).mean((1, 3)))


def shaken(strokes: Strokes, seed: int = 5) -> Strokes:
    rng = np.random.default_rng(seed)
    return replace(
        strokes,
        points=strokes.points + rng.normal(0, 0.6, strokes.points.shape),
        half_width=strokes.half_width + rng.normal(0, 0.4, strokes.half_width.shape),
    )


def signal_to_noise(one: Floats, other: Floats) -> float:
    return float(-10 * np.log10(np.mean((one - other) ** 2)))


def test_a_repeating_strip_is_found_and_drawn_again() -> None:
    rng, strokes = np.random.default_rng(1), arcs(9)
    phase = rng.uniform(0, 9, 9)
    page = draw(strokes, grain(144, 24, rng), phase, 9.0)
    found = fit_brush(ink_of(page[None]), shaken(strokes), QUICK)
    assert found.brush.model is BrushModel.TEXTURE
    assert found.evidence.repeat * found.evidence.width == pytest.approx(72, rel=0.01)
    assert found.evidence.explained > found.evidence.null + 0.2
    assert found.texels < found.ink_pixels
    drawn = 1 - apply_brush(found.brush, found.strokes, (SIZE, SIZE), found.laying)[..., 0]
    plain = fit_brush(ink_of(page[None]), shaken(strokes), replace(QUICK, model="profile"))
    smooth = 1 - apply_brush(plain.brush, plain.strokes, (SIZE, SIZE), plain.laying)[..., 0]
    assert signal_to_noise(page, drawn) > signal_to_noise(page, smooth) + 5


def test_a_known_brush_is_laid_along_other_strokes(tmp_path: Path) -> None:
    rng, strokes = np.random.default_rng(9), arcs(7)
    strip = grain(144, 24, rng)
    padded = np.pad(strip, ((0, 0), (4, 4)))  # from -1..1 to about -1.3..1.3
    export_brush(Brush("known", BrushModel.TEXTURE, padded, 8.0, 9.0), tmp_path)
    page = draw(strokes, strip, rng.uniform(0, 9, 7), 9.0)
    found = fit_brush(ink_of(page[None]), shaken(strokes), replace(QUICK, brush=str(tmp_path)))
    assert found.brush.name == "known"
    assert found.brush.repeat * found.brush.width == pytest.approx(72, rel=0.02)
    drawn = 1 - apply_brush(found.brush, found.strokes, (SIZE, SIZE), found.laying)[..., 0]
    assert found.evidence.explained > 0.3
    assert signal_to_noise(page, drawn) > 23


def test_grain_that_never_repeats_is_taken_for_grain() -> None:
    rng, strokes = np.random.default_rng(2), arcs(9)
    page = draw(strokes, grain(4000, 24, rng), 26.0 * np.arange(9.0), 250.0)
    found = fit_brush(ink_of(page[None]), shaken(strokes), QUICK)
    assert found.brush.model is BrushModel.GRAIN
    drawn = 1 - apply_brush(found.brush, found.strokes, (SIZE, SIZE), found.laying)[..., 0]
    assert drawn[page > 0.2].std() == pytest.approx(page[page > 0.2].std(), rel=0.25)


def test_a_one_sided_profile_is_found_and_strokes_are_turned() -> None:
    strokes = arcs(8)
    strip = np.tile(np.linspace(0.15, 0.95, 24) ** 2, (4, 1))
    found = fit_brush(ink_of(draw(strokes, strip, np.zeros(8), 1.0)[None]), shaken(strokes), QUICK)
    assert found.brush.model is BrushModel.PROFILE
    assert np.ptp(found.laying.sign) == 0  # all were drawn the same way round
    lower, upper = found.brush.profile[:12].mean(), found.brush.profile[12:].mean()
    assert max(lower, upper) > 1.4 * min(lower, upper)


def test_solid_ink_needs_no_grain() -> None:
    strokes = arcs(6)
    found = fit_brush(ink_of(draw(strokes, np.ones((4, 24)), np.zeros(6), 1.0)[None]), shaken(strokes), QUICK)
    assert found.brush.model is BrushModel.PROFILE


def test_one_brush_draws_a_clip_and_does_not_swim() -> None:
    rng, still = np.random.default_rng(4), arcs(7)
    strip, phase = grain(144, 24, rng), rng.uniform(0, 9, 7)
    drawings = [replace(still, points=still.points + np.array([2.0 * k, 1.5 * k])) for k in range(3)]
    pages = np.stack([draw(one, strip, phase, 9.0) for one in drawings])
    rows = [shaken(one, 20 + k).at_drawing(0, k) for k, one in enumerate(drawings)]
    clip = _as_clip(rows)
    found = fit_brush(ink_of(pages), clip, QUICK)
    assert found.brush.model is BrushModel.TEXTURE
    assert found.evidence.agreement > 0.5
    assert np.abs(found.laying.shift).max() < 3 * 0.6 / 8  # widths: three deviations of first points that are shaken
    for k in range(3):
        one = found.strokes.at_drawing(k, 0)
        drawn = (
            1 - apply_brush(found.brush, one, (SIZE, SIZE), found.laying.at_drawing(found.strokes.layout, k))[..., 0]
        )
        assert signal_to_noise(pages[k], drawn) > 24


def test_lines_that_boil_are_drawn_by_one_brush_that_begins_anywhere_on_each_drawing() -> None:
    rng, still = np.random.default_rng(6), arcs(6)
    strip, drawings = grain(144, 24, rng), 3
    pages = np.stack([draw(still, strip, rng.uniform(0, 9, 6), 9.0) for _ in range(drawings)])
    clip = _as_clip([shaken(still, 30 + k).at_drawing(0, k) for k in range(drawings)])
    scores = []
    for boil in (True, False):
        found = fit_brush(ink_of(pages), clip, replace(QUICK, boil=boil))
        layings = [found.laying.at_drawing(found.strokes.layout, k) for k in range(drawings)]
        drawn = [
            1 - apply_brush(found.brush, found.strokes.at_drawing(k, 0), (SIZE, SIZE), laying)[..., 0]
            for k, laying in enumerate(layings)
        ]
        scores.append(signal_to_noise(pages, np.stack(drawn)))
        assert (np.ptp(found.laying.shift) > 3) == boil  # widths; fitted as if they did not, they settle by one or two
    assert scores[0] > scores[1] + 4


def _as_clip(rows: list[Strokes]) -> Strokes:
    """Strokes of one drawing each as strokes of one life."""
    from videovec.strokes import Layout

    count, drawings = len(rows[0]), len(rows)
    layout = Layout(rows[0].layout.segments, np.zeros(count, np.intp), np.full(count, drawings - 1))
    pick = [(rows[k], s) for s in range(count) for k in range(drawings)]
    return Strokes(
        ids=rows[0].ids, layout=layout, is_closed=rows[0].is_closed, layer=rows[0].layer, color=rows[0].color,
        points=np.concatenate([one.points_of(s) for one, s in pick]),
        half_width=np.concatenate([one.half_width_of(s) for one, s in pick]),
        opacity=np.ones(len(pick)), visible=np.tile([0.0, 1.0], (len(pick), 1)),
    )  # fmt: skip


def test_fitting_a_brush_needs_strokes() -> None:
    with pytest.raises(FitError, match="at least one stroke"):
        fit_brush(ink_of(np.zeros((1, 20, 20))), Strokes.empty(), QUICK)


def _with(tensors: BrushTensors, name: str, value: torch.Tensor) -> BrushTensors:
    changed: dict[str, Any] = {name: value}
    return replace(tensors, **changed)


@pytest.mark.parametrize("name", ["points", "half_width", "density", "phase", "shift", "strip"])
def test_gradients_of_painting_match_finite_differences(name: str) -> None:
    rng = np.random.default_rng(6)
    curve = np.array([[6.0, 20], [14, 8], [26, 30], [34, 18]])
    strokes = Strokes.from_curves([curve], [np.array([4.0, 5.0])])
    brush = Brush("b", BrushModel.TEXTURE, grain(40, 12, rng) * 0.8 + 0.1, 8.0, 3.3)
    laying = replace(Laying.plain(strokes.layout), density=np.array([0.7, 0.9]))
    pairs = find_pairs(strokes, laying, (1, 40, 40))
    pairs = replace(
        pairs,
        **{
            k: getattr(pairs, k).double()
            for k in ("weights", "t", "direction", "offset", "arc", "tangent", "begin", "sign")
        },
    )
    start = BrushTensors.of(strokes, laying, brush)
    start = BrushTensors(
        start.points.double(), start.half_width.double(), start.density.double(), start.phase.double(),
        start.shift.double(), start.strip.double(), start.width, start.repeat,
    )  # fmt: skip

    def coverage(value: torch.Tensor) -> torch.Tensor:
        return paint(pairs, _with(start, name, value))

    value = getattr(start, name).requires_grad_()
    weights = torch.as_tensor(rng.normal(size=len(pairs.pixels)))
    (gradient,) = torch.autograd.grad((coverage(value) * weights).sum(), value)
    direction = torch.as_tensor(rng.normal(size=tuple(value.shape)))
    step = 1e-6
    with torch.no_grad():
        ahead, behind = (coverage(value + sign * step * direction) for sign in (1, -1))
    assert float((gradient * direction).sum()) == pytest.approx(
        float(((ahead - behind) * weights).sum()) / (2 * step), rel=1e-3
    )


def test_alignment_finds_phase_and_direction_of_pieces_of_one_texture() -> None:
    rng = np.random.default_rng(7)
    texture = grain(96, 24, rng) - 0.55
    strips, starts = [], []
    for k in range(8):
        start, length = int(rng.integers(96)), int(rng.integers(70, 200))
        piece = texture[(start + np.arange(length)) % 96] + 0.05 * rng.normal(size=(length, 24))
        piece = piece[::-1, ::-1] if k % 3 == 0 else piece
        strips.append(Strip(piece, np.ones_like(piece), np.ones(length), np.nan))
        starts.append(start)
    repeat = find_repeat(strips, 6.0, 12.0)
    assert repeat == pytest.approx(8.0, rel=0.006)
    found = align(strips, 8.0)
    assert found.score > 0.8
    is_turned = np.arange(8) % 3 == 0
    assert np.array_equal(found.sign < 0, is_turned) or np.array_equal(found.sign > 0, is_turned)


@pytest.mark.parametrize(("share", "strokes"), [(0.5, 1), (0.0, 2)])
def test_a_gap_of_grain_is_bridged_and_a_gap_that_was_drawn_is_not(share: float, strokes: int) -> None:
    """Two lines 8 px wide with 4 px between them, where half of the pixels hold ink or none does."""
    ends = [np.linspace((12, 60), (80, 60), 4), np.linspace((92, 60), (160, 60), 4)]
    page = np.zeros((SIZE, SIZE))
    page[56:64, 8:84] = page[56:64, 88:164] = 0.8
    page[56:64, 84:88] = 0.8 * (np.random.default_rng(1).random((8, 4)) < share)
    two = Strokes.from_curves(ends, [np.full(2, 4.0)] * 2)
    assert len(bridge(two, ink_of(page[None]), EditSettings())) == strokes


def test_a_line_that_leaves_a_fat_one_is_traced_and_scraps_on_its_edge_are_not() -> None:
    fat = Strokes.from_curves([np.array([[12.0, 60], [60, 58], [110, 62], [164, 60]])], [np.full(2, 8.0)])
    thin = Strokes.from_curves([np.array([[70.0, 62], [90, 85], [110, 100], [130, 120]])], [np.full(2, 3.0)])
    flat = Brush("flat", BrushModel.PROFILE, np.ones((1, 24)), 8.0, 1.0)
    both = Strokes.from_curves([fat.points_of(0), thin.points_of(0)], [np.full(2, 6.0), np.full(2, 2.5)])
    page = 1 - apply_brush(flat, both, (SIZE, SIZE), Laying.plain(both.layout))[..., 0]
    scrap = Strokes.from_curves([np.array([[60.0, 64], [60, 66], [60, 67], [60, 68]])], [np.full(2, 2.0)])
    traced = Strokes.concatenate([fat, replace(scrap, ids=np.array([2]))])
    found = mend(traced, ink_of(page[None]), EditSettings())
    assert len(found) == 2
    assert found.points_of(0) == pytest.approx(fat.points_of(0))
    assert arc_length(found.points_of(1)) > 0.5 * arc_length(thin.points_of(0))  # the fat line has its beginning
    true = sample_by_arc(thin.points_of(0), 400)
    at = sample_by_arc(found.points_of(1), 40)
    assert np.linalg.norm(at[:, None] - true, axis=2).min(axis=1).max() < 1.5


def test_thin_lines_beside_dark_ones_survive_being_made_solid() -> None:
    page = np.zeros((SIZE, SIZE))
    page[40:160:12, 10:166] = 0.9
    page[44:160:12, 10:166] = 0.3  # 3 px away: of a third of the ink
    made = solidify(ink_of(page[None])).coverage[0]
    assert (made[page == 0.3] > 127).all()
    assert (made[42:160:12, 20:150] < 64).all()  # and nothing between


def test_shortening_segments_keeps_the_curves() -> None:
    strokes = arcs(5)
    shorter = shorten_segments(strokes, 30.0)
    assert shorter.layout.segments.min() > 3
    for row in range(5):
        one, other = (sample_by_arc(s.points_of(row), 50) for s in (strokes, shorter))
        assert one == pytest.approx(other, abs=1e-3)


def test_textured_ink_is_told_from_solid_ink_and_made_solid() -> None:
    rng, strokes = np.random.default_rng(8), arcs(7)
    solid = ink_of(draw(strokes, np.ones((4, 24)), np.zeros(7), 1.0)[None])
    rough = ink_of(draw(strokes, grain(400, 24, rng), 3.0 * np.arange(7.0), 30.0)[None])
    assert not looks_textured(solid).is_textured
    assert looks_textured(rough).is_textured
    made = solidify(rough).coverage[0] / 255
    assert signal_to_noise(solid.coverage[0] / 255, made) > signal_to_noise(
        solid.coverage[0] / 255, rough.coverage[0] / 255
    )
    assert not looks_textured(solidify(rough)).is_textured
