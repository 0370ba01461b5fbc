"""One stroke as a user of the tracking API sees it: over frames."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from videovec.clip import Timeline
from videovec.errors import InputError
from videovec.stroke_life import StrokeLife
from videovec.stroke_shape import StrokeShape

__all__ = ["StrokeTrack"]

Floats = NDArray[np.float64]


@dataclass(frozen=True, slots=True, eq=False)
class StrokeTrack:
    """A stroke over the frames of a clip.

    Args:
        stroke: The stroke over the drawings of its life.
        timeline: Which drawing is shown when.
        error: Root mean square coverage error on each of its drawings. [K]
        confidence: How well the ink supports it on each of its drawings, in [0, 1]. [K]
    """

    stroke: StrokeLife
    timeline: Timeline
    error: Floats
    confidence: Floats

    @property
    def id(self) -> int:
        """Its identity."""
        return self.stroke.id

    @property
    def frames(self) -> NDArray[np.intp]:
        """Frames of its life, counted from 0; also those on which it is hidden. int [F]"""
        drawing = self.timeline.drawing_of_frame
        return np.flatnonzero((drawing >= self.stroke.first) & (drawing <= self.stroke.last))

    @property
    def life(self) -> tuple[int, int]:
        """First and last frame of its life."""
        frames = self.frames
        return int(frames[0]), int(frames[-1])

    def __contains__(self, frame: int) -> bool:
        """Whether it is alive on a frame."""
        first, last = self.life
        return first <= frame <= last

    def at(self, frame: int) -> StrokeShape:
        """The stroke on a frame of its life.

        Raises:
            InputError: It is not alive then.
        """
        if frame not in self:
            first, last = self.life
            raise InputError(f"stroke {self.id} lives on frames {first}..{last}, got {frame}")
        return self.stroke.at(int(self.timeline.drawing_of_frame[frame]))

    def follow(self, u: ArrayLike) -> Floats:
        """Where material points are on every frame.

        Args:
            u: Arc fractions. [...]

        Returns:
            x and y, NaN where the stroke is not alive or the point is hidden. [..., T, 2] px
        """
        fractions = np.asarray(u, dtype=np.float64)
        flat = fractions.reshape(-1)
        paths = np.full((len(flat), len(self.stroke.points), 2), np.nan)
        for k in range(len(self.stroke.points)):
            shape = self.stroke.at(self.stroke.first + k)
            is_seen = (flat >= shape.visible[0]) & (flat <= shape.visible[1]) & shape.is_visible
            paths[is_seen, k] = shape.positions(flat[is_seen])
        followed = np.full((len(flat), self.timeline.frame_count, 2), np.nan)
        frames = self.frames
        followed[:, frames] = paths[:, self.timeline.drawing_of_frame[frames] - self.stroke.first]
        return followed.reshape(*fractions.shape, self.timeline.frame_count, 2)
