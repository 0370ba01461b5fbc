"""Terms of the fit of one drawing beside the photometric one: the shape of segments, and what a viewer sees."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor

from videovec.losses import continuity, curvature, self_intersection
from videovec.optimise import PixelTerm, Term
from videovec.parameters import Parameters
from videovec.perceptual import PerceptualTerm
from videovec.settings import FitSettings
from videovec.strokes import Strokes

__all__ = ["drawing_terms"]

_SMOOTH = 45.0  # degrees; joints that turn more are corners, which stay


def drawing_terms(
    strokes: Strokes, target: NDArray[np.uint8], settings: FitSettings, device: torch.device
) -> list[Term | PixelTerm]:
    """The terms that have a weight.

    The photometric term of `optimise` is a sum over pixels. So are these: the terms on the shape of segments are
    summed over segments, which makes one that is crossed as bad as ``weight`` pixels that are wrong; the perceptual
    one, a mean over the page, is multiplied by its pixels.

    Args:
        strokes: Strokes of drawing 0, as the fit begins.
        target: Ink coverage, 255 is full. uint8 [1, H, W]
        settings: Weights, and how often the perceptual term is evaluated.
        device: Where the fit runs.
    """
    weights, side = settings.weights, float(max(target.shape[1:]))
    before, after = (torch.as_tensor(index, device=device) for index in _smooth_joints(strokes))
    shapes: list[tuple[float, Callable[[Tensor], Tensor]]] = [
        (weights.self_intersection, self_intersection),
        (weights.curvature, lambda segments: curvature(segments, side)),
        (weights.continuity, lambda segments: continuity(segments, before, after)),
    ]
    index = torch.as_tensor(strokes.layout.segment_points, device=device)
    terms: list[Term | PixelTerm] = [
        _of_segments(loss, index, weight * len(index)) for weight, loss in shapes if weight > 0 and len(strokes)
    ]
    if weights.perceptual > 0:
        seen = PerceptualTerm(torch.as_tensor(target, device=device), device)
        terms.append(PixelTerm(seen.gradient, weights.perceptual * target.size, settings.perceptual_every))
    return terms


def _of_segments(loss: Callable[[Tensor], Tensor], index: Tensor, weight: float) -> Term:
    def term(parameters: Parameters) -> Tensor:
        return weight * loss(parameters.points[index])

    return term


def _smooth_joints(strokes: Strokes) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """Segments before and after each joint at which a stroke has no corner. int [K], int [K]"""
    before = np.flatnonzero(np.diff(strokes.layout.segment_row) == 0)
    segments = strokes.segments()
    arriving = segments[before, 3] - segments[before, 2]
    leaving = segments[before + 1, 1] - segments[before + 1, 0]
    scale = np.linalg.norm(arriving, axis=1) * np.linalg.norm(leaving, axis=1)
    is_smooth = (arriving * leaving).sum(axis=1) > np.cos(np.radians(_SMOOTH)) * scale
    return before[is_smooth], before[is_smooth] + 1
