"""Progress says stage, how far and how long, in the way that the place where it is read can show."""

from __future__ import annotations

import io
import time

import pytest
from rich.console import Console
from rich.progress import Progress as Bars

from videovec import console
from videovec.console import BarProgress, LineProgress, complain, progress_on
from videovec.progress import Silent


class _Clock:
    def __init__(self) -> None:
        self.now = 0.0

    def monotonic(self) -> float:
        return self.now


@pytest.fixture
def clock(monkeypatch: pytest.MonkeyPatch) -> _Clock:
    clock = _Clock()
    monkeypatch.setattr(console, "time", clock)
    return clock


def test_a_stage_is_one_line_when_it_ends(clock: _Clock) -> None:
    stream = io.StringIO()
    lines = LineProgress(stream)
    lines.stage("decode", 2)
    clock.now = 1.5
    lines.advance(2)
    lines.stage("fit", 0)
    clock.now = 2.0
    lines.close()
    assert stream.getvalue() == "decode 2/2 in 1.5 s\nfit in 0.5 s\n"


def test_the_time_left_leaves_out_the_first_step_which_may_compile(clock: _Clock) -> None:
    lines = LineProgress(io.StringIO())
    lines.stage("fit", 101)
    clock.now = 12.0
    assert lines.status() == "fit 0/101, for 12 s"
    lines.advance()
    assert lines.status() == "fit 1/101, for 12 s"
    clock.now = 22.0
    lines.advance(20)
    assert lines.status() == "fit 21/101, 40 s left"
    lines.close()


def test_a_stage_that_does_not_advance_is_not_silent() -> None:
    stream = io.StringIO()
    lines = LineProgress(stream, every=0.02)
    lines.stage("compile", 0)
    for _ in range(200):
        if stream.getvalue().count("compile, for 0 s") > 1:
            break
        time.sleep(0.01)
    lines.close()
    assert stream.getvalue().count("compile, for 0 s") > 1


def test_a_terminal_gets_bars_and_notes_above_them() -> None:
    stream = io.StringIO()
    with Bars(console=Console(file=stream, force_terminal=True, width=100)) as bars:
        progress = BarProgress(bars)
        progress.stage("decode", 3)
        progress.advance(3)
        progress.stage("fit", 0)
        progress.note("compiling")
        progress.close()
        assert [(task.description, task.completed, task.total) for task in bars.tasks] == [
            ("decode", 3, 3),
            ("fit", 1, 1),
        ]
    assert "compiling" in stream.getvalue()


def test_off_a_terminal_and_when_quiet_there_are_no_bars() -> None:
    stream = io.StringIO()
    with progress_on(stream) as progress:
        progress.stage("decode", 1)
    assert "\x1b" not in stream.getvalue()
    assert "decode 0/1" in stream.getvalue()
    with progress_on(stream, quiet=True) as progress:
        assert isinstance(progress, Silent)


def test_a_complaint_is_one_line(capsys: pytest.CaptureFixture[str]) -> None:
    complain("broken\nin   two")
    assert capsys.readouterr().err == "videovec: broken in two\n"
