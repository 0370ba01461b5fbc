"""Brush files read back: by Pillow, and by parsers of the formats written for these tests alone."""

from __future__ import annotations

import ast
import json
import re
import struct
import xml.etree.ElementTree as ET
from pathlib import Path

import numpy as np
import pytest
from PIL import Image
from scipy.ndimage import gaussian_filter, map_coordinates

from videovec.brush import Brush, BrushModel, Brushwork, Laying, apply_brush, export_brush, load_brush, solid_strokes
from videovec.brush.apply import mean_ink
from videovec.brush.export_gimp import CELL, dab_cells
from videovec.errors import FitError, InputError
from videovec.strokes import Strokes


@pytest.fixture
def brush() -> Brush:
    field = gaussian_filter(np.random.default_rng(0).normal(size=(96, 24)), (2, 1), mode=("wrap", "nearest"))
    v = np.abs((np.arange(24) + 0.5) / 24 * 2 - 1) * 1.3
    ink = np.clip(0.6 + 0.25 * field / field.std(), 0, 1) * np.clip((1.1 - v) / 0.2, 0, 1)
    return Brush("rubbed", BrushModel.TEXTURE, ink, 9.5, 8.0)


def test_a_brush_read_back_is_the_brush(brush: Brush, tmp_path: Path) -> None:
    export_brush(brush, tmp_path)
    for place in (tmp_path, tmp_path / "rubbed.json"):
        again = load_brush(place)
        assert (again.name, again.model, again.width, again.repeat) == ("rubbed", BrushModel.TEXTURE, 9.5, 8.0)
        assert np.abs(again.strip - brush.strip).max() < 1e-5


def test_the_strip_is_a_16_bit_image_with_columns_along_the_stroke(brush: Brush, tmp_path: Path) -> None:
    export_brush(brush, tmp_path)
    with Image.open(tmp_path / "rubbed.png") as image:
        assert image.size == (96, 24)
        assert np.asarray(image).max() > 255
        assert np.asarray(image)[5, 40] == round(brush.strip[40, 5] * 65535)


def test_pillow_reads_the_gimp_tip(brush: Brush, tmp_path: Path) -> None:
    export_brush(brush, tmp_path)
    with Image.open(tmp_path / "rubbed.gbr") as image:
        assert image.size == (CELL, CELL)
        assert image.info["spacing"] == 20
        assert image.info["comment"].startswith(b"rubbed")
        assert np.abs(np.asarray(image) / 255 - dab_cells(brush)[0]).max() < 0.003


def test_the_pipe_holds_as_many_tips_as_it_says(brush: Brush, tmp_path: Path) -> None:
    export_brush(brush, tmp_path)
    data = (tmp_path / "rubbed.gih").read_bytes()
    title, rest = data.split(b"\n", 1)
    head, body = rest.split(b"\n", 1)
    assert title == b"rubbed"
    said = dict(pair.split(b":") for pair in head.split()[1:])
    count = 0
    while body:
        size, version, width, height, depth = struct.unpack(">5I", body[:20])
        assert (version, width, height, depth, body[20:24]) == (2, CELL, CELL, 1, b"GIMP")
        body = body[size + width * height :]
        count += 1
    assert count == int(said[b"ncells"]) == int(head.split()[0]) == 32


