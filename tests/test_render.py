"""Images and gradients: the back ends against the dense definition, the definition against geometry and differences."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import cache

import numpy as np
import pytest
import torch
from numpy.typing import NDArray
from torch import Tensor

from videovec.errors import ConfigError, FitError
from videovec.render import (
    PairList,
    Scene,
    composite,
    coverage_loss_and_gradients,
    list_pairs,
    render_image,
    resolve_backend,
)
from videovec.render.fused import match_with_torch
from videovec.render.numba_pairs import find_pairs as find_with_numba
from videovec.render.pairs import cut_chunks
from videovec.render.torch_pairs import find_pairs as find_with_torch
from videovec.settings import RenderSettings

LEAVES = ("control", "half_width", "interval", "opacity", "color")
SIDE = 40

Floats = NDArray[np.float64]
Curve = list[tuple[float, float]]


def scene_of(strokes: list[list[Curve]], half_widths: list[tuple[float, float]], *, side: int = SIDE) -> Scene:
    """One drawing; a stroke is a list of segments, each with the half-widths of its stroke's two ends."""
    row = [r for r, segments in enumerate(strokes) for _ in segments]
    rng = np.random.default_rng(1)
    return Scene(
        control=torch.tensor([segment for segments in strokes for segment in segments], dtype=torch.float64),
        half_width=torch.tensor([half_widths[r] for r in row], dtype=torch.float64),
        interval=torch.tensor([[0.0, 1.0]], dtype=torch.float64).repeat(len(row), 1),
        row=torch.tensor(row),
        opacity=torch.tensor(rng.uniform(0.5, 0.95, len(strokes))),
        color=torch.tensor(rng.uniform(0, 1, (len(strokes), 3))),
        drawing=torch.zeros(len(strokes), dtype=torch.long),
        size=(1, side, side),
    )


def random_strokes(count: int, side: float, seed: int = 0) -> list[list[Curve]]:
    """Curved strokes of one or two smooth segments."""
    rng = np.random.default_rng(seed)
    strokes = []
    for _ in range(count):
        heading, point, points = rng.uniform(0, 2 * np.pi), rng.uniform(0.15, 0.85, 2) * side, []
        for _ in range(3 * rng.integers(1, 3) + 1):
            points.append((float(point[0]), float(point[1])))
            heading += rng.normal(0, 0.35)
            point = point + side / 10 * np.array([np.cos(heading), np.sin(heading)])
        strokes.append([points[i : i + 4] for i in range(0, len(points) - 1, 3)])
    return strokes


def circle(x: float, y: float, radius: float) -> list[Curve]:
    k = 0.5523 * radius
    corners = [(1, 0), (0, 1), (-1, 0), (0, -1)]
    return [
        [
            (x + radius * a, y + radius * b),
            (x + radius * a + k * c, y + radius * b + k * d),
            (x + radius * c + k * a, y + radius * d + k * b),
            (x + radius * c, y + radius * d),
        ]
        for (a, b), (c, d) in zip(corners, corners[1:] + corners[:1], strict=True)
    ]


KINKED = ("cusp", "handles on joints, centres on the curve")
"""Scenes with pixels at which coverage has no derivative."""

LONE: Curve = [(8.2, 9.1), (15.4, 30.7), (24.9, 3.2), (33.3, 27.6)]
LOOP: Curve = [(6.3, 31.2), (52.1, 4.4), (-11.7, 6.1), (33.8, 30.9)]
CUSP: Curve = [(8.1, 30.3), (33.2, 8.7), (6.4, 8.2), (31.9, 31.1)]
ACROSS: Curve = [(5.2, 20.3), (15.1, 21.8), (25.6, 18.4), (35.7, 20.9)]
DOWN: Curve = [(20.4, 4.6), (18.7, 15.2), (22.3, 24.8), (19.6, 36.1)]
LEAVING: Curve = [(24.6, 16.2), (40.3, 14.7), (47.1, 26.4), (40.8, 46.9)]
DOT: Curve = [(20.3, 18.6)] * 4
STUB: Curve = [(20.5, 20.5), (20.5, 20.5), (29.5, 20.5), (29.5, 20.5)]

