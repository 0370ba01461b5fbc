"""What strokes are registered to: the skeleton of a drawing's ink, its direction, and where other ink lies."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

__all__ = ["Target", "distance_to", "make_target", "sample"]

Floats = NDArray[np.float64]
Image = NDArray[np.float32]

_MOMENT_SCALES = ((6.0, 2), (16.0, 4))
"""Standard deviation of each moment's window, px, and by how much the ink is shrunk before it is blurred."""
_MOMENT_FLOOR = 1e-3
"""Blurred ink below which a moment fades, since there is nothing to point to."""


@dataclass(frozen=True, slots=True, eq=False)
class Target:
    """A drawing as M points on the centre lines of its ink, in working px.

    Args:
        scale: Working px for each px of the drawing.
        ink: Coverage. float32 [H, W] in [0, 1]
        threshold: Coverage above which a pixel is ink.
        skeleton: Where the thinned ink is. bool [H, W]
        points: Centre-line points, to a fraction of a pixel. [M, 2] px
        direction: Unit tangents, of arbitrary sign. [M, 2]
        half_width: Of the ink around each point. [M] px
        moment_maps: Pull of the surrounding ink, two vectors for each pixel. float32 [H, W, 4]
        distance: From each pixel to the nearest skeleton pixel. float32 [H, W] px
        nearest: The centre-line point whose pixel that is; 0 where there is none. int [H, W]
    """

    scale: float
    ink: Image
    threshold: float
    skeleton: NDArray[np.bool_]
    points: Floats
    direction: Floats
    half_width: Floats
    moment_maps: Image
    distance: Image
    nearest: NDArray[np.int32]

    def __len__(self) -> int:
        """M."""
        return len(self.points)

    def moments(self, positions: Floats) -> Floats:
        """Pull of the ink around some positions. [N, 4]"""
        return sample(self.moment_maps, positions)

    def on_page(self, positions: Floats) -> NDArray[np.bool_]:
        """Which positions are not beyond the page. bool [N]"""
        return np.asarray(((positions >= 0.0) & (positions <= self.ink.shape[::-1])).all(axis=1))

    def distance_at(self, positions: Floats) -> Floats:
        """Distance of some positions from the skeleton; beyond the page the distance to the page is added. [N] px"""
        height, width = self.distance.shape
        inside = np.clip(positions, 0.5, [width - 0.5, height - 0.5])
        return np.asarray(sample(self.distance, inside) + np.linalg.norm(positions - inside, axis=1))


def sample(image: Image, positions: Floats) -> Floats:
    """Values of an image between its pixel centres, its edge beyond. [N] or [N, C]"""
    if len(positions) == 0:
        return np.zeros((0, *image.shape[2:]))
    # Far outside, cv2.remap's fixed-point coordinates overflow.
    at = np.clip(positions - 0.5, -1.0, [image.shape[1], image.shape[0]]).astype(np.float32)
    rows = [
        cv2.remap(image, at[i : i + 30000, None, 0], at[i : i + 30000, None, 1], cv2.INTER_LINEAR,
                  borderMode=cv2.BORDER_REPLICATE)
        for i in range(0, len(at), 30000)
    ]  # fmt: skip
    return np.asarray(np.concatenate(rows)[:, 0], dtype=np.float64)


def make_target(coverage: NDArray[np.uint8], long_edge: int) -> Target:
    """Thin a drawing's ink and look around on it.

    Args:
        coverage: Ink of one drawing. uint8 [H, W]
        long_edge: The drawing is shrunk to this size if it is larger. px

    Returns:
        The target; one without points if there is no ink.
    """
    scale = min(1.0, long_edge / max(coverage.shape))
    ink = coverage.astype(np.float32) / 255.0
    if scale < 1.0:
        size = (max(1, round(ink.shape[1] * scale)), max(1, round(ink.shape[0] * scale)))
        ink = np.asarray(cv2.resize(ink, size, interpolation=cv2.INTER_AREA), np.float32)
    threshold = ink_threshold(ink)
    mask = ink > threshold
    skeleton = _thin(mask)
    to_skeleton, nearest = distance_to(skeleton)
    row, column = np.nonzero(skeleton)
    points = np.stack([column + 0.5, row + 0.5], axis=1)
    depth = cv2.distanceTransform(np.pad(mask, 1).astype(np.uint8), cv2.DIST_L2, 5)[1:-1, 1:-1]
    half_width = depth[row, column].astype(np.float64) if len(points) else np.zeros(0)
    direction = _direction(ink, points, half_width)
    return Target(
        scale=scale,
        ink=ink,
        threshold=threshold,
        skeleton=skeleton,
        points=_centred(ink, points, direction, half_width),
        direction=direction,
        half_width=half_width,
        moment_maps=_moment_maps(ink),
        distance=to_skeleton,
        nearest=nearest,
    )


