"""What independent programs draw, and what should be drawn, for the tests of the writers."""

from __future__ import annotations

import io

import numpy as np
import resvg_py
import skia
from numpy.typing import NDArray
from PIL import Image

from videovec.curves import evaluate, segments_of, width_at
from videovec.stroke_shape import StrokeShape

Floats = NDArray[np.float64]

_SAMPLES = 150  # discs along a segment that stand for it
_SCALLOP = 0.01  # px
_OVERSAMPLING = 4


def stroke(points: object, half_width: object, *, is_closed: bool = False, visible: object = (0.0, 1.0)) -> StrokeShape:
    """A black stroke of identity 1."""
    start, end = np.asarray(visible, float)
    return StrokeShape(
        id=1,
        points=np.asarray(points, float),
        half_width=np.asarray(half_width, float),
        color=np.zeros(3),
        opacity=1.0,
        visible=(float(start), float(end)),
        is_closed=is_closed,
    )


def coverage(shapes: list[StrokeShape], size: int) -> Floats:
    """How much of each pixel lies in the discs along any of the strokes. [size, size]"""
    outside = np.full((size * _OVERSAMPLING, size * _OVERSAMPLING), np.inf)
    for shape in shapes:
        part = shape.visible_part()
        count = len(part.half_width) - 1
        segments = segments_of(part.points)
        fastest = 3 * np.linalg.norm(np.diff(segments, axis=1), axis=-1).max()  # px for each unit of t, at most
        apart = np.sqrt(8 * max(part.half_width.min(), 0.1) * _SCALLOP)  # px at which discs leave so deep a scallop
        place = np.linspace(0, count, count * max(_SAMPLES, int(np.ceil(fastest / apart))) + 1)
        segment = np.minimum(place.astype(np.intp), count - 1)
        centres = evaluate(segments[segment], place - segment)
        for centre, radius in zip(centres, width_at(part.half_width, segment, place - segment), strict=True):
            first = np.maximum(np.floor((centre - radius - 1) * _OVERSAMPLING).astype(int), 0)
            last = np.ceil((centre + radius + 1) * _OVERSAMPLING).astype(int)
            window = outside[first[1] : last[1], first[0] : last[0]]
            y, x = (np.indices(window.shape) + first[::-1, None, None] + 0.5) / _OVERSAMPLING
            np.minimum(window, np.hypot(x - centre[0], y - centre[1]) - radius, out=window)
    return _averaged(np.clip(0.5 - outside * _OVERSAMPLING, 0, 1), _OVERSAMPLING)


def resvg(document: str, scale: int = 1) -> Floats:
    """A document on white as resvg draws it, at ``scale`` times its size and averaged down. Grey in [0, 1], [H, W]"""
    content = bytes(resvg_py.svg_to_bytes(svg_string=document, background="#ffffff", zoom=scale))
    return _averaged(np.asarray(Image.open(io.BytesIO(content)).convert("L"), float) / 255, scale)


def by_skia(document: str, size: tuple[int, int], scale: int = 1) -> Floats:
    """A document on white as Skia draws it; see :func:`resvg`."""
    height, width = size
    surface = skia.Surface(width * scale, height * scale)
    canvas = surface.getCanvas()
    canvas.clear(skia.ColorWHITE)
    canvas.scale(scale, scale)
    data = document.encode()  # the stream borrows it: it must outlive the parsing
    skia.SVGDOM.MakeFromStream(skia.MemoryStream(data)).render(canvas)
    return _averaged(surface.makeImageSnapshot().toarray()[..., :3].mean(-1) / 255, scale)


def psnr(a: Floats, b: Floats) -> float:
    """Peak signal-to-noise ratio of images in [0, 1]. dB"""
    return float(-10 * np.log10(max(float(np.mean((a - b) ** 2)), 1e-12)))


def _averaged(image: Floats, scale: int) -> Floats:
    height, width = image.shape[0] // scale, image.shape[1] // scale
    return np.asarray(image.reshape(height, scale, width, scale).mean((1, 3)))
