"""Strokes as moving paths of a constant number of points: what Lottie and animated SVG are written from."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from videovec.curves import arc_length
from videovec.settings import ExportSettings
from videovec.stroke_shape import StrokeShape, shape_of_row
from videovec.tracks import StrokeTracks
from videovec.write.easing import reduce_paths
from videovec.write.keyframes import Animated, reduce_keyframes
from videovec.write.outline import outline, plan_outline
from videovec.write.style import is_constant_width, mean_half_widths
from videovec.write.time_base import TimeBase

__all__ = ["StrokeMotion", "stroke_motions"]

Floats = NDArray[np.float64]

_DOT = 0.05  # px of extent up to which some players draw nothing of a line, not even its round ends
_WIDTH_TOLERANCE = 0.05  # px
_OPACITY_TOLERANCE = 0.01


@dataclass(frozen=True, slots=True, eq=False)
class StrokeMotion:
    """A stroke over its life.

    Args:
        id: Its identity.
        begin: When it is first shown. Ticks
        end: When it is shown no more. Ticks
        color: Ink, sRGB in [0, 1]. [3]
        loops: Its centre line, or the one or two closed loops of its outline, which share their keyframes. Values
            [K, 3n+1, 2] px
        is_closed: Whether the loops are closed; an outline's always are.
        half_width: Of a centre line; none for an outline, which is filled. Values [K] px
        visible: The part of a centre line that is seen; none where that is always all of it. Values [K, 2]
        opacity: Zero while the stroke is hidden. Values [K]
    """

    id: int
    begin: int
    end: int
    color: Floats
    loops: tuple[Animated, ...]
    is_closed: bool
    half_width: Animated | None
    visible: Animated | None
    opacity: Animated


def stroke_motions(tracks: StrokeTracks, base: TimeBase, settings: ExportSettings) -> Iterator[StrokeMotion]:
    """The strokes of a clip as moving paths, from the lowest layer to the highest.

    Args:
        tracks: The strokes.
        base: The clock.
        settings: How far reduced keyframes may be off, and whether held drawings are stepped through.

    Yields:
        Each stroke of which anything is ever seen.
    """
    strokes = tracks.strokes
    is_line = is_constant_width(strokes, settings.line_tolerance)
    mean = mean_half_widths(strokes)
    for stroke in np.argsort(strokes.layer, kind="stable"):
        rows = np.arange(*strokes.layout.stroke_rows[stroke : stroke + 2])
        shapes = [shape_of_row(strokes, int(row)) for row in rows]
        if not any(shape.is_visible for shape in shapes):
            continue
        drawings = strokes.layout.row_drawing[rows]
        is_drawn = is_line[stroke] and min(np.ptp(shape.points, axis=0).max() for shape in shapes) > _DOT
        clock = _Clock(
            base.drawing_ticks[drawings].astype(np.float64),
            (base.exposure[drawings] > 1) & (not settings.lottie_smooth),
            _room(settings),
        )
        seen = shapes[int(np.argmax([shape.is_visible for shape in shapes]))]
        yield StrokeMotion(
            id=seen.id,
            begin=int(base.drawing_ticks[drawings[0]]),
            end=int(base.drawing_ticks[drawings[-1] + 1]),
            color=seen.color,
            loops=_lines(shapes, clock) if is_drawn else _outlines(shapes, clock),
            is_closed=seen.is_closed or not is_drawn,
            half_width=clock.reduce(mean[rows], _WIDTH_TOLERANCE) if is_drawn else None,
            visible=_visible(shapes, clock) if is_drawn else None,
            opacity=_ended(_opacity(shapes, clock), int(base.drawing_ticks[drawings[-1] + 1]), base),
        )


@dataclass(frozen=True, slots=True, eq=False)
class _Clock:
    """When the rows of a stroke are, which of them are held, and how far a point may be off."""

    times: Floats
    is_held: NDArray[np.bool_]
    tolerance: float

    def reduce(self, values: Floats, tolerance: float, is_step: NDArray[np.bool_] | None = None) -> Animated:
        """Keyframes for one value per row; ``is_step`` marks rows after which it jumps even though none is held."""
        return reduce_keyframes(
            self.times, values, tolerance, self.is_held if is_step is None else self.is_held | is_step
        )


def _room(settings: ExportSettings) -> float:
    """What rounded coordinates leave of the tolerance. px"""
    rounding = np.hypot(0.5, 0.5) * 0.1**settings.lottie_decimals
    return float(max(settings.lottie_tolerance - rounding, settings.lottie_tolerance / 2))


def _lines(shapes: list[StrokeShape], clock: _Clock) -> tuple[Animated, ...]:
    points = np.stack([shape.points for shape in shapes])
    return reduce_paths(clock.times, [points], clock.is_held, clock.tolerance, is_open=not shapes[0].is_closed)


def _outlines(shapes: list[StrokeShape], clock: _Clock) -> tuple[Animated, ...]:
    """One or two loops with the same keyframes; half of what they may be off is the plan's."""
    loops = outline(shapes, plan_outline(shapes, clock.tolerance / 2))
    return reduce_paths(clock.times, loops, clock.is_held, clock.tolerance / 2)


def _visible(shapes: list[StrokeShape], clock: _Clock) -> Animated | None:
    """The visible interval; while nothing is seen it stays as it was, for the opacity hides the stroke then."""
    if all(shape.is_whole for shape in shapes if shape.is_visible):
        return None
    is_visible = np.array([shape.is_visible for shape in shapes])
    source = np.maximum.accumulate(np.where(is_visible, np.arange(len(shapes)), -1))
    source[source < 0] = int(np.argmax(is_visible))
    intervals = np.array([shape.visible for shape in shapes])[source]
    longest = max(arc_length(shape.points) for shape in shapes)
    return clock.reduce(intervals, clock.tolerance / max(longest, clock.tolerance))


def _opacity(shapes: list[StrokeShape], clock: _Clock) -> Animated:
    """Opacity, which drops to nothing at once where the stroke is hidden."""
    is_visible = np.array([shape.is_visible for shape in shapes])
    values = np.where(is_visible, [shape.opacity for shape in shapes], 0.0)
    return clock.reduce(values, _OPACITY_TOLERANCE, np.append(is_visible[1:] != is_visible[:-1], False))


def _ended(opacity: Animated, end: int, base: TimeBase) -> Animated:
    """Opacity that is nothing from the end of a life on: rlottie shows a layer on its ``op`` as well."""
    if end >= base.frame_ticks[-1]:
        return opacity
    return Animated(
        np.append(opacity.times, float(end)), np.append(opacity.values, 0.0), np.append(opacity.is_hold, True)
    )
