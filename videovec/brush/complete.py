"""Strokes traced on ink that was made solid, rid of scraps on its rough edge and completed by the lines they missed.

A rough edge grows spurs, and a line that leaves a fat one at a sharp angle may be taken for such a spur and dropped.
What is as long as a line and a half is wide is a line; anything shorter beside others is the edge's.
"""

from __future__ import annotations

from dataclasses import replace

from videovec.brush.prepare import mean_width
from videovec.edits.drop import drop
from videovec.edits.layers import Page, layers_of
from videovec.edits.uncovered import add_strokes
from videovec.ink import Ink
from videovec.settings import EditSettings
from videovec.strokes import Strokes

__all__ = ["complete"]

_LINE = 1.5  # widths from which on a stroke that hardly leaves the ink of others is one


def complete(strokes: Strokes, solid: Ink, settings: EditSettings) -> Strokes:
    """Drop scraps that others draw, and trace lines that none draws.

    Args:
        strokes: As traced on one drawing, not fitted yet.
        solid: That drawing, made solid.
        settings: The price of a stroke.
    """
    if not len(strokes):
        return strokes
    wide = replace(settings, d_min=_LINE * mean_width(strokes))
    page = Page(solid.coverage[0], layers_of(strokes, solid.size))
    next_id = int(strokes.ids.max()) + 1
    return add_strokes(drop(strokes, page, wide), page, solid, wide, next_id)
