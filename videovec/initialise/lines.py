"""Where the lines of a drawing are: a mask that holds hairlines as well as brush lines, several times enlarged."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

__all__ = ["LineMask", "line_mask"]

Coverage = NDArray[np.float32]

_FAINT = 0.06  # coverage below which nothing is a ridge, on a page without noise
_THIN_PEAK = 0.8  # ridges fainter than this belong to lines thinner than a pixel or so
_LEVEL_THIN, _LEVEL = 0.5, 0.7  # fractions of the ridge's peak at which lines are cut out
_VALLEY = 0.1  # peaks per px² by which ink must curve up to lie between lines
_GRAIN = 3.0  # and noise levels
_PINHOLE = 2.0  # px² of ink between lines that is not cut out
_QUIET = 0.004  # noise below which every mark was meant
_SPECK = 5.0  # noise levels that a component's ink must weigh on a noisy page
_LEAST_INK, _LEAST_SIDE = 1.5, 4.0  # px² of ink or px of extent that it must have there


@dataclass(frozen=True, slots=True, eq=False)
class LineMask:
    """The lines of one drawing.

    Args:
        mask: 255 on lines. uint8 [H * scale, W * scale]
        scale: Pixels of the mask per px.
        peak: Coverage on the middle of a typical line.
    """

    mask: NDArray[np.uint8]
    scale: int
    peak: float


def ridge_peak(coverage: Coverage, floor: float) -> float:
    """Median coverage of local maxima above a floor; zero where there are none."""
    blurred = cv2.GaussianBlur(coverage, (0, 0), 0.5)
    is_peak = (blurred >= cv2.dilate(blurred, np.ones((3, 3), np.uint8))) & (blurred > floor)
    return float(np.median(blurred[is_peak])) if is_peak.any() else 0.0


def _enlargement(coverage: Coverage, level: float) -> int:
    """How many times lines are enlarged so that the thin ones are some pixels wide."""
    mask = (coverage > level).astype(np.uint8)
    distance = cv2.distanceTransform(mask, cv2.DIST_L2, 3)
    is_ridge = (distance >= cv2.dilate(distance, np.ones((3, 3), np.uint8))) & (mask > 0)
    width = 2.0 * float(np.quantile(distance[is_ridge], 0.3)) if is_ridge.any() else 1.0
    return 4 if width <= 5.0 else 2 if width <= 12.0 else 1


def _without_specks(mask: NDArray[np.uint8], coverage: Coverage, scale: int, noise: float) -> NDArray[np.uint8]:
    """Drop components whose ink the page's noise could have made."""
    if noise < _QUIET:
        return mask
    count, labels, stats, _ = cv2.connectedComponentsWithStats(mask, connectivity=8)
    row, column = np.nonzero(mask)
    weight = np.bincount(labels[row, column], coverage[row // scale, column // scale], count) / scale**2
    area = stats[:, cv2.CC_STAT_AREA] / scale**2
    side = np.hypot(stats[:, cv2.CC_STAT_WIDTH], stats[:, cv2.CC_STAT_HEIGHT]) / scale
    keep = weight > _SPECK * noise * np.sqrt(np.maximum(area, 4.0))
    keep &= (weight > _LEAST_INK) | (side > _LEAST_SIDE)
    kept = np.zeros_like(mask)
    kept[row, column] = np.where(keep[labels[row, column]], np.uint8(255), np.uint8(0))
    return kept


def _without_valleys(mask: NDArray[np.bool_], large: Coverage, scale: int, limit: float) -> NDArray[np.bool_]:
    """Cut a mask where ink curves up, all directions together: between lines that a threshold runs together.

    Along a thin line ink swells and shrinks with the pixels, but across it curves down by far more. Pinholes are left
    as they were: between lines that touch again and again they would make a ladder.

    Args:
        mask: Lines. bool [H * scale, W * scale]
        large: The enlarged drawing. [H * scale, W * scale]
        scale: Its pixels per px.
        limit: Laplacian. coverage per px²
    """
    smooth = cv2.GaussianBlur(large, (0, 0), 0.25 * scale)
    curved = cv2.Sobel(smooth, cv2.CV_32F, 2, 0, ksize=3) + cv2.Sobel(smooth, cv2.CV_32F, 0, 2, ksize=3)
    cut = mask & (0.25 * scale**2 * curved <= limit)  # the kernels weigh four times
    _, labels, stats, _ = cv2.connectedComponentsWithStats((~cut).astype(np.uint8), connectivity=4)
    is_hole = stats[:, cv2.CC_STAT_AREA] < _PINHOLE * scale**2
    is_hole[0] = False
    return np.asarray(cut | (mask & is_hole[labels]))


def line_mask(coverage: Coverage, noise: float) -> LineMask:
    """Cut the lines of a drawing out.

    Args:
        coverage: Ink. float32 [H, W] in [0, 1]
        noise: Standard deviation of the page's noise, in coverage.

    Returns:
        Their mask, empty where there are none.
    """
    floor = max(_FAINT, 5.0 * noise)
    peak = ridge_peak(coverage, floor)
    if peak <= 0.0:
        return LineMask(np.zeros(coverage.shape, np.uint8), 1, 0.0)
    is_thin = peak < _THIN_PEAK
    level = (_LEVEL_THIN if is_thin else _LEVEL) * peak
    scale = 4 if is_thin else _enlargement(coverage, level)
    source = cv2.GaussianBlur(coverage, (0, 0), 0.5) if is_thin else coverage
    size = (coverage.shape[1] * scale, coverage.shape[0] * scale)
    large = np.asarray(cv2.resize(source, size, interpolation=cv2.INTER_CUBIC) if scale > 1 else source, np.float32)
    is_line = large > level
    if is_thin:
        is_line = _without_valleys(is_line, large, scale, _VALLEY * peak + _GRAIN * noise)
    mask = is_line.astype(np.uint8) * np.uint8(255)
    return LineMask(_without_specks(mask, coverage, scale, noise), scale, peak)
