"""Half-widths of strokes, weighed: the ink that lies nearest to each stretch of a stroke, over its length."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import gaussian_filter1d
from scipy.spatial import cKDTree

from videovec.initialise.centreline import CentreLine
from videovec.initialise.polyline import arc

__all__ = ["measure_widths"]

Floats = NDArray[np.float64]

_FAINT = 0.01  # coverage that is not weighed
_WINDOW = 1.5  # widths over which the ink is averaged
_CLEAR = 1.5  # widths from other strokes, and from ends, within which the ink is not a stroke's own
_SPARSE = 0.25  # widths between samples that are looked around
_STEADY = 0.12  # relative spread of a stroke's width below which it is constant


def _weigh(lines: list[CentreLine], coverage: NDArray[np.float32]) -> list[Floats]:
    """Ink whose nearest sample is each sample of each line, per px of line. S times [M] px"""
    samples = np.concatenate([line.line for line in lines])
    widest = max(line.width for line in lines)
    row, column = np.nonzero(coverage > _FAINT)
    distance, nearest = cKDTree(samples).query(
        np.stack([column + 0.5, row + 0.5], axis=1), distance_upper_bound=1.5 * widest + 2.0
    )
    found = np.isfinite(distance)
    mass = np.bincount(nearest[found], coverage[row[found], column[found]], len(samples))
    return np.split(mass, np.cumsum([len(line.line) for line in lines])[:-1])


def _is_clear(lines: list[CentreLine]) -> list[NDArray[np.bool_]]:
    """Whether the ink around each sample is its stroke's own. S times bool [M]

    Of wide lines some samples stand for their neighbours: looking around grows with the square of their number.
    """
    strides = [max(1, int(_SPARSE * line.width / _spacing(line.line))) for line in lines]
    sparse = [line.line[::stride] for line, stride in zip(lines, strides, strict=True)]
    tree = cKDTree(np.concatenate(sparse))
    result = []
    for i, (line, stride) in enumerate(zip(lines, strides, strict=True)):
        along = arc(line.line)
        away = np.minimum(along, along[-1] - along)
        clear = np.ones(len(along), bool) if line.is_closed else away > 0.6 * line.width
        reach = _CLEAR * line.width
        around = tree.query_ball_point(sparse[i], reach, return_length=True)
        alone = around == cKDTree(sparse[i]).query_ball_point(sparse[i], reach, return_length=True)
        result.append(clear & np.repeat(alone, stride)[: len(along)])
    return result


def _spacing(line: Floats) -> float:
    """Mean distance of neighbouring samples. px"""
    return max(float(arc(line)[-1]) / max(len(line) - 1, 1), 1e-6)


def measure_widths(lines: list[CentreLine], coverage: NDArray[np.float32]) -> list[Floats]:
    """Measure how wide strokes are.

    Where other strokes are near, or at an end, the width is carried over from the rest of the stroke. A stroke whose
    width hardly changes gets one width, and a stroke that is never clear gets that of the drawing.

    Args:
        lines: Centre lines.
        coverage: The ink. [H, W] in [0, 1]

    Returns:
        Half-width at every sample of every line. S times [M] px
    """
    if not lines:
        return []
    masses, clears = _weigh(lines, coverage), _is_clear(lines)
    measured: list[tuple[Floats, Floats]] = []
    for line, mass, clear in zip(lines, masses, clears, strict=True):
        step = _spacing(line.line)
        mode = "wrap" if line.is_closed else "constant"
        sigma = max(_WINDOW * line.width, 1.0) / step
        weight = gaussian_filter1d(clear.astype(float), sigma, mode=mode)
        width = gaussian_filter1d(np.where(clear, mass, 0.0), sigma, mode=mode) / (step * np.maximum(weight, 1e-9))
        measured.append((width, weight))
    sure = [width[clear] for (width, _), clear in zip(measured, clears, strict=True) if clear.any()]
    typical = float(np.median(np.concatenate(sure))) if sure else float(np.median([line.width for line in lines]))
    result = []
    for (width, weight), clear in zip(measured, clears, strict=True):
        if clear.sum() < 4:
            result.append(np.full(len(width), 0.5 * typical))
            continue
        middle = float(np.median(width[clear]))
        spread = float(np.quantile(width[clear], 0.9) - np.quantile(width[clear], 0.1)) / middle
        if spread < _STEADY:
            result.append(np.full(len(width), 0.5 * middle))
            continue
        at = np.flatnonzero(weight > 0.2 * weight.max())
        result.append(0.5 * np.interp(np.arange(len(width)), at, width[at]))
    return result
