"""Terms of the fit on the shape of segments, and structural similarity.

All are unweighted means without unit, so that their weights do not depend on the size of the page or the number of
strokes. Terms that tie drawings together are in `videovec.temporal`.
"""

from __future__ import annotations

from typing import Any

import cv2
import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor

from videovec.render import PairList

__all__ = ["StructuralTerm", "continuity", "curvature", "self_intersection"]

UNIT_LENGTH = 6.0
"""Length of the control polygon at which orientation is tested: its legs are then about 2, and the sigmoid of their
cross product neither flat nor saturated."""
SAMPLES, NEWTON_STEPS = 17, 3
"""Parameters among which a segment's slowest point is sought, and steps that refine it."""
TIGHTEST = 1e4
"""Sharpest curvature that costs nothing, in 1 / page side (supplement A: kappa_max)."""
WINDOW, SPREAD = 11, 1.5
"""Width and standard deviation of the Gaussian window of structural similarity. px"""
STABLE_MEAN, STABLE_VARIANCE = 0.01**2, 0.03**2
"""Constants C1 and C2 of structural similarity for values in [0, 1]."""


def self_intersection(segments: Tensor) -> Tensor:
    """Penalise segments whose two handles cross.

    A soft test of whether the leg P0 P1 crosses the leg P2 P3: each pair must lie on opposite sides of the other's
    line. With orientation o in (0, 1), "opposite sides" is a + b - 2ab and "both" is the product. A straight segment
    is undecided, 1/4.

    Args:
        segments: Control points of each segment. [G, 4, 2] px

    Returns:
        Mean over all segments, in (0, 1). Scalar.

    Source:
        Supplement A, Eq. (1) and (2). Units are ours: each segment is scaled to `UNIT_LENGTH`.
    """
    length = segments.diff(dim=-2).square().sum(-1).clamp(min=1e-12).sqrt().sum(-1)
    p0, p1, p2, p3 = (segments * (UNIT_LENGTH / length.clamp(min=1e-3))[..., None, None]).unbind(-2)
    legs_split = _either(_side(p0, p1, p2), _side(p0, p1, p3))
    handles_split = _either(_side(p2, p3, p0), _side(p2, p3, p1))
    return (legs_split * handles_split).mean()


def _side(a: Tensor, b: Tensor, c: Tensor) -> Tensor:
    """Whether c lies to the right of the line from a to b, softly; y points down."""
    u, v = b - a, c - a
    return torch.sigmoid(u[..., 1] * v[..., 0] - u[..., 0] * v[..., 1])


def _either(a: Tensor, b: Tensor) -> Tensor:
    return a + b - 2 * a * b


def curvature(segments: Tensor, side: float, tightest: float = TIGHTEST) -> Tensor:
    """Penalise bends tighter than a threshold, such as cusps.

    With R the radius at the threshold, a bend of radius r < R costs 1 - r / R: bounded at cusps, where the curvature
    itself is not.

    Args:
        segments: Control points of each segment. [G, 4, 2] px
        side: Longer side of the page. px
        tightest: Curvature that costs nothing, in 1 / side.

    Returns:
        Mean over all segments, each at its slowest point, in [0, 1). Scalar.

    Source:
        Supplement A, kappa_max = 1e4. It names no unit; per page side is our reading: 0.05 px at 512 px.
    """
    first, second = _derivatives(segments, _slowest(segments))
    cross = (first[..., 0] * second[..., 1] - first[..., 1] * second[..., 0]).abs()
    cubed = (first.square().sum(-1) + 1e-12) ** 1.5
    # 1 - radius / threshold radius, written so that straight segments, whose cross product is 0, stay finite.
    bend = cross * (side / tightest)
    return ((bend - cubed).clamp(min=0) / bend.clamp(min=1e-12)).mean()


def _slowest(segments: Tensor) -> Tensor:
    """Where each segment is slowest, which is where it may have a cusp. t [G, 1]"""
    with torch.no_grad():
        t = torch.linspace(0, 1, SAMPLES, dtype=segments.dtype, device=segments.device).expand(len(segments), -1)
        speed = _derivatives(segments[:, None], t[..., None])[0].square().sum(-1)
        t = t.gather(1, speed.argmin(dim=1, keepdim=True))
        third = 6 * (segments[:, 3] - 3 * segments[:, 2] + 3 * segments[:, 1] - segments[:, 0])
        for _ in range(NEWTON_STEPS):
            first, second = _derivatives(segments, t)
            bend = (second.square().sum(-1) + (first * third).sum(-1))[:, None]
            slope = (first * second).sum(-1)[:, None]
            t = torch.where(bend > 0, t - (slope / bend.clamp(min=1e-12)).clamp(-1, 1), t).clamp(0, 1)
    # One more step whose numerator alone has a gradient: that of the minimum.
    first, second = _derivatives(segments, t)
    slope = (first * second).sum(-1)[:, None]
    is_inside = (t > 0) & (t < 1) & (bend > 0)
    return torch.where(is_inside, t - (slope - slope.detach()) / bend.clamp(min=1e-12), t)


