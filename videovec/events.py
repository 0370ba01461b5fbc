"""What happens in the life of a stroke."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum

__all__ = ["Event", "EventKind"]


class EventKind(StrEnum):
    """The turns that a stroke's life can take."""

    BIRTH = "birth"
    DEATH = "death"
    OCCLUSION = "occlusion"
    REAPPEARANCE = "reappearance"
    SPLIT = "split"
    MERGE = "merge"
    CUT = "cut"


@dataclass(frozen=True, slots=True)
class Event:
    """One turn in the life of a stroke.

    Args:
        kind: What happened.
        drawing: First drawing on which it holds (for a death, the first without the stroke).
        ids: The strokes to which it happened; none for a cut.
        parents: The strokes that a split or merge came from.
        score: How sure the evidence is, in [0, 1].
    """

    kind: EventKind
    drawing: int
    ids: tuple[int, ...]
    parents: tuple[int, ...] = ()
    score: float = 1.0
