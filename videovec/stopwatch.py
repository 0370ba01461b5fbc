"""How long each stage takes."""

from __future__ import annotations

import time

from videovec.progress import Progress

__all__ = ["Stopwatch"]


class Stopwatch:
    """Passes progress on to a listener, and keeps how long each stage took; a stage that comes again is added up."""

    def __init__(self, listener: Progress) -> None:
        self._listener = listener
        self._seconds: dict[str, float] = {}
        self._stage = ""
        self._since = 0.0

    def stage(self, name: str, total: int) -> None:
        """Begin a stage."""
        self._stop()
        self._stage = name
        self._listener.stage(name, total)

    def advance(self, count: int = 1) -> None:
        """Pass it on."""
        self._listener.advance(count)

    def note(self, text: str) -> None:
        """Pass it on."""
        self._listener.note(text)

    def seconds(self) -> dict[str, float]:
        """How long each stage took until now."""
        self._stop()
        return {name: round(seconds, 3) for name, seconds in self._seconds.items()}

    def _stop(self) -> None:
        now = time.perf_counter()
        if self._stage:
            self._seconds[self._stage] = self._seconds.get(self._stage, 0.0) + now - self._since
        self._since = now
