"""True strokes as an image: the share of every pixel's area that they cover, independent of videovec's renderer."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from videovec.curves import evaluate, segments_of
from videovec.strokes import Strokes

__all__ = ["draw_area"]

Floats = NDArray[np.float64]

_CHORDS = 16  # of each segment
_ACROSS = 8.0  # points across the thinnest line, at least where that needs no more than
_MOST = 24  # points to a px in each direction


def draw_area(strokes: Strokes, size: tuple[int, int]) -> Floats:
    """Coverage of strokes of constant widths and with round ends, by area.

    A pixel is the mean of many points, each inside or outside of the strokes.

    Args:
        strokes: Strokes of drawing 0; the width of each is its mean one.
        size: H and W. px

    Returns:
        [H, W] in [0, 1]
    """
    thinnest = 2.0 * float(strokes.half_width.min())
    samples = int(np.clip(np.ceil(_ACROSS / thinnest), 8, _MOST))
    inside = np.zeros((size[0] * samples, size[1] * samples), bool)
    t = np.linspace(0, 1, _CHORDS + 1)
    for row in range(strokes.row_count):
        reach = float(strokes.half_width_of(row).mean()) * samples
        points = evaluate(segments_of(strokes.points_of(row))[:, None], t[None]).reshape(-1, 2) * samples
        for a, b in pairwise(points):
            _fill_capsule(inside, a, b, reach)
    parts = inside.reshape(size[0], samples, size[1], samples)
    return np.asarray(parts.mean(axis=(1, 3)), dtype=np.float64)


def _fill_capsule(inside: NDArray[np.bool_], a: Floats, b: Floats, reach: float) -> None:
    """Mark the points within reach of a chord."""
    left, top = np.maximum(np.floor(np.minimum(a, b) - reach), 0).astype(int)
    right, bottom = np.maximum(np.ceil(np.maximum(a, b) + reach) + 1, 0).astype(int)
    part = inside[top:bottom, left:right]
    x = np.arange(left, left + part.shape[1]) + 0.5 - a[0]
    y = (np.arange(top, top + part.shape[0]) + 0.5 - a[1])[:, None]
    way = b - a
    along = np.clip((x * way[0] + y * way[1]) / max(float(way @ way), 1e-12), 0.0, 1.0)
    part |= (x - along * way[0]) ** 2 + (y - along * way[1]) ** 2 <= reach * reach
