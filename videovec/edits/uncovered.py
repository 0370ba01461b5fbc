"""Add strokes for ink that none draws."""

from __future__ import annotations

from dataclasses import replace

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from videovec.curves import arc_length, sample_by_arc
from videovec.edits.layers import Page, layers_of
from videovec.edits.shapes import Shape, shapes_of, strokes_of
from videovec.initialise import initialise
from videovec.ink import Ink
from videovec.settings import EditSettings, InitialiseSettings
from videovec.strokes import Strokes

__all__ = ["add_strokes"]

Floats = NDArray[np.float64]

_SPREAD = 0.5  # of a typical line's width: what the residual is averaged over, so that edges do not count
_LEFT = 0.3  # of the ridge's strength that such an average has where a line is missing
_STROKE = 10  # control points that a stroke more must be worth beside its own
_BESIDE = 1.0  # px between a short stroke's edge and others beside which it is no stroke
_NOISE = 5.0  # standard deviations of page noise that a patch must weigh


def add_strokes(strokes: Strokes, page: Page, ink: Ink, settings: EditSettings, next_id: int) -> Strokes:
    """Trace the ink that is left over and keep the strokes that earn their price.

    Args:
        strokes: Strokes of one drawing.
        page: They drawn, against the ink; new strokes are added to it.
        ink: The ink of that drawing alone.
        settings: What counts as uncovered, and the price of a control point.
        next_id: The first identity that is free.

    Returns:
        The old strokes, then the new ones.
    """
    residual = np.maximum(page.residual, 0.0)
    patches = _patches(residual, _typical_width(strokes), ink.noise, settings)
    if not patches.any():
        return strokes
    left = np.where(patches, residual * 255.0, 0.0).round().astype(np.uint8)
    found = initialise(
        replace(ink, coverage=left[None]), 0, replace(InitialiseSettings(), tolerance=settings.tolerance)
    )
    shapes = shapes_of(strokes)
    above = int(max(strokes.layer, default=-1)) + 1
    bodies = _bodies(strokes)
    for shape, layer in zip(shapes_of(found), layers_of(found, page.size), strict=True):
        if _is_speck(shape, bodies, settings):
            continue
        if -page.rise([], [layer]) > settings.price * (len(shape.points) + _STROKE):
            page.add(layer)
            shapes.append(replace(shape, id=next_id, layer=above))
            next_id, above = next_id + 1, above + 1
    return strokes_of(shapes)


def _bodies(strokes: Strokes) -> cKDTree | None:
    """Points all along strokes; none where there are none."""
    if not len(strokes):
        return None
    lines = [strokes.points_of(s) for s in range(len(strokes))]
    return cKDTree(np.concatenate([sample_by_arc(line, max(2, round(arc_length(line)))) for line in lines]))


def _is_speck(shape: Shape, bodies: cKDTree | None, settings: EditSettings) -> bool:
    """Whether a stroke is so short and so close to others that it is an error of theirs and no stroke."""
    if bodies is None or arc_length(shape.points) >= settings.d_min:
        return False
    reach = _BESIDE + 2.0 * float(shape.half_width.max())
    return bool(np.isfinite(bodies.query(shape.points[::3], distance_upper_bound=reach)[0]).any())


def _typical_width(strokes: Strokes) -> float:
    return 2.0 * float(np.median(strokes.half_width)) if len(strokes) else 1.0


def _patches(residual: Floats, width: float, noise: float, settings: EditSettings) -> NDArray[np.bool_]:
    """Where whole lines or spots are missing, not only their edges. bool [H, W]"""
    sigma = max(_SPREAD * width, 0.5)
    strength = cv2.GaussianBlur(residual.astype(np.float32), (0, 0), sigma)
    seed = strength > _LEFT * min(1.0, width)
    near = cv2.dilate((seed).astype(np.uint8), np.ones((3, 3), np.uint8)) > 0
    region = near | ((residual > 0.1) & (cv2.dilate(near.astype(np.uint8), np.ones((5, 5), np.uint8)) > 0))
    count, label = cv2.connectedComponents(region.astype(np.uint8), connectivity=8)
    area = np.bincount(label.ravel(), minlength=count)
    weight = np.bincount(label.ravel(), np.square(residual).ravel(), count)
    mass = np.bincount(label.ravel(), residual.ravel(), count)
    keep = (weight > settings.delta_max * residual.size) & (mass > _NOISE * noise * np.sqrt(area))
    keep[0] = False
    return np.asarray(keep[label])
