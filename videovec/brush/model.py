"""A brush, how it was laid along strokes, and the two files that keep it: a 16-bit strip and a JSON."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum

import numpy as np
from numpy.typing import NDArray

from videovec.errors import FitError
from videovec.strokes import Layout

__all__ = ["SUPPORT", "Brush", "BrushModel", "Laying"]

Floats = NDArray[np.float64]

SUPPORT = 1.3  # half-widths from the centre line to the edge of a strip; beyond, a brush leaves no ink


class BrushModel(StrEnum):
    """What a brush's texture is: which of its marks come back, and which only look alike."""

    PROFILE = "profile"
    """Ink depends on the place across the stroke alone."""
    TEXTURE = "texture"
    """One periodic strip is laid along every stroke."""
    GRAIN = "grain"
    """A profile with grain of known statistics; every stroke has its own."""


@dataclass(frozen=True, slots=True, eq=False)
class Brush:
    """A brush in stroke coordinates: u along the arc in widths, v across in half-widths.

    Args:
        name: What it is called; the stem of its files.
        model: What its strip means.
        strip: Ink at every place, u by v; texel centres at (k + 0.5), v from -1.3 to 1.3; it repeats in u.
            [U, V] in [0, 1]
        width: Width of the pen that it was learned from. px
        repeat: Length of the strip. Widths
    """

    name: str
    model: BrushModel
    strip: Floats
    width: float
    repeat: float

    def __post_init__(self) -> None:
        if self.strip.ndim != 2 or not self.strip.size:
            raise FitError(f"a brush's strip must be [U, V], got {self.strip.shape}")
        if not (self.width > 0 and self.repeat > 0):
            raise FitError(f"a brush's width and repeat must be positive, got {self.width} and {self.repeat}")

    @property
    def profile(self) -> Floats:
        """Mean ink across the stroke. [V]"""
        return np.asarray(self.strip.mean(axis=0))


@dataclass(frozen=True, slots=True, eq=False)
class Laying:
    """How a brush was laid along S strokes over their drawings.

    A texel is at u = sign * arc / width + phase, v = sign * distance / half-width: a stroke drawn from its end has
    sign -1. Phases belong to the stroke and not to its drawings, so that a texture does not swim.

    Args:
        sign: Direction in which each stroke was drawn, 1 or -1. [S]
        phase: At every joint of a stroke, stroke by stroke; linear in t between. [sum of n+1] widths
        density: Ink at every joint of every row against the stroke's opacity, linear in t. [J] in [0, 1]
    """

    sign: Floats
    phase: Floats
    density: Floats

    @staticmethod
    def plain(layout: Layout, phase: Floats | None = None) -> Laying:
        """Every stroke drawn from its beginning with full density, from the given phases [S] or from 0."""
        joints = layout.segments + 1
        start = np.zeros(len(joints)) if phase is None else phase
        return Laying(np.ones(len(joints)), np.repeat(start, joints), np.ones(int(layout.row_joints[-1])))

    def at_drawing(self, layout: Layout, drawing: int) -> Laying:
        """The laying of the strokes alive at one drawing, as `Strokes.at_drawing` gives them."""
        rows = np.flatnonzero(layout.row_drawing == drawing)
        stroke = np.zeros(len(layout.segments), np.bool_)
        stroke[layout.row_stroke[rows]] = True
        of_phase = np.repeat(np.arange(len(stroke)), layout.segments + 1)
        return Laying(self.sign[stroke], self.phase[stroke[of_phase]], self.density[np.isin(layout.joint_row, rows)])


def stroke_joints(layout: Layout) -> NDArray[np.intp]:
    """Where the joints of each stroke begin in `Laying.phase`, then their number. int [S+1]"""
    return np.concatenate([[0], np.cumsum(layout.segments + 1)]).astype(np.intp)
