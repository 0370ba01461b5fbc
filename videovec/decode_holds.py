"""Which frames show the same drawing: a streaming merge of frames that differ by no more than noise."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import cv2
import numpy as np
from numpy.typing import NDArray

from videovec.decode_frame import Pixels

__all__ = ["HoldMerger", "compression_noise", "largest_change"]

Floats = NDArray[np.float32]

WINDOW = 9
"""Side of the square in which a change is judged: a piece of line long enough to stand out of noise. px"""

QUIET = 1.0
"""Change that is none, so that rounding does not split a hold. 8-bit levels"""

WORST_WINDOW = 100.0
"""How many times the noise beside lines a held drawing may change in its worst window, at a line's edge. Measured with
x264 at crf 8 to 33: up to 50."""

TRACE = 4.0
"""Deviations from the page below this are noise, or the fringe of a line. 8-bit levels"""

LEAST_TRACES = 0.01
"""Share of the page beside lines that shows a trace from which there is noise and not only fringes."""


@dataclass(slots=True)
class _Hold:
    """The drawing at hand: its first frame, and the sum of all once they differ."""

    first: Pixels
    count: int = 1
    total: NDArray[np.float64] | None = None
    noise: float | None = None

    def join(self, image: Pixels) -> None:
        if self.total is None and not np.array_equal(image, self.first):
            self.total = self.first.astype(np.float64) * self.count
        if self.total is not None:
            self.total += image
        self.count += 1

    def mean(self) -> Pixels:
        if self.total is None:
            return self.first
        mean: Pixels = np.rint(self.total / self.count).astype(self.first.dtype)
        return mean

    def shows(self, image: Pixels, tolerance: float) -> bool:
        if np.array_equal(image, self.first):
            return True
        change = largest_change(self.mean(), image)
        if change <= min(QUIET, tolerance) or change > tolerance:
            return change <= tolerance
        if self.noise is None:
            self.noise = compression_noise(self.first)
        return change <= WORST_WINDOW * self.noise


@dataclass(slots=True)
class HoldMerger:
    """Takes frames one by one and keeps one image for each drawing: the mean of its frames.

    A frame joins the drawing if it differs from the drawing's mean, not from the frame before, by no more than noise;
    so slow motion cannot creep along unnoticed. How noisy a clip is shows beside its lines; without noise, frames must
    be equal but for rounding.

    Args:
        tolerance: Largest change that is still the same drawing however noisy the clip is: root mean square over the
            window where it is largest. 8-bit levels
    """

    tolerance: float
    drawings: list[Pixels] = field(default_factory=list)
    _hold: _Hold | None = None

    def add(self, image: Pixels) -> int:
        """Take the next frame. [H, W, 3]

        Returns:
            The drawing that it shows.
        """
        if self._hold is not None and self._hold.shows(image, self.tolerance):
            self._hold.join(image)
        else:
            self.finish()
            self._hold = _Hold(image)
        return len(self.drawings)

    def finish(self) -> None:
        """Close the drawing at hand; after the last frame, all are in ``drawings``."""
        if self._hold is not None:
            self.drawings.append(self._hold.mean())
        self._hold = None


def _levels(image: Pixels) -> Floats:
    """Values in 8-bit levels, whatever the depth. [H, W, 3]"""
    return image.astype(np.float32) * np.float32(255 / np.iinfo(image.dtype).max)


def largest_change(before: Pixels, after: Pixels) -> float:
    """Root mean square change in the window and channel where it is largest. 8-bit levels"""
    levels = 255 / float(np.iinfo(before.dtype).max)
    squares = cv2.sqrBoxFilter(cv2.absdiff(after, before), cv2.CV_32F, (WINDOW, WINDOW))
    return levels * math.sqrt(float(squares.max()))


def compression_noise(image: Pixels) -> float:
    """Noise of an image beside its lines, where lossy codecs spread their error.

    Transform codecs spread the error of a block over the whole block, so the page a few px beside a line shows how
    wrong the line itself may be. Noise is dense: a few faint pixels are faint lines.

    Args:
        image: uint8 or uint16 [H, W, 3]

    Returns:
        Root mean square deviation from the page beside lines. 8-bit levels
    """
    grey = _levels(image).mean(axis=2)
    page = float(np.median(grey))
    contrast = np.abs(grey - page)
    ink = (contrast > 0.25 * float(contrast.max())).astype(np.uint8)
    near, far = (cv2.dilate(ink, np.ones((2 * r + 1, 2 * r + 1), np.uint8)) > 0 for r in (2, 8))
    beside = contrast[far & ~near]
    if not len(beside) or np.mean((beside > 0.5) & (beside < TRACE)) < LEAST_TRACES:
        return 0.0
    return math.sqrt(float(np.mean(beside.astype(np.float64) ** 2)))
