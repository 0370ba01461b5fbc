"""What is known of the strokes of a clip: the data behind :class:`videovec.tracks.StrokeTracks`.

In the example ``tracks`` are those of :mod:`videovec.tracks`.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from videovec.brushwork import Brushwork
from videovec.clip import Timeline
from videovec.errors import FitError, InputError
from videovec.events import Event
from videovec.stroke_life import StrokeLife
from videovec.stroke_track import StrokeTrack
from videovec.strokes import Strokes

__all__ = ["TrackSet"]

Floats = NDArray[np.float64]


@dataclass(frozen=True, slots=True, eq=False)
class TrackSet:
    """S strokes with their identities over a clip: what edits and layouts read, and all that is stored.

    Args:
        name: Name of the clip.
        size: Height and width of the page. px
        page: Colour of the page, sRGB in [0, 1]. [3]
        timeline: Which drawing is shown when.
        strokes: The strokes over the drawings.
        events: Births, deaths and other turns, by drawing.
        error: Root mean square coverage error under each row. [R]
        confidence: How well each row's ink supports it, in [0, 1]. [R]
        brushwork: The brushes of textured lines; none for solid ones.
        is_finished: Whether the fit behind them came to its end, and was not interrupted.
    """

    name: str
    size: tuple[int, int]
    page: Floats
    timeline: Timeline
    strokes: Strokes
    events: tuple[Event, ...]
    error: Floats
    confidence: Floats
    brushwork: Brushwork | None = None
    is_finished: bool = True

    def __post_init__(self) -> None:
        rows = self.strokes.row_count
        if self.error.shape != (rows,) or self.confidence.shape != (rows,):
            raise FitError(f"tracks need error and confidence [{rows}], got {self.error.shape}")

    def __len__(self) -> int:
        """S."""
        return len(self.strokes)

    def __iter__(self) -> Iterator[StrokeTrack]:
        """Every stroke, in the order of ``strokes``."""
        return (self[stroke] for stroke in self.strokes.ids.tolist())

    def __contains__(self, stroke: int) -> bool:
        """Whether there is a stroke of an identity."""
        return stroke in self.strokes.ids

    def __getitem__(self, stroke: int) -> StrokeTrack:
        """The stroke of an identity.

        >>> tracks[2].life
        (0, 5)
        >>> tracks[2].at(3).points.shape
        (4, 2)

        Raises:
            InputError: There is none.
        """
        position = self.position(stroke)
        rows = slice(*self.strokes.layout.stroke_rows[position : position + 2].tolist())
        life = StrokeLife.of(self.strokes, position)
        return StrokeTrack(life, self.timeline, self.error[rows], self.confidence[rows])

    def position(self, stroke: int) -> int:
        """Where in ``strokes`` the stroke of an identity stands.

        Raises:
            InputError: There is none.
        """
        places = np.flatnonzero(self.strokes.ids == stroke)
        if not len(places):
            known = f"the {len(self)} identities lie in {self.strokes.ids.min()}..{self.strokes.ids.max()}"
            raise InputError(f"there is no stroke {stroke}; {known if len(self) else 'there are no strokes'}")
        return int(places[0])

    def check_frame(self, frame: int) -> None:
        """Refuse a frame that the clip does not have.

        Raises:
            InputError: It lies outside 0 .. T - 1.
        """
        if not 0 <= frame < self.timeline.frame_count:
            raise InputError(f"frame must lie in 0..{self.timeline.frame_count - 1}, got {frame}")

    def frame_of(self, event: Event) -> int:
        """The frame from which an event holds; T for one after the last drawing."""
        return int(np.searchsorted(self.timeline.drawing_of_frame, event.drawing))
