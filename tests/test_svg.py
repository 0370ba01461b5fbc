"""SVG frames: what drawing programs and independent rasterisers find in them."""

from __future__ import annotations

import io
import re
import xml.etree.ElementTree as ET
from dataclasses import replace

import numpy as np
import pytest
from drawn import by_skia, coverage, psnr, resvg
from small_tracks import ROUND, SIZE, WAVE, life, tracks_of
from svgelements import SVG, Path

from videovec.errors import ConfigError
from videovec.tracks import StrokeTracks
from videovec.write.svg import SVG_STYLES, path_data, svg_frame, svg_frames

Floats = np.typing.NDArray[np.float64]

NAME = "{http://www.w3.org/2000/svg}"
INKSCAPE = "{http://www.inkscape.org/namespaces/inkscape}"


def paths(document: str) -> list[ET.Element]:
    return list(ET.parse(io.StringIO(document)).getroot().iter(f"{NAME}path"))


@pytest.fixture
def tracks() -> StrokeTracks:
    """A tapering stroke that loses its second half, a ring of constant width above it, and a dot."""
    return tracks_of(
        [
            life(7, WAVE, [1.5, 3.0, 2.0], visible=np.array([[0, 1], [0, 0.5]])),
            life(12, ROUND, [1.5] * 3, is_closed=True),
            life(3, np.full((4, 2), 80.0), [3, 3]),
        ]
    )


@pytest.mark.parametrize("style", SVG_STYLES)
def test_every_frame_is_the_page_and_a_path_for_each_stroke(tracks: StrokeTracks, style: str) -> None:
    documents = list(svg_frames(tracks, style))
    assert len(documents) == 3
    assert documents[1] == documents[2] != documents[0]
    for document in documents:
        root = ET.fromstring(document.encode())
        assert (root.get("width"), root.get("height"), root.get("viewBox")) == ("96", "96", "0 0 96 96")
        (layer,) = root.findall(f"{NAME}g")
        assert layer.get("id") == layer.get(f"{INKSCAPE}label") == "lines"
        assert layer.get(f"{INKSCAPE}groupmode") == "layer"
        assert [path.get("id") for path in layer] == ["stroke-0003", "stroke-0007", "stroke-0012"]
        assert [path.get("data-stroke-id") for path in layer] == ["3", "7", "12"]
        assert not re.search(r"transform|clip|style=|<style|class=", document)
        assert set(re.findall("[A-Za-z]", "".join(str(path.get("d")) for path in layer))) <= set("MCZ")


@pytest.mark.parametrize("frame", [0, 1])
@pytest.mark.parametrize("style", ["outline", "powerstroke", "auto"])
def test_an_independent_rasteriser_draws_the_ink_of_the_strokes(tracks: StrokeTracks, style: str, frame: int) -> None:
    document = svg_frame(tracks, frame, style)
    truth = 1 - coverage(tracks.at_frame(frame), SIZE)
    assert psnr(resvg(document, 4), truth) > 44
    assert psnr(by_skia(document, (SIZE, SIZE), 8), truth) > 44


def test_a_centre_line_draws_strokes_of_constant_width() -> None:
    tracks = tracks_of([life(1, WAVE, [2.0] * 3), life(2, ROUND, [1.0] * 3, is_closed=True)])
    document = svg_frame(tracks, 1, "stroke")
    assert psnr(resvg(document, 4), 1 - coverage(tracks.at_frame(1), SIZE)) > 44
    assert {path.get("stroke-linecap") for path in paths(document)} == {"round"}
    assert {path.get("stroke-linejoin") for path in paths(document)} == {"round"}


def test_auto_draws_a_line_where_that_is_within_a_quarter_pixel_of_nearly_all_edges() -> None:
    thickens = life(2, WAVE, [2.0] * 3)
    thickens = replace(thickens, half_width=np.array([[2.0, 2, 2], [2.0, 3, 2]]))
    many = np.concatenate([WAVE[:1], np.repeat(np.linspace(12, 80, 30), 3)[:, None] + np.array([0, 3])])
    odd = life(4, many, [2.0] * 30 + [2.9])
    tracks = tracks_of([life(1, WAVE, [2.0, 2.3, 2.0]), thickens, life(3, WAVE, [2.0, 2.8, 2.0]), odd])
    kinds = [path.get("fill") == "none" for path in paths(svg_frame(tracks, 0))]
    assert kinds == [True, False, False, True]


