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
"""Blocks that differ from the page by no more than this are even, so that a clean page stays exact."""

BLOCKS = 32
"""Number of blocks along the shorter side, of each of which the median colour is taken."""

SLIGHT = 0.15
"""Blocks that differ from the page by less than this are shaded; by more, inked."""

LEAST_SHADED = 0.05
"""Share of shaded blocks from which the page counts as uneven."""

LARGEST_NOISE = 0.08
"""Largest standard deviation that is taken for noise."""

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
    medians = _block_medians(image)
    departure = np.abs(medians - page.color).max(axis=2)
    if np.mean((departure > FLAT) & (departure < SLIGHT)) < LEAST_SHADED:
        return image
    surface = _shading(medians)
    if np.abs(surface - page.color).max() <= FLAT:
        return image
    flat = np.empty_like(image)
    is_light = page.color.mean() >= 0.5
    for channel, blocks in enumerate(np.moveaxis(surface, 2, 0)):
        shading = _enlarged(blocks, image.shape[:2])
        color, values = np.float32(page.color[channel]), image[..., channel]
        if is_light:
            flat[..., channel] = values * (color / np.maximum(shading, 1e-3))
        else:
            flat[..., channel] = 1 - (1 - values) * ((1 - color) / np.maximum(1 - shading, 1e-3))
    return np.clip(flat, 0, 1)


def _block_medians(image: Floats) -> NDArray[np.float64]:
    """Median colour of every block of a grid over the page. [rows, columns, 3]

    The page is stretched to whole blocks, so that the grid covers it evenly.
    """
    block = max(1, min(image.shape[:2]) // BLOCKS)
    stride = max(1, block // 6)
    rows, columns = (round(side / block) for side in image.shape[:2])
    per_block = -(-block // stride)
    grid = cv2.resize(image, (columns * per_block, rows * per_block), interpolation=cv2.INTER_NEAREST)
    blocks = grid.reshape(rows, per_block, columns, per_block, 3).transpose(0, 2, 4, 1, 3)
    medians: NDArray[np.float64] = np.median(blocks.reshape(rows, columns, 3, -1), axis=3).astype(np.float64)
    return medians


def _enlarged(blocks: NDArray[np.float64], size: tuple[int, ...]) -> Floats:
    """Values of blocks, at every pixel; continued in straight lines beyond the outermost centres. [H, W]"""
    padded = np.pad(blocks, 2, mode="reflect", reflect_type="odd").astype(np.float32)
    y, x = ((np.arange(side) + 0.5) * count / side + 1.5 for side, count in zip(size, blocks.shape, strict=True))
    columns, rows = np.meshgrid(x.astype(np.float32), y.astype(np.float32))
    return np.asarray(cv2.remap(padded, columns, rows, cv2.INTER_CUBIC, borderMode=cv2.BORDER_REPLICATE), np.float32)


def _shading(medians: NDArray[np.float64]) -> NDArray[np.float64]:
    """The page's colour at every block: a smooth surface through the blocks that carry no ink.

    A polynomial by iteratively reweighted least squares, to which ink is an outlier; then what it leaves, smoothed.

    Args:
        medians: Median colours. [rows, columns, 3]
    """
    rows, columns = medians.shape[:2]
    y, x = np.meshgrid(np.linspace(-1, 1, rows), np.linspace(-1, 1, columns), indexing="ij")
    powers = [(i, j) for i in range(DEGREE + 1) for j in range(DEGREE + 1 - i)]
    basis = np.stack([x.ravel() ** i * y.ravel() ** j for i, j in powers], axis=1)
    colors = medians.reshape(-1, 3)
    weight = np.ones((len(basis), 1))
    for step in range(16):
        coefficients, *_ = np.linalg.lstsq(basis * weight, colors * weight, rcond=None)
        residual = np.abs(colors - basis @ coefficients).max(axis=1, keepdims=True)
        scale = max(0.004, 1.5 * float(np.median(residual)))
        # First least absolute deviations, which a bad start does not mislead; then ink is left out altogether.
        weight = 1 / np.sqrt(np.maximum(residual, 1e-3)) if step < 8 else 1 / (1 + (residual / scale) ** 4)
    surface = (basis @ coefficients).reshape(medians.shape)
    trust = (1 / (1 + (residual / (2 * scale)) ** 4)).reshape(rows, columns, 1)
    left = cv2.GaussianBlur((medians - surface) * trust, (0, 0), 1.5)
    surface += left / np.maximum(cv2.GaussianBlur(trust, (0, 0), 1.5)[..., None], 0.05)
    return np.clip(surface, 0, 1)


def page_noise(deviation: Floats, strongest: float) -> tuple[float, float]:
    """Noise of the page, far from ink and beside it, where lossy codecs ring.

    Args:
        deviation: Value less page. [H, W, 3]
        strongest: Largest deviation of ink.

    Returns:
        Root mean square deviation far from ink, and 2 to 7 px beside it.
    """
    signed = deviation.mean(axis=2)
    size = np.abs(signed)
    spread = min(LARGEST_NOISE, float(np.quantile(size, 0.75)) / 0.674)  # a page at white shows half of its noise
    ink = (size > max(0.25 * strongest, 4 * spread)).astype(np.uint8)
    near, wide = (cv2.dilate(ink, np.ones((2 * r + 1, 2 * r + 1), np.uint8)) > 0 for r in (2, 7))
    faint = size < max(0.1 * strongest, 4 * spread)
    return _rms(signed[~wide & faint]), _rms(signed[wide & ~near & faint])


def _rms(values: Floats) -> float:
    """Root mean square; 0 of none."""
    return float(np.sqrt(np.mean(values.astype(np.float64) ** 2))) if len(values) else 0.0
