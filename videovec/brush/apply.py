"""Any strokes drawn with a brush: to judge it, to use it, and to draw what a fit has found."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import torch
from numpy.typing import NDArray

from videovec.brush.model import SUPPORT, Brush, BrushModel, Laying
from videovec.brush.paint import BrushTensors, alphas, find_pairs
from videovec.brush.prepare import mean_width
from videovec.strokes import Strokes

__all__ = ["apply_brush", "mean_ink", "solid_strokes"]

Floats = NDArray[np.float64]


def apply_brush(
    brush: Brush,
    strokes: Strokes,
    size: tuple[int, int],
    laying: Laying | None = None,
    page: tuple[float, float, float] = (1.0, 1.0, 1.0),
    seed: int = 0,
) -> Floats:
    """Draw the strokes of one drawing with a brush.

    Args:
        brush: The brush.
        strokes: Strokes of drawing 0, in their own colours and layers.
        size: Height and width of the page. px
        laying: How the brush lies along them; by default forwards, with full density, from random phases, and scaled
            to the strokes' mean width.
        page: Colour of the page, sRGB in [0, 1].
        seed: Of the random phases.

    Returns:
        The picture, sRGB. [H, W, 3] in [0, 1]
    """
    height, width = size
    picture = np.tile(np.asarray(page, dtype=np.float64), (height * width, 1))
    if not len(strokes):
        return picture.reshape(height, width, 3)
    if laying is None:
        laying = scattered(brush, strokes, np.random.default_rng(seed))
        brush = replace(brush, width=mean_width(strokes))
    with torch.no_grad():
        pairs = find_pairs(strokes, laying, (1, height, width))
        alpha = alphas(pairs, BrushTensors.of(strokes, laying, brush)).numpy().astype(np.float64)
    pixel, row = pairs.pixels.numpy()[pairs.at.numpy()], pairs.row.numpy()
    for one in strokes.rows_at(0):
        own = row == one
        clear = np.ones(height * width)
        np.multiply.at(clear, pixel[own], 1 - alpha[own])
        touched = np.unique(pixel[own])
        kept = clear[touched, None]
        picture[touched] = kept * picture[touched] + (1 - kept) * strokes.color[strokes.layout.row_stroke[one]]
    return picture.reshape(height, width, 3)


def scattered(brush: Brush, strokes: Strokes, rng: np.random.Generator) -> Laying:
    """Every stroke begun anywhere along the strip, except where the strip does not vary along it."""
    phase = rng.uniform(0, brush.repeat, len(strokes)) * (brush.model is not BrushModel.PROFILE)
    return Laying.plain(strokes.layout, phase)


def mean_ink(brush: Brush) -> float:
    """Mean ink of a brush inside the strokes' edges, in [0, 1]: the opacity of a solid stroke of as much ink."""
    profile = brush.profile
    v = ((np.arange(len(profile)) + 0.5) / len(profile) * 2 - 1) * SUPPORT
    return float(min(profile.sum() / max((np.abs(v) <= 1).sum(), 1), 1.0))


def solid_strokes(brush: Brush, strokes: Strokes, laying: Laying) -> Strokes:
    """Strokes of even ink that stand for textured ones where texture cannot be kept: mean density as opacity."""
    layout = strokes.layout
    count = np.diff(layout.row_joints)
    density = np.add.reduceat(laying.density, layout.row_joints[:-1]) / count
    return replace(strokes, opacity=np.clip(strokes.opacity * density * mean_ink(brush), 0.0, 1.0))
