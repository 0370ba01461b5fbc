"""The benchmark of clips on one made here, tiny, so that it cannot rot."""

from __future__ import annotations

import csv
import math
import xml.etree.ElementTree as ET
from io import StringIO
from pathlib import Path

import cv2
import numpy as np
import pytest

from videovec.bench.chart import Panel, chart_svg
from videovec.bench.clip_methods import METHODS, present_methods
from videovec.bench.clip_pictures import curves_svg, strip
from videovec.bench.clip_report import clips_over_time, clips_to_csv, clips_to_table
from videovec.bench.clip_truth import read_clips
from videovec.bench.clips import ClipResult, ClipRun, bench_clips
from videovec.clip_metrics import score_clip
from videovec.config import configure
from videovec.errors import ConfigError, InputError
from videovec.link import link
from videovec.progress import Silent
from videovec.strokes import Strokes

WIDTH, HEIGHT, D = 128, 96, 4
LINES = np.array([[[16.0, 20.0], [100.0, 34.0]], [[20.0, 78.0], [96.0, 70.0]]])
STEP = np.array([3.0, 1.5])


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Two straight strokes, 3 px wide, that move by `STEP` a drawing; drawn by OpenCV, 16 times as large."""
    clip = tmp_path_factory.mktemp("clips") / "two"
    clip.mkdir()
    control = []
    for drawing in range(D):
        large = np.full((HEIGHT * 16, WIDTH * 16), 255, np.uint8)
        moved = LINES + drawing * STEP
        for start, stop in np.rint(moved * 16).astype(int).tolist():
            cv2.line(large, start, stop, 0, 48, cv2.LINE_AA)
        cv2.imwrite(str(clip / f"{drawing:04d}.png"), cv2.resize(large, (WIDTH, HEIGHT), interpolation=cv2.INTER_AREA))
        control.append([np.linspace(start, stop, 4) for start, stop in moved])
    np.savez(clip / "gt.npz", ctrl=np.array(control), seg_stroke=np.arange(2))
    return clip.parent


@pytest.fixture(scope="module")
def runs(folder: Path) -> list[tuple[ClipRun, ClipResult]]:
    found: list[tuple[ClipRun, ClipResult]] = []
    bench_clips(read_clips(folder), configure(None, ["fit.steps=20"]), METHODS, lambda *pair: found.append(pair))
    return found


def test_every_method_that_is_installed_has_its_figures(runs: list[tuple[ClipRun, ClipResult]]) -> None:
    results = [result for _, result in runs]
    assert [result.method for result in results] == present_methods(METHODS, Silent())
    for result in results:
        assert result.score.idf1 > 0.8, result.method
        assert result.median("psnr") > 15.0
        assert result.lottie_bytes > 500
        assert len(result.pictures) == len(result.score.error_over_time) == D


def test_ours_holds_two_moving_lines(runs: list[tuple[ClipRun, ClipResult]]) -> None:
    result = runs[0][1]
    assert (result.strokes, result.true_strokes, result.drawings) == (2, 2, D)
    assert result.score.full_life == 1.0
    assert result.score.idf1 > 0.95
    assert result.median("ssim") > 0.98
    assert result.median("lpips") < 0.02
    assert min(result.score.identity_over_time) > 0.95


def test_tables_hold_a_row_for_each_method_and_drawing(runs: list[tuple[ClipRun, ClipResult]]) -> None:
    results = [result for _, result in runs]
    rows = list(csv.DictReader(StringIO(clips_to_csv(results))))
    assert [row["method"] for row in rows] == [result.method for result in results]
    assert float(rows[0]["psnr"]) == pytest.approx(results[0].median("psnr"))
    over_time = list(csv.DictReader(StringIO(clips_over_time(results))))
    assert len(over_time) == D * len(results)
    assert math.isnan(float(over_time[0]["error"]))  # nothing is followed on the drawing that is asked about
    for result in results:
        assert f" {result.method} " in clips_to_table(results)


def test_pictures_show_every_method(runs: list[tuple[ClipRun, ClipResult]]) -> None:
    made, results = zip(*runs, strict=True)
    sheet = strip(made, results)
    assert sheet.shape[0] % (len(results) + 1) == 0
    assert sheet.shape[0] <= (len(results) + 1) * 224
    rows = np.split(sheet[:, :, :].astype(int), len(results) + 1)
    assert all(np.ptp(row[24:], axis=-1).max() > 60 for row in rows[1:])  # strokes in colour below grey drawings
    assert np.ptp(rows[0], axis=-1).max() == 0
    document = ET.fromstring(curves_svg(results))
    assert len(document.findall("{*}g")) == 3
    assert len(document.findall(".//{*}polyline")) == 3 * len(results)


def test_a_chart_leaves_out_what_is_not_there() -> None:
    document = ET.fromstring(
        chart_svg([Panel("a", {"x": [1.0, math.nan, 3.0, 5.0], "y": [math.nan] * 4}, is_log=True)])
    )
    assert [len(line.get("points", "").split()) for line in document.findall(".//{*}polyline")] == [1, 2]
    assert [text.text for text in document.findall(".//{*}text")][3:5] == ["1", "10"]
    whole = ET.fromstring(chart_svg([Panel("a", {"x": [0.4, 0.5]}, shown=(0.0, 1.0))]))
    assert [text.text for text in whole.findall(".//{*}text")][2:7] == ["0", "0.5", "1", "1", "2"]  # ticks, drawings
    empty = ET.fromstring(chart_svg([Panel("a", {"x": [math.nan]})]))
    assert not empty.findall(".//{*}polyline")


def test_true_strokes_through_the_linker_of_the_peers_are_perfect(folder: Path) -> None:
    (clip,) = read_clips(folder)
    alone = [
        Strokes.from_curves([s.points for s in drawing], [np.ones(2) for _ in drawing], drawing=d)
        for d, drawing in enumerate(clip.frames)
    ]
    assert score_clip(clip.frames, link(alone, search_range=8.0)).idf1 == pytest.approx(1.0)


def test_what_is_not_there_is_told(folder: Path) -> None:
    with pytest.raises(ConfigError, match="unknown pipeline slid"):
        bench_clips(read_clips(folder), configure(), ["slid"])
    with pytest.raises(InputError, match=r"NAME/gt\.npz"):
        read_clips(folder, ["three"])
