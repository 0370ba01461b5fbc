"""What every SVG and every Lottie document begins and ends with."""

from __future__ import annotations

import json
from typing import Any

import svgwrite

from videovec import __version__
from videovec.stroke_shape import hex_colour
from videovec.track_set import TrackSet
from videovec.write.time_base import TimeBase

__all__ = ["lottie_document", "svg_page", "svg_text"]

Json = dict[str, Any]


def svg_page(tracks: TrackSet) -> svgwrite.Drawing:
    """An SVG document of the clip's size, filled with its page's colour unless that is white."""
    height, width = tracks.size
    document = svgwrite.Drawing(size=(width, height), viewBox=f"0 0 {width} {height}", debug=False)
    page = hex_colour(tracks.page)
    if page != "#ffffff":
        document.add(document.rect((0, 0), (width, height), id="page", fill=page, debug=False))
    return document


def svg_text(document: svgwrite.Drawing) -> str:
    """The document as text."""
    return f'<?xml version="1.0" encoding="UTF-8"?>\n{document.tostring()}\n'


def lottie_document(tracks: TrackSet, base: TimeBase, rate: float, layers: list[Json], assets: list[Json]) -> str:
    """A Lottie document of some layers.

    Args:
        tracks: For its name, its size and the colour of its page.
        base: For its duration.
        rate: Ticks per second, as it is written.
        layers: From the uppermost to the lowest; they are numbered, and the page is laid under them unless it is white.
        assets: What the layers refer to.

    Returns:
        JSON, in one line.
    """
    height, width = tracks.size
    page, end = hex_colour(tracks.page), int(base.frame_ticks[-1])
    if page != "#ffffff":
        blank = {"nm": "page", "ip": 0, "op": end, "st": 0, "sr": 1, "bm": 0, "ks": {"o": {"a": 0, "k": 100}}}
        layers = [*layers, blank | {"ty": 1, "sw": width, "sh": height, "sc": page}]
    document = {
        "v": "5.7.0",
        "nm": tracks.name,
        "meta": {"g": f"videovec {__version__}"},
        "fr": rate,
        "ip": 0,
        "op": end,
        "w": width,
        "h": height,
        "ddd": 0,
        "assets": assets,
        "layers": [layer | {"ind": index} for index, layer in enumerate(layers, start=1)],
    }
    return json.dumps(document, separators=(",", ":"))
