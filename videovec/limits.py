"""What values a setting may take, said beside its type: ``Annotated[float, Between(0.0)]``."""

from __future__ import annotations

import math
from dataclasses import dataclass

__all__ = ["Between", "OneOf"]


@dataclass(frozen=True, slots=True)
class Between:
    """A number no less than ``low`` and no more than ``high``."""

    low: float = -math.inf
    high: float = math.inf

    def problem(self, value: float) -> str | None:
        """What the value must be, where it is not that."""
        if self.low <= value <= self.high:
            return None
        if math.isinf(self.high):
            return f"at least {self.low:g}"
        return f"at most {self.high:g}" if math.isinf(self.low) else f"between {self.low:g} and {self.high:g}"


@dataclass(frozen=True, slots=True)
class OneOf:
    """One of a few words."""

    words: tuple[str, ...]

    def problem(self, value: str) -> str | None:
        """What the value must be, where it is not that."""
        return None if value in self.words else "one of " + ", ".join(self.words)
