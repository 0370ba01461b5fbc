"""Strokes that are known to be true, against which found ones are measured."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

__all__ = ["TrueStroke"]


@dataclass(frozen=True, slots=True, eq=False)
class TrueStroke:
    """A true stroke on one drawing.

    Args:
        id: Its identity over the clip.
        points: Control points. [3n+1, 2] px
        visible: Arc fractions that are seen; none if it is hidden.
    """

    id: int
    points: NDArray[np.float64]
    visible: tuple[tuple[float, float], ...] = ((0.0, 1.0),)
