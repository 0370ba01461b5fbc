"""Which inks a clip is drawn with, and which pixels show them.

Only the cores of lines are asked: edges are mixtures with the page, and lossy chroma frays them. A core *shows* its ink
where its surroundings have its own colour (a plateau, on lines of about 2.5 px and more), or where the line's ink (mass
per length) is at least ``RESOLVED`` times its peak, so that it is wider than a pixel; unless it runs along the rows of
pixels or their diagonals, where a hairline may spread evenly over two. A thinner line shows only a lower bound of its
ink's depth: a hairline of black ink and a wider line of grey ink look the same. The rule for those:

1. If an ink of the same hue and at least their depth is shown elsewhere, they are drawn with it.
2. Else they are drawn with the deepest colour of their hue: black, for greys.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

__all__ = ["SAME_COLOR", "Cores", "estimate_palette", "find_cores", "is_share", "magnitude"]

Floats = NDArray[np.float32]

MOST_INKS = 8
"""Largest number of inks of a clip."""

MOST_CORES = 200_000
"""Number of cores from which the inks of a clip are estimated."""

SAME_COLOR = 0.17
"""Cores within this distance, over all channels, are of one ink."""

SAME_HUE = math.radians(15)
"""Lines whose deviation from the page has the same direction to within this are of one hue."""

PLATEAU_SHARE = 0.003
"""Share of all cores that must lie on plateaus of one colour to make an ink."""

THIN_SHARE = 0.03
"""Share of all cores that an ink without a plateau must have."""

RESOLVED = 1.4
"""Mass over peak from which a line is wider than a pixel. px"""

TWO_ROWS = 2.4
"""Mass over peak beyond that of a hairline on the border of two rows. px"""

VALLEY = 0.25
"""Cores between two shades, against those of the rarer one, from which the shades are one ink."""

NEARLY_DEEPEST = 0.97
"""A line under 2.5 px that comes this near to the deepest colour of its hue is drawn with it."""

LENGTH_PER_PIXEL = 1.12
"""Mean length of a digital line per pixel of its skeleton, over all directions. px"""

OBLIQUE = 0.25
"""Sine of four times a line's angle from which it is oblique."""

COHERENT = 0.5
"""Share of the gradients around a pixel that must be of one line, for the line to have a direction."""

REACH = 7
"""Side of the window in which the mass and peak of a line are taken. px"""


