"""Page and ink: what is drawn, as coverage in [0, 1], apart from what it is drawn on."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import cv2
import numpy as np
from numpy.typing import NDArray

from videovec.clip import Clip
from videovec.errors import FitError, InputError
from videovec.fades import find_fades
from videovec.page import Page, estimate_page, flatten, page_noise, unit_values
from videovec.palette import SAME_COLOR, Cores, estimate_palette, find_cores, is_share, magnitude
from videovec.progress import Progress, Silent
from videovec.settings import InkSettings

__all__ = ["Ink", "amount_of_ink", "extract_ink", "first_full", "ink_alone"]

Floats = NDArray[np.float32]

LUMA_CHROMA = np.array([[0.299, 0.587, 0.114], [-0.168736, -0.331264, 0.5], [0.5, -0.418688, -0.081312]])
"""From RGB to YCbCr. Source: ITU-T T.871."""

METRIC = LUMA_CHROMA.T @ np.diag([1, 0.1, 0.1]) @ LUMA_CHROMA
"""How coverage is read from colour: mostly from luma, since video stores colour at half the resolution. Where all
channels agree, as in lossless art, it makes no difference."""

_FAINT = 40
"""Coverage of the palest entry of the palette that is no edge of a line, of 255."""

_POOR = 0.8
"""Share of the most ink of any drawing; with less, the first one is too poor to begin with."""
_FULL = 0.95
"""Share of it that is as much as can be hoped for."""

NEARBY = 7.0
"""How far along a line the ink that it shows is taken for its own. px"""


@dataclass(frozen=True, slots=True, eq=False)
class Ink:
    """The ink of D drawings.

    Args:
        coverage: Ink fraction of each pixel, 255 is full. uint8 [D, H, W]
        label: Palette entry of each pixel's ink; meaningful where coverage > 0. uint8 [D, H, W]
        palette: Colour of each ink, sRGB in [0, 1]. [I, 3]
        page: Colour of the flattened page, sRGB in [0, 1]. [3]
        noise: Standard deviation of the page's noise, in coverage.
        seen: Where lines fade, the share of their ink that is seen; coverage is then that of the lines themselves. None
            where nothing fades. uint8 [D, H, W]
    """

    coverage: NDArray[np.uint8]
    label: NDArray[np.uint8]
    palette: NDArray[np.float64]
    page: NDArray[np.float64]
    noise: float
    seen: NDArray[np.uint8] | None = None

    def __post_init__(self) -> None:
        if self.coverage.ndim != 3 or self.label.shape != self.coverage.shape:
            raise FitError(f"ink needs coverage and label [D, H, W], got {self.coverage.shape} and {self.label.shape}")

    @property
    def size(self) -> tuple[int, int]:
        """Height and width. px"""
        return int(self.coverage.shape[1]), int(self.coverage.shape[2])

    @property
    def shown(self) -> NDArray[np.uint8]:
        """What strokes of these inks should draw: coverage, less where they fade. uint8 [D, H, W]"""
        return self.coverage if self.seen is None else self.seen

    @property
    def drawing_count(self) -> int:
        """D."""
        return int(self.coverage.shape[0])

    def at_drawing(self, drawing: int) -> Ink:
        """The ink of one drawing, as if nothing faded."""
        part = slice(drawing, drawing + 1)
        return Ink(self.coverage[part], self.label[part], self.palette, self.page, self.noise)


def extract_ink(clip: Clip, settings: InkSettings | None = None, progress: Progress | None = None) -> Ink:
    """Tell page and ink apart, with one palette for the whole clip.

    Args:
        clip: The drawings.
        settings: How; the defaults if none.
        progress: Told of every drawing.

    Returns:
        Coverage and ink of every pixel. Where black ink lies on a clean white page, coverage is 255 less grey.

    Raises:
        InputError: Nothing is drawn.
    """
    settings, progress = settings or InkSettings(), progress or Silent()
    count = len(clip.drawings)
    progress.stage("ink", count)
    samples = np.unique(np.linspace(0, count - 1, min(count, settings.samples)).round().astype(np.intp))
    page = estimate_page(clip, samples, settings.flatten)
    noise, palette = _survey(clip, samples, page, settings)
    coverage = np.zeros((count, *clip.size), np.uint8)
    label = np.zeros((count, *clip.size), np.uint8)
    for drawing, image in enumerate(clip.drawings):
        deviation = _deviation(unit_values(image), page)
        coverage[drawing], label[drawing] = _read_drawing(deviation, palette - page.color, noise, settings)
        progress.advance()
    if not coverage.any():
        raise InputError(f"{clip.name}: must show lines on an even page, got no ink in any of {count} drawings")
    depth = float(magnitude((palette - page.color).astype(np.float32)).max())
    ink = Ink(coverage, label, palette, page.color, max(noise) / depth)
    return _with_fades(ink, clip, page) if len(palette) > 1 and count > 1 else ink


def _with_fades(ink: Ink, clip: Clip, page: Page) -> Ink:
    """The ink with lines that fade as lines of one ink."""
    fades = find_fades(ink.palette - page.color, ink.label, ink.coverage)
    if not fades:
        return ink
    seen = np.zeros_like(ink.coverage)
    whole = np.array([fades.get(i, i) for i in range(len(ink.palette))])
    scale = _shares(ink.palette - page.color)
    for drawing, image in enumerate(clip.drawings):
        own = scale[whole[ink.label[drawing]]]
        share = np.clip(np.einsum("hwc,hwc->hw", _deviation(unit_values(image), page), own), 0, 1)
        seen[drawing] = np.rint(255 * np.where(ink.coverage[drawing] > 0, share, 0))
        for weak in fades:
            _fill(ink.coverage[drawing], ink.label[drawing] == weak)
    kept = [i for i in range(len(ink.palette)) if i not in fades]
    place = np.array([kept.index(i) for i in whole.tolist()], np.uint8)
    return replace(ink, label=place[ink.label], palette=ink.palette[kept], seen=seen)


def _fill(coverage: NDArray[np.uint8], mask: NDArray[np.bool_]) -> None:
    """Raise the coverage of lines that fade such that most of them is full; in place.

    Args:
        coverage: Share of the nearest entry of the palette, of which they may show less. uint8 [H, W]
        mask: The pixels of that entry. bool [H, W]
    """
    mask = mask & (coverage > _FAINT)
    if mask.any():
        full = np.percentile(coverage[mask], 90)
        coverage[mask] = np.minimum(255.0, coverage[mask] * (255.0 / full)).round().astype(np.uint8)


def _shares(inks: NDArray[np.float64]) -> Floats:
    """What a deviation is multiplied by to give the share of each ink. [I, 3]"""
    weighted = inks @ METRIC
    return np.asarray(weighted / (weighted * inks).sum(axis=1, keepdims=True), np.float32)


def ink_alone(ink: Ink, label: int) -> Ink:
    """One ink, without the others; where another crosses it, it runs on underneath.

    Args:
        ink: All inks.
        label: Position of the one in the palette.

    Returns:
        Ink of the same size and palette.
    """
    if len(ink.palette) == 1:
        return ink
    coverage = np.where(ink.label == label, ink.coverage, np.uint8(0))
    for drawing, whole in zip(coverage, ink.coverage, strict=True):
        depth = cv2.distanceTransform((whole > 127).astype(np.uint8), cv2.DIST_L2, 3)
        reach = 2 * int(np.ceil(np.percentile(depth[depth > 0], 95))) + 1 if depth.any() else 1
        kernel = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (2 * reach + 1, 2 * reach + 1))
        bridged = cv2.morphologyEx(drawing, cv2.MORPH_CLOSE, kernel)
        np.maximum(drawing, np.minimum(bridged, np.where(drawing > 0, 0, whole)), out=drawing)
    return replace(ink, coverage=coverage, label=np.full_like(ink.label, label), seen=None)


def _deviation(image: Floats, page: Page) -> Floats:
    """Value less page, shading taken out. [H, W, 3]"""
    return flatten(image, page) - page.color.astype(np.float32)


def _survey(
    clip: Clip, samples: NDArray[np.intp], page: Page, settings: InkSettings
) -> tuple[tuple[float, float], NDArray[np.float64]]:
    """Noise far from ink and beside it, and the palette."""

    def deviations() -> Iterator[Floats]:
        return (_deviation(unit_values(clip.drawings[drawing]), page) for drawing in samples)

    peaks, noises = [], []
    for deviation in deviations():
        peaks.append(float(np.quantile(magnitude(deviation), 0.9999)))
        noises.append(page_noise(deviation, peaks[-1]))
    strongest = max(peaks)
    if strongest < settings.least_contrast:
        raise InputError(
            f"{clip.name}: must show lines that differ from the page by {settings.least_contrast:.0%} of full, "
            f"got no ink (at most {strongest:.1%})"
        )
    far, beside = (float(np.median([noise[k] for noise in noises])) for k in (0, 1))
    threshold = max(settings.least_contrast, 6 * max(far, beside), 0.15 * strongest)
    cores = Cores.concatenate([find_cores(deviation, threshold)[1] for deviation in deviations()])
    return (far, beside), estimate_palette(cores, page.color, max(far, beside))


def _read_drawing(
    deviation: Floats, inks: NDArray[np.float64], noise: tuple[float, float], settings: InkSettings
) -> tuple[NDArray[np.uint8], NDArray[np.uint8]]:
    """Coverage and label of one drawing. uint8 [H, W] each"""
    label = _labels(deviation, inks, max(noise), max(settings.least_contrast, 4 * max(noise)))
    share = np.clip(np.einsum("hwc,hwc->hw", deviation, _shares(inks)[label]), 0, 1)
    depth = magnitude(inks.astype(np.float32))[label]
    share[~_is_ink(share * depth, noise, settings)] = 0
    return np.rint(share * 255).astype(np.uint8), label


def _labels(deviation: Floats, inks: NDArray[np.float64], noise: float, threshold: float) -> NDArray[np.uint8]:
    """The ink of every pixel: cores by what they show, all others that of the nearest core. uint8 [H, W]"""
    if len(inks) == 1:
        return np.zeros(deviation.shape[:2], np.uint8)
    core, cores = find_cores(deviation, threshold)
    if not core.any():
        return np.zeros(deviation.shape[:2], np.uint8)
    label = np.zeros(core.shape, np.uint8)
    label[core], shows = _closest_ink(cores, inks)
    if shows.any():
        shown = np.zeros(core.shape, np.bool_)
        shown[core] = shows
        nearest, distance = _nearest(shown)
        candidate = label.ravel()[nearest]
        fits = np.zeros(core.shape, np.bool_)
        for index, ink in enumerate(inks):
            mine = core & (candidate == index) & (distance <= NEARBY)
            fits[mine] = is_share(deviation[mine].astype(np.float64), ink[None], noise)
        label = np.where(fits & ~shown, candidate, label)
    nearest, _ = _nearest(core)
    return label.ravel()[nearest]


def _nearest(mask: NDArray[np.bool_]) -> tuple[NDArray[np.intp], Floats]:
    """Flat index of the nearest pixel of a mask, and its distance. [H, W] each, px"""
    distance, name = cv2.distanceTransformWithLabels(
        (~mask).astype(np.uint8), cv2.DIST_L2, cv2.DIST_MASK_5, labelType=cv2.DIST_LABEL_PIXEL
    )
    place = np.zeros(int(name.max()) + 1, np.intp)
    place[name[mask]] = np.flatnonzero(mask)
    return place[name], np.asarray(distance, np.float32)


def _closest_ink(cores: Cores, inks: NDArray[np.float64]) -> tuple[NDArray[np.uint8], NDArray[np.bool_]]:
    """The ink of each core by its colour: one that shows its ink has it, another a share of it.

    Returns:
        The ink, uint8 [N], and whether it is shown, bool [N].
    """
    whole = np.stack([np.linalg.norm(cores.deviation - ink, axis=1) for ink in inks.astype(np.float32)])
    shows = cores.is_plateau | cores.is_certain | (cores.is_resolved & (whole.min(axis=0) < 0.5 * SAME_COLOR))
    partly = []
    for ink in inks.astype(np.float32):
        share = np.clip(cores.deviation @ (ink / (ink @ ink)), 0, 1)
        partly.append(np.linalg.norm(cores.deviation - share[:, None] * ink, axis=1) - 1e-3 * np.linalg.norm(ink))
    best = np.where(shows, whole.argmin(axis=0), np.argmin(partly, axis=0))
    return best.astype(np.uint8), shows


def _is_ink(size: Floats, noise: tuple[float, float], settings: InkSettings) -> NDArray[np.bool_]:
    """Where there is ink and not noise: strong pixels, faint lines that stand out once smoothed, and their edges.

    Args:
        size: Magnitude along the pixel's ink. [H, W]
        noise: Far from ink, and beside it.
        settings: The noise floor.
    """
    if max(noise) == 0:
        anything: NDArray[np.bool_] = size > 0
        return anything
    strong = size > max(noise) * 2 * settings.noise_floor
    beside = cv2.dilate(strong.astype(np.uint8), np.ones((21, 21), np.uint8)) > 0
    floor = np.where(beside, noise[1], noise[0]) * settings.noise_floor
    smooth = cv2.GaussianBlur(size, (0, 0), 1.0)
    seed = strong | ((size > floor) & (smooth > 0.5 * floor))
    return cv2.dilate(seed.astype(np.uint8), np.ones((3, 3), np.uint8)) > 0


def amount_of_ink(ink: Ink) -> NDArray[np.int64]:
    """Sum of coverage on each drawing. [D]"""
    return np.array([coverage.sum(dtype=np.int64) for coverage in ink.coverage])


def first_full(amount: NDArray[np.int64]) -> int:
    """The first of some drawings on which enough is drawn to begin there.

    Args:
        amount: Sum of coverage on each drawing, at least one. [D]
    """
    return 0 if amount[0] >= _POOR * amount.max() else int(np.argmax(amount >= _FULL * amount.max()))
