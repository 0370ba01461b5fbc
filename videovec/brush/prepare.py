"""Solid strokes made ready for a brush: short segments, and a symmetric profile with density along them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from videovec.brush.coordinates import sample_rows
from videovec.brush.gauge import centre_support, full_scale
from videovec.brush.refine import Laid, RefineSchedule, refine
from videovec.brush.strips import TEXELS_ACROSS
from videovec.brushwork import SUPPORT, Brush, BrushModel, Laying
from videovec.curves import split
from videovec.progress import Progress
from videovec.strokes import Layout, Strokes

__all__ = ["fit_profile", "mean_width", "shorten_segments"]

Floats = NDArray[np.float64]

_START_DENSITY = 0.75  # a logit at 1 would not move


def mean_width(strokes: Strokes) -> float:
    """Mean width along all visible strokes. px"""
    half_width = sample_rows(strokes).half_width
    return 2 * float(half_width.mean()) if len(half_width) else 1.0


def shorten_segments(strokes: Strokes, longest: float) -> Strokes:
    """Halve segments until none is longer than this in the mean over its drawings; the curves stay. px"""
    while True:
        layout = strokes.layout
        control = strokes.segments()
        polygon = np.linalg.norm(np.diff(control, axis=1), axis=2).sum(1)
        chord = np.linalg.norm(control[:, 3] - control[:, 0], axis=1)
        stroke = layout.row_stroke[layout.segment_row]
        first = np.concatenate([[0], np.cumsum(layout.segments)])
        place = first[stroke] + np.arange(len(stroke)) - layout.row_segments[layout.segment_row]
        count = np.bincount(place, minlength=int(first[-1]))
        is_long = np.bincount(place, 0.5 * (polygon + chord), minlength=int(first[-1])) / count > longest
        if not is_long.any():
            return strokes
        strokes = _halve(strokes, is_long[place], np.add.reduceat(is_long, first[:-1]))


def _halve(strokes: Strokes, which: NDArray[np.bool_], more: NDArray[np.intp]) -> Strokes:
    """Halve the segments ``which`` [G], ``more`` of them in each stroke [S]."""
    layout = strokes.layout
    control, joints = strokes.segments(), strokes.half_width[layout.segment_joints]
    before, after = split(control, 0.5)
    middle = joints.mean(1)
    new_layout = Layout(layout.segments + more, layout.first, layout.last)
    points, half_width = [], []
    for row in range(strokes.row_count):
        part = slice(layout.row_segments[row], layout.row_segments[row + 1])
        points.append(control[part.start, :1])
        half_width.append(joints[part.start, :1])
        for g in range(part.start, part.stop):
            pieces = (before[g], after[g]) if which[g] else (control[g],)
            points.extend(piece[1:] for piece in pieces)
            half_width.append(np.array([middle[g], joints[g, 1]]) if which[g] else joints[g, 1:])
    return replace(strokes, layout=new_layout, points=np.concatenate(points), half_width=np.concatenate(half_width))


def fit_profile(strokes: Strokes, coverage: NDArray[np.uint8], steps: int, progress: Progress) -> Laid:
    """Fit ink across and density along solid strokes, and the strokes themselves.

    Args:
        strokes: A solid fit.
        coverage: Ink fraction, 255 is full. uint8 [D, H, W]
        steps: Optimiser updates.
        progress: Advanced at every step.

    Returns:
        Strokes whose half-width is where the ink ends, laid with a brush that is its profile.
    """
    v = np.abs((np.arange(TEXELS_ACROSS) + 0.5) / TEXELS_ACROSS * 2 - 1) * SUPPORT
    box = np.clip((1.05 - v) / 0.25, 0.01, 0.95)
    brush = Brush("brush", BrushModel.PROFILE, box[None], mean_width(strokes), 1.0)
    laying = Laying.plain(strokes.layout)
    laid = Laid(strokes, replace(laying, density=_START_DENSITY * laying.density), brush)
    laid = refine(laid, coverage, RefineSchedule(steps, points=0.15, half_width=0.03), progress)
    laid = centre_support(laid)
    return full_scale(replace(laid.brush, width=mean_width(laid.strokes)), laid)
