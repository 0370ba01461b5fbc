"""A decoded clip: its drawings, how long each is held, and when."""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction

import numpy as np
from numpy.typing import NDArray

from videovec.errors import InputError

__all__ = ["Clip", "Timeline"]

Image = NDArray[np.uint8]


@dataclass(frozen=True, slots=True, eq=False)
class Timeline:
    """Which drawing is shown when, over T frames.

    Args:
        drawing_of_frame: The drawing that each frame shows, from 0, not decreasing. int [T]
        times: When each frame is shown, from 0, strictly increasing. T fractions, seconds
        duration: When the last frame ends. Seconds
        frame_numbers: Number of each frame in the source, from 1. int [T]

    Raises:
        InputError: There is no frame, or the lengths differ.
    """

    drawing_of_frame: NDArray[np.intp]
    times: tuple[Fraction, ...]
    duration: Fraction
    frame_numbers: NDArray[np.intp]

    def __post_init__(self) -> None:
        if not self.times:
            raise InputError("a clip needs at least one frame, got none")
        if not len(self.times) == len(self.drawing_of_frame) == len(self.frame_numbers):
            raise InputError(f"{len(self.times)} times for {len(self.drawing_of_frame)} frames")

    @property
    def frame_count(self) -> int:
        """T."""
        return len(self.times)

    @property
    def drawing_count(self) -> int:
        """D."""
        return int(self.drawing_of_frame[-1]) + 1

    @property
    def frame_rate(self) -> Fraction:
        """Mean frames per second; exact where the rate is constant. A still counts as one frame a second."""
        return Fraction(self.frame_count) / self.duration if self.duration else Fraction(1)

    def first_frames(self) -> NDArray[np.intp]:
        """The first frame that shows each drawing. int [D]"""
        return np.searchsorted(self.drawing_of_frame, np.arange(self.drawing_count))


@dataclass(frozen=True, slots=True, eq=False)
class Clip:
    """D drawings and when each is shown.

    Args:
        name: What the clip is called; the stem of its outputs.
        drawings: D images of one size, sRGB-encoded, alpha composited. uint8 or uint16 [H, W, 3]
        timeline: When they are shown.

    Raises:
        InputError: The drawings differ in size, or are not as many as the timeline shows.
    """

    name: str
    drawings: tuple[Image, ...]
    timeline: Timeline

    def __post_init__(self) -> None:
        sizes = {drawing.shape[:2] for drawing in self.drawings}
        if len(sizes) > 1:
            raise InputError(f"{self.name}: all frames must have one size, got {sorted(sizes)}")
        if len(self.drawings) != self.timeline.drawing_count:
            raise InputError(f"{self.name}: {self.timeline.drawing_count} drawings shown, got {len(self.drawings)}")

    @property
    def size(self) -> tuple[int, int]:
        """Height and width. px"""
        height, width = self.drawings[0].shape[:2]
        return int(height), int(width)
