"""First strokes: traced, scattered, or an artist's."""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest

from videovec.clip import Clip, Timeline
from videovec.errors import InputError
from videovec.fit import draw_coverage, fit
from videovec.initialise import initialise
from videovec.ink import Ink
from videovec.render import resolve_backend
from videovec.settings import Config, InitialiseSettings, RenderSettings
from videovec.start import first_strokes, scatter, start_drawing, start_settings
from videovec.strokes import Strokes

SIZE = 128
CURVES = (
    np.array([[20.0, 20.0], [60.0, 10.0], [90.0, 40.0], [105.0, 100.0]]),
    np.array([[20.0, 60.0], [30.0, 90.0], [50.0, 110.0], [85.0, 112.0]]),
    np.array([[60.0, 50.0], [62.0, 60.0], [64.0, 70.0], [60.0, 80.0]]),
)


def _true() -> Strokes:
    return Strokes.from_curves(list(CURVES), [np.full(2, 1.5)] * len(CURVES))


def _ink() -> Ink:
    coverage = draw_coverage(_true(), (1, SIZE, SIZE), resolve_backend(RenderSettings()))
    return Ink(coverage, np.zeros_like(coverage), np.zeros((1, 3)), np.ones(3), 0.0)


def _svg(folder: Path, shift: float = 0.0, scale: float = 1.0) -> Path:
    """The true strokes in reverse order and direction, moved, and thinner than the ink."""
    paths = []
    for curve in CURVES[::-1]:
        at = [f"{x:.3f},{y:.3f}" for x, y in (curve[::-1] - SIZE / 2) * scale + SIZE / 2 + shift]
        paths.append(f'<path d="M{at[0]} C{at[1]} {at[2]} {at[3]}" fill="none" stroke="black" stroke-width="1"/>')
    path = folder / "reference.svg"
    path.write_text(f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {SIZE} {SIZE}">{"".join(paths)}</svg>')
    return path


def _config(**initialise: object) -> Config:
    return Config(initialise=replace(InitialiseSettings(), **initialise))  # type: ignore[arg-type]


def test_lines_are_traced_unless_told() -> None:
    traced = first_strokes(_ink(), 0, Config())
    np.testing.assert_array_equal(traced.points, initialise(_ink(), 0, InitialiseSettings()).points)


def test_random_strokes_are_as_many_as_told_and_the_same_for_a_seed() -> None:
    config = _config(method="random", strokes=50)
    one, same = first_strokes(_ink(), 0, config), first_strokes(_ink(), 0, config)
    other = first_strokes(_ink(), 0, replace(config, seed=1))
    assert len(one) == 50
    np.testing.assert_array_equal(one.points, same.points)
    assert not np.array_equal(one.points, other.points)


def test_random_strokes_lie_all_over_the_page() -> None:
    strokes = scatter(_ink(), 400, np.random.default_rng(0))
    middles = strokes.points.reshape(-1, 4, 2).mean(axis=1)
    counts = np.histogram2d(middles[:, 0], middles[:, 1], bins=4, range=[[0, SIZE], [0, SIZE]])[0]
    assert counts.min() >= 8
    assert counts.sum() > 360


def test_random_strokes_find_the_drawing() -> None:
    config = _config(method="random", strokes=60)
    result = fit(_ink(), first_strokes(_ink(), 0, config), start_settings(config))
    assert result.psnr[0] > 35
    assert len(result.strokes) < 20


def test_a_reference_keeps_its_strokes_and_takes_the_width_of_the_ink(tmp_path: Path) -> None:
    config = _config(reference=str(_svg(tmp_path)))
    result = fit(_ink(), first_strokes(_ink(), 0, config), start_settings(config))
    assert result.strokes.ids.tolist() == [1, 2, 3]
    for found, true in zip(result.strokes.points.reshape(-1, 4, 2), CURVES[::-1], strict=True):
        np.testing.assert_allclose(found[[0, -1]], true[[-1, 0]], atol=0.5)
    np.testing.assert_allclose(result.strokes.half_width, 1.5, atol=0.15)


@pytest.mark.parametrize(("shift", "scale"), [(4.0, 1.0), (0.0, 1.08)])
def test_a_reference_that_lies_off_the_ink_is_moved_onto_it(tmp_path: Path, shift: float, scale: float) -> None:
    config = _config(reference=str(_svg(tmp_path, shift, scale)))
    result = fit(_ink(), first_strokes(_ink(), 0, config), start_settings(config))
    assert result.strokes.ids.tolist() == [1, 2, 3]
    for found, true in zip(result.strokes.points.reshape(-1, 4, 2), CURVES[::-1], strict=True):
        np.testing.assert_allclose(found[[0, -1]], true[[-1, 0]], atol=0.5)


def test_the_reference_frame_is_a_number_of_the_source() -> None:
    image = np.zeros((8, 8, 3), np.uint8)
    numbers = np.array([11, 12, 13])
    timeline = Timeline(np.array([0, 0, 1]), tuple(Fraction(n, 8) for n in range(3)), Fraction(3, 8), numbers)
    clip = Clip("clip", (image, image), timeline)
    assert start_drawing(clip, _ink(), InitialiseSettings()) == 0
    assert start_drawing(clip, _ink(), InitialiseSettings(reference="a.svg", reference_frame=13)) == 1
    with pytest.raises(InputError, match=r"11\.\.13.*got 1"):
        start_drawing(clip, _ink(), InitialiseSettings(reference="a.svg"))


@pytest.mark.parametrize(("amounts", "start"), [([9, 10, 10], 0), ([0, 5, 10, 10], 2), ([3, 10, 4], 1), ([7], 0)])
def test_strokes_start_from_the_first_drawing_that_shows_enough(amounts: list[int], start: int) -> None:
    coverage = np.zeros((len(amounts), 4, 10), np.uint8)
    for drawing, amount in zip(coverage, amounts, strict=True):
        drawing[1, :amount] = 255
    ink = replace(_ink(), coverage=coverage, label=np.zeros_like(coverage))
    timeline = Timeline(np.zeros(1, np.intp), (Fraction(0),), Fraction(1), np.array([1]))
    assert start_drawing(Clip("clip", (coverage[0],), timeline), ink, InitialiseSettings()) == start
