"""Strokes traced on ink that was made solid, rid of scraps on its rough edge and given the lines they missed.

A rough edge grows spurs, and a line that leaves a fat one at a sharp angle may be taken for such a spur and dropped.
What is as long as a line and a half is wide is a line; anything shorter beside others is the edge's.
"""

from __future__ import annotations

from dataclasses import replace

from videovec.brush.prepare import mean_width
from videovec.brush.scraps import drop_scraps
from videovec.edits import complete
from videovec.edits.drop import drop
from videovec.edits.layers import Page, layers_of
from videovec.ink import Ink
from videovec.settings import EditSettings
from videovec.strokes import Strokes

__all__ = ["mend"]

_LINE = 1.5  # widths from which on a stroke that hardly leaves the ink of others is one


def mend(strokes: Strokes, solid: Ink, settings: EditSettings) -> Strokes:
    """Drop scraps that others draw, and trace lines that none draws.

    Args:
        strokes: As traced on one drawing, not fitted yet.
        solid: That drawing, made solid.
        settings: The price of a stroke.
    """
    if not len(strokes):
        return strokes
    wide = replace(settings, d_min=_LINE * mean_width(strokes))
    kept = drop(strokes, Page(solid.coverage[0], layers_of(strokes, solid.size)), wide)
    return drop_scraps(complete(kept, solid, wide))
