"""A run knows its folder, and knows when what lies in it can be used again."""

from __future__ import annotations

import os
from dataclasses import replace
from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest

from videovec.clip import Clip, Timeline
from videovec.errors import OutputError
from videovec.run_folder import RunFolder, RunRecord, default_folder, hash_of_clip, hash_of_config
from videovec.settings import Config, ExportSettings, FitSettings

RECORD = RunRecord(
    status="running",
    source="clip.mp4",
    frames=(None, 8, None),
    clip={"frames": 8},
    clip_hash="a",
    config_hash="b",
    config={"seed": 0},
    versions={"videovec": "0"},
)


def _clip(value: int = 0, duration: int = 1) -> Clip:
    timeline = Timeline(np.array([0, 0]), (Fraction(0), Fraction(1, 24)), Fraction(duration), np.array([1, 2]))
    return Clip("walk", (np.full((2, 3, 3), value, np.uint8),), timeline)


@pytest.mark.parametrize(
    ("source", "name"),
    [
        ("walk.mp4", "walk_videovec"),
        ("walk_%04d.png", "walk_videovec"),
        ("%04d.png", "clip_videovec"),
        ("shots.v2.mov", "shots.v2_videovec"),
        ("frames", "frames_videovec"),
    ],
)
def test_outputs_go_beside_the_clip(tmp_path: Path, source: str, name: str) -> None:
    (tmp_path / "frames").mkdir()
    assert default_folder(tmp_path / source) == tmp_path / name


def test_a_folder_given_as_a_dot_still_has_a_name(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "walk").mkdir()
    monkeypatch.chdir(tmp_path / "walk")
    assert default_folder(".") == tmp_path / "walk_videovec"


def test_outputs_go_here_where_the_clip_cannot_be_joined(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(os, "access", lambda place, mode: Path(place) != tmp_path)
    assert default_folder(tmp_path / "walk.mp4") == Path("walk_videovec")


def test_a_record_is_read_as_it_was_written(tmp_path: Path) -> None:
    folder = RunFolder(tmp_path / "out")
    record = replace(RECORD, status="done", seconds={"fit": 1.5}, outputs=("clip.json",))
    folder.write_record(record)
    assert folder.record() == record
    assert [path.name for path in (tmp_path / "out").iterdir()] == ["run.json"]


@pytest.mark.parametrize("text", ["", "{", "[]", '{"format": 99}', '{"format": 1, "status": "done"}', "null"])
def test_a_record_that_is_no_record_counts_as_none(tmp_path: Path, text: str) -> None:
    (tmp_path / "run.json").write_text(text)
    assert RunFolder(tmp_path).record() is None


@pytest.mark.parametrize(
    ("earlier", "is_fitted"),
    [
        (replace(RECORD, status="done"), True),
        (replace(RECORD, status="fitted"), True),
        (replace(RECORD, status="interrupted"), False),
        (replace(RECORD, status="done", clip_hash="x"), False),
        (replace(RECORD, status="done", config_hash="x"), False),
    ],
)
def test_only_finished_strokes_of_the_same_clip_and_settings_are_used_again(
    earlier: RunRecord, is_fitted: bool
) -> None:
    assert earlier.is_fitted_as(RECORD) == is_fitted


def test_pixels_times_and_names_tell_clips_apart() -> None:
    assert hash_of_clip(_clip()) == hash_of_clip(_clip())
    assert len({hash_of_clip(clip) for clip in (_clip(), _clip(value=1), _clip(duration=2))}) == 3


def test_the_way_of_writing_does_not_count_for_the_strokes_but_all_else_does() -> None:
    config = Config()
    names = {
        hash_of_config(config, "1"),
        hash_of_config(replace(config, export=ExportSettings(svg_style="outline")), "1"),
        hash_of_config(replace(config, fit=FitSettings(steps=1)), "1"),
        hash_of_config(config, "2"),
    }
    assert len(names) == 3


def test_a_file_that_a_setting_names_counts_with_its_content(tmp_path: Path) -> None:
    reference = tmp_path / "first.svg"
    config = replace(Config(), initialise=replace(Config().initialise, reference=str(reference)))
    names = [hash_of_config(config, "1")]
    for text in ("<svg/>", "<svg width='3'/>"):
        reference.write_text(text)
        names.append(hash_of_config(config, "1"))
    assert len(set(names)) == 3
    assert hash_of_config(config, "1") == names[-1]


def test_an_empty_or_new_folder_or_our_own_may_be_written_to(tmp_path: Path) -> None:
    RunFolder.claim(tmp_path)
    RunFolder.claim(tmp_path / "a" / "b")
    assert not (tmp_path / "a").exists()
    RunFolder(tmp_path).write_record(RECORD)
    (tmp_path / "clip.json").write_text("{}")
    RunFolder.claim(tmp_path)


def test_a_file_or_a_folder_of_others_may_not(tmp_path: Path) -> None:
    (tmp_path / "letter.txt").write_text("dear")
    with pytest.raises(OutputError, match=r"letter\.txt is a file"):
        RunFolder.claim(tmp_path / "letter.txt")
    with pytest.raises(OutputError, match="not from videovec"):
        RunFolder.claim(tmp_path)
    RunFolder.claim(tmp_path, force=True)


def test_stale_files_are_removed_and_nothing_else(tmp_path: Path) -> None:
    folder = tmp_path / "out"
    (folder / "svg").mkdir(parents=True)
    for name in ("out/svg/frame_0001.svg", "out/svg/frame_0002.svg", "out/notes.txt", "outside.txt"):
        (tmp_path / name).write_text("x")
    RunFolder(folder).remove_stale(("svg/frame_0002.svg", "../outside.txt", "gone.json"))
    left = {path.relative_to(tmp_path).as_posix() for path in tmp_path.rglob("*.*")}
    assert left == {"out/svg/frame_0001.svg", "out/notes.txt", "outside.txt"}
