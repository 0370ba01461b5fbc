"""The figures of a run, against pictures whose error is known."""

from __future__ import annotations

from fractions import Fraction

import numpy as np
import pytest
from numpy.typing import NDArray

from videovec.clip import Clip, Timeline
from videovec.picture import render_strokes
from videovec.quality import measure
from videovec.strokes import Strokes
from videovec.tracks import StrokeTracks

INK = (0.8, 0.2, 0.1)
PAGE = np.array([0.9, 0.95, 1.0])


def _bar() -> Strokes:
    """A bar from (8, 12) to (24, 12), 4 px wide, that covers whole pixels but for its round ends."""
    return Strokes.from_curves([np.linspace([8.0, 12.0], [24.0, 12.0], 4)], [np.full(2, 2.0)], color=INK)


def _tracks(strokes: Strokes) -> StrokeTracks:
    timeline = Timeline(np.array([0]), (Fraction(0),), Fraction(1), np.array([1]))
    rows = strokes.row_count
    return StrokeTracks("bar", (24, 32), PAGE, timeline, strokes, (), np.zeros(rows), np.ones(rows))


def _clip(image: NDArray[np.float64], kind: type = np.uint8) -> Clip:
    full = np.iinfo(kind).max
    return Clip("bar", ((image * full).round().astype(kind),), _tracks(_bar()).timeline)


def _true_bar() -> NDArray[np.float64]:
    """The same bar, by hand: full ink inside, page outside. [24, 32, 3]"""
    image = np.tile(PAGE, (24, 32, 1))
    image[10:14, 8:24] = INK
    return image


def test_a_bar_is_drawn_in_its_ink_on_its_page() -> None:
    picture = render_strokes(_bar(), (24, 32), 0, PAGE)
    assert picture.shape == (24, 32, 3)
    np.testing.assert_allclose(picture[10:14, 9:23], np.broadcast_to(INK, (4, 14, 3)), atol=0.01)
    np.testing.assert_allclose(picture[:8], np.broadcast_to(PAGE, (8, 32, 3)), atol=1e-6)


@pytest.mark.parametrize("kind", [np.uint8, np.uint16])
def test_strokes_that_are_the_picture_have_no_error(kind: type) -> None:
    picture = render_strokes(_bar(), (24, 32), 0, PAGE).astype(float)
    quality = measure(_clip(picture, kind), _tracks(_bar()))
    assert quality.psnr[0] > 50
    assert quality.error[0] < 0.01


def test_an_empty_page_has_error_1_and_the_psnr_of_the_missing_ink() -> None:
    truth = _true_bar()
    quality = measure(_clip(truth), _tracks(Strokes.empty()))
    assert quality.error[0] == pytest.approx(1.0)
    assert quality.psnr[0] == pytest.approx(-10 * np.log10(np.mean((truth - PAGE) ** 2)), abs=0.05)


def test_ink_where_there_is_none_counts_as_much_as_ink_that_is_missing() -> None:
    shifted = np.roll(_true_bar(), 8, axis=0)
    quality = measure(_clip(shifted), _tracks(_bar()))
    assert quality.error[0] == pytest.approx(np.sqrt(2), rel=0.05)
