"""Drawings with known strokes for the benchmarks of the renderer, and their exact rasters."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise

import numpy as np
import torch
from numpy.typing import NDArray

from videovec.render import Scene


def random_drawing(strokes: int, side: int, width: float = 3.0, drawings: int = 1, seed: int = 0) -> Scene:
    """Smooth strokes of three to five segments of a twentieth of the side each, opaque, on every drawing.

    Args:
        strokes: Number of strokes on each drawing.
        side: Height and width. px
        width: Of the strokes. px
        drawings: Number of drawings; each moves the strokes a little.
        seed: Of the geometry.
    """
    rng = np.random.default_rng(seed)
    curves, row = [], []
    for stroke in range(strokes):
        count = int(rng.integers(3, 6))
        heading = rng.uniform(0, 2 * np.pi) + np.cumsum(rng.normal(0, 0.25, 3 * count))
        steps = side * 0.0085 * np.stack([np.cos(heading), np.sin(heading)], axis=-1)
        points = rng.uniform(0.1, 0.9, 2) * side + np.concatenate([np.zeros((1, 2)), np.cumsum(steps, axis=0)])
        curves += [points[3 * k : 3 * k + 4] for k in range(count)]
        row += [stroke] * count
    one = torch.tensor(np.array(curves), dtype=torch.float32)
    shift = torch.arange(drawings, dtype=torch.float32)[:, None, None, None] * 0.37
    control = (one + shift).reshape(-1, 4, 2)
    rows = torch.tensor(row) + strokes * torch.arange(drawings)[:, None]
    return Scene(
        control=control,
        half_width=torch.full((len(control), 2), width / 2),
        interval=torch.tensor([[0.0, 1.0]]).repeat(len(control), 1),
        row=rows.reshape(-1),
        opacity=torch.ones(strokes * drawings),
        color=torch.ones(strokes * drawings, 1),
        drawing=torch.arange(drawings).repeat_interleave(strokes),
        size=(drawings, side, side),
    )


def on_page(scene: Scene, side: int) -> Scene:
    """The same strokes on a page of another size."""
    return replace(scene, size=(scene.size[0], side, side))


def exact_raster(scene: Scene, samples: int = 8) -> NDArray[np.float32]:
    """Area of each pixel of the first drawing within half-width of its strokes, by many point samples. [H, W]

    Widths are those of the segments' first ends: constant ones only.
    """
    _, height, width = scene.size
    inside = np.zeros((height * samples, width * samples), bool)
    t = np.linspace(0, 1, 33)[:, None]
    for control, half in zip(scene.control.numpy().astype(float), scene.half_width[:, 0].numpy(), strict=True):
        p = control[:, None]
        curve = ((1 - t) ** 3 * p[0] + 3 * t * (1 - t) ** 2 * p[1] + 3 * t**2 * (1 - t) * p[2] + t**3 * p[3]) * samples
        for a, b in pairwise(curve):
            _fill_capsule(inside, a, b, float(half) * samples)
    share: NDArray[np.float32] = inside.reshape(height, samples, width, samples).mean(axis=(1, 3), dtype=np.float32)
    return share


def _fill_capsule(inside: NDArray[np.bool_], a: NDArray[np.float64], b: NDArray[np.float64], reach: float) -> None:
    low = np.maximum(np.floor(np.minimum(a, b) - reach).astype(int), 0)
    high = np.minimum(np.ceil(np.maximum(a, b) + reach).astype(int) + 1, inside.shape[::-1])
    if np.any(low >= high):
        return
    x, y = np.arange(low[0], high[0]) + 0.5 - a[0], (np.arange(low[1], high[1]) + 0.5 - a[1])[:, None]
    e = b - a
    part = np.clip((x * e[0] + y * e[1]) / max(float(e @ e), 1e-12), 0, 1)
    inside[low[1] : high[1], low[0] : high[0]] |= (x - part * e[0]) ** 2 + (y - part * e[1]) ** 2 <= reach * reach