def test_dabs_laid_over_one_another_are_the_strip(brush: Brush) -> None:
    cells = dab_cells(brush)
    page = np.ones((CELL, 16 * len(cells)))
    for k, cell in enumerate(cells):
        page[:, (16 * k + np.arange(CELL) - CELL // 2) % page.shape[1]] *= 1 - cell
    u = (np.arange(page.shape[1]) + 0.5) / 64 * 12 - 0.5
    v = ((np.arange(CELL) + 0.5) / CELL * 2 - 1) * 1.25
    rows = (v / 1.3 + 1) * 12 - 0.5
    wanted = map_coordinates(np.pad(brush.strip, ((1, 1), (0, 0)), mode="wrap"), np.meshgrid(u + 1, rows), order=1)
    assert np.abs(1 - page - wanted).max() < 0.01


def test_the_krita_preset_is_a_picture_that_names_its_tip(brush: Brush, tmp_path: Path) -> None:
    export_brush(brush, tmp_path)
    with Image.open(tmp_path / "rubbed.kpp") as image:
        image.load()
        assert image.format == "PNG"
        assert image.info["version"] == "2.2"
        preset = ET.fromstring(image.info["preset"])
    assert preset.attrib == {"paintopid": "paintbrush", "name": "rubbed"}
    params = {param.attrib["name"]: param.text or "" for param in preset}
    tip = ET.fromstring(params["brush_definition"])
    assert tip.attrib["filename"] == params["requiredBrushFile"] == "rubbed.gih"
    assert (tmp_path / tip.attrib["filename"]).exists()


def test_the_blender_script_is_python_and_names_its_picture(brush: Brush, tmp_path: Path) -> None:
    export_brush(brush, tmp_path)
    source = (tmp_path / "rubbed_blender.py").read_text()
    ast.parse(source)
    named = re.findall(r"'(\w+\.png)'", source)
    assert named == ["rubbed_blender.png"]
    with Image.open(tmp_path / named[0]) as image:
        assert image.mode == "RGBA"
        assert np.abs(np.asarray(image)[..., 3].T / 255 - brush.strip).max() < 0.003


@pytest.mark.parametrize("content", ["{}", "not json", json.dumps({"version": 99})])
def test_what_is_no_brush_is_refused(tmp_path: Path, content: str) -> None:
    (tmp_path / "x.json").write_text(content)
    with pytest.raises(InputError, match=r"x\.json"):
        load_brush(tmp_path / "x.json")


def test_a_folder_without_a_brush_is_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="one brush"):
        load_brush(tmp_path)


def test_a_brush_must_have_a_strip_and_a_width(brush: Brush) -> None:
    with pytest.raises(FitError, match="strip"):
        Brush("x", BrushModel.GRAIN, np.zeros(5), 1.0, 1.0)
    with pytest.raises(FitError, match="positive"):
        Brush("x", BrushModel.GRAIN, brush.strip, 0.0, 1.0)


def test_applying_draws_in_the_strokes_colours_on_the_page() -> None:
    solid = Brush("solid", BrushModel.PROFILE, np.full((1, 24), 1.0), 8.0, 1.0)
    across = np.stack([np.linspace(5, 45, 4), np.full(4, 25.0)], axis=1)
    down = across[:, ::-1]
    strokes = Strokes.concatenate(
        [
            Strokes.from_curves([across], [np.full(2, 4.0)], color=(1, 0, 0)),
            Strokes.from_curves([down], [np.full(2, 4.0)], color=(0, 0, 1), first_id=2),
        ]
    )
    strokes = Strokes(
        strokes.ids, strokes.layout, strokes.is_closed, np.array([0, 1]), strokes.color, strokes.points,
        strokes.half_width, strokes.opacity, strokes.visible,
    )  # fmt: skip
    picture = apply_brush(solid, strokes, (50, 50), page=(0.2, 0.3, 0.4))
    assert picture[2, 2] == pytest.approx([0.2, 0.3, 0.4])
    assert picture[25, 12] == pytest.approx([1, 0, 0], abs=0.01)
    assert picture[25, 25] == pytest.approx([0, 0, 1], abs=0.01)


def test_the_same_seed_draws_the_same_and_another_does_not(brush: Brush) -> None:
    curve = np.stack([np.linspace(5, 95, 4), np.full(4, 25.0)], axis=1)
    strokes = Strokes.from_curves([curve], [np.full(2, 5.0)])
    first, same, other = (apply_brush(brush, strokes, (50, 100), seed=seed) for seed in (1, 1, 2))
    assert np.array_equal(first, same)
    assert np.abs(first - other).max() > 0.1


def test_solid_strokes_hold_as_much_ink_as_textured_ones(brush: Brush) -> None:
    curve = np.stack([np.linspace(10, 190, 4), np.full(4, 25.0)], axis=1)
    strokes = Strokes.from_curves([curve], [np.full(2, 5.0)])
    laying = Laying(np.ones(1), np.zeros(2), np.array([0.5, 0.9]), np.zeros(2))
    textured = (1 - apply_brush(brush, strokes, (50, 200), laying)[..., 0]).sum()
    plain = solid_strokes(Brushwork((brush,), np.zeros(1, np.intp), laying), strokes)
    assert plain.opacity[0] * 180 * 10 == pytest.approx(textured, rel=0.12)
    assert 0 < mean_ink(brush) < 1
