"""Whether drawings are of textured lines, from a solid fit: what the command line proposes a preset by."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from videovec.brush.choose import grain_level
from videovec.brush.model import SUPPORT, Brush, BrushModel, Laying
from videovec.brush.prepare import mean_width
from videovec.brush.refine import Laid
from videovec.brush.strips import TEXELS_ACROSS, unroll
from videovec.ink import Ink
from videovec.strokes import Strokes

__all__ = ["TextureEvidence", "looks_textured"]

_LEAST_GRAIN = 0.06
_LEAST_WIDTH = 3.5  # px; inside thinner strokes every pixel holds an edge
_NOISE_LEVELS = 3.0


@dataclass(frozen=True, slots=True)
class TextureEvidence:
    """What speaks for texture.

    Args:
        is_textured: Whether lines look textured.
        grain: Standard deviation of ink against density inside the strokes.
        width: Mean width of the strokes. px
        threshold: What the grain was held against.
    """

    is_textured: bool
    grain: float
    width: float
    threshold: float


def looks_textured(ink: Ink, strokes: Strokes) -> TextureEvidence:
    """Tell textured lines from solid ones by the ink inside them.

    Args:
        ink: D drawings.
        strokes: A solid fit of them, or of some.

    Returns:
        The verdict and what it rests on; lines too thin to show grain count as solid.
    """
    threshold = max(_LEAST_GRAIN, _NOISE_LEVELS * ink.noise)
    if not len(strokes):
        return TextureEvidence(False, 0.0, 0.0, threshold)
    width = mean_width(strokes)
    v = np.abs((np.arange(TEXELS_ACROSS) + 0.5) / TEXELS_ACROSS * 2 - 1) * SUPPORT
    edge = 1.0 / max(width / 2, 0.5)  # a pixel, in half-widths
    box = np.clip((1 + edge / 2 - v) / edge, 0.0, 1.0)
    brush = Brush("solid", BrushModel.PROFILE, box[None], max(width, 1.0), 1.0)
    grain = grain_level(unroll(Laid(strokes, Laying.plain(strokes.layout), brush), ink.coverage))
    return TextureEvidence(width >= _LEAST_WIDTH and grain > threshold, grain, width, threshold)
