"""Renderers other than ours, in the same loop: strokes that are moved until a drawing of theirs is the input."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from importlib import import_module
from typing import Any

import numpy as np
import torch
from torch import Tensor

from videovec.initialise import initialise
from videovec.ink import Ink
from videovec.parameters import Parameters
from videovec.render.splats import draw_splats, place_splats
from videovec.settings import Config
from videovec.strokes import Strokes

__all__ = ["fit_with_diffvg", "fit_with_splats"]

SPACING = 0.5
"""Distance between sampled Gaussians. px"""
_RATE, _WIDTH_RATE = 0.3, 0.03  # steps of Adam, as in our own fit: px, and of the logarithm of half-widths

Draw = Callable[[Parameters, tuple[int, int]], Tensor]


def fit_with_splats(ink: Ink, config: Config) -> Strokes:
    """Our first strokes, fitted with the supplement's sampled Gaussians."""

    def draw(free: Parameters, size: tuple[int, int]) -> Tensor:
        scene = free.scene((1, *size), free.intervals())
        scene = replace(scene, color=scene.opacity.new_ones((len(scene.opacity), 1)))
        return draw_splats(place_splats(scene, SPACING), size, scene.opacity.new_zeros(1))[..., 0]

    return _fit(ink, config, draw)


def fit_with_diffvg(ink: Ink, config: Config) -> Strokes:
    """Our first strokes, fitted with DiffVG.

    Source:
        Li et al. 2020, "Differentiable vector graphics rasterization for editing and learning"; module ``pydiffvg``.
    """
    diffvg: Any = import_module("pydiffvg")

    def draw(free: Parameters, size: tuple[int, int]) -> Tensor:
        layout, half_width = free.strokes.layout, free.log_half_width.exp()
        paths, groups = [], []
        for row, count in enumerate(layout.segments.tolist()):
            points = free.points[layout.row_points[row] : layout.row_points[row + 1]]
            width = half_width[layout.row_joints[row] : layout.row_joints[row + 1]].mean()
            handles = torch.full((count,), 2, dtype=torch.int32)
            paths.append(diffvg.Path(handles, points.contiguous(), False, stroke_width=width))
            ink_color = torch.ones(4)
            groups.append(diffvg.ShapeGroup(torch.tensor([row]), None, stroke_color=ink_color))
        scene = diffvg.RenderFunction.serialize_scene(size[1], size[0], paths, groups)
        return torch.as_tensor(diffvg.RenderFunction.apply(size[1], size[0], 2, 2, 0, None, *scene))[..., 3]

    return _fit(ink, config, draw)


def _fit(ink: Ink, config: Config, draw: Draw) -> Strokes:
    """Adam on the sum of squared coverage errors, with our steps and rates."""
    free = Parameters.of(initialise(ink, 0, config.initialise))
    seen = torch.as_tensor(ink.coverage[0].astype(np.float32) / np.float32(255.0))
    moved = [{"params": [free.points], "lr": _RATE}, {"params": [free.log_half_width], "lr": _WIDTH_RATE}]
    adam = torch.optim.Adam(moved, betas=(0.9, 0.99))
    fall = torch.optim.lr_scheduler.CosineAnnealingLR(adam, max(config.fit.steps, 1))
    for _ in range(config.fit.steps):
        adam.zero_grad()
        (draw(free, ink.size) - seen).square().sum().backward()  # type: ignore[no-untyped-call]
        adam.step()
        fall.step()
    return free.to_strokes()
