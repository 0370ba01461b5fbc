"""Which inks a clip is drawn with.

Only the cores of lines are asked: edges are mixtures with the page, and lossy chroma frays them. A core is *wide*
where its surroundings have its own colour, on lines of about 2.5 px and more; such a plateau shows the ink itself. A
thin line shows only a lower bound of its ink's depth: a hairline of black ink and a wider line of grey ink look the
same. The rule for thin lines:

1. If a wide ink of the same hue and at least their depth exists, they are drawn with it.
2. Else, if their ink (mass per length) is at least ``RESOLVED`` times their peak, they are wider than a pixel, so
   that their peak is the ink's depth.
3. Else, or if their peak comes near it, they are drawn with the deepest colour of their hue: black, for greys.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

__all__ = ["Cores", "core_masks", "estimate_palette", "magnitude", "sample_cores"]

Floats = NDArray[np.float32]

MOST_INKS = 8
"""Largest number of inks of a clip."""

SAME_COLOR = 0.17
"""Wide cores within this distance, over all channels, are of one ink."""

SAME_HUE = math.radians(15)
"""Lines whose deviation from the page has the same direction to within this are of one hue."""

LEAST_SHARE = 0.01
"""Share of all cores that an ink must have."""

RESOLVED = 1.6
"""Mass over peak from which a line is wider than a pixel. px"""

NEARLY_DEEPEST = 0.85
"""A thin line that comes this near to the deepest colour of its hue is drawn with it."""


LENGTH_PER_PIXEL = 1.12
"""Mean length of a digital line per pixel of its skeleton, over all directions. px"""


@dataclass(frozen=True, slots=True, eq=False)
class Cores:
    """Middles of lines, for statistics.

    Args:
        deviation: Value less page. [N, 3]
        is_wide: Whether each lies on a plateau. bool [N]
        mass: Magnitude summed across the line. [N] px
    """

    deviation: Floats
    is_wide: NDArray[np.bool_]
    mass: Floats

    @staticmethod
    def concatenate(parts: list[Cores]) -> Cores:
        """Cores of several drawings."""
        return Cores(
            np.concatenate([part.deviation for part in parts]),
            np.concatenate([part.is_wide for part in parts]),
            np.concatenate([part.mass for part in parts]),
        )

    def select(self, which: NDArray[np.bool_]) -> Cores:
        """Some of the cores."""
        return Cores(self.deviation[which], self.is_wide[which], self.mass[which])


def magnitude(deviation: Floats) -> Floats:
    """Distance from the page, 1 from white to black. [...]"""
    size: Floats = np.sqrt(np.einsum("...c,...c->...", deviation, deviation) / 3)
    return size


def core_masks(deviation: Floats, threshold: float) -> tuple[NDArray[np.bool_], NDArray[np.bool_]]:
    """Pixels in the middle of lines, and which of them lie on a plateau.

    Args:
        deviation: Value less page. [H, W, 3]
        threshold: Magnitude under which there is only noise.

    Returns:
        Cores, and wide cores among them. bool [H, W] each
    """
    size = magnitude(deviation)
    core = (size > threshold) & (size >= 0.9 * cv2.dilate(size, np.ones((3, 3), np.uint8)))
    rows, columns = np.nonzero(core)
    own = deviation[rows, columns]
    alike = np.zeros(len(rows), np.int8)
    for dy, dx in ((-1, -1), (-1, 0), (-1, 1), (0, -1), (0, 1), (1, -1), (1, 0), (1, 1)):
        y, x = np.clip(rows + dy, 0, core.shape[0] - 1), np.clip(columns + dx, 0, core.shape[1] - 1)
        alike += magnitude(deviation[y, x] - own) <= 0.2 * size[rows, columns]
    wide = np.zeros_like(core)
    wide[rows, columns] = alike >= 6
    return core, wide


def sample_cores(deviation: Floats, threshold: float) -> Cores:
    """The cores of a drawing, with the mass of their lines.

    Args:
        deviation: Value less page. [H, W, 3]
        threshold: Magnitude under which there is only noise.
    """
    core, wide = core_masks(deviation, threshold)
    size = magnitude(deviation)
    line = (size > threshold) & (size > 0.5 * cv2.dilate(size, np.ones((5, 5), np.uint8)))
    skeleton = cv2.ximgproc.thinning(line.astype(np.uint8) * 255) > 0
    ink = cv2.boxFilter(size, cv2.CV_32F, (7, 7), normalize=False)
    length = cv2.boxFilter(skeleton.astype(np.float32), cv2.CV_32F, (7, 7), normalize=False) * LENGTH_PER_PIXEL
    return Cores(deviation[core], wide[core], (ink / np.maximum(length, 1))[core])


def estimate_palette(cores: Cores, page: NDArray[np.float64]) -> NDArray[np.float64]:
    """The inks of a clip.

    Args:
        cores: Cores of its lines.
        page: Colour of its page, sRGB in [0, 1]. [3]

    Returns:
        Colours, sRGB in [0, 1], the most used first. [I, 3]
    """
    least = max(8, LEAST_SHARE * len(cores.deviation))
    inks = _wide_inks(cores.deviation[cores.is_wide].astype(np.float64), least)
    thin = cores.select(~cores.is_wide & ~_is_explained(cores.deviation, inks))
    inks = np.concatenate([inks, _thin_inks(thin, page, least)])[:MOST_INKS]
    if not len(inks):
        inks = _thin_inks(cores, page, 1)
    return np.clip(page + inks, 0, 1)


def _wide_inks(colors: NDArray[np.float64], least: float) -> NDArray[np.float64]:
    """Deviations around which wide cores crowd, the most frequent first. [I, 3]"""
    inks: list[NDArray[np.float64]] = []
    while len(colors) >= least and len(inks) < MOST_INKS:
        bins = np.floor(colors * 16).astype(np.intp) + 16
        cell = np.bincount(bins @ np.array([1024, 32, 1]), minlength=1).argmax()
        center = np.median(colors[bins @ np.array([1024, 32, 1]) == cell], axis=0)
        for _ in range(3):
            near = np.linalg.norm(colors - center, axis=1) < SAME_COLOR / 2
            center = np.median(colors[near], axis=0)
        if near.sum() >= least:
            inks.append(center)
        colors = colors[np.linalg.norm(colors - center, axis=1) >= SAME_COLOR]
    return np.array(inks).reshape(-1, 3)


def _is_explained(deviation: Floats, inks: NDArray[np.float64]) -> NDArray[np.bool_]:
    """Whether each deviation is a share of an ink. bool [N]"""
    explained = np.zeros(len(deviation), np.bool_)
    for ink in inks:
        share = deviation @ (ink / (ink @ ink))
        explained |= (_angle(deviation, ink) < SAME_HUE) & (share < 1.1)
    return explained


def _angle(deviation: Floats, direction: NDArray[np.float64]) -> NDArray[np.float64]:
    cosine = deviation @ direction / np.maximum(1e-9, np.linalg.norm(deviation, axis=1) * np.linalg.norm(direction))
    angle: NDArray[np.float64] = np.arccos(np.clip(cosine, -1, 1))
    return angle


def _thin_inks(cores: Cores, page: NDArray[np.float64], least: float) -> NDArray[np.float64]:
    """Inks of lines that have no plateau, hue by hue. [I, 3]"""
    inks: list[NDArray[np.float64]] = []
    while len(cores.deviation) >= least and len(inks) < MOST_INKS:
        direction = _frequent_direction(cores.deviation.astype(np.float64))
        same = _angle(cores.deviation, direction) < SAME_HUE
        if same.sum() >= least:
            inks.append(direction * _thin_depth(cores.select(same), page, direction))
        cores = cores.select(_angle(cores.deviation, direction) >= 1.3 * SAME_HUE)
    return np.array(inks).reshape(-1, 3)


def _frequent_direction(deviation: NDArray[np.float64]) -> NDArray[np.float64]:
    """Unit vector around which deviations crowd, strong ones first. [3]"""
    size = np.linalg.norm(deviation, axis=1, keepdims=True)
    units = deviation / np.maximum(size, 1e-9)
    bins = np.rint(units * 6).astype(np.intp) + 6
    keys = bins @ np.array([169, 13, 1])
    direction = units[keys == np.bincount(keys, weights=size[:, 0]).argmax()].mean(axis=0)
    for _ in range(5):
        near = (units @ direction) / np.linalg.norm(direction) > math.cos(SAME_HUE)
        direction = (deviation[near] * size[near]).sum(axis=0)
        direction = direction / np.linalg.norm(direction)
    unit: NDArray[np.float64] = direction
    return unit


def _thin_depth(cores: Cores, page: NDArray[np.float64], direction: NDArray[np.float64]) -> float:
    """How far from the page the ink of thin lines lies along a unit vector: rules 2 and 3."""
    room = np.where(direction < 0, page, 1 - page)
    deepest = float(np.min(room[np.abs(direction) > 1e-3] / np.abs(direction[np.abs(direction) > 1e-3])))
    peak = float(np.quantile(cores.deviation @ direction, 0.98))
    mass = float(np.median(cores.mass)) * math.sqrt(3)
    if peak >= NEARLY_DEEPEST * deepest or mass < RESOLVED * peak:
        return deepest
    return peak
