"""Page and ink: what is drawn, as coverage in [0, 1], apart from what it is drawn on."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from videovec.errors import FitError

__all__ = ["Ink"]


@dataclass(frozen=True, slots=True, eq=False)
class Ink:
    """The ink of D drawings.

    Args:
        coverage: Ink fraction of each pixel, 255 is full. uint8 [D, H, W]
        label: Palette entry of each pixel's ink; meaningful where coverage > 0. uint8 [D, H, W]
        palette: Colour of each ink, sRGB in [0, 1]. [I, 3]
        page: Colour of the flattened page, sRGB in [0, 1]. [3]
        noise: Standard deviation of the page's noise, in coverage.
    """

    coverage: NDArray[np.uint8]
    label: NDArray[np.uint8]
    palette: NDArray[np.float64]
    page: NDArray[np.float64]
    noise: float

    def __post_init__(self) -> None:
        if self.coverage.ndim != 3 or self.label.shape != self.coverage.shape:
            raise FitError(f"ink needs coverage and label [D, H, W], got {self.coverage.shape} and {self.label.shape}")

    @property
    def size(self) -> tuple[int, int]:
        """Height and width. px"""
        return int(self.coverage.shape[1]), int(self.coverage.shape[2])

    @property
    def drawing_count(self) -> int:
        """D."""
        return int(self.coverage.shape[0])

    def at_drawing(self, drawing: int) -> Ink:
        """The ink of one drawing."""
        part = slice(drawing, drawing + 1)
        return Ink(self.coverage[part], self.label[part], self.palette, self.page, self.noise)
