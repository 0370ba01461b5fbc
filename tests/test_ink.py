"""Page and ink: coverage of lines whose coverage is known in closed form."""

from __future__ import annotations

import io
import json
from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray
from PIL import Image

from videovec.clip import Clip, Timeline
from videovec.decode import decode
from videovec.errors import InputError
from videovec.ink import Ink, extract_ink, ink_alone
from videovec.settings import InkSettings

Floats = NDArray[np.float64]
Pixels = NDArray[np.uint8]
Color = tuple[int, int, int]

SIZE = (120, 160)
WHITE: Color = (255, 255, 255)
BLACK: Color = (0, 0, 0)


def line_coverage(start: float, width: float, slope: float = 0.12) -> Floats:
    """Area coverage of an upright, slanted line, exact along each row. [H, W]"""
    y, x = np.mgrid[0 : SIZE[0], 0 : SIZE[1]]
    left = start + slope * (y - 60) - width / 2
    across: Floats = np.clip(np.minimum(x + 1, left + width) - np.maximum(x, left), 0, 1)
    across[:10] = across[-10:] = 0
    return across


def mix(inks: list[tuple[Floats, Color]], page: Color = WHITE) -> Floats:
    """Inks laid side by side on a page. [H, W, 3]"""
    image = np.full((*SIZE, 3), page, dtype=np.float64)
    for coverage, color in inks:
        image += coverage[..., None] * (np.array(color, float) - np.array(page, float))
    return image


def three(width: float, color: Color = BLACK) -> tuple[Floats, list[tuple[Floats, Color]]]:
    """Three lines of one ink: their coverage, and what ``mix`` takes."""
    coverage = line_coverage(30, width) + line_coverage(80, width, -0.3) + line_coverage(130, width, 0.05)
    return coverage, [(coverage, color)]


def as_clip(*images: Floats | Pixels | NDArray[np.uint16]) -> Clip:
    """A clip with one drawing for each image, rounded to 8 bits if it holds floats."""
    drawings = tuple(
        np.clip(np.rint(image), 0, 255).astype(np.uint8) if image.dtype.kind == "f" else image for image in images
    )
    count = len(drawings)
    timeline = Timeline(
        np.arange(count), tuple(Fraction(k, 24) for k in range(count)), Fraction(count, 24), np.arange(1, count + 1)
    )
    return Clip("test", drawings, timeline)  # type: ignore[arg-type]


def error(ink: Ink, coverage: Floats, drawing: int = 0) -> float:
    """Root mean square difference of coverage."""
    return float(np.sqrt(np.mean((ink.coverage[drawing] / 255 - coverage) ** 2)))


def levels(ink: Ink) -> list[list[int]]:
    return np.rint(ink.palette * 255).astype(int).tolist()  # type: ignore[no-any-return]


@pytest.mark.parametrize("width", [0.2, 0.3, 0.5, 1.0, 1.5, 2.0, 3.0, 9.0])
def test_black_on_white_is_255_less_grey_at_any_width(width: float) -> None:
    coverage, inks = three(width)
    clip = as_clip(mix(inks))
    ink = extract_ink(clip)
    assert np.array_equal(ink.coverage[0], 255 - clip.drawings[0][..., 0])
    assert levels(ink) == [[0, 0, 0]]
    assert ink.page.tolist() == [1.0, 1.0, 1.0]
    assert ink.noise == 0
    assert ink.coverage.max() == pytest.approx(255 * min(1.0, coverage.max()), abs=1)


def test_a_hairline_on_the_border_of_two_rows_is_not_taken_for_grey() -> None:
    image = np.full((*SIZE, 3), 255.0)
    image[59:61, 20:140] = 255 * 0.75
    image[20:100, 79:81] = 255 * 0.75
    ink = extract_ink(as_clip(image))
    assert levels(ink) == [[0, 0, 0]]
    assert ink.coverage.max() <= 65


@pytest.mark.parametrize("color", [(200, 200, 200), (128, 128, 128), (250, 220, 60), (255, 150, 150)])
@pytest.mark.parametrize("width", [2.0, 3.0, 6.0])
def test_light_inks_reach_full_coverage(color: Color, width: float) -> None:
    coverage, inks = three(width, color)
    ink = extract_ink(as_clip(mix(inks)))
    assert levels(ink) == [list(color)]
    assert error(ink, coverage) < 0.01


def test_sixteen_bits_give_the_same_coverage() -> None:
    coverage, inks = three(3.0)
    ink = extract_ink(as_clip(np.rint(mix(inks) * 257).astype(np.uint16)))
    assert error(ink, coverage) < 0.003