SCENES: dict[str, Callable[[], Scene]] = {
    "lone stroke": lambda: scene_of([[LONE]], [(0.8, 2.6)]),
    "self-crossing": lambda: scene_of([[LOOP]], [(1.5, 1.1)]),
    "crossing strokes": lambda: scene_of([[ACROSS], [DOWN], [LONE]], [(2.5, 1.0), (0.6, 2.0), (1.0, 1.0)]),
    "cusp": lambda: scene_of([[CUSP]], [(1.0, 1.6)]),
    "dots": lambda: scene_of([[DOT], [[(9.4, 30.1)] * 4]], [(2.4, 2.4), (0.3, 0.3)]),
    "closed stroke": lambda: scene_of([circle(20.3, 19.6, 11.2)], [(1.4, 1.4)]),
    "leaving the page": lambda: scene_of(
        [[LEAVING], [[(-9.0, -8.0), (-3.0, -1.0), (3.0, 2.0), (12.0, 9.0)]]], [(2.0, 3.0)] * 2
    ),
    "hairlines": lambda: scene_of([[LONE], [ACROSS]], [(0.2, 0.2), (0.1, 0.4)]),
    "thick": lambda: scene_of([[ACROSS]], [(9.0, 30.0)]),
    "handles on joints, centres on the curve": lambda: scene_of([[STUB]], [(1.5, 1.5)]),
    "hidden ends": lambda: replace(
        scene_of([[LONE], [ACROSS]], [(1.0, 2.0), (1.4, 0.4)]),
        interval=torch.tensor([[0.13, 0.71], [0.4, 0.95]], dtype=torch.float64),
    ),
    "hidden altogether": lambda: replace(
        scene_of([[LONE], [ACROSS]], [(1.0, 1.0)] * 2),
        interval=torch.tensor([[0.3, 0.3], [0.0, 1.0]], dtype=torch.float64),
    ),
    "many": lambda: scene_of(random_strokes(12, SIDE), [(1.0, 1.6)] * 12),
}


def in_precision(scene: Scene, dtype: torch.dtype) -> Scene:
    return replace(scene, **{name: getattr(scene, name).to(dtype) for name in LEAVES})


def image_and_gradients(scene: Scene, scale: float, backend: str, steps: int = 12) -> list[Tensor]:
    """Colour and coverage on a dense page, then the gradients of a fixed weighting of both by all leaves."""
    leaves = {name: getattr(scene, name).detach().clone().requires_grad_() for name in LEAVES}
    free = replace(scene, **leaves)
    pairs = list_pairs(free, scale)
    for _ in range(steps):  # each improves the nearest points
        color, coverage = composite(free, pairs, scale, backend)
    drawings, height, width = scene.size
    weights = torch.randn(drawings * height * width, 4, generator=torch.Generator().manual_seed(3), dtype=torch.float64)
    seen = weights[pairs.active].to(color.dtype)
    loss = (color * seen[:, :3]).sum() + (coverage * seen[:, 3]).sum()
    gradients = torch.autograd.grad(loss, list(leaves.values()), allow_unused=True, materialize_grads=True)
    return [value.detach().double() for value in (color, coverage, *gradients)]


@cache
def true_image_and_gradients(name: str, scale: float) -> list[Tensor]:
    scene = in_precision(in_precision(SCENES[name](), torch.float32), torch.float64)
    return image_and_gradients(scene, scale, "reference")


def distance(a: Tensor, b: Tensor) -> float:
    """Norm of the difference, relative where the truth is not small."""
    return float((a - b).norm() / max(float(b.norm()), 1.0))


@pytest.mark.parametrize("scale", [1.0, 3.0])
@pytest.mark.parametrize("backend", ["torch", "numba"])
@pytest.mark.parametrize("name", SCENES)
def test_back_ends_draw_and_differentiate_like_the_definition(name: str, backend: str, scale: float) -> None:
    scene = in_precision(in_precision(SCENES[name](), torch.float32), torch.float64)
    truth = true_image_and_gradients(name, scale)
    for precision, tolerance in ((torch.float64, 1e-7), (torch.float32, 1e-4)):
        found = image_and_gradients(in_precision(scene, precision), scale, backend)
        assert [distance(a, b) for a, b in zip(found, truth, strict=True)] == pytest.approx([0] * 7, abs=tolerance)


@pytest.mark.parametrize("scale", [1.0, 3.0])
@pytest.mark.parametrize("name", [name for name in SCENES if name not in KINKED])
def test_gradients_match_finite_differences(name: str, scale: float) -> None:
    scene = SCENES[name]()
    analytic = dict(zip(LEAVES, image_and_gradients(scene, scale, "numba")[2:], strict=True))
    pairs = list_pairs(scene, scale)
    for leaf in LEAVES:
        if leaf == "interval" and name != "hidden ends":
            continue  # no difference across t = 0 or 1
        value = getattr(scene, leaf)
        direction = torch.randn(value.shape, generator=torch.Generator().manual_seed(5), dtype=torch.float64)
        ends = [
            weighted_sum(replace(scene, **{leaf: value + step * direction}), pairs, scale) for step in (1e-6, -1e-6)
        ]
        numeric = (ends[0] - ends[1]) / 2e-6
        size = max(float(analytic[leaf].norm()), 1e-2)
        assert float((analytic[leaf] * direction).sum()) == pytest.approx(numeric, abs=1e-5 * size), leaf


