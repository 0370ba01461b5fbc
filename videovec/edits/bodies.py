"""Points all along a drawing's strokes, to find what passes near a place."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from videovec.curves import evaluate, segments_of
from videovec.edits.shapes import Shape

__all__ = ["Bodies"]

Ints = NDArray[np.intp]


@dataclass(frozen=True, slots=True, eq=False)
class Bodies:
    """Points along strokes, at least one.

    Args:
        tree: To find them by. P points, px
        owner: Which stroke each belongs to. [P]
    """

    tree: cKDTree
    owner: Ints

    @classmethod
    def of(cls, shapes: list[Shape], spacing: float = 1.0) -> Bodies:
        """Points along all strokes, their ends among them.

        Args:
            shapes: One stroke at least.
            spacing: Largest distance between neighbours. px
        """
        control = [segments_of(shape.points) for shape in shapes]
        owner, segments = np.repeat(np.arange(len(shapes)), [len(part) for part in control]), np.concatenate(control)
        legs = np.linalg.norm(np.diff(segments, axis=1), axis=-1)
        # No speed exceeds three times the longest leg.
        count = 1 + np.ceil(3.0 * legs.max(axis=1) / spacing).astype(np.intp)
        which = np.repeat(np.arange(len(segments)), count)
        within = np.arange(len(which)) - np.repeat(np.cumsum(count) - count, count)
        return cls(cKDTree(evaluate(segments[which], within / (count[which] - 1).clip(1))), owner[which])