@pytest.mark.parametrize(
    "colors",
    [
        [(230, 40, 40), (40, 60, 200), BLACK],
        [BLACK, (150, 150, 150)],
        [(20, 20, 60), (10, 160, 140)],
        [(240, 220, 40), (30, 150, 60), (255, 130, 0)],
    ],
)
@pytest.mark.parametrize("width", [2.0, 3.0, 5.0])
def test_every_ink_is_told_apart_and_edges_make_none(colors: list[Color], width: float) -> None:
    parts = [line_coverage(30 + 45 * k, width, 0.12 + 0.1 * k) for k in range(len(colors))]
    ink = extract_ink(as_clip(mix(list(zip(parts, colors, strict=True)))))
    assert sorted(levels(ink)) == sorted(list(color) for color in colors)
    assert error(ink, sum(parts, np.zeros(SIZE))) < 0.01
    for part, color in zip(parts, colors, strict=True):
        label = ink.label[0][part > 0.1]
        assert np.mean(label == levels(ink).index(list(color))) > 0.99


def test_one_palette_serves_the_whole_clip() -> None:
    red, blue = line_coverage(40, 3.0), line_coverage(100, 3.0)
    first, second = mix([(red, (220, 40, 40))]), mix([(blue, (40, 60, 200))])
    ink = extract_ink(as_clip(first, second))
    assert sorted(levels(ink)) == [[40, 60, 200], [220, 40, 40]]
    assert error(ink, red, 0) < 0.005
    assert error(ink, blue, 1) < 0.005
    alone = ink.at_drawing(1)
    assert alone.drawing_count == 1
    assert alone.size == SIZE
    assert levels(alone)[int(alone.label[0][blue > 0.5][0])] == [40, 60, 200]


def test_a_drawing_without_ink_has_none_in_a_clip_that_has_some() -> None:
    coverage, inks = three(3.0)
    blank = mix([])
    ink = extract_ink(as_clip(blank, mix(inks), blank))
    assert ink.coverage[0].max() == ink.coverage[2].max() == 0
    assert error(ink, coverage, 1) < 0.003


@pytest.mark.parametrize("page", [(20, 24, 22), (0, 0, 0), (40, 70, 55)])
@pytest.mark.parametrize("width", [0.5, 3.0])
def test_chalk_on_a_dark_board_is_ink(page: Color, width: float) -> None:
    coverage, inks = three(width, WHITE)
    ink = extract_ink(as_clip(mix(inks, page)))
    assert np.allclose(ink.palette, 1, atol=0.01)
    assert np.rint(ink.page * 255).tolist() == list(page)
    assert error(ink, coverage) < 0.005


def shading(kind: str) -> Floats:
    """Brightness of unevenly lit paper. [H, W, 1]"""
    y, x = np.mgrid[0 : SIZE[0], 0 : SIZE[1]]
    x, y = x / SIZE[1] - 0.5, y / SIZE[0] - 0.5
    light = {
        "gradient": 1 - 0.3 * (x + 0.5),
        "vignette": 1 - 0.6 * (x**2 + y**2),
        "both": (1 - 0.25 * (y + 0.5)) * (1 - 0.5 * (x**2 + y**2)),
    }
    brightness: Floats = light[kind][..., None]
    return brightness


@pytest.mark.parametrize("kind", ["gradient", "vignette", "both"])
@pytest.mark.parametrize("noise", [0.0, 3.0])
def test_uneven_warm_paper_is_flattened(kind: str, noise: float) -> None:
    coverage, inks = three(3.0, (30, 30, 40))
    grain = np.random.default_rng(5).normal(0, noise, (*SIZE, 1))
    ink = extract_ink(as_clip(mix(inks, (246, 240, 224)) * shading(kind) + grain))
    assert len(ink.palette) == 1
    assert error(ink, coverage) < 0.004 + noise / 255
    assert np.mean(ink.coverage[0][coverage == 0]) < 0.5


def test_flattening_can_be_left_off() -> None:
    coverage, inks = three(3.0)
    clip = as_clip(mix(inks) * shading("gradient"))
    assert error(extract_ink(clip, InkSettings(flatten=True)), coverage) < 0.003
    assert error(extract_ink(clip, InkSettings(flatten=False)), coverage) > 0.01


@pytest.mark.parametrize("sigma", [2.0, 6.0, 12.0])
@pytest.mark.parametrize("width", [0.5, 1.0, 3.0])
def test_grain_is_no_ink_and_thin_lines_survive_it(sigma: float, width: float) -> None:
    coverage, inks = three(width)
    noisy = mix(inks, (240, 240, 240)) + np.random.default_rng(7).normal(0, sigma, (*SIZE, 1))
    ink = extract_ink(as_clip(noisy))
    away = line_coverage(30, 12) + line_coverage(80, 12, -0.3) + line_coverage(130, 12, 0.05) == 0
    away[:16] = away[-16:] = False
    assert np.mean(ink.coverage[0][away] > 0) < 0.002
    assert np.mean(ink.coverage[0][coverage > 0.4] > 0) > 0.99
    assert ink.noise == pytest.approx(sigma / 240, rel=0.3)
    assert len(ink.palette) == 1


