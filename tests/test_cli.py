"""What the command line answers, on stdout, on stderr and as exit status."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path
from types import ModuleType

import imageio.v3 as iio
import numpy as np
import pytest
from numpy.typing import NDArray
from typer.testing import CliRunner, Result

from videovec.cli import app
from videovec.clip import Clip
from videovec.errors import ConfigError, FitError
from videovec.options import parse_frames
from videovec.progress import Progress
from videovec.settings import Config
from videovec.strokes import Strokes
from videovec.tracks import StrokeTracks

Command = Callable[..., Result]


def tracks_of(clip: Clip) -> StrokeTracks:
    """One straight stroke through all drawings."""
    line = np.linspace([4.0, 4.0], [28.0, 20.0], 4)
    count = len(clip.drawings)
    single = [Strokes.from_curves([line], [np.ones(2)], drawing=drawing) for drawing in range(count)]
    layout = type(single[0].layout)(np.array([1]), np.array([0]), np.array([count - 1]))
    strokes = Strokes(
        ids=np.array([1]),
        layout=layout,
        is_closed=np.array([False]),
        layer=np.array([0]),
        color=np.zeros((1, 3)),
        points=np.concatenate([part.points for part in single]),
        half_width=np.ones(2 * count),
        opacity=np.ones(count),
        visible=np.tile([0.0, 1.0], (count, 1)),
    )
    page = np.ones(3)
    return StrokeTracks(clip.name, clip.size, page, clip.timeline, strokes, (), np.zeros(count), np.ones(count))


def bar_image(side: int) -> NDArray[np.uint8]:
    """A line 3 px wide from (0.2, 0.3) to (0.8, 0.7) of the side; its edge is a ramp one pixel wide."""
    y, x = (np.mgrid[:side, :side] + 0.5) / side
    along = np.clip(((x - 0.2) * 0.6 + (y - 0.3) * 0.4) / 0.52, 0, 1)
    distance = side * np.hypot(x - 0.2 - 0.6 * along, y - 0.3 - 0.4 * along)
    return np.repeat((255 * np.clip(distance - 1, 0, 1)).astype(np.uint8)[..., None], 3, axis=2)


@pytest.fixture
def gif(tmp_path: Path) -> Path:
    """Three drawings of a line."""
    frames = np.full((3, 24, 32, 3), 255, np.uint8)
    for number, frame in enumerate(frames):
        frame[10 + 2 * number, 4:28] = 0
    path = tmp_path / "clip.gif"
    iio.imwrite(path, frames, duration=100, loop=0)
    return path


@pytest.fixture
def videovec(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> Command:
    """The command, with pipelines that are quick, wrong, impossible, or interrupted."""

    def good(clip: Clip, config: Config, progress: Progress) -> StrokeTracks:
        progress.stage("fit", 2)
        progress.advance(2)
        return tracks_of(clip)

    def wrong(clip: Clip, config: Config, progress: Progress) -> StrokeTracks:
        raise FitError("strokes.points must be (4, 2), got (3, 2)")

    def crash(clip: Clip, config: Config, progress: Progress) -> StrokeTracks:
        raise IndexError("17 is out of bounds")

    def interrupted(clip: Clip, config: Config, progress: Progress) -> StrokeTracks:
        raise KeyboardInterrupt

    for function in (good, wrong, crash, interrupted):
        module = ModuleType(f"videovec.pipelines.{function.__name__}")
        module.run = function  # type: ignore[attr-defined]
        monkeypatch.setitem(sys.modules, module.__name__, module)
    monkeypatch.chdir(tmp_path)

    def call(*arguments: str | Path) -> Result:
        return CliRunner().invoke(app, [str(argument) for argument in arguments])

    return call


def test_run_writes_a_folder_beside_the_clip_and_says_where(videovec: Command, gif: Path) -> None:
    result = videovec("run", gif, "-s", "pipeline=good")
    assert result.exit_code == 0, result.output
    assert str(gif.parent / "clip_videovec") in result.stdout
    record = json.loads((gif.parent / "clip_videovec" / "run.json").read_text())
    assert record["status"] == "done"
    assert set(record["seconds"]) >= {"decode", "fit"}
    assert record["clip"]["frames"] == 3
    for name in record["outputs"]:
        assert (gif.parent / "clip_videovec" / name).stat().st_size > 0


def test_progress_goes_to_stderr_in_plain_lines_and_the_result_to_stdout(videovec: Command, gif: Path) -> None:
    result = videovec("run", gif, "-s", "pipeline=good", "--json")
    assert json.loads(result.stdout)["frames"] == 3
    assert "fit 2/2 in" in result.stderr
    assert "\x1b" not in result.stderr
    assert videovec("run", gif, "-s", "pipeline=good", "--json", "--quiet").stderr == ""


def test_a_second_run_uses_the_strokes_of_the_first_until_something_changes(videovec: Command, gif: Path) -> None:
    first = ("run", gif, "-s", "pipeline=good")
    assert "used again" not in videovec(*first).stderr
    assert "used again" in videovec(*first).stderr
    assert "used again" in videovec(*first, "--svg-style", "stroke").stderr
    assert "used again" not in videovec(*first, "--fresh").stderr
    assert "used again" not in videovec(*first, "--seed", "4").stderr
    assert "used again" not in videovec(*first, "--seed", "4", "--frames", "1:2").stderr


def test_strokes_that_are_gone_are_fitted_again(videovec: Command, gif: Path) -> None:
    videovec("run", gif, "-s", "pipeline=good")
    (gif.parent / "clip_videovec" / "tracks.npz").unlink()
    result = videovec("run", gif, "-s", "pipeline=good")
    assert result.exit_code == 0
    assert "used again" not in result.stderr


def test_outputs_of_other_strokes_do_not_stay_but_those_of_the_same_strokes_do(videovec: Command, gif: Path) -> None:
    lottie = gif.parent / "clip_videovec" / "clip.json"
    videovec("run", gif, "-s", "pipeline=good")
    videovec("track", gif, "-s", "pipeline=good")
    assert lottie.exists()
    videovec("track", gif, "-s", "pipeline=good", "--seed", "1")
    assert not lottie.exists()
    assert {path.name for path in lottie.parent.rglob("*.*")} == {"run.json", "tracks.npz", "tracks.json"}


def test_a_dry_run_writes_nothing(videovec: Command, gif: Path) -> None:
    result = videovec("run", gif, "-s", "pipeline=good", "--dry-run", "--json")
    assert result.exit_code == 0
    assert json.loads(result.stdout)["drawings"] == 3
    assert [path.name for path in gif.parent.iterdir()] == ["clip.gif"]


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["missing.mp4"], "missing.mp4"),
        (["{gif}", "-s", "fit.stpes=1"], "unknown setting fit.stpes; did you mean 'steps'?"),
        (["{gif}", "-s", "pipeline=goood"], "unknown pipeline goood"),
        (["{gif}", "--preset", "soild"], "unknown preset soild; did you mean 'solid'?"),
        (["{gif}", "--svg-style", "outlines"], "export.svg_style must be one of"),
        (["{gif}", "--frames", "0:3"], "--frames must be A:B"),
        (["{gif}", "--frames", "9:"], "frames"),
        (["{gif}", "-s", "pipeline=good", "-o", "{gif}"], "is a file"),
        (["{empty}"], "empty"),
        (["{text}"], "text.mp4"),
    ],
)
def test_the_users_mistakes_are_told_in_one_line_and_exit_2(
    videovec: Command, gif: Path, arguments: list[str], message: str
) -> None:
    empty, text = gif.with_name("empty.mp4"), gif.with_name("text.mp4")
    empty.touch()
    text.write_text("not a video\n" * 9)
    result = videovec("run", *(part.format(gif=gif, empty=empty, text=text) for part in arguments))
    lines = result.stderr.splitlines()
    assert result.exit_code == 2
    assert lines[-1].startswith("videovec: ")
    assert message in lines[-1]
    assert "Traceback" not in result.stderr
    assert result.stdout == ""
    assert not (gif.parent / "clip_videovec").exists()


@pytest.mark.parametrize(("pipeline", "what"), [("wrong", "must be (4, 2)"), ("crash", "IndexError: 17")])
def test_our_own_faults_exit_1_without_a_traceback(videovec: Command, gif: Path, pipeline: str, what: str) -> None:
    result = videovec("run", gif, "-s", f"pipeline={pipeline}")
    assert result.exit_code == 1
    assert result.stderr.splitlines()[-1].startswith("videovec: a fault of videovec: ")
    assert what in result.stderr
    assert json.loads((gif.parent / "clip_videovec" / "run.json").read_text())["status"] == "failed"


def test_debug_shows_where_an_error_comes_from(videovec: Command, gif: Path) -> None:
    result = videovec("--debug", "run", gif, "-s", "pipeline=crash")
    assert isinstance(result.exception, IndexError)


def test_frames_above_max_error_exit_3_and_are_named(videovec: Command, gif: Path) -> None:
    result = videovec("run", gif, "-s", "pipeline=good", "--max-error", "0.05")
    assert result.exit_code == 3
    assert "3 frames lie above --max-error 0.05: 1, 2, 3" in result.stderr
    assert videovec("run", gif, "-s", "pipeline=good", "--max-error", "5").exit_code == 0


def test_an_interruption_exits_130_and_says_so(videovec: Command, gif: Path) -> None:
    result = videovec("run", gif, "-s", "pipeline=interrupted")
    assert result.exit_code == 130
    assert "interrupted" in result.stderr
    assert json.loads((gif.parent / "clip_videovec" / "run.json").read_text())["status"] == "interrupted"


def test_a_signal_from_the_keyboard_ends_a_real_process_with_130(gif: Path) -> None:
    code = (
        "import signal, sys, time, types\n"
        "signal.signal(signal.SIGINT, signal.default_int_handler)\n"  # shells have background jobs ignore it
        "module = types.ModuleType('videovec.pipelines.slow')\n"
        "module.run = lambda clip, config, progress: (progress.note('started'), time.sleep(60))\n"
        "sys.modules['videovec.pipelines.slow'] = module\n"
        "from videovec.cli import main\n"
        "main()\n"
    )
    command = [sys.executable, "-c", code, "run", str(gif), "-s", "pipeline=slow"]
    with subprocess.Popen(command, stderr=subprocess.PIPE, text=True) as process:
        assert process.stderr is not None
        assert any("started" in line for line in process.stderr)
        time.sleep(0.2)
        os.kill(process.pid, signal.SIGINT)
        assert process.wait(20) == 130
        assert "Traceback" not in process.stderr.read()


def test_files_of_others_are_not_written_over_without_force(videovec: Command, gif: Path) -> None:
    folder = gif.parent / "mine"
    folder.mkdir()
    (folder / "letter.txt").write_text("dear")
    result = videovec("run", gif, "-s", "pipeline=good", "-o", folder)
    assert result.exit_code == 2
    assert "not from videovec" in result.stderr
    assert videovec("run", gif, "-s", "pipeline=good", "-o", folder, "--force").exit_code == 0
    assert (folder / "letter.txt").read_text() == "dear"


@pytest.mark.parametrize(
    ("text", "numbers"),
    [
        (None, [1, 2, 3, 4, 5]),
        ("2:4", [2, 3, 4]),
        (":2", [1, 2]),
        ("4:", [4, 5]),
        ("3", [3]),
        ("-2:", [4, 5]),
        (":-2", [1, 2, 3, 4]),
        ("-1", [5]),
        (":", [1, 2, 3, 4, 5]),
    ],
)
def test_frames_are_counted_from_1_and_both_ends_are_included(text: str | None, numbers: list[int]) -> None:
    assert [1, 2, 3, 4, 5][parse_frames(text) or slice(None)] == numbers


@pytest.mark.parametrize("text", ["", "0:2", "a:b", "1:2:3", "1-3", "1.5:2"])
def test_other_texts_are_no_frames(text: str) -> None:
    with pytest.raises(ConfigError, match="--frames must be A:B"):
        parse_frames(text)


@pytest.mark.parametrize("command", [["--help"], ["-h"], ["run", "--help"], ["doctor", "--help"], ["--version"]])
def test_help_and_version_exit_0(videovec: Command, command: list[str]) -> None:
    result = videovec(*command)
    assert result.exit_code == 0
    assert "videovec" in result.stdout


@pytest.mark.parametrize("command", [["vectorise"], ["run"], ["run", "a", "b"], ["run", "a", "--nonsense"]])
def test_wrong_usage_exits_2(videovec: Command, command: list[str]) -> None:
    assert videovec(*command).exit_code == 2


def test_export_writes_other_files_from_the_same_strokes(videovec: Command, gif: Path) -> None:
    folder = gif.parent / "clip_videovec"
    assert videovec("track", gif, "-s", "pipeline=good").exit_code == 0
    assert {path.name for path in folder.iterdir()} == {"run.json", "tracks.npz", "tracks.json"}
    strokes = (folder / "tracks.npz").read_bytes()
    result = videovec("export", folder, "-f", "svg", "--svg-style", "outline")
    assert result.exit_code == 0, result.stderr
    assert "3 files written" in result.stdout
    assert (folder / "svg" / "frame_0003.svg").exists()
    assert not (folder / "clip.json").exists()
    assert (folder / "tracks.npz").read_bytes() == strokes


def test_export_shows_the_strokes_alone_where_the_clip_has_moved_away(videovec: Command, gif: Path) -> None:
    folder = gif.parent / "clip_videovec"
    videovec("track", gif, "-s", "pipeline=good")
    gif.unlink()
    result = videovec("export", folder, "-f", "preview", "-o", gif.parent / "film")
    assert result.exit_code == 0, result.stderr
    assert "the clip is missing" in result.stderr
    assert (gif.parent / "film" / "preview.mp4").stat().st_size > 0


@pytest.mark.parametrize("command", ["export", "view", "compare"])
def test_a_folder_without_a_finished_run_is_the_users_mistake(videovec: Command, gif: Path, command: str) -> None:
    result = videovec(command, gif.parent)
    assert result.exit_code == 2
    assert "must be the folder of a run" in result.stderr
    videovec("run", gif, "-s", "pipeline=wrong")
    result = videovec(command, gif.parent / "clip_videovec")
    assert result.exit_code == 2
    assert "one that is failed" in result.stderr


def test_an_unknown_format_is_told_with_a_suggestion(videovec: Command, gif: Path) -> None:
    videovec("track", gif, "-s", "pipeline=good")
    result = videovec("export", gif.parent / "clip_videovec", "-f", "lotie")
    assert result.exit_code == 2
    assert "did you mean 'lottie'?" in result.stderr


def test_compare_puts_runs_side_by_side(videovec: Command, gif: Path) -> None:
    videovec("track", gif, "-s", "pipeline=good", "-o", "a")
    videovec("track", gif, "-s", "pipeline=good", "-o", "b", "--frames", "1:2")
    compared = json.loads(videovec("compare", "a", "b", "--json").stdout)
    assert (compared["a"]["frames"], compared["b"]["frames"]) == (3, 2)
    assert "strokes" in videovec("compare", "a", "b").stdout


def test_view_names_the_preview(videovec: Command, gif: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    opened: list[str] = []
    monkeypatch.setattr("typer.launch", opened.append)
    videovec("run", gif, "-s", "pipeline=good")
    result = videovec("view", gif.parent / "clip_videovec")
    assert result.exit_code == 0, result.stderr
    assert opened == [str(gif.parent / "clip_videovec" / "preview.mp4")]
    (gif.parent / "clip_videovec" / "preview.mp4").unlink()
    assert videovec("view", gif.parent / "clip_videovec").exit_code == 2


def test_bench_measures_a_drawing_with_known_strokes(videovec: Command, tmp_path: Path) -> None:
    folder = tmp_path / "stills" / "bar"
    folder.mkdir(parents=True)
    bar = np.linspace([0.2, 0.3], [0.8, 0.7], 4)
    (folder / "truth.json").write_text(json.dumps({"strokes": [[bar.tolist()]]}))
    iio.imwrite(folder / "w3_64.png", bar_image(64))
    result = videovec("bench", "stills", tmp_path / "stills", "-s", "fit.steps=20", "-o", "scores.csv")
    assert result.exit_code == 0, result.output
    assert "w3 64" in result.stdout
    assert len((tmp_path / "scores.csv").read_text().splitlines()) == 2
    assert videovec("bench", "stills", tmp_path / "nothing").exit_code == 2


def test_bench_measures_a_clip_with_known_strokes(videovec: Command, tmp_path: Path) -> None:
    (tmp_path / "clips" / "truth").mkdir(parents=True)
    line = np.linspace([4.0, 4.0], [28.0, 20.0], 4)
    stroke = {"id": 1, "points": line.tolist(), "visible": [[0.0, 1.0]]}
    truth = {
        "size": [32, 24],
        "frame_rate": 10,
        "drawing_of_frame": [0],
        "strokes": [{"id": 1, "name": "line", "is_closed": False, "width": 2, "color": [0, 0, 0]}],
        "drawings": [[stroke]],
    }
    (tmp_path / "clips" / "truth" / "line.json").write_text(json.dumps(truth))
    iio.imwrite(tmp_path / "clips" / "line.png", bar_image(32)[:24])
    result = videovec("bench", "clips", tmp_path / "clips", "--method", "good", "-o", "scores.csv", "--pictures", "p")
    assert result.exit_code == 0, result.output
    assert "line" in result.stdout
    assert len((tmp_path / "scores.csv").read_text().splitlines()) == 2
    assert len((tmp_path / "scores_over_time.csv").read_text().splitlines()) == 2
    assert sorted(path.name for path in (tmp_path / "p").iterdir()) == ["line_curves.svg", "line_strip.png"]


def test_doctor_finds_this_machine_able(videovec: Command) -> None:
    result = videovec("doctor", "--json")
    assert result.exit_code == 0, result.output
    findings = {finding["name"]: finding for finding in json.loads(result.stdout)}
    assert "torch" in findings["libraries"]["state"]
    assert not any(finding["is_fatal"] for finding in findings.values())


def test_settings_lists_every_setting_with_the_values_of_a_preset(videovec: Command) -> None:
    listed = json.loads(videovec("settings", "--preset", "preview", "-s", "seed=3", "--json").stdout)
    assert listed["fit.steps"] == 70
    assert listed["seed"] == 3
    assert "How far a fitted cubic may lie" in videovec("settings").stdout


def test_help_is_fast() -> None:
    code = "import time; a = time.process_time(); import videovec.cli; print(time.process_time() - a)"
    runs = [subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True) for _ in range(3)]
    assert min(float(run.stdout) for run in runs) < 0.4


def test_an_edited_frame_needs_a_finished_run_and_is_put_back_into_it(videovec: Command, gif: Path) -> None:
    folder = gif.parent / "clip_videovec"
    asked = ("run", gif, "-s", "pipeline=good", "-s", "fit.joint_steps=5", "--correct", folder / "svg/frame_0002.svg")
    result = videovec(*asked)
    assert result.exit_code == 2
    assert "must hold a finished run" in result.stderr
    assert videovec(*asked[:-2]).exit_code == 0
    before = (folder / "tracks.npz").read_bytes()
    result = videovec(*asked)
    assert result.exit_code == 0, result.output
    assert (folder / "tracks.npz").read_bytes() != before  # fitted on
    assert videovec(*asked[:-2]).exit_code == 0
