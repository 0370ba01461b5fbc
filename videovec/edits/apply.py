"""One round of edits."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from videovec.edits.divide import divide
from videovec.edits.drop import drop
from videovec.edits.ends import COARSE, FINE, move_ends
from videovec.edits.joints import remove_joints
from videovec.edits.layers import Page, layers_of
from videovec.edits.meet import EARLY, LATE, meet
from videovec.edits.merge import merge
from videovec.edits.uncovered import add_strokes
from videovec.ink import Ink
from videovec.settings import EditSettings
from videovec.strokes import Strokes

__all__ = ["complete", "edit", "finish"]

_CHANCE = 8.0  # variances of the noise: what a control point gains by following it is 2, and noise is not white


def edit(strokes: Strokes, ink: Ink, settings: EditSettings) -> Strokes:
    """Simplify and densify the strokes of one drawing.

    No edit raises the sum of squared coverage errors by more than the price of the control points that it saves, nor
    adds some that do not lower it by as much; but for covered ends that go to the middle of the line over them, of
    which the fit that follows makes a gain.

    Args:
        strokes: Strokes of drawing 0.
        ink: The ink of that drawing alone.
        settings: Thresholds and the price.

    Returns:
        The edited strokes; those that stay keep their identities, new ones get new ones.
    """
    next_id = int(max(strokes.ids, default=0)) + 1  # one that was dropped keeps its identity to itself
    settings = _priced(strokes, ink, settings)
    page = Page(ink.coverage[0], layers_of(strokes, ink.size))
    strokes = drop(strokes, page, settings)
    strokes = merge(strokes, page, settings)
    strokes = move_ends(strokes, page, settings, COARSE)
    strokes = meet(strokes, page, settings, EARLY)
    strokes = add_strokes(strokes, page, ink, settings, next_id)
    strokes = remove_joints(strokes, page, settings)
    return divide(strokes, page, settings)


def complete(strokes: Strokes, ink: Ink, settings: EditSettings) -> Strokes:
    """Add strokes for ink that none draws; those that there are stay as they are, and come first.

    Args:
        strokes: Strokes of drawing 0.
        ink: The ink of that drawing alone.
        settings: What counts as uncovered, and the price of a control point.
    """
    page = Page(ink.coverage[0], layers_of(strokes, ink.size))
    next_id = int(max(strokes.ids, default=0)) + 1
    return add_strokes(strokes, page, ink, _priced(strokes, ink, settings), next_id)


def finish(strokes: Strokes, ink: Ink, settings: EditSettings) -> Strokes:
    """Move the ends of fitted strokes to where their ink ends or to the line that they meet; nothing else changes.

    Args:
        strokes: Strokes of drawing 0.
        ink: The ink of that drawing alone.
        settings: The price of a control point.
    """
    page = Page(ink.coverage[0], layers_of(strokes, ink.size))
    settings = _priced(strokes, ink, settings)
    return meet(move_ends(strokes, page, settings, FINE), page, settings, LATE)


def _priced(strokes: Strokes, ink: Ink, settings: EditSettings) -> EditSettings:
    """The settings with the price and the threshold of uncovered ink that a drawing's lines and noise make."""
    strength = _strength(strokes)
    price = settings.price * strength**2 + _CHANCE * ink.noise**2
    return replace(settings, price=price, delta_max=settings.delta_max * strength)


def _strength(strokes: Strokes) -> float:
    """Coverage on the middle of a typical line: what lines thinner than a pixel can get wrong is its square."""
    return min(1.0, 2.0 * float(np.median(strokes.half_width))) if len(strokes) else 1.0