def weighted_sum(scene: Scene, pairs: PairList, scale: float) -> float:
    """The weighting of `image_and_gradients`."""
    for _ in range(12):
        color, coverage = composite(scene, pairs, scale, "numba")
    drawings, height, width = scene.size
    weights = torch.randn(drawings * height * width, 4, generator=torch.Generator().manual_seed(3), dtype=torch.float64)
    seen = weights[pairs.active]
    return float((color * seen[:, :3]).sum() + (coverage * seen[:, 3]).sum())


def test_two_thousand_strokes_agree_between_the_fast_back_ends() -> None:
    scene = in_precision(scene_of(random_strokes(2000, 128), [(0.5, 1.0)] * 2000, side=512), torch.float32)
    found = {name: image_and_gradients(scene, 1.0, name, steps=2) for name in ("torch", "numba")}
    assert [distance(a, b) for a, b in zip(found["numba"], found["torch"], strict=True)] == pytest.approx(
        [0] * 7, abs=1e-4
    )


@pytest.mark.parametrize("name", SCENES)
def test_nothing_is_ever_not_a_number(name: str) -> None:
    scene = in_precision(SCENES[name](), torch.float32)
    centred = replace(scene, control=scene.control.floor() + 0.5)
    for backend in ("torch", "numba"):
        assert all(bool(value.isfinite().all()) for value in image_and_gradients(centred, 1.0, backend))


def exact_coverage(polyline: Floats, half_width: float, side: int, samples: int = 16) -> Floats:
    """Area of each pixel within ``half_width`` of a polyline, by many point samples."""
    grid = (np.arange(side * samples) + 0.5) / samples
    point = np.stack(np.meshgrid(grid, grid), axis=-1).reshape(-1, 1, 2)
    begin, edge = polyline[:-1], np.diff(polyline, axis=0)
    inside = np.zeros(len(point), bool)
    for a, e in zip(begin, edge, strict=True):
        r = point[:, 0] - a
        part = np.clip(r @ e / max(e @ e, 1e-12), 0, 1)
        inside |= np.square(r - part[:, None] * e).sum(-1) <= half_width**2
    share: Floats = inside.reshape(side, samples, side, samples).mean(axis=(1, 3))
    return share


def coverage_of(scene: Scene) -> Floats:
    bare = replace(scene, opacity=torch.ones_like(scene.opacity), color=torch.ones(len(scene.opacity), 1).double())
    return np.asarray(render_image(bare, torch.zeros(1))[0, :, :, 0])


@pytest.mark.parametrize(("half_width", "least"), [(0.26, 44.0), (0.75, 44.0), (1.5, 47.0), (3.0, 47.0)])
def test_a_curved_stroke_covers_the_area_that_it_covers(half_width: float, least: float) -> None:
    t = np.linspace(0, 1, 65)[:, None]
    curve = np.array([(8.2, 9.1), (18.4, 30.7), (22.9, 20.2), (33.3, 27.6)])
    points = (1 - t) ** 3 * curve[0] + 3 * t * (1 - t) ** 2 * curve[1] + 3 * t**2 * (1 - t) * curve[2] + t**3 * curve[3]
    scene = scene_of([[[(float(x), float(y)) for x, y in curve]]], [(half_width, half_width)])
    error = coverage_of(scene) - exact_coverage(points, half_width, SIDE)
    assert -10 * np.log10(np.square(error).mean()) > least


@pytest.mark.parametrize("length", [0.0, 0.4, 12.0])
@pytest.mark.parametrize("half_width", [0.1, 0.25, 0.6, 2.0])
def test_lines_and_dots_of_any_width_have_their_mass(half_width: float, length: float) -> None:
    rng = np.random.default_rng(0)
    masses = []
    for x, y in np.ndindex(8, 8):
        heading = rng.uniform(0, 2 * np.pi)
        middle, half = 10 + np.array([x, y]) / 8, length / 2 * np.array([np.cos(heading), np.sin(heading)])
        line = [(float(u), float(v)) for u, v in (middle + part * half for part in (-1, -1 / 3, 1 / 3, 1))]
        masses.append(coverage_of(scene_of([[line]], [(half_width, half_width)], side=20)).sum())
    assert np.mean(masses) == pytest.approx(2 * half_width * length + np.pi * half_width**2, rel=0.1)


