"""The benchmarks of strokes that are carried: they run, tiny, and what they measure can be bad."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
import pytest

from benchmarks import blinks, lives, propagation, strides
from benchmarks.foreshortened import foreshortened_movie
from benchmarks.propagation import Known, interval_errors, share_right
from benchmarks.strides import every_nth, kept, unexplained
from videovec.clip_metrics import TrueStroke
from videovec.decode import decode
from videovec.ink import Ink
from videovec.strokes import Layout, Strokes

SIZE, D = 96, 4
LINES = np.array([[[16.0, 20.0], [80.0, 34.0]], [[20.0, 78.0], [76.0, 70.0]]])
STEP = np.array([2.0, 1.0])


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Two straight strokes, 3 px wide, that move by `STEP` a drawing; drawn by OpenCV, 16 times as large."""
    clip = tmp_path_factory.mktemp("clips") / "two"
    clip.mkdir()
    for drawing in range(D):
        large = np.full((SIZE * 16, SIZE * 16), 255, np.uint8)
        for start, stop in np.rint((LINES + drawing * STEP) * 16).astype(int).tolist():
            cv2.line(large, start, stop, 0, 48, cv2.LINE_AA)
        cv2.imwrite(str(clip / f"{drawing:04d}.png"), cv2.resize(large, (SIZE, SIZE), interpolation=cv2.INTER_AREA))
    control = [[np.linspace(a, b, 4) for a, b in LINES + drawing * STEP] for drawing in range(D)]
    np.savez(clip / "gt.npz", ctrl=np.array(control), seg_stroke=np.arange(2), stroke_width=3.0)
    return clip.parent


def known(visible: tuple[tuple[float, float], ...] = ((0.0, 1.0),)) -> tuple[Known, Strokes]:
    """A stroke 30 px long that moves by 10 px, and strokes that follow it exactly."""
    first = np.linspace([10.0, 20.0], [40.0, 20.0], 4)
    curves = [first, first + np.array([0.0, 10.0])]
    coverage = np.zeros((2, 64, 64), np.uint8)
    for drawing, curve in enumerate(curves):
        y = int(curve[0, 1])
        coverage[drawing, y - 1 : y + 1, 10:40] = 255
    ink = Ink(coverage, np.zeros_like(coverage), palette=np.zeros((1, 3)), page=np.ones(3), noise=0.0)
    begun = Strokes.from_curves([first], [np.ones(2)])
    truth = [[TrueStroke(1, curve, visible)] for curve in curves]
    followed = replace(
        begun,
        layout=Layout(*(np.array([n], np.intp) for n in (1, 0, 1))),
        points=np.concatenate(curves),
        half_width=np.ones(4),
        opacity=np.ones(2),
        visible=np.tile([0.0, 1.0], (2, 1)),
    )
    return Known("known", ink, truth, begun), followed


def rows(text: str) -> list[list[str]]:
    lines = [line for line in text.splitlines() if line.startswith("| ")]
    return [[cell.strip() for cell in line.strip("|").split("|")] for line in lines[1:]]


def test_chains_of_moved_strokes_have_their_figures(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    propagation.main(["moved", str(folder), "--every", "2"])
    clip, mean = rows(capsys.readouterr().out)
    assert clip[:4] == ["two", "2", "2", "1.000"]
    assert float(clip[5]) < 0.3  # px of error
    assert mean[3:] == clip[3:]


def test_a_stroke_that_stays_behind_is_not_right() -> None:
    scene, followed = known()
    assert share_right(scene, followed) == 1.0
    assert share_right(scene, replace(followed, points=np.tile(followed.points[:4], (2, 1)))) == 0.0


def test_ends_of_what_is_seen_are_off_by_their_distance() -> None:
    scene, followed = known(((0.0, 0.5),))
    assert interval_errors(scene, followed) == pytest.approx([15.0])  # px, half of a stroke of 30


def test_ink_without_a_stroke_and_a_stroke_without_ink_are_counted() -> None:
    scene, followed = known()
    assert not np.any(unexplained(followed, scene.ink))
    half = replace(followed, visible=np.array([[0.0, 1.0], [0.0, 0.5]]))
    bare, empty = unexplained(half, scene.ink)
    assert bare[1] == pytest.approx((15 - 3.5) / 30, abs=0.1)
    assert empty[1] == 0
    away = replace(followed, points=followed.points + np.array([0.0, 20.0]))
    assert [share[1] for share in unexplained(away, scene.ink)] == [1.0, 1.0]


def test_an_artists_stroke_is_kept_in_its_direction_alone() -> None:
    scene, followed = known()
    assert kept(scene.first, followed) == (1, 1, 1)
    turned = followed.points.reshape(2, 4, 2)[:, ::-1].reshape(-1, 2)
    assert kept(scene.first, replace(followed, points=turned)) == (1, 0, 1)
    assert kept(scene.first, replace(followed, visible=np.array([[0.0, 1.0], [0.0, 0.0]]))) == (1, 1, 0)


def test_clips_are_thinned_out_and_shown(folder: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert len(every_nth(decode(folder / "two" / "%04d.png"), 2).drawings) == 2
    strides.main(["gifs", str(folder / "two" / "%04d.png"), "--every", "2", "--pictures", str(tmp_path)])
    (row,) = rows(capsys.readouterr().out)
    assert row[1:3] == ["2", "2"]
    assert {path.suffix for path in tmp_path.iterdir()} == {".png", ".npz"}


def test_the_foreshortened_movie_has_every_line_from_its_first_drawing_on() -> None:
    movie = foreshortened_movie(8)
    names = [{getattr(item, "name", "") for item in drawing} for drawing in movie.drawings]
    assert all(later <= names[0] for later in names)
    assert len(names[0] - names[-1]) == 2  # the marks on the faces, which are turned away


def test_half_a_closed_stroke_is_not_the_whole_one() -> None:
    truth, followed = known()
    closed = replace(truth, first=replace(truth.first, is_closed=np.ones(1, bool)))
    assert blinks.whole_share(closed, followed) == 1.0
    assert blinks.whole_share(closed, replace(followed, visible=np.tile([0.0, 0.5], (2, 1)))) == 0.0
    assert blinks.whole_share(closed, replace(followed, points=followed.points + 5.0)) == 0.0


def test_blinks_are_measured() -> None:
    assert blinks.measure("bird, at once", 2).startswith("| bird, at once | 6 / 6 | 1.000 |")


def test_the_menu_closes_up_to_one_bar_and_parts_into_a_cross() -> None:
    drawings = lives.menu_movie().drawings
    assert [len(drawings[d]) for d in (0, 5, 6, 7, 8, 12, 13)] == [3, 3, 1, 1, 2, 2, 3]


def test_the_benchmark_of_lives_prints_a_row_for_a_movie(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(lives, "CHOSEN_ON", {"short": lambda: lives.bars_movie(2)})
    monkeypatch.setattr(lives, "CONFIRMED_ON", {})
    lives.main([])
    assert "| short | 4 / 4 | 1.000 |" in capsys.readouterr().out
