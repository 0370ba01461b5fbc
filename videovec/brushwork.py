"""What textured strokes are drawn with: brushes, which of them draws each stroke, and how it was laid along it."""

from __future__ import annotations

from dataclasses import dataclass, replace
from enum import StrEnum

import numpy as np
from numpy.typing import NDArray

from videovec.errors import FitError
from videovec.strokes import Layout, Strokes

__all__ = ["SUPPORT", "Brush", "BrushModel", "Brushwork", "Laying", "stroke_joints"]

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
    """How a brush was laid along S strokes over their drawings, in R rows.

    A texel is at u = sign * arc / width + phase + shift, v = sign * distance / half-width: a stroke drawn from its end
    has sign -1. Phases belong to the stroke and not to its drawings, so that a texture does not swim; shifts say where
    the arc of one drawing is wrong by more than the others': a first point that lies elsewhere along the ink, a corner
    cut short. They are anything only where lines boil.

    Args:
        sign: Direction in which each stroke was drawn, 1 or -1. [S]
        phase: At every joint of a stroke, stroke by stroke; linear in t between. [sum of n+1] widths
        density: Ink at every joint of every row against the stroke's opacity, linear in t. [J] in [0, 1]
        shift: At every joint of every row, linear in t. [J] widths
    """

    sign: Floats
    phase: Floats
    density: Floats
    shift: Floats

    @staticmethod
    def plain(layout: Layout, phase: Floats | None = None) -> Laying:
        """Every stroke drawn from its beginning with full density, from the given phases [S] or from 0."""
        joints = layout.segments + 1
        start = np.zeros(len(joints)) if phase is None else phase
        count = int(layout.row_joints[-1])
        return Laying(np.ones(len(joints)), np.repeat(start, joints), np.ones(count), np.zeros(count))

    def select(self, layout: Layout, which: NDArray[np.bool_]) -> Laying:
        """The laying of some strokes, by mask, as `Strokes.select` gives them."""
        joints = which[layout.row_stroke][layout.joint_row]
        of_phase = np.repeat(which, layout.segments + 1)
        return Laying(self.sign[which], self.phase[of_phase], self.density[joints], self.shift[joints])

    def at_drawing(self, layout: Layout, drawing: int) -> Laying:
        """The laying of the strokes alive at one drawing, as `Strokes.at_drawing` gives them."""
        rows = layout.row_drawing == drawing
        stroke = np.zeros(len(layout.segments), np.bool_)
        stroke[layout.row_stroke[rows]] = True
        joints, of_phase = rows[layout.joint_row], np.repeat(stroke, layout.segments + 1)
        return Laying(self.sign[stroke], self.phase[of_phase], self.density[joints], self.shift[joints])


@dataclass(frozen=True, slots=True, eq=False)
class Brushwork:
    """The brushes of a clip and how they were laid along its S strokes.

    Args:
        brushes: One, or one for each ink.
        chosen: Which of them draws each stroke. int [S]
        laying: How it was laid.
    """

    brushes: tuple[Brush, ...]
    chosen: NDArray[np.intp]
    laying: Laying

    def __post_init__(self) -> None:
        if not self.brushes or self.chosen.shape != self.laying.sign.shape:
            raise FitError(f"each of {len(self.laying.sign)} strokes needs one of {len(self.brushes)} brushes")

    def at_drawing(self, layout: Layout, drawing: int) -> Brushwork:
        """That of the strokes alive at one drawing, as `Strokes.at_drawing` gives them."""
        alive = (layout.first <= drawing) & (drawing <= layout.last)
        return replace(self, chosen=self.chosen[alive], laying=self.laying.at_drawing(layout, drawing))

    def carried_to(self, before: Strokes, after: Strokes) -> Brushwork:
        """That of strokes after an edit: what it left alone stays as it was, anything else is laid plainly.

        Args:
            before: The strokes that these brushes draw.
            after: The edited strokes; an identity that is new takes the first brush.
        """
        place = {one: k for k, one in enumerate(before.ids.tolist())}
        laid = Laying.plain(after.layout)
        chosen = np.zeros(len(after), np.intp)
        for new, identity in enumerate(after.ids.tolist()):
            old = place.get(identity)
            if old is None:
                continue
            chosen[new] = self.chosen[old]
            if _is_same(before, old, after, new):
                for values, known in zip(
                    _parts(laid, after.layout, new), _parts(self.laying, before.layout, old), strict=True
                ):
                    values[...] = known
        return Brushwork(self.brushes, chosen, laid)


def _parts(laying: Laying, layout: Layout, stroke: int) -> tuple[Floats, ...]:
    """Views of what a laying holds of one stroke: sign, phases, density and shifts."""
    first, last = layout.stroke_rows[stroke : stroke + 2]
    joints, phases = layout.row_joints, stroke_joints(layout)
    return (
        laying.sign[stroke : stroke + 1],
        laying.phase[phases[stroke] : phases[stroke + 1]],
        laying.density[joints[first] : joints[last]],
        laying.shift[joints[first] : joints[last]],
    )


def _is_same(before: Strokes, old: int, after: Strokes, new: int) -> bool:
    """Whether a stroke has the same points over the same life."""
    one, other = before.layout, after.layout
    if (one.segments[old], one.first[old], one.last[old]) != (other.segments[new], other.first[new], other.last[new]):
        return False
    return bool(np.array_equal(_points(before, old), _points(after, new)))


def _points(strokes: Strokes, stroke: int) -> Floats:
    """Control points of a stroke over its whole life. [P, 2] px"""
    first, last = strokes.layout.row_points[strokes.layout.stroke_rows[stroke : stroke + 2]]
    return strokes.points[first:last]


def stroke_joints(layout: Layout) -> NDArray[np.intp]:
    """Where the joints of each stroke begin in `Laying.phase`, then their number. int [S+1]"""
    return np.concatenate([[0], np.cumsum(layout.segments + 1)]).astype(np.intp)
