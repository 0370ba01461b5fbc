"""An animated Lottie document: a layer for every stroke, with as few keyframes as a tolerance allows.

A stroke of constant width is a stroked path, one of varying width a filled outline, since no player draws tapered
strokes. Each path has one number of vertices for its whole life and is closed or open for good: players differ, and
fail silently, where these change.
"""

from __future__ import annotations

import io
import json
import zipfile
from collections.abc import Callable, Iterable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from videovec import __version__
from videovec.settings import ExportSettings
from videovec.tracks import StrokeTracks
from videovec.write.heads import lottie_document
from videovec.write.keyframes import EVEN, Animated
from videovec.write.motion import StrokeMotion, stroke_motions
from videovec.write.time_base import time_base

__all__ = ["dotlottie_bytes", "lottie_text"]

Floats = NDArray[np.float64]
Json = Any  # what json.dumps takes
Value = Callable[[Floats], Json]

_ROUND = 2  # both the cap and the join of that shape
_NONZERO = 1
_STILL: Json = {"ty": "tr"}  # what groups end with; all that it leaves out keeps them where they are


def lottie_text(tracks: StrokeTracks, settings: ExportSettings, motions: Iterable[StrokeMotion] | None = None) -> str:
    """A clip as a Lottie document.

    Args:
        tracks: The strokes of a clip.
        settings: Tolerance and decimals of the keyframes.
        motions: The strokes as moving paths, where they are known already.

    Returns:
        JSON, in one line.
    """
    base = time_base(tracks.timeline)
    paths = stroke_motions(tracks, base, settings) if motions is None else motions
    layers = [_layer(motion, settings.lottie_decimals) for motion in paths][::-1]
    return lottie_document(tracks, base, _compact(float(base.rate), 9), layers, [])


def dotlottie_bytes(lottie: str) -> bytes:
    """A Lottie document as a dotLottie archive, the same bytes for the same document.

    Source:
        dotLottie 1.0: ``manifest.json`` beside ``animations/ID.json``.
    """
    manifest = {"version": "1.0", "generator": f"videovec {__version__}", "animations": [{"id": "clip"}]}
    buffer = io.BytesIO()
    with zipfile.ZipFile(buffer, "w", zipfile.ZIP_DEFLATED, compresslevel=9) as archive:
        for name, text in (("manifest.json", json.dumps(manifest)), ("animations/clip.json", lottie)):
            entry = zipfile.ZipInfo(name)  # dated 1980, whenever it is made
            entry.compress_type = zipfile.ZIP_DEFLATED
            archive.writestr(entry, text)
    return buffer.getvalue()


def _layer(motion: StrokeMotion, decimals: int) -> dict[str, Json]:
    name = f"stroke_{motion.id:04d}"
    colour = {"a": 0, "k": [_compact(x, 4) for x in motion.color.tolist()] + [1]}
    opacity = _property(motion.opacity, lambda x: _compact(100 * float(x), 1))
    items: list[Json] = [
        {"ty": "sh", "ks": _property(loop, lambda points: _bezier(points, motion.is_closed, decimals))}
        for loop in motion.loops
    ]
    if motion.visible is not None:
        items.append(_trim(motion.visible))
    if motion.half_width is None:
        items.append({"ty": "fl", "c": colour, "o": opacity, "r": _NONZERO})
    else:
        width = _property(motion.half_width, lambda x: _compact(2 * float(x), decimals))
        items.append({"ty": "st", "c": colour, "o": opacity, "w": width, "lc": _ROUND, "lj": _ROUND})
    group = {"ty": "gr", "it": [*items, _STILL]}
    return _layer_head(name, motion.begin, motion.end) | {"ty": 4, "shapes": [group]}


def _layer_head(name: str, begin: int, end: int) -> dict[str, Json]:
    return {"nm": name, "ip": begin, "op": end, "st": 0, "ks": {}}


def _trim(visible: Animated) -> Json:
    start, end = (
        _property(Animated(visible.times, visible.values[:, k], visible.is_hold), lambda u: _compact(100 * float(u), 2))
        for k in (0, 1)
    )
    return {"ty": "tm", "s": start, "e": end, "o": {"a": 0, "k": 0}, "m": 1}


def _property(animated: Animated, value: Value) -> Json:
    """A static or animated property, of what ``value`` makes of each keyframe's value."""
    values = [value(each) for each in animated.values]
    if animated.is_static:
        return {"a": 0, "k": values[0]}
    keyframes: list[Json] = []
    last = len(values) - 1
    for k, (time, at) in enumerate(zip(animated.times.tolist(), values, strict=True)):
        keyframe: dict[str, Json] = {"t": _compact(time, 3), "s": [at]}
        if k < last and animated.is_hold[k]:
            keyframe["h"] = 1
        elif k < last:
            keyframe |= _easing(None if animated.handles is None else animated.handles[k])
        keyframes.append(keyframe)
    return {"a": 1, "k": keyframes}


def _easing(handles: Floats | None) -> Json:
    """The easing between two keyframes; an even one is the diagonal."""
    if handles is None or np.abs(handles - EVEN).max() < 0.001:
        return {"o": {"x": 0, "y": 0}, "i": {"x": 1, "y": 1}}
    x1, y1, x2, y2 = (_compact(float(handle), 3) for handle in handles)
    return {"o": {"x": x1, "y": y1}, "i": {"x": x2, "y": y2}}


def _bezier(points: Floats, is_closed: bool, decimals: int) -> Json:
    """A spline as vertices with their handles relative to them; a closed one does not repeat its first vertex."""
    vertices = np.round(points[::3], decimals)
    out = np.zeros_like(vertices)
    into = np.zeros_like(vertices)
    out[:-1] = points[1::3] - vertices[:-1]
    into[1:] = points[2::3] - vertices[1:]
    if is_closed:
        into[0] = into[-1]
        vertices, out, into = vertices[:-1], out[:-1], into[:-1]
    return {"c": is_closed, **{key: _pairs(at, decimals) for key, at in (("v", vertices), ("i", into), ("o", out))}}


def _pairs(array: Floats, decimals: int) -> list[list[float]]:
    return [[x if x % 1 else int(x), y if y % 1 else int(y)] for x, y in np.round(array, decimals).tolist()]


def _compact(value: float, decimals: int) -> float:
    """A rounded number, whole where it can be: it takes fewer bytes."""
    rounded = round(value, decimals)
    return rounded if rounded % 1 else int(rounded)
