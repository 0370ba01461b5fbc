"""One frame as it comes from a file, before holds are merged."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from fractions import Fraction
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from videovec.errors import InputError

__all__ = ["SMALLEST_SIDE", "FrameSource", "Pixels", "SourceFrame", "broadcast_rate", "to_rgb"]

Pixels = NDArray[np.unsignedinteger[Any]]
"""uint8 or uint16."""

SMALLEST_SIDE = 8
"""Images with a shorter side hold no line art. px"""


@dataclass(frozen=True, slots=True, eq=False)
class SourceFrame:
    """One frame of a file.

    Args:
        image: Its pixels, sRGB-encoded, alpha composited. uint8 or uint16 [H, W, 3]
        time: When it is shown, on the clock of the file. Seconds
        duration: How long the file says that it is shown. Seconds
    """

    image: Pixels
    time: Fraction
    duration: Fraction


class FrameSource(Protocol):
    """Something that frames come from, as often as asked."""

    @property
    def frame_count(self) -> int:
        """How many frames the source says that it has; 0 when it does not know."""

    @property
    def rate(self) -> Fraction | None:
        """The nominal frame rate, where times are rounded to ticks of a coarser clock."""

    @property
    def tick(self) -> Fraction:
        """Step of the clock in which times are written. Seconds"""

    def frames(self) -> Iterator[SourceFrame]:
        """All frames, in order of time."""


def to_rgb(pixels: NDArray[Any], what: str) -> Pixels:
    """Make three channels of grey, grey with alpha, RGB or RGBA; alpha is composited on white.

    Args:
        pixels: bool, uint8 or uint16 [H, W] or [H, W, 1..4]
        what: Name of the image, for the error.

    Returns:
        uint8 or uint16 [H, W, 3]

    Raises:
        InputError: The image is too small, or of another type.
    """
    if pixels.dtype == np.bool_:
        pixels = pixels.astype(np.uint8) * np.uint8(255)
    if pixels.dtype.kind in "iu" and pixels.dtype.itemsize > 2 and pixels.min() >= 0 and pixels.max() <= 65535:
        pixels = pixels.astype(np.uint16)
    if pixels.dtype not in (np.uint8, np.uint16):
        raise InputError(f"{what}: must have 8 or 16 bits per channel, got {pixels.dtype}")
    if pixels.ndim == 2:
        pixels = pixels[..., None]
    if min(pixels.shape[:2]) < SMALLEST_SIDE:
        raise InputError(
            f"{what}: must be at least {SMALLEST_SIDE} px on each side, got {pixels.shape[1]} x {pixels.shape[0]}"
        )
    if pixels.shape[2] in (2, 4):
        pixels = _on_white(pixels[..., :-1], pixels[..., -1:])
    return np.ascontiguousarray(np.broadcast_to(pixels, (*pixels.shape[:2], 3)))


def _on_white(color: Pixels, alpha: Pixels) -> Pixels:
    """Composite straight alpha on white, rounded to the nearest value. [H, W, C]"""
    full = np.iinfo(color.dtype).max
    wide, a = color.astype(np.uint64), alpha.astype(np.uint64)
    return ((wide * a + full * (full - a) + full // 2) // full).astype(color.dtype)


def broadcast_rate(rate: float | Fraction) -> Fraction:
    """The exact rate that a rounded one stands for: 23.976 and 29.97 are multiples of 1000/1001.

    Args:
        rate: Frames per second, as people and containers round it.

    Returns:
        The nearest whole rate, or whole rate times 1000/1001, within 1e-4 of it; else the rate itself.
    """
    given = Fraction(rate)
    for exact in (Fraction(round(given)), Fraction(round(given * 1001 / 1000) * 1000, 1001)):
        if exact and abs(exact - given) <= given / 10_000:
            return exact
    return given.limit_denominator(100_000)
