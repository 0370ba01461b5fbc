"""Brushes are used from the command line: on an artist's SVG, and on frames of a run."""

from __future__ import annotations

import io
from fractions import Fraction
from pathlib import Path

import imageio.v3 as iio
import numpy as np
import pytest
from typer.testing import CliRunner

from videovec.brush import Brush, BrushModel, export_brush
from videovec.cli import app
from videovec.clip import Timeline
from videovec.errors import InputError
from videovec.painting import paint
from videovec.run_folder import RunFolder, RunRecord
from videovec.strokes import Strokes
from videovec.tracks import StrokeTracks

SVG = (
    '<svg xmlns="http://www.w3.org/2000/svg" width="48" height="32">'
    '<path d="M8 16 H40" stroke="black" stroke-width="8" fill="none"/></svg>'
)


@pytest.fixture
def brush(tmp_path: Path) -> Path:
    """A brush of full ink on its left half and none on its right half."""
    strip = np.repeat(np.repeat([[1.0, 0.0]], 12, axis=1), 8, axis=0)
    export_brush(Brush("half", BrushModel.PROFILE, strip, 8.0, 1.0), tmp_path / "brush")
    return tmp_path / "brush"


def test_an_svg_is_painted_at_its_own_size_with_ink_where_the_brush_has_it(tmp_path: Path, brush: Path) -> None:
    (tmp_path / "line.svg").write_text(SVG)
    picture = iio.imread(io.BytesIO(paint(brush, tmp_path / "line.svg")))
    assert picture.shape == (32, 48, 3)
    above, below = picture[13:15, 12:36].mean(), picture[17:19, 12:36].mean()
    assert abs(above - below) > 200
    assert (picture[:8] == 255).all()


def test_a_frame_of_a_run_is_painted_on_its_page(tmp_path: Path, brush: Path) -> None:
    strokes = Strokes.from_curves([np.linspace([8.0, 16.0], [40.0, 16.0], 4)], [np.full(2, 4.0)])
    timeline = Timeline(np.array([0]), (Fraction(0),), Fraction(1), np.array([5]))
    page = np.array([1.0, 1.0, 0.0])
    tracks = StrokeTracks("line", (32, 48), page, timeline, strokes, (), np.zeros(1), np.ones(1))
    folder = tmp_path / "line_videovec"
    tracks.save(folder / "tracks.npz")
    RunFolder(folder).write_record(RunRecord("done", "line.png", (None, None, None), {}, "", "", {}, {}))
    picture = iio.imread(io.BytesIO(paint(brush, folder, frame=5)))
    assert picture[2, 2].tolist() == [255, 255, 0]
    assert picture[12:20, 24].min() < 50
    with pytest.raises(InputError, match=r"frame must be one of 5\.\.5, got 1"):
        paint(brush, folder)


def test_the_commands_write_what_they_name(tmp_path: Path, brush: Path) -> None:
    (tmp_path / "line.svg").write_text(SVG)
    picture = tmp_path / "out.png"
    applied = CliRunner().invoke(app, ["brush", "apply", str(brush), str(tmp_path / "line.svg"), "-o", str(picture)])
    assert applied.exit_code == 0, applied.output
    assert iio.imread(picture).shape == (32, 48, 3)
    exported = CliRunner().invoke(app, ["brush", "export", str(brush), "-o", str(tmp_path / "copy")])
    assert exported.exit_code == 0, exported.output
    assert {path.suffix for path in (tmp_path / "copy").iterdir()} >= {".png", ".json", ".gih", ".gbr", ".kpp"}


@pytest.mark.parametrize("content", ["", "not an svg", "<svg xmlns='http://www.w3.org/2000/svg'/>"])
def test_a_drawing_that_is_none_is_the_users_mistake(tmp_path: Path, brush: Path, content: str) -> None:
    (tmp_path / "line.svg").write_text(content)
    called = CliRunner().invoke(app, ["brush", "apply", str(brush), str(tmp_path / "line.svg"), "-o", "x.png"])
    assert called.exit_code == 2
    assert called.stderr.startswith("videovec: ")
