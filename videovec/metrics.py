"""How close strokes are to true strokes, and their picture to the true picture.

Geometry follows the supplement: Chamfer distance, length difference, count. Topology asks what an animator would: is
each true stroke one stroke here, and nothing but it? Images are compared by PSNR and SSIM (and LPIPS, see
`videovec.perceptual`).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import torch
from numpy.typing import NDArray
from scipy.optimize import linear_sum_assignment
from scipy.spatial import cKDTree

from videovec.curves import arc_length, sample_by_arc
from videovec.errors import FitError
from videovec.strokes import Strokes

__all__ = ["Topology", "chamfer", "length_difference", "psnr", "ssim", "topology"]

Floats = NDArray[np.float64]

SAMPLES = 200
"""Points on each stroke, equally far apart along it. Source: supplement A, "Chamfer Distance"."""
_ENOUGH = 0.9  # share of a stroke's length that must be covered
_SSIM_WINDOW = 11  # px


def _samples(strokes: Strokes) -> Floats:
    """Points on every row. [R, 200, 2] px"""
    return np.stack([sample_by_arc(strokes.points_of(row), SAMPLES) for row in range(strokes.row_count)])


def _need_strokes(truth: Strokes, strokes: Strokes) -> None:
    if not truth.row_count or not strokes.row_count:
        raise FitError(f"a comparison needs strokes, got {truth.row_count} true and {strokes.row_count} others")


def chamfer(truth: Strokes, strokes: Strokes) -> float:
    """Chamfer distance between two drawings.

    Args:
        truth: True strokes of one drawing.
        strokes: Strokes to judge.

    Returns:
        Half the mean nearest distance each way. px

    Raises:
        FitError: There is no stroke on one side.

    Source:
        Supplement A, Eq. (3), with 200 points on each stroke.
    """
    _need_strokes(truth, strokes)
    one, two = _samples(truth).reshape(-1, 2), _samples(strokes).reshape(-1, 2)
    there, back = cKDTree(two).query(one)[0], cKDTree(one).query(two)[0]
    return float(0.5 * there.mean() + 0.5 * back.mean())


def length_difference(truth: Strokes, strokes: Strokes) -> float:
    """Difference of the total stroke lengths over the true one. Source: supplement A."""
    _need_strokes(truth, strokes)
    one, two = (sum(arc_length(s.points_of(row)) for row in range(s.row_count)) for s in (truth, strokes))
    return float(abs(two - one) / one)


@dataclass(frozen=True, slots=True)
class Topology:
    """Whether strokes are the true strokes, one for one.

    Args:
        covered: Share of true strokes of whose length 90 % lies near a single stroke ("c90").
        matched: Share of true strokes that have a stroke to themselves: assigned one to one by mean distance, and each
            covering 90 % of the other ("strict").
        fragments: Strokes that lie along one true stroke but cover less than 90 % of it.
        merges: Strokes that lie along no single true stroke.
    """

    covered: float
    matched: float
    fragments: int
    merges: int


def topology(truth: Strokes, strokes: Strokes, tolerance: float) -> Topology:
    """Compare which ink belongs together.

    Args:
        truth: True strokes of one drawing.
        strokes: Strokes to judge.
        tolerance: Distance within which a stroke covers a point. px

    Returns:
        The shares and counts.

    Raises:
        FitError: There is no stroke on one side.
    """
    _need_strokes(truth, strokes)
    one, two = _samples(truth), _samples(strokes)
    there = np.stack([cKDTree(points).query(one)[0] for points in two], axis=1)  # [truth, strokes, samples]
    back = np.stack([cKDTree(points).query(two)[0] for points in one], axis=0)
    recall, precision = (there <= tolerance).mean(axis=2), (back <= tolerance).mean(axis=2)
    rows, columns = linear_sum_assignment(there.mean(axis=2) + back.mean(axis=2))
    matched = (recall[rows, columns] >= _ENOUGH) & (precision[rows, columns] >= _ENOUGH)
    is_part = precision.max(axis=0) >= _ENOUGH
    is_whole = np.any((recall >= _ENOUGH) & (precision >= _ENOUGH), axis=0)
    return Topology(
        covered=float((recall.max(axis=1) >= _ENOUGH).mean()),
        matched=float(matched.sum() / len(one)),
        fragments=int((is_part & ~is_whole).sum()),
        merges=int((~is_part).sum()),
    )


def psnr(truth: Floats, image: Floats) -> float:
    """Peak signal-to-noise ratio of two images with values in [0, 1], over all pixels and channels. dB"""
    error = float(np.mean((np.asarray(truth, float) - np.asarray(image, float)) ** 2))
    return float("inf") if error == 0.0 else float(-10.0 * np.log10(error))


def ssim(truth: Floats, image: Floats) -> float:
    """Structural similarity of two images of one channel with values in [0, 1].

    The mean over all 11 x 11 Gaussian windows (sigma 1.5) that lie inside the image; K1 0.01, K2 0.03.

    Args:
        truth: True image. [H, W]
        image: Image to judge. [H, W]

    Returns:
        1 for equal images.

    Source:
        Wang et al. 2004, "Image quality assessment: from error visibility to structural similarity".
    """
    if truth.ndim != 2 or truth.shape != image.shape or min(truth.shape) < _SSIM_WINDOW:
        raise FitError(f"ssim needs two equal images over 10 px, got {truth.shape} and {image.shape}")
    from kornia.metrics import ssim as ssim_of_windows  # takes a second to import, which a run need not spend

    one, two = (torch.from_numpy(np.array(x, np.float64))[None, None] for x in (truth, image))
    return float(ssim_of_windows(one, two, _SSIM_WINDOW, padding="valid").mean())