def test_a_closed_stroke_has_no_seam() -> None:
    around = coverage_of(scene_of([circle(20.0, 20.0, 11.2)], [(1.4, 1.4)]))
    assert np.abs(around - around.T).max() < 1e-6  # the seam lies on the x axis alone
    assert np.abs(around - around[:, ::-1]).max() < 1e-6


def test_opacity_is_the_coverage_of_the_centre_line_however_often_a_stroke_crosses_itself() -> None:
    scene = scene_of([[LOOP]], [(2.5, 2.5)])
    image = render_image(
        replace(scene, opacity=torch.tensor([0.4]).double(), color=torch.zeros(1, 3).double()), torch.ones(3)
    )
    assert float(image.min()) == pytest.approx(0.6, abs=1e-6)


def test_later_rows_lie_above() -> None:
    scene = scene_of([[ACROSS], [DOWN]], [(2.0, 2.0)] * 2)
    opaque = replace(scene, opacity=torch.ones(2).double(), color=torch.eye(3)[:2].double())
    assert render_image(opaque, torch.ones(3))[0, 20, 20].tolist() == pytest.approx([0, 1, 0], abs=1e-6)


def test_drawings_do_not_see_each_other() -> None:
    one = scene_of(random_strokes(6, SIDE), [(1.0, 2.0)] * 6)
    both = replace(
        one,
        control=torch.cat([one.control, one.control.flip(-1)]),
        half_width=one.half_width.repeat(2, 1),
        interval=one.interval.repeat(2, 1),
        row=torch.cat([one.row, one.row + 6]),
        opacity=one.opacity.repeat(2),
        color=one.color.repeat(2, 1),
        drawing=torch.tensor([0] * 6 + [2] * 6),
        size=(3, SIDE, SIDE),
    )
    image = render_image(both, torch.ones(3))
    assert torch.equal(image[0], render_image(one, torch.ones(3))[0])
    torch.testing.assert_close(image[2], image[0].transpose(0, 1), rtol=0, atol=1e-9)
    assert bool((image[1] == 1).all())


@pytest.mark.parametrize("scale", [1.0, 4.0])
@pytest.mark.parametrize("name", SCENES)
def test_both_builders_list_the_same_pairs(name: str, scale: float) -> None:
    scene = SCENES[name]()
    chunks = cut_chunks(scene)
    ours, theirs = find_with_numba(scene, chunks, scale), find_with_torch(scene, chunks, scale)
    for field in ("chunk_pairs", "x", "y", "active", "start", "order", "order_row", "drawing_pixels"):
        assert torch.equal(getattr(ours, field), getattr(theirs, field)), field
    if name != "dots":  # all their points are nearest
        torch.testing.assert_close(ours.t, theirs.t)


def test_a_list_stays_valid_within_its_margin() -> None:
    scene = scene_of(random_strokes(12, SIDE), [(1.0, 1.6)] * 12)
    pairs = list_pairs(scene, 1.0)
    moved = replace(scene, control=scene.control + 0.6, half_width=scene.half_width + 0.1)
    for _ in range(4):
        _, stale = composite(moved, pairs, 1.0)
    new = list_pairs(moved, 1.0)
    _, fresh = composite(moved, new, 1.0)
    page = torch.zeros(SIDE * SIDE, dtype=torch.float64)
    stale, fresh = page.index_put((pairs.active,), stale), page.index_put((new.active,), fresh)
    torch.testing.assert_close(stale, fresh, rtol=0, atol=2e-2)  # chunks are cut elsewhere


def test_a_scene_without_strokes_is_the_page() -> None:
    empty = replace(
        scene_of([[LONE]], [(1.0, 1.0)]),
        control=torch.zeros(0, 4, 2),
        half_width=torch.zeros(0, 2),
        interval=torch.zeros(0, 2),
        row=torch.zeros(0, dtype=torch.long),
        opacity=torch.zeros(0),
        color=torch.zeros(0, 3),
        drawing=torch.zeros(0, dtype=torch.long),
    )
    page = torch.tensor([0.2, 0.4, 0.6])
    for backend in ("numba", "torch", "reference"):
        assert torch.equal(render_image(empty, page, backend=backend), page.expand(1, SIDE, SIDE, 3))
    match = coverage_loss_and_gradients(
        empty, list_pairs(empty, 1.0), 1.0, torch.zeros(1, SIDE, SIDE, dtype=torch.uint8)
    )
    assert float(match.loss.sum()) == 0


