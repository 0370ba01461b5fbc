"""What a person sees while videovec works: bars on a terminal, plain lines elsewhere. All of it on stderr."""

from __future__ import annotations

import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from typing import TextIO

from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, TaskID, TextColumn, TimeElapsedColumn, TimeRemainingColumn
from rich.progress import Progress as Bars

from videovec.progress import Progress, Silent

__all__ = ["BarProgress", "LineProgress", "complain", "progress_on"]

LINE_EVERY = 5.0
"""Seconds between two lines about one stage, off a terminal."""


class LineProgress:
    """One line as a stage ends, and one every few seconds while it lasts."""

    def __init__(self, stream: TextIO) -> None:
        self._stream = stream
        self._name = ""
        self._done = self._total = 0
        self._began = self._told = 0.0

    def stage(self, name: str, total: int) -> None:
        """End the present stage and begin another."""
        self.close()
        self._name, self._done, self._total = name, 0, total
        self._began = self._told = time.monotonic()

    def advance(self, count: int = 1) -> None:
        """Count steps; say so now and then."""
        self._done += count
        now = time.monotonic()
        if now - self._told >= LINE_EVERY and self._done < self._total:
            self._told = now
            left = (now - self._began) / max(self._done, 1) * (self._total - self._done)
            self._say(f"{self._name} {self._done}/{self._total}, {left:.0f} s left")

    def note(self, text: str) -> None:
        """Say it at once."""
        self._say(text)

    def close(self) -> None:
        """End the present stage."""
        if self._name:
            count = f" {self._done}/{self._total}" if self._total else f" {self._done}" if self._done else ""
            self._say(f"{self._name}{count} in {time.monotonic() - self._began:.1f} s")
        self._name = ""

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
        yield lines
        lines.close()


def complain(message: str) -> None:
    """Say in one line what went wrong."""
    print(f"videovec: {' '.join(message.split())}", file=sys.stderr)
