"""What a person sees while videovec works: bars on a terminal, plain lines elsewhere. All of it on stderr."""

from __future__ import annotations

import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from threading import Event, Thread
from typing import TextIO

from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, TaskID, TextColumn, TimeElapsedColumn, TimeRemainingColumn
from rich.progress import Progress as Bars

from videovec.progress import Progress, Silent

__all__ = ["BarProgress", "LineProgress", "complain", "progress_on"]

LINE_EVERY = 5.0
"""Seconds between two lines about one stage, off a terminal."""


class LineProgress:
    """One line as a stage ends, and one every few seconds while it lasts; whether it advances or not."""

    def __init__(self, stream: TextIO, every: float = LINE_EVERY) -> None:
        self._stream = stream
        self._name = ""
        self._done = self._total = 0
        self._began = 0.0
        self._first: tuple[float, int] | None = None
        self._is_over = Event()
        self._beat = Thread(target=self._tell_now_and_then, args=(every,), daemon=True)
        self._beat.start()

    def stage(self, name: str, total: int) -> None:
        """End the present stage and begin another."""
        self._end()
        self._done, self._total, self._first, self._began = 0, total, None, time.monotonic()
        self._name = name

    def advance(self, count: int = 1) -> None:
        """Count steps."""
        self._done += count
        if self._first is None:
            self._first = (time.monotonic(), self._done)

    def note(self, text: str) -> None:
        """Say it at once."""
        self._say(text)

    def status(self) -> str:
        """Stage, how far, and how long it still takes; the first step, which may have to compile, does not count."""
        now = time.monotonic()
        if self._first is None or self._done == self._first[1] or self._done >= self._total:
            return f"{self._name}{self._count()}, for {now - self._began:.0f} s"
        since, done = self._first
        left = (now - since) / (self._done - done) * (self._total - self._done)
        return f"{self._name}{self._count()}, {left:.0f} s left"

    def close(self) -> None:
        """End the present stage, and listen no more."""
        self._end()
        self._is_over.set()
        self._beat.join()

    def _end(self) -> None:
        if self._name:
            self._say(f"{self._name}{self._count()} in {time.monotonic() - self._began:.1f} s")
        self._name = ""

    def _count(self) -> str:
        return f" {self._done}/{self._total}" if self._total else f" {self._done}" if self._done else ""

    def _tell_now_and_then(self, every: float) -> None:
        while not self._is_over.wait(every):
            if self._name and time.monotonic() - self._began >= every:
                self._say(self.status())

    def _say(self, text: str) -> None:
        print(text, file=self._stream, flush=True)


class BarProgress:
    """One bar for each stage: how many of how many, and how long it still takes."""

    def __init__(self, bars: Bars) -> None:
        self._bars = bars
        self._task: TaskID | None = None
        self._is_counted = False

    def stage(self, name: str, total: int) -> None:
        """End the present bar and begin another; a stage without a number of steps just pulses."""
        self.close()
        self._is_counted = total > 0
        self._task = self._bars.add_task(name, total=total or None)

    def advance(self, count: int = 1) -> None:
        """Move the bar."""
        if self._task is not None:
            self._bars.advance(self._task, count)

    def note(self, text: str) -> None:
        """Print it above the bars."""
        self._bars.console.print(text, style="dim", highlight=False)

    def close(self) -> None:
        """End the present bar."""
        if self._task is None:
            return
        if not self._is_counted:
            self._bars.update(self._task, total=1, completed=1)
        self._bars.stop_task(self._task)
        self._task = None


@contextmanager
def progress_on(stream: TextIO | None = None, *, quiet: bool = False) -> Iterator[Progress]:
    """Listen to work for as long as it lasts.

    Args:
        stream: Where to tell it; stderr unless told.
        quiet: Tell nothing.
    """
    stream = stream or sys.stderr
    if quiet:
        yield Silent()
    elif stream.isatty():
        columns = (TextColumn("{task.description:<12}"), BarColumn(), MofNCompleteColumn())
        with Bars(*columns, TimeElapsedColumn(), TimeRemainingColumn(), console=Console(file=stream)) as bars:
            yield BarProgress(bars)
    else:
        lines = LineProgress(stream)
        try:
            yield lines
        finally:
            lines.close()


def complain(message: str) -> None:
    """Say in one line what went wrong."""
    print(f"videovec: {' '.join(message.split())}", file=sys.stderr)