@dataclass(frozen=True, slots=True, eq=False)
class Cores:
    """Middles of lines, for statistics.

    Args:
        deviation: Value less page. [N, 3]
        is_plateau: Whether each lies in surroundings of its own colour. bool [N]
        is_resolved: Whether each seems to show the ink of a line wider than a pixel. bool [N]
        is_certain: Whether each does, and is no hairline on the border of two rows of pixels. bool [N]
    """

    deviation: Floats
    is_plateau: NDArray[np.bool_]
    is_resolved: NDArray[np.bool_]
    is_certain: NDArray[np.bool_]

    @staticmethod
    def concatenate(parts: list[Cores]) -> Cores:
        """Cores of several drawings."""
        return Cores(
            np.concatenate([part.deviation for part in parts]),
            np.concatenate([part.is_plateau for part in parts]),
            np.concatenate([part.is_resolved for part in parts]),
            np.concatenate([part.is_certain for part in parts]),
        )

    def thinned(self, most: int) -> Cores:
        """Evenly chosen cores, no more than ``most``."""
        step = max(1, -(-len(self.deviation) // most))
        return Cores(self.deviation[::step], self.is_plateau[::step], self.is_resolved[::step], self.is_certain[::step])


def magnitude(deviation: Floats) -> Floats:
    """Distance from the page, 1 from white to black. [...]"""
    size: Floats = np.sqrt(np.einsum("...c,...c->...", deviation, deviation) / 3)
    return size


def find_cores(deviation: Floats, threshold: float) -> tuple[NDArray[np.bool_], Cores]:
    """Pixels in the middle of lines, and what they show.

    Args:
        deviation: Value less page. [H, W, 3]
        threshold: Magnitude under which there is only noise.

    Returns:
        Where they are, bool [H, W], and what they show, in the order of the array.
    """
    size = magnitude(deviation)
    core = (size > threshold) & (size >= 0.9 * cv2.dilate(size, np.ones((3, 3), np.uint8)))
    rows, columns = np.nonzero(core)
    own, peak = deviation[rows, columns], size[rows, columns]
    alike = np.zeros(len(rows), np.int8)
    for dy, dx in ((-1, -1), (-1, 0), (-1, 1), (0, -1), (0, 1), (1, -1), (1, 0), (1, 1)):
        y, x = np.clip(rows + dy, 0, core.shape[0] - 1), np.clip(columns + dx, 0, core.shape[1] - 1)
        alike += magnitude(deviation[y, x] - own) <= 0.2 * peak
    nearby = cv2.dilate(size, np.ones((REACH, REACH), np.uint8))[rows, columns]
    width = np.where(peak >= 0.95 * nearby, _mass(size, threshold)[rows, columns] / peak, 0)
    certain = (width >= TWO_ROWS) | ((width >= RESOLVED) & _is_oblique(size)[rows, columns])
    return core, Cores(own, alike >= 6, width >= RESOLVED, certain)


def _is_oblique(size: Floats) -> NDArray[np.bool_]:
    """Whether lines run neither along the rows of pixels nor along their diagonals. bool [H, W]

    A hairline that does may lie on the border of two rows all the way, and then looks like a grey line of two pixels.
    """
    dx, dy = cv2.Sobel(size, cv2.CV_32F, 1, 0), cv2.Sobel(size, cv2.CV_32F, 0, 1)
    xx, xy, yy = (cv2.blur(product, (REACH, REACH)) for product in (dx * dx, dx * dy, dy * dy))
    along_one = np.hypot(xx - yy, 2 * xy) > COHERENT * (xx + yy)
    oblique: NDArray[np.bool_] = along_one & (np.abs(np.sin(2 * np.arctan2(2 * xy, xx - yy))) > OBLIQUE)
    return oblique


def _mass(size: Floats, threshold: float) -> Floats:
    """Ink per length of the lines around each pixel. [H, W] magnitude times px"""
    line = (size > threshold) & (size > 0.5 * cv2.dilate(size, np.ones((5, 5), np.uint8)))
    skeleton = cv2.ximgproc.thinning(line.astype(np.uint8) * 255) > 0
    ink = cv2.boxFilter(size, cv2.CV_32F, (REACH, REACH), normalize=False)
    pixels = cv2.boxFilter(skeleton.astype(np.float32), cv2.CV_32F, (REACH, REACH), normalize=False)
    mass: Floats = ink / np.maximum(1, pixels * LENGTH_PER_PIXEL)
    return mass


def estimate_palette(cores: Cores, page: NDArray[np.float64], noise: float) -> NDArray[np.float64]:
    """The inks of a clip.

    Args:
        cores: Cores of its lines.
        page: Colour of its page, sRGB in [0, 1]. [3]
        noise: Standard deviation of its noise, sRGB in [0, 1].

    Returns:
        Colours, sRGB in [0, 1]. [I, 3]
    """
    cores = cores.thinned(MOST_CORES)
    total = len(cores.deviation)
    colors = cores.deviation.astype(np.float64)
    inks = _shown_inks(colors[cores.is_plateau], max(16, PLATEAU_SHARE * total))
    resolved = colors[cores.is_certain & ~cores.is_plateau]
    for ink in inks:
        resolved = resolved[np.linalg.norm(resolved - ink, axis=1) > SAME_COLOR + 3 * noise]
    thin = [_or_deepest(ink, page) for ink in _shown_inks(resolved, max(8, THIN_SHARE * total))]
    inks = _merge_shades(_distinct([*inks, *thin]), colors[cores.is_plateau | cores.is_certain])
    rest = colors[~is_share(colors, inks, noise)]
    inks = _distinct([*inks, *_thin_inks(rest, page, max(8, THIN_SHARE * total))])[:MOST_INKS]
    if not len(inks):
        inks = _thin_inks(colors, page, 1)[:1]
    return np.clip(page + inks, 0, 1)


def _shown_inks(colors: NDArray[np.float64], least: float) -> NDArray[np.float64]:
    """Deviations around which colours crowd, the most frequent first. [I, 3]"""
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


def _distinct(inks: list[NDArray[np.float64]]) -> NDArray[np.float64]:
    """Inks without those that are like an earlier one. [I, 3]"""
    kept: list[NDArray[np.float64]] = []
    for ink in inks:
        if all(np.linalg.norm(ink - other) > SAME_COLOR for other in kept):
            kept.append(ink)
    return np.array(kept).reshape(-1, 3)


def _merge_shades(inks: NDArray[np.float64], colors: NDArray[np.float64]) -> NDArray[np.float64]:
    """Inks of one hue as one, where cores of all depths lie between them: a soft line, not two inks.

    Args:
        inks: Deviations. [I, 3]
        colors: Deviations of cores that show their ink. [N, 3]
    """
    merged = list(inks[np.argsort(-np.linalg.norm(inks, axis=1))])
    for shallow in merged[::-1]:
        for deep in merged:
            length = float(np.linalg.norm(deep))
            if length <= np.linalg.norm(shallow) or _angle(shallow[None], deep)[0] > SAME_HUE / 2:
                continue
            hue = colors[_angle(colors, deep) < SAME_HUE]
            depth, start = hue @ deep / length**2, float(shallow @ deep) / length**2
            counts = np.histogram(depth, np.linspace(start - (1 - start) / 6, 1 + (1 - start) / 6, 9))[0]
            if counts[2:6].min() > VALLEY * min(counts[0:3].max(), counts[5:8].max()):
                merged = [ink for ink in merged if ink is not shallow]
                break
    return np.array(merged).reshape(-1, 3)


def is_share(deviation: NDArray[np.float64], inks: NDArray[np.float64], noise: float) -> NDArray[np.bool_]:
    """Whether each deviation is that of a pixel that some ink covers in part. bool [N]"""
    explained = np.zeros(len(deviation), np.bool_)
    for ink in inks:
        along = deviation @ (ink / np.linalg.norm(ink))
        explained |= (_angle(deviation, ink) < SAME_HUE) & (along < 1.15 * np.linalg.norm(ink) + 5 * noise)
    return explained


def _angle(deviation: NDArray[np.float64], direction: NDArray[np.float64]) -> NDArray[np.float64]:
    cosine = deviation @ direction / np.maximum(1e-9, np.linalg.norm(deviation, axis=1) * np.linalg.norm(direction))
    angle: NDArray[np.float64] = np.arccos(np.clip(cosine, -1, 1))
    return angle


def _thin_inks(deviation: NDArray[np.float64], page: NDArray[np.float64], least: float) -> NDArray[np.float64]:
    """Inks of lines that show none, hue by hue. [I, 3]"""
    inks: list[NDArray[np.float64]] = []
    while len(deviation) >= least and len(inks) < MOST_INKS:
        direction = _frequent_direction(deviation)
        angle = _angle(deviation, direction)
        if np.count_nonzero(angle < SAME_HUE) >= least:
            inks.append(direction * _deepest(direction, page))
        deviation = deviation[angle >= 1.3 * SAME_HUE]
    return np.array(inks).reshape(-1, 3)


def _frequent_direction(deviation: NDArray[np.float64]) -> NDArray[np.float64]:
    """Unit vector around which deviations crowd, strong ones first. [3]"""
    size = np.linalg.norm(deviation, axis=1, keepdims=True)
    units = deviation / np.maximum(size, 1e-9)
    keys = (np.rint(units * 6).astype(np.intp) + 6) @ np.array([169, 13, 1])
    direction: NDArray[np.float64] = units[keys == np.bincount(keys, weights=size[:, 0]).argmax()].mean(axis=0)
    for _ in range(5):
        near = (units @ direction) / np.linalg.norm(direction) > math.cos(SAME_HUE)
        direction = (deviation[near] * size[near]).sum(axis=0)
        direction = direction / np.linalg.norm(direction)
    return direction


def _deepest(direction: NDArray[np.float64], page: NDArray[np.float64]) -> float:
    """How far from the page colours go along a unit vector."""
    moves = np.abs(direction) > 1e-3
    room = np.where(direction < 0, page, 1 - page)
    return float(np.min(room[moves] / np.abs(direction[moves])))


def _or_deepest(ink: NDArray[np.float64], page: NDArray[np.float64]) -> NDArray[np.float64]:
    """The ink of a thin line, or the deepest of its hue if it comes near that."""
    size = float(np.linalg.norm(ink))
    deepest = _deepest(ink / size, page)
    return ink * (deepest / size) if size >= NEARLY_DEEPEST * deepest else ink
