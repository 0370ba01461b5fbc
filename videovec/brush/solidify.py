"""Textured ink made solid, so that it can be traced: grain is not lines.

Blurred ink is held against half of its own local level, which is where the edge of a blurred stroke stays. The blur is
the least one at which specks and pinholes no longer grow fewer, of those that are small beside the lines.
"""

from __future__ import annotations

from dataclasses import replace

import cv2
import numpy as np
from cv2 import ximgproc
from numpy.typing import NDArray

from videovec.ink import Ink

__all__ = ["blur_of", "solid_coverage", "solidify"]

Image = NDArray[np.float32]

_BLURS = (0.5, 0.7, 1.0, 1.4, 2.0, 2.8, 4.0)  # px
_WIDEST = 0.3  # of the width of the blurred lines that the blur may be: more would swallow thin lines and those beside
_FAINTEST = 0.12  # local level below which ink is not made up
_EDGE = 0.5  # share of the local level at a stroke's edge
_LOOK = 8  # drawings, at most, that the blur is chosen on


def solidify(ink: Ink, blur: float | None = None) -> Ink:
    """The ink with its grain averaged away: strokes full inside, edges a pixel wide.

    Args:
        ink: D drawings of textured lines.
        blur: Standard deviation of the blur, px; the least that rids the ink of specks and pinholes unless told.

    Returns:
        Ink of the same size, labels and palette.
    """
    blur = blur_of(ink) if blur is None else blur
    coverage = np.empty_like(ink.coverage)
    for page, seen in zip(coverage, ink.coverage, strict=True):
        page[...] = np.round(255 * solid_coverage(seen, blur))
    labels = np.stack([_nearest_label(*pair) for pair in _pairs(ink, coverage)])
    return replace(ink, coverage=coverage, label=labels, seen=None)


def _pairs(ink: Ink, coverage: NDArray[np.uint8]) -> list[tuple[NDArray[np.uint8], NDArray[np.uint8], bool]]:
    is_plain = len(ink.palette) < 2
    return [(label, seen, is_plain) for label, seen in zip(ink.label, ink.coverage, strict=True)]


def _nearest_label(label: NDArray[np.uint8], seen: NDArray[np.uint8], is_plain: bool) -> NDArray[np.uint8]:
    """Labels carried from inked pixels to those that become inked."""
    if is_plain or not (seen > 0).any():
        return label
    _, nearest = cv2.distanceTransformWithLabels(
        (seen < 64).astype(np.uint8), cv2.DIST_L2, 3, labelType=cv2.DIST_LABEL_PIXEL
    )
    inked = np.flatnonzero(seen.reshape(-1) >= 64)
    by_label = np.zeros(int(nearest.max()) + 1, np.intp)
    by_label[nearest.reshape(-1)[inked]] = inked
    return np.asarray(label.reshape(-1)[by_label[nearest]])


def blur_of(ink: Ink) -> float:
    """The least blur, of those that leave lines their width, with hardly more specks and pinholes than any. px"""
    which = np.unique(np.linspace(0, ink.drawing_count - 1, min(_LOOK, ink.drawing_count)).astype(int))
    looks = [np.mean([_look(ink.coverage[page], blur) for page in which], axis=0) for blur in _BLURS]
    flaws, width = np.array(looks).T
    fits = np.flatnonzero((np.array(_BLURS) <= _WIDEST * width) | (np.arange(len(_BLURS)) == 0))
    return _BLURS[int(fits[flaws[fits] <= 1.5 * flaws[fits].min() + 0.15][0])]


def solid_coverage(coverage: NDArray[np.uint8], blur: float) -> Image:
    """One drawing made solid. float32 [H, W] in [0, 1]"""
    steepness = np.float32(blur * np.sqrt(2 * np.pi))  # of a blurred edge, undone
    return np.asarray(np.clip(0.5 + (_relative(coverage, blur) - _EDGE) * steepness, 0, 1), dtype=np.float32)


def _relative(coverage: NDArray[np.uint8], blur: float) -> Image:
    """Blurred ink against its own level nearby. float32 [H, W]"""
    blurred = cv2.GaussianBlur(coverage.astype(np.float32) / 255, (0, 0), blur)
    side = 2 * int(np.ceil(4 * blur)) + 1
    level = cv2.dilate(blurred, cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (side, side)))
    level = cv2.GaussianBlur(level, (0, 0), 2 * blur)
    return np.asarray(blurred / np.maximum(level, _FAINTEST), dtype=np.float32)


def _look(coverage: NDArray[np.uint8], blur: float) -> tuple[float, float]:
    """Specks and pinholes per 100 px of skeleton, and the mean width of what is inside in px."""
    inside = (_relative(coverage, blur) > _EDGE).astype(np.uint8)
    length = max(int((ximgproc.thinning(255 * inside) > 0).sum()), 1)
    largest = np.pi * (3 * blur + 2) ** 2
    count = 0
    for mask, connectivity in ((inside, 8), (1 - inside, 4)):
        _, _, stats, _ = cv2.connectedComponentsWithStats(mask, connectivity=connectivity)
        count += int((stats[1:, cv2.CC_STAT_AREA] < largest).sum())
    return 100.0 * count / length, float(inside.sum()) / length
