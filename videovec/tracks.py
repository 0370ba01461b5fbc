"""Strokes seen over time: what a run knows of every stroke at every frame."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from videovec.clip import Clip, Timeline
from videovec.errors import FitError, InputError
from videovec.events import Event
from videovec.files import write_file
from videovec.fit import FitResult
from videovec.ink import Ink
from videovec.strokes import Strokes
from videovec.track_archive import (
    pack,
    pack_events,
    pack_strokes,
    pack_timeline,
    unpack,
    unpack_events,
    unpack_strokes,
    unpack_timeline,
)

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

    def save(self, path: str | Path) -> Path:
        """Write everything to an ``.npz`` without pickle, from which all can be exported again.

        Raises:
            OutputError: The place cannot be written to.
        """
        return write_file(Path(path), self.to_bytes())

    def to_bytes(self) -> bytes:
        """What :meth:`save` writes."""
        arrays = {
            "name": np.array(self.name),
            "size": np.array(self.size, dtype=np.int64),
            "page": self.page,
            "error": self.error,
            "confidence": self.confidence,
        }
        parts = (pack_timeline(self.timeline), pack_strokes(self.strokes), pack_events(self.events))
        for part in parts:
            arrays |= part
        return pack(arrays)

    @staticmethod
    def load(path: str | Path) -> StrokeTracks:
        """Read what :meth:`save` wrote.

        Raises:
            InputError: There is no such file, or it holds no tracks of this version.
        """
        try:
            data = Path(path).read_bytes()
        except OSError as error:
            raise InputError(f"cannot read tracks {path}: {error.strerror or error}") from error
        arrays = unpack(data, str(path))
        height, width = arrays["size"].tolist()
        return StrokeTracks(
            name=str(arrays["name"]),
            size=(height, width),
            page=arrays["page"].astype(np.float64),
            timeline=unpack_timeline(arrays),
            strokes=unpack_strokes(arrays),
            events=unpack_events(arrays),
            error=arrays["error"].astype(np.float64),
            confidence=arrays["confidence"].astype(np.float64),
        )
