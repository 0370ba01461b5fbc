"""Strokes joined over gaps in their grain: where paper or a dry brush left a line bare for less than its own width.

A gap of grain is closed by more blur, and a gap that was drawn is not: strokes that continue one another are joined
where the ink that was made solid with twice the blur runs on from one to the other.
"""

from __future__ import annotations

from dataclasses import replace

from videovec.brush.prepare import mean_width
from videovec.brush.solidify import blur_of, solidify
from videovec.edits.layers import Page, layers_of
from videovec.edits.merge import merge
from videovec.ink import Ink
from videovec.settings import EditSettings
from videovec.strokes import Strokes

__all__ = ["bridge"]

_BLUR = 2.0  # times the blur at which the ink was traced
_REACH = 1.5  # widths over which a gap may be grain


def bridge(strokes: Strokes, ink: Ink, settings: EditSettings) -> Strokes:
    """Join strokes of one drawing that gaps in the grain part.

    Args:
        strokes: A solid fit.
        ink: The drawing, textured.
        settings: What a stroke less is worth.

    Returns:
        Fewer strokes; of two that were joined the longer one's identity stays.
    """
    if len(strokes) < 2:
        return strokes
    solid = solidify(ink, _BLUR * blur_of(ink)).coverage[0]
    page = Page(solid, layers_of(strokes, ink.size))
    longest = max(settings.d_min, _REACH * mean_width(strokes))
    return merge(strokes, page, replace(settings, d_min=longest))