def ink_threshold(ink: Image) -> float:
    """A fraction of the ridge height, so that hairlines have a skeleton too; above 1 on an empty page."""
    drawn = ink[ink > 0.08]
    return 0.4 * float(np.percentile(drawn, 90)) if len(drawn) else 2.0


def _thin(mask: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Guo-Hall thinning; the border is padded, since OpenCV's leaves border pixels as they are."""
    if not mask.any():
        return mask
    padded = np.pad(mask, 2).astype(np.uint8) * 255
    thin = cv2.ximgproc.thinning(padded, thinningType=cv2.ximgproc.THINNING_GUOHALL)
    return np.asarray(thin[2:-2, 2:-2] > 0)


def distance_to(skeleton: NDArray[np.bool_]) -> tuple[Image, NDArray[np.int32]]:
    """Distance of each pixel from a skeleton, and the number of its nearest pixel in reading order."""
    if not skeleton.any():
        far = np.full(skeleton.shape, float(sum(skeleton.shape)), np.float32)
        return far, np.zeros(skeleton.shape, np.int32)
    distance, label = cv2.distanceTransformWithLabels(
        (~skeleton).astype(np.uint8), cv2.DIST_L2, 5, labelType=cv2.DIST_LABEL_PIXEL
    )
    order = np.zeros(int(label.max()) + 1, np.int32)
    order[label[skeleton]] = np.arange(int(skeleton.sum()))
    return np.asarray(distance, np.float32), np.asarray(order[label], np.int32)


def _direction(ink: Image, points: Floats, half_width: Floats) -> Floats:
    """Main direction of the structure tensor: across it the ink changes most. [M, 2]"""
    if len(points) == 0:
        return np.zeros((0, 2))
    width = float(np.median(half_width))
    smooth = cv2.GaussianBlur(ink, (0, 0), max(1.0, 0.5 * width))
    gx, gy = cv2.Sobel(smooth, cv2.CV_32F, 1, 0), cv2.Sobel(smooth, cv2.CV_32F, 0, 1)
    products = np.stack([gx * gx, gx * gy, gy * gy], axis=2)
    tensor = np.asarray(cv2.GaussianBlur(products, (0, 0), max(1.5, width)), np.float32)
    xx, xy, yy = sample(tensor, points).T
    angle = 0.5 * np.arctan2(2 * xy, xx - yy) + 0.5 * np.pi
    return np.stack([np.cos(angle), np.sin(angle)], axis=1)


def _centred(ink: Image, points: Floats, direction: Floats, half_width: Floats) -> Floats:
    """Shift points along their normals to the centre of the ink that they lie in. [M, 2]"""
    if len(points) == 0:
        return points
    normal = np.stack([-direction[:, 1], direction[:, 0]], axis=1)
    offsets = np.linspace(-2.0, 2.0, 9)
    across = sample(ink, (points[:, None] + offsets[:, None] * normal[:, None]).reshape(-1, 2)).reshape(-1, 9)
    across[np.abs(offsets) > half_width[:, None] + 1.5] = 0.0
    shift = (across @ offsets) / np.maximum(across.sum(axis=1), 1e-6)
    # In the middle of a wide line all samples are full and nothing can be learned.
    return np.asarray(points + np.clip(shift, -1.0, 1.0)[:, None] * normal)


def _moment_maps(ink: Image) -> Image:
    """Scale times the gradient of the logarithm of blurred ink, at two scales. [H, W, 4]"""
    height, width = ink.shape
    maps = []
    for sigma, shrink in _MOMENT_SCALES:
        size = (max(1, width // shrink), max(1, height // shrink))
        small = cv2.resize(ink, size, interpolation=cv2.INTER_AREA)
        blurred = cv2.GaussianBlur(small, (0, 0), sigma / shrink, borderType=cv2.BORDER_CONSTANT)
        gradient = [cv2.Sobel(blurred, cv2.CV_32F, *axis, scale=0.125) for axis in ((1, 0), (0, 1))]
        pull = sigma / shrink * np.stack(gradient, axis=2) / (blurred + _MOMENT_FLOOR)[..., None]
        maps.append(cv2.resize(pull, (width, height), interpolation=cv2.INTER_LINEAR).reshape(height, width, 2))
    return np.asarray(np.concatenate(maps, axis=2), np.float32)
