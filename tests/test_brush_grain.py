"""Grain of chance laid along strokes: made-up strips whose places are known, and strokes that no statistics saw."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.ndimage import gaussian_filter

from videovec.brush.grain import measure_grain, synthesise_grain
from videovec.brush.lay import grain_begins
from videovec.brush.strips import TEXELS_PER_WIDTH, Strip

Floats = NDArray[np.float64]
WIDTHS, ACROSS = 48, 24
COLUMNS = WIDTHS * TEXELS_PER_WIDTH
PROFILE = np.full(ACROSS, 0.5)


def rubbed(columns: int, rng: np.random.Generator) -> Floats:
    """Grain of mean 0, periodic along the first axis."""
    field = gaussian_filter(rng.normal(size=(columns, ACROSS)), (2.0, 1.2), mode=("wrap", "nearest"))
    return np.asarray(np.clip(0.15 * field / field.std(), -0.5, 0.5))


def strip_of(grain: Floats) -> Strip:
    return Strip(grain, np.ones(grain.shape), np.ones(len(grain)), float("nan"))


def drawn_by_chance(count: int, seed: int) -> list[Strip]:
    """Strokes of 15 widths, each with grain of its own."""
    rng = np.random.default_rng(seed)
    return [strip_of(rubbed(15 * TEXELS_PER_WIDTH, rng)) for _ in range(count)]


def explained(strips: list[Strip], texture: Floats) -> float:
    """Mean share of the grain of strokes that the texture explains where each of them begins."""
    begins = np.round(grain_begins(strips, np.ones(len(strips)), texture, WIDTHS) * TEXELS_PER_WIDTH).astype(int)
    laid = [texture[(begin + np.arange(len(s.grain))) % COLUMNS] for s, begin in zip(strips, begins, strict=True)]
    left = [np.square(s.grain - there).sum() / np.square(s.grain).sum() for s, there in zip(strips, laid, strict=True)]
    return 1 - float(np.mean(left))


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_strokes_cut_from_a_strip_begin_where_they_were_cut(sign: float) -> None:
    rng = np.random.default_rng(4)
    texture = rubbed(COLUMNS, rng)
    places, length = rng.uniform(0, WIDTHS, 12), 10 * TEXELS_PER_WIDTH
    strips = []
    for place in places:
        along = place * TEXELS_PER_WIDTH + sign * (np.arange(length) + 0.5) - 0.5
        grain = texture[np.round(along).astype(int) % COLUMNS]
        strips.append(strip_of(grain + rng.normal(0, 0.05, grain.shape) if sign > 0 else grain[:, ::-1]))
    found = grain_begins(strips, np.full(12, sign), texture, WIDTHS)
    off = (found - places + WIDTHS / 2) % WIDTHS - WIDTHS / 2
    assert np.abs(off).max() <= 1.0 / TEXELS_PER_WIDTH


def test_strokes_that_gave_no_statistics_are_explained_as_well_as_those_that_did() -> None:
    seen, unseen = drawn_by_chance(20, 1), drawn_by_chance(20, 2)
    texture = synthesise_grain(measure_grain(seen, PROFILE), COLUMNS, np.random.default_rng(3)) - PROFILE
    gains = explained(seen, texture), explained(unseen, texture)
    anywhere = [1 - np.square(s.grain - texture[: len(s.grain)]).sum() / np.square(s.grain).sum() for s in seen]
    assert min(gains) > float(np.mean(anywhere)) + 0.2  # it is worth looking for a place
    assert gains[1] == pytest.approx(gains[0], abs=0.05)
    assert max(gains) < 0.0  # and no place is a copy: the profile alone has a smaller squared error
