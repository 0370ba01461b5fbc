"""Scraps dropped: strokes whose middle never leaves the ink of others, as rough edges and wrong widths make them.

Of two lines that touch, either leaves the other's edge by its own half-width somewhere. What runs along the edge of a
fat line or under it is no line, however long it is.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from videovec.brush.coordinates import RowSamples, sample_rows
from videovec.strokes import Strokes

__all__ = ["drop_scraps"]

Floats = NDArray[np.float64]

_OWN = 0.5  # of its own half-width, mean over it, by which a line's middle leaves the edge of any other somewhere
_OTHER = 0.35  # of the other's half-width, by which it does so too: rough edges are wide on wide lines
_NEIGHBOURS = 64  # samples of others that are looked at around a place


def drop_scraps(strokes: Strokes) -> Strokes:
    """Drop what runs along or under others all its length, the shortest first.

    Args:
        strokes: Those of one drawing.

    Returns:
        The strokes that somewhere leave all others.
    """
    samples = sample_rows(strokes)
    row = np.repeat(np.arange(len(strokes)), np.diff(samples.starts))
    is_kept = np.ones(len(strokes), bool)
    for stroke in np.argsort(samples.lengths, kind="stable"):
        others = is_kept[row] & (row != stroke)
        if others.any() and not _leaves(samples, row == stroke, others):
            is_kept[stroke] = False
    return strokes if is_kept.all() else strokes.select(is_kept)


def _leaves(samples: RowSamples, own: NDArray[np.bool_], others: NDArray[np.bool_]) -> bool:
    """Whether some of the ``own`` samples lie beyond the edges of the ``others`` [M] twice, of which there are some."""
    count = min(_NEIGHBOURS, int(others.sum()))
    distance, which = cKDTree(samples.points[others]).query(samples.points[own], k=np.arange(1, count + 1))
    half_width = samples.half_width[others][which]
    beyond = distance - half_width - np.maximum(_OWN * float(samples.half_width[own].mean()), _OTHER * half_width)
    return bool((beyond > 0).all(axis=1).any())
