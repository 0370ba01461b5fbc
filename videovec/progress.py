"""How long work reports how far it is, without knowing who listens."""

from __future__ import annotations

from typing import Protocol

__all__ = ["Progress", "Silent"]


class Progress(Protocol):
    """Told of every stage, and of every step of it."""

    def stage(self, name: str, total: int) -> None:
        """A stage begins that will take ``total`` steps."""

    def advance(self, count: int = 1) -> None:
        """``count`` more steps of the stage are done."""

    def note(self, text: str) -> None:
        """Something that a person should read, such as a compilation that takes a while."""


class Silent:
    """Listens to nothing."""

    def stage(self, name: str, total: int) -> None:
        """Ignore it."""

    def advance(self, count: int = 1) -> None:
        """Ignore it."""

    def note(self, text: str) -> None:
        """Ignore it."""
