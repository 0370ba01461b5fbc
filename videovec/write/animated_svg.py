"""A clip as one SVG that plays in a browser, without scripts or style sheets.

The same moving paths as in Lottie, animated by SMIL. Keyframes that hold are two at one time: the old value until then
and the new one from then on.
"""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
import svgwrite
from numpy.typing import NDArray
from svgwrite.base import BaseElement

from videovec.settings import ExportSettings
from videovec.stroke_shape import hex_colour
from videovec.tracks import StrokeTracks
from videovec.write.heads import svg_page, svg_text
from videovec.write.keyframes import Animated
from videovec.write.motion import StrokeMotion, stroke_motions
from videovec.write.svg import number, path_data
from videovec.write.time_base import TimeBase, time_base

__all__ = ["animated_svg_text"]

_EVEN = "0 0 1 1"


def animated_svg_text(
    tracks: StrokeTracks, settings: ExportSettings, motions: Iterable[StrokeMotion] | None = None
) -> str:
    """A clip as an SVG document that repeats without end.

    Args:
        tracks: The strokes of a clip.
        settings: Tolerance of the keyframes.
        motions: The strokes as moving paths, where they are known already.
    """
    base = time_base(tracks.timeline)
    document = svg_page(tracks)
    layer = document.g(id="lines", debug=False)
    for motion in stroke_motions(tracks, base, settings) if motions is None else motions:
        layer.add(_path(motion, _Clock(base), document))
    document.add(layer)
    return svg_text(document)


def _spline(handles: NDArray[np.float64]) -> str:
    """An easing as SVG writes it."""
    return " ".join(number(handle, 4) for handle in handles)


class _Clock:
    """Writes values over time as elements that animate an attribute."""

    def __init__(self, base: TimeBase) -> None:
        self._end = float(base.frame_ticks[-1])
        self._seconds = number(float(self._end / base.rate), 6)

    def set(self, path: BaseElement, attribute: str, animated: Animated, values: list[str]) -> None:
        """Give a path an attribute, and where it changes an animation of it."""
        path.attribs[attribute] = values[0]
        self.add(path, attribute, animated, values)

    def add(self, path: BaseElement, attribute: str, animated: Animated, values: list[str]) -> None:
        """Animate an attribute of a path through the values of its keyframes, unless they are all the same."""
        if len(set(values)) == 1:
            return
        times, shown, splines = [0.0], [values[0]], []
        for k, time in enumerate(animated.times.tolist()):
            if k and animated.is_hold[k - 1]:
                times.append(time)
                shown.append(values[k - 1])
                splines.append(_EVEN)
            if time > 0 or k:
                times.append(time)
                shown.append(values[k])
                handles = (
                    None if animated.handles is None or not k or animated.is_hold[k - 1] else animated.handles[k - 1]
                )
                splines.append(_EVEN if handles is None else _spline(handles))
        if times[-1] < self._end:
            times.append(self._end)
            shown.append(values[-1])
            splines.append(_EVEN)
        animation = self._animation(attribute, times, shown)
        if set(splines) != {_EVEN}:
            animation.attribs |= {"calcMode": "spline", "keySplines": ";".join(splines)}
        path.add(animation)

    def _animation(self, attribute: str, times: list[float], values: list[str]) -> BaseElement:
        animation = BaseElement(debug=False)
        animation.elementname = "animate"
        animation.attribs = {
            "attributeName": attribute,
            "dur": f"{self._seconds}s",
            "repeatCount": "indefinite",
            "keyTimes": ";".join(number(time / self._end, 6) for time in times),
            "values": ";".join(values),
        }
        return animation


def _path(motion: StrokeMotion, clock: _Clock, document: svgwrite.Drawing) -> BaseElement:
    colour = hex_colour(motion.color)
    lines = [
        " ".join(path_data(points, motion.is_closed) for points in together)
        for together in zip(*(loop.values for loop in motion.loops), strict=True)
    ]
    path = document.path(lines[0], id=f"stroke-{motion.id:04d}", debug=False)
    path.attribs["data-stroke-id"] = str(motion.id)
    clock.add(path, "d", motion.loops[0], lines)
    if motion.half_width is None:
        path.attribs.update({"fill": colour, "fill-rule": "nonzero"})
    else:
        path.attribs.update({"fill": "none", "stroke": colour, "stroke-linecap": "round", "stroke-linejoin": "round"})
        clock.set(path, "stroke-width", motion.half_width, [number(2 * width) for width in motion.half_width.values])
    if motion.visible is not None:
        views = motion.visible.values
        path.attribs["pathLength"] = "1"
        clock.set(path, "stroke-dasharray", motion.visible, [f"{number(end - start, 4)} 2" for start, end in views])
        clock.set(path, "stroke-dashoffset", motion.visible, [number(-start, 4) for start, _ in views])
    opacity = _from_the_start(motion)
    clock.set(path, "opacity", opacity, [number(value) for value in opacity.values])
    return path


def _from_the_start(motion: StrokeMotion) -> Animated:
    """Opacity, which is nothing before the stroke is born."""
    opacity = motion.opacity
    if motion.begin == 0:
        return opacity
    return Animated(
        np.concatenate([[0.0], opacity.times]),
        np.concatenate([[0.0], opacity.values]),
        np.concatenate([[True], opacity.is_hold]),
    )
