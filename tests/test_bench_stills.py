"""The benchmark of stills on a drawing made here, tiny, so that it cannot rot."""

from __future__ import annotations

import csv
import json
from pathlib import Path

import cv2
import numpy as np
import pytest
from typer.testing import CliRunner

from videovec.bench import TRACERS, bench_stills, read_stills, scores_to_csv, scores_to_table, sheet
from videovec.bench.drawings import textured_stills
from videovec.bench.peers import installed
from videovec.bench.stills import Result
from videovec.cli import app
from videovec.errors import InputError
from videovec.settings import Config

SIZE = 96
ENDS = [((0.1, 0.2), (0.9, 0.8)), ((0.15, 0.85), (0.8, 0.1))]


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """One drawing of two straight strokes, 3 px wide, drawn by OpenCV at sixteen times the size."""
    large = np.full((SIZE * 16, SIZE * 16), 255, np.uint8)
    for start, stop in ENDS:
        one, two = (tuple(int(v * SIZE * 16) for v in point) for point in (start, stop))
        cv2.line(large, one, two, 0, 48, cv2.LINE_AA)
    drawing = tmp_path / "cross"
    drawing.mkdir()
    image = cv2.resize(large, (SIZE, SIZE), interpolation=cv2.INTER_AREA)
    cv2.imwrite(str(drawing / f"w3_{SIZE}.png"), image)
    strokes = [[np.linspace(start, stop, 4).tolist()] for start, stop in ENDS]
    (drawing / "truth.json").write_text(json.dumps({"strokes": strokes}), encoding="utf-8")
    return tmp_path


def test_ours_finds_the_strokes_of_a_cross(folder: Path) -> None:
    results: list[Result] = []
    (score,) = bench_stills(read_stills(folder), Config(), watch=results.append)
    assert score.success
    assert (score.strokes, score.true_strokes, score.covered, score.matched) == (2, 2, 1.0, 1.0)
    assert score.chamfer < 0.3
    assert score.psnr > 35.0
    assert score.ssim > 0.99
    assert score.lpips < 0.01
    assert sheet(results[0], 2).shape == (2 * SIZE, 6 * SIZE, 3)


@pytest.mark.parametrize("method", list(TRACERS))
def test_every_tracer_that_is_installed_has_its_row(folder: Path, method: str) -> None:
    scores = bench_stills(read_stills(folder), Config(), (method,))
    assert len(scores) == int(installed(TRACERS[method]))
    if scores:
        assert method in scores_to_table(scores)
        assert scores[0].psnr > 15.0
        assert scores_to_csv(scores).splitlines()[1].startswith(f"cross,w3,{SIZE},")


def test_the_supplement_stands_beside_its_size(folder: Path) -> None:
    (folder / "cross" / f"w3_{SIZE}.png").rename(folder / "cross" / "w3_512.png")
    scores = bench_stills(read_stills(folder), Config(), ("ours, not fitted",))
    assert "39.70" in scores_to_table(scores)


def test_a_folder_without_drawings_is_an_error(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="found none"):
        read_stills(tmp_path)


def test_an_unknown_method_is_an_error(folder: Path) -> None:
    with pytest.raises(InputError, match="got 'magic'"):
        bench_stills(read_stills(folder), Config(), ("magic",))


def test_a_drawing_without_an_image_is_drawn_from_its_truth(folder: Path) -> None:
    (seen,) = read_stills(folder, ("w3",), (SIZE,))
    image = seen.clip().drawings[0]
    assert seen.path is not None
    assert image.shape == (SIZE, SIZE, 3)
    (drawn,) = read_stills(folder, ("w3",), (128,))
    assert drawn.path is None
    grey = 1.0 - drawn.clip().drawings[0][..., 0] / 255.0
    length = sum(128 * float(np.hypot(b[0] - a[0], b[1] - a[1])) for a, b in ENDS)
    width = 3.0 * 128 / 512
    caps = 2 * np.pi * width**2 / 4  # two round ends of each of two strokes
    crossing = width**2  # drawn once; the two lines meet at nearly a right angle
    # a slope of 3 in 4 meets the lattice of sample points at steps of a fiftieth of the width
    assert grey.sum() == pytest.approx(length * width + caps - crossing, rel=0.02)
    assert drawn.truth.half_width == pytest.approx(width / 2)


def test_pictures_and_drawn_sizes_come_from_the_command_line(folder: Path, tmp_path: Path) -> None:
    pictures = tmp_path / "pictures"
    told = ["bench", "stills", str(folder), "--set-name", "hairline", "--size", "64", "--pictures", str(pictures), "-q"]
    result = CliRunner().invoke(app, [*told, "-s", "fit.steps=5"])
    assert result.exit_code == 0, result.output
    image = cv2.imread(str(pictures / "cross_hairline_64_ours.png"))
    assert image is not None
    assert image.shape == (128, 384, 3)


def test_a_textured_drawing_holds_the_ink_of_its_strokes_and_another_of_its_brush_differs(folder: Path) -> None:
    (one,) = textured_stills(folder, (SIZE,), ("made_crayon",), 0.08)
    (other,) = textured_stills(folder, (SIZE,), ("made_crumbs",), 0.08)
    ink = [1.0 - still.clip().drawings[0][..., 0] / 255.0 for still in (one, other)]
    length = sum(SIZE * float(np.hypot(b[0] - a[0], b[1] - a[1])) for a, b in ENDS)
    for page in ink:
        assert 0.2 < page.sum() / (length * 0.08 * SIZE) < 1.0  # pale where pressure is low, bare where the tip is
        assert page[:4].sum() == 0.0
    assert np.abs(ink[0] - ink[1]).max() > 0.2
    assert one.set_name == "textured80"


def test_textured_drawings_are_benched_from_the_command_line(folder: Path, tmp_path: Path) -> None:
    drawings = ["--textured", "--size", "96", "--pen", "0.06", "--brush", "made_crayon"]
    quick = ["-s", "fit.steps=20", "-s", "brush.profile_steps=10", "-s", "brush.texture_steps=10"]
    methods = ["--method", "ours, with its brush", "--method", "ours"]
    told = ["bench", "stills", str(folder), *drawings, *quick, *methods, "-o", str(tmp_path / "scores.csv"), "-q"]
    result = CliRunner().invoke(app, told)
    assert result.exit_code == 0, result.output
    assert "texturedN" in result.output
    one, two = csv.DictReader((tmp_path / "scores.csv").read_text(encoding="utf-8").splitlines())
    brushed, even = sorted((one, two), key=lambda row: len(row["method"]), reverse=True)
    assert {brushed["name"], even["name"]} == {"cross-made_crayon"}
    assert float(brushed["psnr"]) > float(even["psnr"])


def test_an_unknown_brush_is_an_error(folder: Path) -> None:
    with pytest.raises(InputError, match="got 'broom'"):
        textured_stills(folder, (SIZE,), ("broom",))
