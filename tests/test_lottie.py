"""Lottie documents: against their schema, and as an independent player draws them."""

from __future__ import annotations

import io
import json
import zipfile
from dataclasses import replace
from fractions import Fraction
from pathlib import Path
from typing import Any

import jsonschema
import numpy as np
import pytest
from drawn import coverage, psnr
from PIL import Image
from rlottie_python.rlottie_wrapper import LottieAnimation
from small_tracks import ROUND, SIZE, WAVE, life, tracks_of

from videovec.clip import Timeline
from videovec.settings import ExportSettings
from videovec.tracks import StrokeTracks
from videovec.write.lottie import dotlottie_bytes, lottie_text
from videovec.write.time_base import time_base

Floats = np.typing.NDArray[np.float64]

SCHEMA = json.loads((Path(__file__).parent / "data" / "lottie.schema.json").read_text(encoding="utf-8"))
SETTINGS = ExportSettings()


@pytest.fixture
def tracks() -> StrokeTracks:
    """Tapering, constant and closed strokes, a dot, and a line that is drawn on and then hidden, in ten drawings."""
    count = 10
    lives = [
        life(7, WAVE, [1.5, 3.0, 2.0]),
        life(12, ROUND, [1.5] * 3, is_closed=True),
        life(4, ROUND + np.array([0, 40]), [1.0, 2.0, 1.0], is_closed=True),
        life(3, np.full((4, 2), 80.0), [3, 3]),
        life(9, np.array([[10, 90], [30, 92], [60, 92], [86, 90.0]]), [1, 1], color=np.array([0.8, 0, 0])),
    ]
    rng = np.random.default_rng(0)
    lives = [_repeated(each, count, rng) for each in lives]
    shown = np.array([[0, min(0.1 + 0.1 * k, 1)] for k in range(count)])
    shown[7:9] = 0.6
    lives[-1] = replace(lives[-1], visible=shown)
    lives[0] = replace(lives[0], first=2, **{name: getattr(lives[0], name)[2:8] for name in _ROWS})
    return tracks_of(lives, exposures=(1, 1, 1, 2, 1, 1, 3, 1, 1, 1))


_ROWS = ("points", "half_width", "opacity", "visible")


def _repeated(each: Any, count: int, rng: np.random.Generator) -> Any:
    """The first drawing of a life, moved along a curve."""
    steps = np.cumsum(rng.uniform(-1, 1, (count, 1, 2)), axis=0)
    points = each.points[:1] + steps
    rows = {name: np.repeat(getattr(each, name)[:1], count, axis=0) for name in _ROWS[1:]}
    return replace(each, points=points, **rows)


def played(document: str, frame: int) -> Floats:
    """A frame on white, as rlottie draws it at four times the size. [H, W, 3] in [0, 1]"""
    player = LottieAnimation.from_data(document)
    image = player.render_pillow_frame(frame_num=frame, width=4 * SIZE, height=4 * SIZE)
    page = Image.new("RGBA", image.size, (255, 255, 255, 255))
    page.alpha_composite(image)
    array = np.asarray(page.convert("RGB"), float) / 255
    return np.asarray(array.reshape(SIZE, 4, SIZE, 4, 3).mean((1, 3)))


def layers(document: str) -> dict[str, Any]:
    return {layer["nm"]: layer for layer in json.loads(document)["layers"]}


def every_bezier(document: str) -> list[list[Any]]:
    """The shapes of each path, keyframe by keyframe."""
    found = []
    for layer in json.loads(document)["layers"]:
        for item in layer["shapes"][0]["it"]:
            if item["ty"] == "sh":
                shape = item["ks"]["k"]
                found.append([key["s"][0] for key in shape] if item["ks"]["a"] else [shape])
    return found


def test_the_document_is_valid_lottie(tracks: StrokeTracks) -> None:
    jsonschema.Draft202012Validator(SCHEMA).validate(json.loads(lottie_text(tracks, SETTINGS)))


@pytest.mark.xfail(raises=jsonschema.ValidationError, reason="proves that the schema can refuse")
def test_a_stroke_without_a_width_is_no_lottie(tracks: StrokeTracks) -> None:
    document = json.loads(lottie_text(tracks, SETTINGS))
    line = next(layer for layer in document["layers"] if layer["nm"] == "stroke_0012")
    del line["shapes"][0]["it"][-2]["w"]
    jsonschema.Draft202012Validator(SCHEMA).validate(document)


@pytest.mark.parametrize("frame", range(13))
def test_rlottie_draws_the_ink_of_every_frame(tracks: StrokeTracks, frame: int) -> None:
    document = lottie_text(tracks, replace(SETTINGS, lottie_tolerance=0.02))
    shapes = [shape for shape in tracks.at_frame(frame) if shape.is_visible]
    red = [shape for shape in shapes if shape.id == 9]
    black = [shape for shape in shapes if shape.id != 9]
    image = played(document, frame)
    assert psnr(image[..., 0], (1 - coverage(black, SIZE)) * (1 - 0.2 * coverage(red, SIZE))) > 40
    assert psnr(image[..., 1], 1 - coverage(shapes, SIZE)) > 40


def test_a_tolerance_saves_most_keyframes_of_a_steady_motion() -> None:
    rng = np.random.default_rng(1)
    steady = np.stack([WAVE + np.array([0, 0.8 * k]) + rng.normal(0, 0.05, WAVE.shape) for k in range(24)])
    plain = _repeated(life(1, WAVE, [2.0] * 3), 24, rng)
    tracks = tracks_of([replace(plain, points=steady)], exposures=(1,) * 24)
    exact, loose = (lottie_text(tracks, replace(SETTINGS, lottie_tolerance=each)) for each in (0.0, 0.5))
    assert len(loose) < 0.3 * len(exact)
    assert all(psnr(played(loose, frame), played(exact, frame)) > 30 for frame in (0, 7, 23))


