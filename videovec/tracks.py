"""Strokes seen over time: what a run knows of every stroke at every frame."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from videovec.clip import Clip, Timeline
from videovec.errors import FitError
from videovec.events import Event
from videovec.fit import FitResult
from videovec.ink import Ink
from videovec.strokes import Strokes

__all__ = ["StrokeTracks"]


@dataclass(frozen=True, slots=True, eq=False)
class StrokeTracks:
    """S strokes with their identities over a clip.

    Args:
        name: Name of the clip.
        size: Height and width of the page. px
        page: Colour of the page, sRGB in [0, 1]. [3]
        timeline: Which drawing is shown when.
        strokes: The strokes over the drawings.
        events: Births, deaths and other turns, by drawing.
        error: Root mean square coverage error under each row. [R]
        confidence: How well each row's ink supports it, in [0, 1]. [R]
    """

    name: str
    size: tuple[int, int]
    page: NDArray[np.float64]
    timeline: Timeline
    strokes: Strokes
    events: tuple[Event, ...]
    error: NDArray[np.float64]
    confidence: NDArray[np.float64]

    def __post_init__(self) -> None:
        rows = self.strokes.row_count
        if self.error.shape != (rows,) or self.confidence.shape != (rows,):
            raise FitError(f"tracks need error and confidence [{rows}], got {self.error.shape}")

    @staticmethod
    def of(clip: Clip, ink: Ink, result: FitResult, events: tuple[Event, ...] = ()) -> StrokeTracks:
        """What a fit found in a clip.

        Args:
            clip: The clip.
            ink: Its ink, for the colour of the page.
            result: The fitted strokes and their evidence.
            events: What happened to them.
        """
        evidence = result.evidence
        return StrokeTracks(
            name=clip.name,
            size=clip.size,
            page=ink.page,
            timeline=clip.timeline,
            strokes=result.strokes,
            events=events,
            error=evidence.error,
            confidence=evidence.support,
        )
