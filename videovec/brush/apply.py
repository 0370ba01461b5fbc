"""Any strokes drawn with a brush: to judge it, to use it, and to draw what a fit has found."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import torch
from numpy.typing import ArrayLike, NDArray

from videovec.brush.paint import BrushTensors, alphas, find_pairs
from videovec.brush.prepare import mean_width
from videovec.brushwork import SUPPORT, Brush, BrushModel, Brushwork, Laying
from videovec.strokes import Strokes

__all__ = ["apply_brush", "brush_coverage", "draw_brushwork", "mean_ink", "solid_strokes", "stroke_marks"]

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
    if laying is None:
        laying = scattered(brush, strokes, np.random.default_rng(seed))
        brush = replace(brush, width=mean_width(strokes))
    return draw_brushwork(Brushwork((brush,), np.zeros(len(strokes), np.intp), laying), strokes, size, page)


def draw_brushwork(
    brushwork: Brushwork, strokes: Strokes, size: tuple[int, int], page: ArrayLike = (1.0, 1.0, 1.0)
) -> Floats:
    """Draw the strokes of one drawing with the brushes that were laid along them.

    Args:
        brushwork: Brushes, and how they lie along these strokes.
        strokes: Strokes of drawing 0, in their own colours and layers.
        size: Height and width of the page. px
        page: Colour of the page, sRGB in [0, 1]. [3]

    Returns:
        The picture, sRGB. [H, W, 3] in [0, 1]
    """
    height, width = size
    picture = np.tile(np.asarray(page, dtype=np.float64), (height * width, 1))
    marks = stroke_marks(brushwork, strokes, size)
    for row in strokes.rows_at(0).tolist():
        pixels, alpha = marks[row]
        clear = 1 - alpha[:, None]
        picture[pixels] = clear * picture[pixels] + (1 - clear) * strokes.color[strokes.layout.row_stroke[row]]
    return picture.reshape(height, width, 3)


def stroke_marks(
    brushwork: Brushwork, strokes: Strokes, size: tuple[int, int]
) -> list[tuple[NDArray[np.intp], NDArray[np.float64]]]:
    """What each stroke of one drawing leaves on the page: pixels, flat in [H, W], and alpha there. R times [N], [N]"""
    marks = [(np.zeros(0, np.intp), np.zeros(0))] * strokes.row_count
    for number, brush in enumerate(brushwork.brushes):
        own = brushwork.chosen == number
        if not own.any():
            continue
        part, laying = strokes.select(own), brushwork.laying.select(strokes.layout, own)
        with torch.no_grad():
            pairs = find_pairs(part, laying, (1, *size))
            alpha = alphas(pairs, BrushTensors.of(part, laying, brush)).numpy().astype(np.float64)
        pixel, row = pairs.pixels.numpy()[pairs.at.numpy()], pairs.row.numpy()
        for one, whole in enumerate(np.flatnonzero(own[strokes.layout.row_stroke]).tolist()):
            mine = row == one
            touched, place = np.unique(pixel[mine], return_inverse=True)
            clear = np.ones(len(touched))
            np.multiply.at(clear, place, 1 - alpha[mine])
            marks[whole] = touched, 1 - clear
    return marks


def brush_coverage(brushwork: Brushwork, strokes: Strokes, size: tuple[int, int, int]) -> NDArray[np.uint8]:
    """Coverage of textured strokes over D drawings, 255 is full. uint8 [D, H, W]"""
    drawn = np.zeros(size, np.uint8)
    for drawing, page in enumerate(drawn):
        alone = strokes.at_drawing(drawing, as_drawing=0)
        ink = draw_brushwork(
            brushwork.at_drawing(strokes.layout, drawing),
            replace(alone, color=np.ones_like(alone.color)),
            (size[1], size[2]),
            np.zeros(3),
        )
        page[...] = np.round(255 * ink[..., 0])
    return drawn


def scattered(brush: Brush, strokes: Strokes, rng: np.random.Generator) -> Laying:
    """Every stroke begun anywhere along the strip, except where the strip does not vary along it."""
    phase = rng.uniform(0, brush.repeat, len(strokes)) * (brush.model is not BrushModel.PROFILE)
    return Laying.plain(strokes.layout, phase)


def mean_ink(brush: Brush) -> float:
    """Mean ink of a brush inside the strokes' edges, in [0, 1]: the opacity of a solid stroke of as much ink."""
    profile = brush.profile
    v = ((np.arange(len(profile)) + 0.5) / len(profile) * 2 - 1) * SUPPORT
    return float(min(profile.sum() / max((np.abs(v) <= 1).sum(), 1), 1.0))


def solid_strokes(brushwork: Brushwork, strokes: Strokes) -> Strokes:
    """Strokes of even ink that stand for textured ones where texture cannot be kept: mean density as opacity."""
    layout, density = strokes.layout, brushwork.laying.density
    ink = np.array([mean_ink(brush) for brush in brushwork.brushes])[brushwork.chosen[layout.row_stroke]]
    mean = np.add.reduceat(density, layout.row_joints[:-1]) / np.diff(layout.row_joints) if len(density) else density
    return replace(strokes, opacity=np.clip(strokes.opacity * mean * ink, 0.0, 1.0))
