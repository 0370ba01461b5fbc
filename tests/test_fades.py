"""Lines whose opacity changes from drawing to drawing."""

from __future__ import annotations

from fractions import Fraction
from functools import partial

import cv2
import numpy as np
import pytest
from numpy.typing import NDArray

from videovec.clip import Clip, Timeline
from videovec.fit import judge
from videovec.initialise import initialise
from videovec.ink import extract_ink
from videovec.opacity import measure_opacity
from videovec.propagate import propagate
from videovec.render import resolve_backend
from videovec.settings import InitialiseSettings, PropagateSettings, RenderSettings

Floats = NDArray[np.float64]

SIZE, WIDTH, COUNT = 128, 7.0, 8
FADING = np.array([[20.0, 40.0], [100.0, 60.0]])
STAYING = np.array([[20.0, 100.0], [110.0, 90.0]])


def draw(lines: list[tuple[Floats, float]]) -> NDArray[np.uint8]:
    """A white page with black lines of some opacity, by supersampling."""
    scale, page = 4, np.ones((SIZE, SIZE))
    for ends, opacity in lines:
        image = np.zeros((SIZE * scale, SIZE * scale), np.uint8)
        at = np.round((ends * scale - 0.5) * 16).astype(np.int32)
        cv2.polylines(image, [at], False, 255, round(WIDTH * scale), cv2.LINE_AA, 4)
        page *= 1 - opacity * cv2.resize(image, (SIZE, SIZE), interpolation=cv2.INTER_AREA) / 255.0
    return np.repeat((255 * page).round().astype(np.uint8)[..., None], 3, axis=2)


def clip_of(drawings: list[NDArray[np.uint8]]) -> Clip:
    times = tuple(Fraction(k, 12) for k in range(len(drawings)))
    numbers = np.arange(1, len(drawings) + 1)
    return Clip("fades", tuple(drawings), Timeline(numbers - 1, times, Fraction(len(drawings), 12), numbers))


def test_a_fading_line_is_one_stroke_whose_opacity_is_what_is_seen() -> None:
    true = np.linspace(1.0, 0.2, COUNT)
    ink = extract_ink(clip_of([draw([(FADING + 2.0 * t, true[t]), (STAYING, 1.0)]) for t in range(COUNT)]))
    assert len(ink.palette) == 1
    trace = partial(initialise, settings=InitialiseSettings())
    carried = propagate(ink, trace(ink.at_drawing(0), 0), PropagateSettings(refine_steps=12), trace).strokes
    strokes = measure_opacity(carried, ink)
    assert strokes.layout.first.tolist() == [0, 0]
    assert strokes.layout.last.tolist() == [COUNT - 1] * 2
    fades = int(np.argmin([strokes.points_of(strokes.row(s, 0))[:, 1].mean() for s in (0, 1)]))
    opacity = strokes.opacity.reshape(2, COUNT)
    np.testing.assert_allclose(opacity[fades], true, atol=0.03)
    np.testing.assert_array_equal(opacity[1 - fades], 1.0)
    assert judge(ink, strokes, resolve_backend(RenderSettings())).psnr.min() > 30.0


@pytest.mark.parametrize("step", [0.0, 12.0])
def test_a_grey_line_under_a_black_one_is_an_ink_of_its_own(step: float) -> None:
    bar = np.array([[30.0, 20.0], [30.0, 120.0]])
    drawings = [draw([(FADING, 0.4), (bar + np.array([step * t, 0.0]), 1.0)]) for t in range(4)]
    ink = extract_ink(clip_of(drawings))
    assert len(ink.palette) == 2
    assert ink.seen is None
