"""One stroke as a user of the tracking API sees it: over frames."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from videovec.clip import Timeline
from videovec.curves import evaluate, parameter_at, segments_of
from videovec.errors import InputError
from videovec.stroke_life import StrokeLife
from videovec.stroke_shape import StrokeShape

__all__ = ["StrokeTrack"]

Floats = NDArray[np.float64]
Ints = NDArray[np.intp]

_ROUNDING = 1e-6  # segments by which a point may lie beyond the end of what is seen


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

    def follow(self, u: ArrayLike, frame: int | None = None) -> Floats:
        """Where material points are on every frame.

        A material point stays at its parameter of its segment: where a stroke is stretched in one part alone, its arc
        fraction changes.

        Args:
            u: Arc fractions. [...]
            frame: Where they are those fractions; if none, on the drawing on which most of the stroke is seen, the
                first of several.

        Returns:
            x and y, NaN where the stroke is not alive or the point is hidden. [..., T, 2] px

        Raises:
            InputError: The stroke is not alive on that frame.
        """
        segment, t = self.places(u, frame)
        return self.follow_places(segment, t).reshape(*np.shape(u), self.timeline.frame_count, 2)

    def places(self, u: ArrayLike, frame: int | None = None) -> tuple[Ints, Floats]:
        """Segment and parameter of material points, see :meth:`follow`. Two [N]"""
        return parameter_at(self._reference(frame).points, np.asarray(u, dtype=np.float64).reshape(-1))

    def follow_places(self, segment: Ints, t: Floats) -> Floats:
        """Where points at parameters of segments are on every frame, see :meth:`follow`. [N], [N] -> [N, T, 2] px"""
        paths = np.full((len(t), len(self.stroke.points), 2), np.nan)
        for k in range(len(self.stroke.points)):
            shape = self.stroke.at(self.stroke.first + k)
            if shape.is_visible:
                first, last = np.add(*parameter_at(shape.points, np.array(shape.visible)))
                is_seen = (segment + t >= first - _ROUNDING) & (segment + t <= last + _ROUNDING)
                paths[is_seen, k] = evaluate(segments_of(shape.points)[segment[is_seen]], t[is_seen])
        followed = np.full((len(t), self.timeline.frame_count, 2), np.nan)
        frames = self.frames
        followed[:, frames] = paths[:, self.timeline.drawing_of_frame[frames] - self.stroke.first]
        return followed

    def _reference(self, frame: int | None) -> StrokeShape:
        """The stroke on a frame, or where most of it is seen."""
        if frame is not None:
            return self.at(frame)
        return self.stroke.at(self.stroke.first + int(np.ptp(self.stroke.visible, axis=1).argmax()))
