"""Drop strokes that draw nothing, or nothing that the others do not."""

from __future__ import annotations

import numpy as np

from videovec.curves import arc_length
from videovec.edits.layers import Layer, Page, layers_of
from videovec.edits.shapes import Shape, shapes_of, strokes_of
from videovec.settings import EditSettings
from videovec.strokes import Strokes

__all__ = ["drop"]

_EXPLAINED = 0.85  # of a short stroke's ink that the others must draw
_STUB = 4.0  # how many times its price a short stroke may cost


def drop(strokes: Strokes, page: Page, settings: EditSettings) -> Strokes:
    """Drop what is too faint to see, and what hardly anything is lost without, the most useless first.

    Args:
        strokes: Strokes of one drawing.
        page: They drawn, against the ink; changed as strokes go.
        settings: Thresholds and the price of a control point.

    Returns:
        The strokes that are worth their price.
    """
    shapes = shapes_of(strokes)
    layers = layers_of(strokes, page.size)
    alive = np.ones(len(shapes), bool)
    for i, shape in enumerate(shapes):
        if min(2.0 * float(shape.half_width.max()), shape.opacity) < settings.sigma_min:
            alive[i] = False
            page.remove(layers[i])
    excess = np.array(
        [
            page.rise([layer], []) - _worth(shape, layer, page, settings)
            for shape, layer in zip(shapes, layers, strict=True)
        ]
    )
    while True:
        excess[~alive] = np.inf
        worst = int(np.argmin(excess)) if len(excess) else 0
        if not len(excess) or excess[worst] > 0.0:
            break
        excess[worst] = page.rise([layers[worst]], []) - _worth(shapes[worst], layers[worst], page, settings)
        if excess[worst] > 0.0:  # another one that drew its ink has gone since
            continue
        alive[worst] = False
        page.remove(layers[worst])
    return strokes_of([shape for shape, keep in zip(shapes, alive, strict=True) if keep])


def _worth(shape: Shape, layer: Layer, page: Page, settings: EditSettings) -> float:
    """By how much the loss may rise if a stroke goes."""
    worth = settings.price * len(shape.points)
    if arc_length(shape.points) < settings.d_min and _explained(layer, page) >= _EXPLAINED:
        worth *= _STUB
    return worth


def _explained(layer: Layer, page: Page) -> float:
    """Share of a drawn layer's seen ink that the other layers draw."""
    others = 1.0 - page.clear[layer.pixels] / (1.0 - layer.coverage)
    own = np.minimum(page.seen[layer.pixels], layer.coverage)
    return float(np.minimum(others, own).sum() / max(float(own.sum()), 1e-9))
