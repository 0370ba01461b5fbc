"""The affine map that a motion of points is nearest to."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

__all__ = ["affine_change"]

Floats = NDArray[np.float64]


def affine_change(centred: Floats, motion: Floats, spread: float) -> Floats:
    """The linear part of a motion, by least squares; less of it in directions in which the points are hardly spread.

    Args:
        centred: Points around their mean. [n, 2] px
        motion: How far each went. [n, 2] px
        spread: Standard deviation of the points in a direction at which half of the change there is believed. px

    Returns:
        The change: a point at p goes p times this farther than the mean. [2, 2]
    """
    normal = centred.T @ centred + len(centred) * spread**2 * np.eye(2)
    return np.asarray(np.linalg.solve(normal, centred.T @ motion))