def test_what_is_hidden_is_not_drawn_and_half_a_stroke_ends_where_it_is_hidden() -> None:
    hidden = life(1, WAVE, [2.0] * 3, visible=np.array([[0.4, 0.4], [0, 1]]))
    clear = life(2, WAVE, [2.0] * 3, opacity=np.array([0.0, 0.25]))
    tracks = tracks_of([hidden, clear])
    assert paths(svg_frame(tracks, 0)) == []
    assert [path.get("stroke-opacity") for path in paths(svg_frame(tracks, 1))] == [None, "0.25"]
    line = np.array([[10, 48], [30, 48], [60, 48], [90, 48.0]])
    (path,) = paths(svg_frame(tracks_of([life(3, line, [2, 2], visible=np.array([[0.25, 0.5]] * 2))]), 0))
    box = Path(path.get("d")).bbox()
    assert box == pytest.approx((30, 48, 50, 48), abs=2e-3)


def test_a_dot_is_drawn_by_every_style() -> None:
    tracks = tracks_of([life(1, np.full((4, 2), 48.0), [5, 5])])
    for style in SVG_STYLES:
        ink = 1 - resvg(svg_frame(tracks, 0, style), 4)
        assert ink.sum() == pytest.approx(np.pi * 25, rel=0.01)


def test_a_page_that_is_not_white_lies_under_the_strokes() -> None:
    dark = replace(tracks_of([life(1, WAVE, [2.0] * 3, color=np.ones(3))]), page=np.array([0.1, 0.2, 0.1]))
    root = ET.fromstring(svg_frame(dark, 0).encode())
    (page,) = root.findall(f"{NAME}rect")
    assert page.get("id") == "page"
    assert page.get("fill") == "#1a331a"
    image = resvg(svg_frame(dark, 0))
    assert image[0, 0] < 0.2
    assert image.max() > 0.95
    assert not ET.fromstring(svg_frame(replace(dark, page=np.ones(3)), 0).encode()).findall(f"{NAME}rect")


def test_a_powerstroke_remembers_its_centre_line_and_half_widths(tracks: StrokeTracks) -> None:
    document = svg_frame(tracks, 0, "powerstroke")
    tapered = next(path for path in paths(document) if path.get("id") == "stroke-0007")
    original = np.array([[float(x), float(y)] for x, y in re.findall(r"([\d.]+),([\d.]+)", _attribute(tapered))])
    np.testing.assert_allclose(original, WAVE, atol=1e-3)
    effects = {effect.get("id"): effect for effect in ET.fromstring(document.encode()).iter(f"{INKSCAPE}path-effect")}
    effect = effects[str(tapered.get(f"{INKSCAPE}path-effect")).removeprefix("#")]
    assert effect.get("offset_points") == "0,1.5 | 1,3 | 2,2"
    assert effect.get("effect") == "powerstroke"
    dot = next(path for path in paths(document) if path.get("id") == "stroke-0003")
    assert dot.get(f"{INKSCAPE}path-effect") is None  # Inkscape would make nothing of it


def test_a_stroke_has_the_same_number_of_points_in_every_frame() -> None:
    bends = life(1, WAVE, [1.0, 3.0, 1.0])
    bends = replace(bends, points=np.stack([WAVE, WAVE[:, ::-1] * [1, 0.3]]))
    documents = svg_frames(tracks_of([bends]), "outline")
    assert len({len(re.findall("C", str(paths(document)[0].get("d")))) for document in documents}) == 1


def test_svgelements_reads_our_coordinates_back(tracks: StrokeTracks) -> None:
    read = SVG.parse(io.StringIO(svg_frame(tracks, 1, "stroke")))
    ring = next(element for element in read.elements() if getattr(element, "id", None) == "stroke-0012")
    assert ring.bbox() == pytest.approx((37.5, 24, 58.5, 44), abs=0.01)


def test_numbers_are_short() -> None:
    assert path_data(np.array([[1, -0.0001], [1 / 3, 2.5], [100, 1e-9], [12.34567, -7]])) == (
        "M 1,0 C 0.333,2.5 100,0 12.346,-7"
    )


def test_an_unknown_style_is_refused(tracks: StrokeTracks) -> None:
    with pytest.raises(ConfigError, match="must be one of auto, stroke, outline, powerstroke, got 'brush'"):
        svg_frame(tracks, 0, "brush")


def test_a_frame_without_strokes_is_an_empty_page() -> None:
    nothing = replace(tracks_of([life(1, WAVE, [1.0] * 3)]).drop(1))
    assert resvg(svg_frame(nothing, 0)).min() == 1


def _attribute(element: ET.Element) -> str:
    return str(element.get(f"{INKSCAPE}original-d"))
