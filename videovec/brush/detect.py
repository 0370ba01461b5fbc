"""Whether drawings are of textured lines: what the command line proposes the textured preset by."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from videovec.brush.solidify import solid_coverage
from videovec.ink import Ink
from videovec.progress import Progress

__all__ = ["TextureEvidence", "looks_textured", "propose_textured"]

_LEAST_GRAIN, _MOST_GRAIN = 0.05, 1.0  # beyond, the middle of a core pixel is empty: gaps between lines, not grain
_NOISE_LEVELS = 3.0
_EDGE = 1.6  # px; nearer to the page ink is thinned by the edge
_LEAST_CORE = 0.3  # share of the ink that must lie deeper; where thin lines run close together, less does
_SLOW = 3.0  # px; ink that varies more slowly is pressure, not grain
_LOOK = 3  # drawings, at most, that are looked at
_BLUR = 1.0  # px; the least at which lines are made solid: more would take the page beside a line for its inside
_NORMAL = 1.4826  # standard deviation of a normal variable against the median of its size


@dataclass(frozen=True, slots=True)
class TextureEvidence:
    """What speaks for texture.

    Args:
        is_textured: Whether the lines look textured.
        grain: Standard deviation of ink inside the lines, slow changes and outliers apart.
        threshold: What the grain was held against.
        core: Share of the ink that lies deep enough inside lines to tell.
    """

    is_textured: bool
    grain: float
    threshold: float
    core: float


def looks_textured(ink: Ink) -> TextureEvidence:
    """Tell textured lines from solid ones by the ink inside them; lines too thin to tell count as solid."""
    which = np.unique(np.linspace(0, ink.drawing_count - 1, min(_LOOK, ink.drawing_count)).astype(int))
    parts = [_inside(ink.coverage[page], _BLUR) for page in which]
    deviations = np.concatenate([deviation for deviation, _ in parts])
    grain = _NORMAL * float(np.median(deviations)) if len(deviations) else 0.0
    core = len(deviations) / max(sum(count for _, count in parts), 1)
    threshold = max(_LEAST_GRAIN, _NOISE_LEVELS * ink.noise)
    is_textured = threshold < grain < _MOST_GRAIN and core > _LEAST_CORE
    return TextureEvidence(is_textured, grain, threshold, core)


def _inside(coverage: NDArray[np.uint8], blur: float) -> tuple[NDArray[np.float32], int]:
    """How far the ink of each pixel in the core of the lines is from that around it, and how many pixels hold ink."""
    inside = (solid_coverage(coverage, blur) > 0.5).astype(np.uint8)
    core = cv2.distanceTransform(inside, cv2.DIST_L2, 5) > _EDGE
    ink, seen = coverage.astype(np.float32) / 255, core.astype(np.float32)
    weight = cv2.GaussianBlur(seen, (0, 0), _SLOW)
    slow = cv2.GaussianBlur(seen * ink, (0, 0), _SLOW) / np.maximum(weight, 1e-3)
    deviation = np.abs(ink - slow) / np.maximum(slow, 0.1)
    return deviation[core].astype(np.float32), int(inside.sum())


def propose_textured(ink: Ink, progress: Progress) -> None:
    """Tell whoever fits solid strokes to textured lines that there is a better way."""
    if looks_textured(ink).is_textured:
        progress.note("lines look textured; try --preset textured")
