"""The page that ink lies on: its colour, its shading and its noise."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from videovec.clip import Clip

__all__ = ["Page", "estimate_page", "flatten", "page_noise", "unit_values"]

Floats = NDArray[np.float32]

SAMPLE = 200_000
"""Number of pixels from which statistics are taken."""

FLAT = 2.0 / 255
"""Shading that varies by no more than this is left alone, so that a clean page stays exact."""

DEGREE = 4
"""Of the polynomial that shading is described by: enough for a gradient with a vignette."""

PAGE_SPREAD = 0.08
"""How far page pixels may lie from the page's most frequent colour."""


@dataclass(frozen=True, slots=True, eq=False)
class Page:
    """What lies under the ink.

    Args:
        color: Of the flattened page, sRGB in [0, 1]. [3]
        flatten: Whether shading is to be divided out.
    """

    color: NDArray[np.float64]
    flatten: bool


def unit_values(image: NDArray[np.unsignedinteger[Any]]) -> Floats:
    """Values in [0, 1]. [H, W, 3]"""
    return image.astype(np.float32) / np.float32(np.iinfo(image.dtype).max)


def estimate_page(clip: Clip, drawings: NDArray[np.intp], flatten: bool) -> Page:
    """The most frequent colour of some drawings: lines cover less than the page does.

    The mode is found on a coarse grid of colours, then refined to the median around it, so that a clean page comes
    out exactly and noise is averaged away.

    Args:
        clip: The clip.
        drawings: Which of its drawings to look at. int [K]
        flatten: Whether uneven paper is to be divided out.
    """
    stride = max(1, int(np.sqrt(len(drawings) * np.prod(clip.size) / SAMPLE)))
    sample = np.concatenate([unit_values(clip.drawings[d][::stride, ::stride]).reshape(-1, 3) for d in drawings])
    bins = np.minimum((sample * 16).astype(np.intp), 15)
    histogram = np.bincount(bins @ np.array([256, 16, 1]), minlength=4096).reshape(16, 16, 16).astype(np.float64)
    cell = np.array(np.unravel_index(int(np.argmax(histogram)), histogram.shape))
    color = np.median(sample[np.all(bins == cell, axis=1)], axis=0)
    for _ in range(3):
        near = np.abs(sample - color).max(axis=1) < PAGE_SPREAD
        color = np.median(sample[near], axis=0)
    return Page(color.astype(np.float64), flatten)


def flatten(image: Floats, page: Page) -> Floats:
    """An image with the shading of its paper taken out.

    Shading multiplies light paper; on a dark board it multiplies the distance from white.

    Args:
        image: sRGB in [0, 1]. [H, W, 3]
        page: The page of the clip.

    Returns:
        The same image where the page is even. [H, W, 3]
    """
    if not page.flatten:
        return image
    surfaces = _shading(image, page)
    ends = np.linspace(0, 1, 17)
    coarse = np.stack([_evaluate(surface, ends, ends) for surface in surfaces], axis=2)
    if np.abs(coarse - page.color).max() <= FLAT:
        return image
    height, width = image.shape[:2]
    x, y = (np.arange(width) + 0.5) / width, (np.arange(height) + 0.5) / height
    flat = np.empty_like(image)
    is_light = page.color.mean() >= 0.5
    for channel, surface in enumerate(surfaces):
        shading = _evaluate(surface, x, y).astype(np.float32)
        color, values = np.float32(page.color[channel]), image[..., channel]
        if is_light:
            flat[..., channel] = values * (color / np.maximum(shading, 1e-3))
        else:
            flat[..., channel] = 1 - (1 - values) * ((1 - color) / np.maximum(1 - shading, 1e-3))
    return np.clip(flat, 0, 1)


def _shading(image: Floats, page: Page) -> NDArray[np.float64]:
    """The page's colour as a smooth surface through the pixels that carry no ink.

    Iteratively reweighted least squares from block medians; ink is an outlier.

    Returns:
        Coefficients of x^i y^j for each channel, x and y in [0, 1]. [3, DEGREE + 1, DEGREE + 1]
    """
    height, width = image.shape[:2]
    block = max(1, min(height, width) // 32)
    rows, columns = height // block, width // block
    stride = max(1, block // 6)
    cropped = image[: rows * block, : columns * block].reshape(rows, block, columns, block, 3)[:, ::stride, :, ::stride]
    medians = np.median(cropped.transpose(0, 2, 4, 1, 3).reshape(rows * columns, 3, -1), axis=2)
    y, x = np.meshgrid(
        (np.arange(rows) + 0.5) * block / height, (np.arange(columns) + 0.5) * block / width, indexing="ij"
    )
    powers = [(i, j) for i in range(DEGREE + 1) for j in range(DEGREE + 1 - i)]
    basis = np.stack([x.ravel() ** i * y.ravel() ** j for i, j in powers], axis=1)
    residual = np.abs(medians - page.color).max(axis=1)
    for _ in range(12):
        scale = max(0.004, 1.5 * float(np.median(residual)))
        weight = (1 / (1 + (residual / scale) ** 4))[:, None]
        coefficients, *_ = np.linalg.lstsq(basis * weight, medians * weight, rcond=None)
        residual = np.abs(medians - basis @ coefficients).max(axis=1)
    surfaces = np.zeros((3, DEGREE + 1, DEGREE + 1))
    for (i, j), term in zip(powers, coefficients, strict=True):
        surfaces[:, j, i] = term
    return surfaces


def _evaluate(surface: NDArray[np.float64], x: NDArray[np.float64], y: NDArray[np.float64]) -> NDArray[np.float64]:
    """A polynomial surface on a grid. [len(y), len(x)]"""
    powers = np.arange(DEGREE + 1)
    return np.clip((y[:, None] ** powers) @ surface @ (x[:, None] ** powers).T, 0, 1)


def page_noise(deviation: Floats, ink: NDArray[np.uint8]) -> tuple[float, float]:
    """Noise of the page, far from ink and beside it.

    Lossy codecs ring beside lines, so two numbers are needed. The page is smooth: a second difference sees noise
    alone (see ``decode_holds.compression_noise``).

    Args:
        deviation: Distance of every pixel from the page's colour. [H, W]
        ink: Nonzero where there surely is ink. uint8 [H, W]

    Returns:
        Standard deviation far from ink, and beside it, in the unit of ``deviation``.
    """
    near, wide = (cv2.dilate(ink, np.ones((2 * r + 1, 2 * r + 1), np.uint8)) > 0 for r in (3, 10))
    return _spread(deviation[~wide]), _spread(deviation[wide & ~near])


def _spread(values: Floats) -> float:
    """Root mean square of the smaller 95 % of values; 0 of none."""
    if not len(values):
        return 0.0
    kept = np.sort(np.abs(values))[: max(1, int(0.95 * len(values)))]
    return float(np.sqrt(np.mean(kept.astype(np.float64) ** 2)))