def test_a_layer_lives_as_long_as_its_stroke(tracks: StrokeTracks) -> None:
    document = lottie_text(tracks, SETTINGS)
    named = layers(document)
    assert (named["stroke_0007"]["ip"], named["stroke_0007"]["op"]) == (2, 11)
    assert (named["stroke_0012"]["ip"], named["stroke_0012"]["op"]) == (0, 13)
    assert list(named) == [f"stroke_{k:04d}" for k in (12, 9, 7, 4, 3)]  # the uppermost comes first
    assert {layer["st"] for layer in named.values()} == {0}
    assert {layer["shapes"][0]["it"][-1]["ty"] for layer in named.values()} == {"tr"}
    head = json.loads(document)
    assert (head["fr"], head["ip"], head["op"], head["w"], head["h"]) == (12, 0, 13, SIZE, SIZE)


def test_paths_keep_their_number_of_vertices_and_stay_open_or_closed(tracks: StrokeTracks) -> None:
    for keyframes in every_bezier(lottie_text(tracks, SETTINGS)):
        assert len({len(shape[part]) for shape in keyframes for part in "vio"}) == 1
        assert len({shape["c"] for shape in keyframes}) == 1


def test_a_held_drawing_is_a_hold_keyframe_and_the_rest_have_easing(tracks: StrokeTracks) -> None:
    document = lottie_text(tracks, replace(SETTINGS, lottie_tolerance=0.0))
    keyframes = layers(document)["stroke_0012"]["shapes"][0]["it"][0]["ks"]["k"]
    assert [key["t"] for key in keyframes] == [0, 1, 2, 3, 5, 6, 7, 10, 11, 12]
    assert [key["t"] for key in keyframes if key.get("h")] == [3, 7]
    for key in keyframes[:-1]:
        assert key.get("h") or (key["o"], key["i"]) == ({"x": 0, "y": 0}, {"x": 1, "y": 1})
    assert "i" not in keyframes[-1]
    smooth = lottie_text(tracks, replace(SETTINGS, lottie_tolerance=0.0, lottie_smooth=True))
    assert not any(key.get("h") for key in layers(smooth)["stroke_0012"]["shapes"][0]["it"][0]["ks"]["k"])


def test_a_stroke_that_is_drawn_on_is_trimmed_and_one_that_is_hidden_has_no_opacity(tracks: StrokeTracks) -> None:
    items = {item["ty"]: item for item in layers(lottie_text(tracks, SETTINGS))["stroke_0009"]["shapes"][0]["it"]}
    ends = {key["t"]: key["s"][0] for key in items["tm"]["e"]["k"]}
    assert ends[0] == 10
    assert set(items["tm"]["s"]) == {"a", "k"}
    opacity = [(key["t"], key["s"][0], key.get("h")) for key in items["st"]["o"]["k"]]
    assert opacity == [(0, 100, 1), (10, 0, 1), (12, 100, None)]


def test_exact_rates_survive_and_uneven_times_get_a_common_clock() -> None:
    def clock(times: list[Fraction], end: Fraction) -> tuple[Fraction, list[int]]:
        shown = np.arange(len(times))
        base = time_base(Timeline(shown, tuple(times), end, shown + 1))
        return base.rate, base.frame_ticks.tolist()

    ntsc = Fraction(1001, 30000)
    assert clock([k * ntsc for k in range(3)], 3 * ntsc) == (1 / ntsc, [0, 1, 2, 3])
    gif = [Fraction(k, 100) for k in (0, 10, 14, 24)]
    assert clock(gif, Fraction(30, 100)) == (Fraction(50), [0, 5, 7, 12, 15])
    odd = [Fraction(0), Fraction(1, 997), Fraction(1, 3)]
    assert clock(odd, Fraction(1)) == (Fraction(1000), [0, 1, 333, 1000])
    assert clock([Fraction(0)], Fraction(0)) == (Fraction(1), [0, 1])


def test_a_frame_rate_of_television_is_written_exactly() -> None:
    ntsc = Fraction(1001, 30000)
    tracks = tracks_of([life(1, WAVE, [1.0] * 3)])
    slower = replace(tracks.timeline, times=tuple(k * ntsc for k in range(3)), duration=3 * ntsc)
    document = json.loads(lottie_text(replace(tracks, timeline=slower), SETTINGS))
    assert document["fr"] == pytest.approx(30000 / 1001, abs=1e-9)


def test_a_dark_page_lies_under_everything(tracks: StrokeTracks) -> None:
    document = lottie_text(replace(tracks, page=np.array([0.0, 0.2, 0.0])), SETTINGS)
    assert json.loads(document)["layers"][-1]["nm"] == "page"
    np.testing.assert_allclose(played(document, 0)[0, -1], [0, 0.2, 0], atol=0.01)


def test_the_archive_holds_the_document_and_is_the_same_each_time(tracks: StrokeTracks) -> None:
    document = lottie_text(tracks, SETTINGS)
    packed = dotlottie_bytes(document)
    assert packed == dotlottie_bytes(document)
    with zipfile.ZipFile(io.BytesIO(packed)) as archive:
        manifest = json.loads(archive.read("manifest.json"))
        (animation,) = manifest["animations"]
        assert archive.read(f"animations/{animation['id']}.json").decode() == document


def test_no_strokes_are_a_document_too(tracks: StrokeTracks) -> None:
    document = lottie_text(tracks.drop(3, 4, 7, 9, 12), SETTINGS)
    jsonschema.Draft202012Validator(SCHEMA).validate(json.loads(document))
    assert json.loads(document)["layers"] == []