@pytest.mark.parametrize("quality", [30, 50, 75, 90])
def test_jpeg_ringing_is_no_ink_and_its_chroma_makes_none(quality: int) -> None:
    colors: list[Color] = [BLACK, (220, 40, 40)]
    parts = [line_coverage(45, 4.0), line_coverage(110, 4.0, -0.2)]
    buffer = io.BytesIO()
    exact = np.clip(np.rint(mix(list(zip(parts, colors, strict=True)))), 0, 255).astype(np.uint8)
    Image.fromarray(exact).save(buffer, "JPEG", quality=quality)
    ink = extract_ink(as_clip(np.asarray(Image.open(buffer).convert("RGB"))))
    assert len(ink.palette) == 2
    total = parts[0] + parts[1]
    assert error(ink, total) < 0.04
    assert ink.coverage[0][total > 0.99].mean() > 0.95 * 255
    assert ink.coverage[0][total == 0].mean() < 0.02 * 255


def test_colour_at_half_resolution_does_not_widen_lines() -> None:
    coverage, inks = three(4.0, (230, 80, 70))
    exact = np.clip(np.rint(mix(inks)), 0, 255).astype(np.uint8)
    luma, blue, red = (np.asarray(channel) for channel in Image.fromarray(exact).convert("YCbCr").split())
    halved = [
        np.asarray(Image.fromarray(channel).resize((80, 60), Image.Resampling.BOX).resize((160, 120)))
        for channel in (blue, red)
    ]
    planes = [Image.fromarray(plane) for plane in (luma, *halved)]
    ink = extract_ink(as_clip(np.asarray(Image.merge("YCbCr", planes).convert("RGB"))))
    assert len(ink.palette) == 1
    assert error(ink, coverage) < 0.02


@pytest.mark.parametrize("name", ["robot.mp4", "ball.gif", "cat", "snail.png"])
def test_our_samples_have_the_inks_that_they_were_drawn_with(name: str) -> None:
    samples = Path(__file__).parent.parent / "samples"
    truth = json.loads((samples / "truth" / f"{name.split('.')[0]}.json").read_text())
    inks = np.array(sorted({tuple(stroke["color"]) for stroke in truth["strokes"]}))
    ink = extract_ink(decode(samples / name))
    assert len(ink.palette) == len(inks)
    distance = np.linalg.norm(ink.palette[:, None] * 255 - inks[None], axis=2)
    assert sorted(distance.argmin(axis=1).tolist()) == list(range(len(inks)))
    assert distance.min(axis=1).max() < 25


def test_lossless_art_without_noise_keeps_its_faintest_fringe() -> None:
    _, inks = three(1.0)
    image = np.rint(mix(inks))
    image[60, 5] = 254
    assert extract_ink(as_clip(image)).coverage[0][60, 5] == 1


@pytest.mark.parametrize("color", [WHITE, (240, 236, 220), (12, 12, 12)])
def test_a_blank_page_is_an_error_that_names_the_clip(color: Color) -> None:
    with pytest.raises(InputError, match="test: must show lines"):
        extract_ink(as_clip(mix([], color)))


def test_paper_grain_alone_is_a_blank_page() -> None:
    grain = np.random.default_rng(2).normal(0, 2.0, (*SIZE, 1))
    with pytest.raises(InputError, match="test: must show lines"):
        extract_ink(as_clip(mix([], (240, 240, 240)) + grain))


def test_an_ink_alone_runs_on_under_another_that_crosses_it_and_ends_where_it_ends() -> None:
    label = np.zeros((1, 60, 60), np.uint8)
    coverage = np.zeros((1, 60, 60), np.uint8)
    coverage[0, 28:32, 5:50] = 255  # a line of ink 0 that ends on a stem of ink 1, and is crossed by another
    coverage[0, 5:55, 20:24] = coverage[0, 5:55, 50:54] = 255
    label[0, 5:55, 20:24] = label[0, 5:55, 50:54] = 1
    ink = Ink(coverage, label, np.eye(3)[:2], np.ones(3), 0.0)
    alone = ink_alone(ink, 0).coverage[0]
    assert (alone[29:31, 5:50] == 255).all()
    assert not alone[:, 50:].any()
    assert not alone[:26].any()
    assert not alone[34:].any()
