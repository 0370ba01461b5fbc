"""Textured strokes where a format knows no brush: every stroke as a picture of itself, in its place.

The pictures are the source's pixels: they blur when enlarged, and a stroke has one for each drawing, so that files grow
with strokes times drawings. What a stroke is stays: its name, and in SVG its centre line.
"""

from __future__ import annotations

import base64
import io
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
from PIL import Image

from videovec.brush import stroke_marks
from videovec.stroke_shape import shape_of_row
from videovec.tracks import StrokeTracks
from videovec.write.heads import lottie_document, svg_page, svg_text
from videovec.write.svg import path_data
from videovec.write.time_base import time_base

__all__ = ["lottie_of_pictures", "picture_frames"]

Json = Any  # what json.dumps takes


@dataclass(frozen=True, slots=True)
class StrokePicture:
    """What one stroke leaves on one drawing.

    Args:
        id: The stroke's identity.
        centre: Its centre line as SVG path data.
        x: Left edge. px
        y: Upper edge. px
        width: Of the picture. px
        height: Of the picture. px
        uri: The picture, a PNG with alpha, as a data URI.
    """

    id: int
    centre: str
    x: int
    y: int
    width: int
    height: int
    uri: str


def stroke_pictures(tracks: StrokeTracks, drawing: int) -> list[StrokePicture]:
    """Pictures of the textured strokes that are seen on a drawing, from the lowest layer to the highest."""
    brushwork = tracks.brushwork
    if brushwork is None:
        return []
    alone = tracks.strokes.at_drawing(drawing, as_drawing=0)
    marks = stroke_marks(brushwork.at_drawing(tracks.strokes.layout, drawing), alone, tracks.size)
    found = []
    for row in alone.rows_at(0).tolist():
        pixels, alpha = marks[row]
        level = np.rint(255 * alpha).astype(np.uint8)
        pixels, level = pixels[level > 0], level[level > 0]
        if not len(pixels):
            continue
        y, x = np.divmod(pixels, tracks.size[1])
        left, top = int(x.min()), int(y.min())
        image = np.zeros((int(y.max()) - top + 1, int(x.max()) - left + 1, 4), np.uint8)
        image[..., :3] = np.rint(255 * alone.color[row])
        image[y - top, x - left, 3] = level
        shape = shape_of_row(alone, row).visible_part()
        centre = path_data(shape.points, shape.is_closed)
        found.append(StrokePicture(shape.id, centre, left, top, image.shape[1], image.shape[0], _uri(image)))
    return found


def _uri(image: np.typing.NDArray[np.uint8]) -> str:
    buffer = io.BytesIO()
    Image.fromarray(image).save(buffer, "png", optimize=True)
    return "data:image/png;base64," + base64.b64encode(buffer.getvalue()).decode()


def picture_frames(tracks: StrokeTracks) -> Iterator[str]:
    """Frames as SVG documents: a group for each stroke, which holds its picture and its centre line, unseen.

    Yields:
        A document for each frame; a held drawing is the same document again.
    """
    documents: dict[int, str] = {}
    for drawing in tracks.timeline.drawing_of_frame.tolist():
        if drawing not in documents:
            documents = {drawing: _document(tracks, drawing)}
        yield documents[drawing]


def _document(tracks: StrokeTracks, drawing: int) -> str:
    document = svg_page(tracks)
    layer = document.g(id="lines", debug=False)
    for picture in stroke_pictures(tracks, drawing):
        stroke = document.g(id=f"stroke-{picture.id:04d}", debug=False)
        stroke.attribs["data-stroke-id"] = str(picture.id)
        place, size = (picture.x, picture.y), (picture.width, picture.height)
        stroke.add(document.image(picture.uri, place, size, debug=False))
        stroke.add(document.path(picture.centre, fill="none", stroke="none", debug=False))
        layer.add(stroke)
    document.add(layer)
    return svg_text(document)


def lottie_of_pictures(tracks: StrokeTracks) -> str:
    """A clip as a Lottie document of embedded images: a layer for each stroke on each drawing.

    Returns:
        JSON, in one line.
    """
    base = time_base(tracks.timeline)
    assets: list[Json] = []
    layers: list[Json] = []
    for drawing in range(tracks.timeline.drawing_count):
        begin, stop = (int(tick) for tick in base.drawing_ticks[drawing : drawing + 2])
        for picture in stroke_pictures(tracks, drawing):
            name = f"stroke_{picture.id:04d}"
            asset = {"id": f"{name}_{drawing}", "w": picture.width, "h": picture.height, "u": "", "e": 1}
            assets.append(asset | {"p": picture.uri})
            layers.append(_layer(name, begin, stop, (picture.x, picture.y)) | {"ty": 2, "refId": asset["id"]})
    layers.reverse()
    return lottie_document(tracks, base, float(base.rate), layers, assets)


def _layer(name: str, begin: int, end: int, place: tuple[int, int]) -> Json:
    moved = {
        "o": {"a": 0, "k": 100},
        "r": {"a": 0, "k": 0},
        "p": {"a": 0, "k": [*place, 0]},
        "a": {"a": 0, "k": [0, 0, 0]},
        "s": {"a": 0, "k": [100, 100, 100]},
    }
    return {"nm": name, "ip": begin, "op": end, "st": 0, "sr": 1, "bm": 0, "ks": moved}