@pytest.mark.parametrize("threads", ["1", "3"])
@pytest.mark.parametrize("with_extra", [False, True])
def test_the_fused_loss_is_the_composed_one(with_extra: bool, threads: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("VIDEOVEC_THREADS", threads)
    parts = [scene_of(random_strokes(8, SIDE, seed), [(0.7, 1.8)] * 8) for seed in range(3)]
    scene = Scene(
        control=torch.cat([part.control for part in parts]),
        half_width=torch.cat([part.half_width for part in parts]),
        interval=torch.cat([part.interval for part in parts]),
        row=torch.cat([part.row + 8 * d for d, part in enumerate(parts)]),
        opacity=torch.cat([part.opacity for part in parts]),
        color=torch.zeros(24, 0, dtype=torch.float64),
        drawing=torch.arange(3).repeat_interleave(8),
        size=(3, SIDE, SIDE),
    )
    target = torch.randint(0, 256, scene.size, generator=torch.Generator().manual_seed(0), dtype=torch.uint8)
    pairs = list_pairs(scene, 1.5)
    extra = torch.randn(len(pairs.active), dtype=torch.float64) if with_extra else None
    for _ in range(8):
        found = coverage_loss_and_gradients(scene, pairs, 1.5, target, extra)
    truth = match_with_torch(scene, pairs, 1.5, target, extra)
    for name in ("loss", "value", "control", "half_width", "interval", "opacity"):
        assert distance(getattr(found, name), getattr(truth, name)) < 1e-6, name


@pytest.mark.cuda
@pytest.mark.skipif(not torch.cuda.is_available(), reason="needs a CUDA device")
@pytest.mark.parametrize("name", SCENES)
def test_a_gpu_draws_and_differentiates_like_the_cpu(name: str) -> None:
    scene = in_precision(SCENES[name](), torch.float32)
    names = (*LEAVES, "row", "drawing")
    there = replace(scene, **{field: getattr(scene, field).cuda() for field in names})
    target = torch.randint(0, 256, scene.size, generator=torch.Generator().manual_seed(0), dtype=torch.uint8)
    near, far = list_pairs(scene, 1.0), list_pairs(there, 1.0)
    for _ in range(8):
        here = coverage_loss_and_gradients(scene, near, 1.0, target)
        away = coverage_loss_and_gradients(there, far, 1.0, target.cuda())
    settled = replace(far, t=far.t.clone())
    away, again = (coverage_loss_and_gradients(there, p, 1.0, target.cuda()) for p in (far, settled))
    for field in ("loss", "value", "control", "half_width", "interval", "opacity"):
        error = distance(getattr(away, field).cpu(), getattr(here, field))
        assert error < (5e-3 if name in KINKED else 1e-3), field  # rounding decides what has no derivative
        assert torch.equal(getattr(away, field), getattr(again, field)), f"{field} differs from call to call"


@pytest.mark.parametrize(
    "settings", [RenderSettings(backend="nubma"), RenderSettings(device="gpu9"), RenderSettings("numba", "meta")]
)
def test_a_renderer_that_cannot_be_is_refused(settings: RenderSettings) -> None:
    with pytest.raises(ConfigError, match=r"render\.(backend|device)"):
        resolve_backend(settings)


def test_a_back_end_that_does_not_exist_is_refused() -> None:
    scene = SCENES["lone stroke"]()
    with pytest.raises(FitError, match="backend"):
        render_image(scene, torch.ones(3), backend="opengl")


def test_the_fast_back_ends_agree_where_nearest_points_are_not_yet_found() -> None:
    scene = scene_of(random_strokes(20, 64), [(1.0, 1.6)] * 20, side=64)
    crumpled = replace(
        scene, control=scene.control + torch.randn(scene.control.shape, generator=torch.Generator().manual_seed(0))
    )
    found = {name: image_and_gradients(crumpled, 3.0, name, steps=1) for name in ("torch", "numba")}
    assert [distance(a, b) for a, b in zip(found["numba"], found["torch"], strict=True)] == pytest.approx(
        [0] * 7, abs=1e-3
    )


@pytest.mark.parametrize("bad", [float("nan"), float("inf")])
def test_points_that_are_no_numbers_are_named(bad: float) -> None:
    scene = SCENES["crossing strokes"]()
    scene.control[1, 2, 0] = bad
    with pytest.raises(FitError, match="segment 1"):
        list_pairs(scene, 1.0)


def test_strokes_far_beyond_the_page_cost_nothing() -> None:
    scene = SCENES["crossing strokes"]()
    far = replace(scene, control=scene.control * 1e7)
    assert len(list_pairs(far, 1.0)) < 10 * SIDE * SIDE
