"""One stroke over the drawings of its life, as arrays of one shape for all of them."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from videovec.stroke_shape import StrokeShape
from videovec.strokes import Layout, Strokes

__all__ = ["StrokeLife"]

Floats = NDArray[np.float64]


@dataclass(frozen=True, slots=True, eq=False)
class StrokeLife:
    """A stroke of n segments over K drawings without a gap.

    Args:
        id: Its identity.
        first: The first of its drawings.
        points: Control points. [K, 3n+1, 2] px
        half_width: Half-width at the joints. [K, n+1] px
        opacity: Plateau coverage. [K] in [0, 1]
        visible: The part of the arc that is seen, as arc fractions. [K, 2]
        color: Ink, sRGB in [0, 1]. [3]
        layer: Compositing order; the higher lies above.
        is_closed: Whether it ends where it begins.
        parent: Identity of the stroke whose part beyond a gap it is, else 0.
    """

    id: int
    first: int
    points: Floats
    half_width: Floats
    opacity: Floats
    visible: Floats
    color: Floats
    layer: int
    is_closed: bool
    parent: int = 0

    @staticmethod
    def of(strokes: Strokes, stroke: int) -> StrokeLife:
        """The life of a stroke, by its position."""
        layout = strokes.layout
        begin, end = layout.stroke_rows[stroke : stroke + 2]
        count = end - begin
        points = strokes.points[layout.row_points[begin] : layout.row_points[end]]
        widths = strokes.half_width[layout.row_joints[begin] : layout.row_joints[end]]
        return StrokeLife(
            id=int(strokes.ids[stroke]),
            first=int(layout.first[stroke]),
            points=points.reshape(count, -1, 2),
            half_width=widths.reshape(count, -1),
            opacity=strokes.opacity[begin:end],
            visible=strokes.visible[begin:end],
            color=strokes.color[stroke],
            layer=int(strokes.layer[stroke]),
            is_closed=bool(strokes.is_closed[stroke]),
            parent=int(strokes.parent[stroke]),
        )

    @property
    def last(self) -> int:
        """The last of its drawings."""
        return self.first + len(self.points) - 1

    @property
    def segment_count(self) -> int:
        """n, the same on every drawing."""
        return int(self.half_width.shape[1]) - 1

    def at(self, drawing: int) -> StrokeShape:
        """The stroke on one drawing of its life."""
        k = drawing - self.first
        return StrokeShape(
            id=self.id,
            points=self.points[k],
            half_width=self.half_width[k],
            color=self.color,
            opacity=float(self.opacity[k]),
            visible=(float(self.visible[k, 0]), float(self.visible[k, 1])),
            is_closed=self.is_closed,
        )

    def reversed(self) -> StrokeLife:
        """The same stroke, run the other way."""
        return replace(
            self,
            points=self.points[:, ::-1],
            half_width=self.half_width[:, ::-1],
            visible=1.0 - self.visible[:, ::-1],
        )

    def between(self, first: int, last: int) -> StrokeLife:
        """The stroke on the drawings ``first .. last`` alone, which lie in its life."""
        part = slice(first - self.first, last - self.first + 1)
        rows = {name: getattr(self, name)[part] for name in ("points", "half_width", "opacity", "visible")}
        return replace(self, first=first, **rows)

    def as_strokes(self) -> Strokes:
        """The stroke as strokes of which there is one."""
        life = (np.array([value], dtype=np.intp) for value in (self.segment_count, self.first, self.last))
        return Strokes(
            ids=np.array([self.id]),
            layout=Layout(*life),
            is_closed=np.array([self.is_closed]),
            layer=np.array([self.layer]),
            color=self.color[None],
            points=self.points.reshape(-1, 2),
            half_width=self.half_width.reshape(-1),
            opacity=self.opacity,
            visible=self.visible,
            parent=np.array([self.parent]),
        )