def _derivatives(segments: Tensor, t: Tensor) -> tuple[Tensor, Tensor]:
    """First and second derivative of segments [..., 4, 2] at t [..., 1]. 2 x [..., 2]"""
    p0, p1, p2, p3 = segments.unbind(-2)
    s = 1 - t
    first = 3 * (s * s * (p1 - p0) + 2 * s * t * (p2 - p1) + t * t * (p3 - p2))
    return first, 6 * (s * (p2 - 2 * p1 + p0) + t * (p3 - 2 * p2 + p1))


def continuity(segments: Tensor, before: Tensor, after: Tensor) -> Tensor:
    """Penalise neighbouring segments that leave their joint in directions that differ.

    Args:
        segments: Control points of each segment. [G, 4, 2] px
        before: Segments that end at the joints that are to be smooth; corners are left out. int64 [K]
        after: Segments that begin there. int64 [K]

    Returns:
        Mean over joints of 1 - cos of the turn, in [0, 2]; 0 without joints. Scalar.
    """
    if not len(before):
        return segments.sum() * 0
    arriving = segments[before, 3] - segments[before, 2]
    leaving = segments[after, 1] - segments[after, 0]
    lengths = (arriving.square().sum(-1) * leaving.square().sum(-1) + 1e-12).sqrt()
    return (1 - (arriving * leaving).sum(-1) / lengths).mean()


class StructuralTerm:
    """One minus structural similarity (SSIM) of ink coverage, with its gradient by the coverage of active pixels.

    Windows see no ink beyond the page. Six separable filters a step: a few milliseconds at 512 px, on the CPU.

    Args:
        target: Ink coverage, 255 is full. uint8 [D, H, W]

    Source:
        Wang et al. 2004, "Image quality assessment: from error visibility to structural similarity".
    """

    def __init__(self, target: Tensor) -> None:
        self._target = target

    def gradient(self, pairs: PairList, value: Tensor) -> tuple[Tensor, Tensor]:
        """Evaluate the term.

        Args:
            pairs: Tells where the active pixels lie.
            value: Coverage of each active pixel. [A]

        Returns:
            1 - SSIM, the mean over the page, of each drawing [D]; the derivative of their sum by each value [A].
        """
        drawings, height, width = self._target.shape
        losses, slopes = value.new_zeros(drawings), torch.zeros_like(value)
        for drawing in range(drawings):
            part = slice(int(pairs.drawing_pixels[drawing]), int(pairs.drawing_pixels[drawing + 1]))
            pixels = (pairs.active[part] - drawing * height * width).cpu().numpy()
            page = np.zeros(height * width, np.float32)
            page[pixels] = value[part].detach().cpu().numpy()
            seen = self._target[drawing].cpu().numpy().astype(np.float32) / np.float32(255)
            loss, slope = _dissimilarity(page.reshape(height, width), seen)
            losses[drawing] = loss
            slopes[part] = torch.from_numpy(slope.reshape(-1)[pixels]).to(slopes)
        return losses, slopes


def _dissimilarity(x: NDArray[Any], y: NDArray[Any]) -> tuple[float, NDArray[Any]]:
    """1 - mean SSIM of two images, and its derivative by each pixel of x."""
    mx: NDArray[Any] = _blur(x)
    my: NDArray[Any] = _blur(y)
    vx, vy, vxy = _blur(x * x) - mx * mx, _blur(y * y) - my * my, _blur(x * y) - mx * my
    a, b = 2 * mx * my + STABLE_MEAN, 2 * vxy + STABLE_VARIANCE
    c, d = mx * mx + my * my + STABLE_MEAN, vx + vy + STABLE_VARIANCE
    similarity = a * b / (c * d)
    # By the local mean of x, of x² and of xy; the filter is its own adjoint.
    by_square = -similarity / d
    by_product = 2 * a / (c * d)
    by_mean = 2 * my * b / (c * d) - 2 * mx * similarity / c - 2 * mx * by_square - my * by_product
    slope: NDArray[Any] = _blur(by_mean) + 2 * x * _blur(by_square) + y * _blur(by_product)
    return 1 - float(similarity.mean(dtype=np.float64)), slope * np.float32(-1 / x.size)


def _blur(image: NDArray[Any]) -> NDArray[Any]:
    return np.asarray(cv2.GaussianBlur(image, (WINDOW, WINDOW), SPREAD, borderType=cv2.BORDER_CONSTANT), np.float32)
