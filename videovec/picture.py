"""Strokes as a picture, for whoever has no need of gradients."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import torch
from numpy.typing import ArrayLike, NDArray

from videovec.parameters import Parameters
from videovec.render import render_image, resolve_backend
from videovec.settings import RenderSettings
from videovec.strokes import Strokes

__all__ = ["render_strokes"]


def render_strokes(
    strokes: Strokes,
    size: tuple[int, int],
    drawing: int = 0,
    page: ArrayLike = (1.0, 1.0, 1.0),
    settings: RenderSettings | None = None,
) -> NDArray[np.float32]:
    """Draw the strokes of one drawing in their inks.

    Args:
        strokes: S strokes over D drawings.
        size: Height and width of the page. px
        drawing: The drawing.
        page: Colour of the page, sRGB in [0, 1]. [3]
        settings: Which renderer, on which device.

    Returns:
        The picture, sRGB in [0, 1]. [H, W, 3]
    """
    backend = resolve_backend(settings or RenderSettings())
    alone = strokes.at_drawing(drawing, as_drawing=0)
    with torch.no_grad():
        free = Parameters.of(alone, backend.device)
        ink = torch.as_tensor(alone.color).to(free.points)[free.index.rows]
        scene = replace(free.scene((1, *size), free.intervals()), color=ink)
        image = render_image(scene, torch.as_tensor(np.asarray(page, float)).to(ink), backend=backend.name)
    return image[0].clamp(0, 1).float().cpu().numpy()
