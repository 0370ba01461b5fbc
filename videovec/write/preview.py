"""Pictures for people: strokes coloured by identity, beside their source."""

from __future__ import annotations

from collections.abc import Sequence

import cv2
import numpy as np
from numpy.typing import NDArray

from videovec.curves import evaluate, segments_of, sub_curve, width_at
from videovec.strokes import Strokes
from videovec.tracks import StrokeTracks
from videovec.write.colours import identity_colours

__all__ = ["contact_sheet", "draw_identities", "draw_strokes"]

Floats = NDArray[np.float64]
Image = NDArray[np.uint8]

_OVERSAMPLING = 2
_SHIFT = 4  # fractional bits of OpenCV's coordinates


def draw_identities(tracks: StrokeTracks, frame: int, scale: float = 1.0, *, labels: bool = False) -> Image:
    """A frame's visible strokes, each in the colour of its identity.

    Args:
        tracks: The strokes of a clip.
        frame: Position of the frame, from 0.
        scale: Pixels of the picture per pixel of the source.
        labels: Write each stroke's identity beside its middle.

    Returns:
        The picture on a white page. uint8 [scale * H, scale * W, 3]
    """
    drawing = int(tracks.timeline.drawing_of_frame[frame])
    return draw_strokes(tracks.strokes, drawing, tracks.size, scale, labels=labels)


def draw_strokes(
    strokes: Strokes, drawing: int, size: tuple[int, int], scale: float = 1.0, *, labels: bool = False
) -> Image:
    """A drawing's visible strokes, each in the colour of its identity; see :func:`draw_identities`."""
    height, width = (max(1, round(scale * side)) for side in size)
    zoom = scale * _OVERSAMPLING
    canvas = np.full((height * _OVERSAMPLING, width * _OVERSAMPLING, 3), 255, np.uint8)
    colours = np.rint(255 * identity_colours(strokes.ids)).astype(int).tolist()
    middles: list[tuple[int, tuple[float, float]]] = []
    for row in strokes.rows_at(drawing):
        stroke = int(strokes.layout.row_stroke[row])
        u0, u1 = (float(u) for u in strokes.visible[row])
        if u0 < u1 and np.isfinite(strokes.points_of(row)).all():
            xy, h = _sample(*sub_curve(strokes.points_of(row), strokes.half_width_of(row), u0, u1))
            _draw_line(canvas, xy * zoom, np.maximum(h, 0.7) * zoom, colours[stroke])
            middles.append((stroke, tuple((xy[len(xy) // 2] * scale).tolist())))
    image: Image = np.asarray(cv2.resize(canvas, (width, height), interpolation=cv2.INTER_AREA), np.uint8)
    if labels:
        for stroke, (x, y) in middles:
            _write(image, str(strokes.ids[stroke]), (round(x) + 3, round(y) - 3), colours[stroke])
    return image


def contact_sheet(images: Sequence[Image], columns: int, gap: int = 4) -> Image:
    """Images side by side, row after row, on light grey.

    Args:
        images: Pictures, grey or colour, of any sizes. uint8 [H, W] or [H, W, 3]
        columns: How many stand in a row.
        gap: Space between them. px

    Returns:
        One picture; every cell has the size of the largest image. uint8 [H', W', 3]
    """
    colour = [image if image.ndim == 3 else np.repeat(image[..., None], 3, axis=2) for image in images]
    height = max(image.shape[0] for image in colour) + gap
    width = max(image.shape[1] for image in colour) + gap
    rows = -(-len(colour) // columns)
    sheet = np.full((rows * height - gap, min(columns, len(colour)) * width - gap, 3), 200, np.uint8)
    for k, image in enumerate(colour):
        y, x = k // columns * height, k % columns * width
        sheet[y : y + image.shape[0], x : x + image.shape[1]] = image
    return sheet


def _sample(points: Floats, half_width: Floats) -> tuple[Floats, Floats]:
    """Positions [M, 2] and half-widths [M] about a pixel apart; the ends of every segment are among them."""
    polygon = np.linalg.norm(np.diff(points, axis=0), axis=1).reshape(-1, 3).sum(1)
    counts = np.maximum(np.ceil(polygon), 1).astype(int)
    segment = np.repeat(np.arange(len(counts)), counts)
    t = np.concatenate([np.arange(1, count + 1) / count for count in counts])
    segment, t = np.concatenate([[0], segment]), np.concatenate([[0.0], t])
    return evaluate(segments_of(points)[segment], t), width_at(half_width, segment, t)


def _draw_line(canvas: Image, xy: Floats, half_width: Floats, colour: list[int]) -> None:
    """One chord after the other, each with its own thickness; OpenCV's thick lines have round ends."""
    at = np.rint((xy - 0.5) * (1 << _SHIFT)).astype(np.int64)
    limit = 1 << 24
    at = np.clip(at, -limit, limit)
    if len(at) == 1:
        at, half_width = np.repeat(at, 2, axis=0), np.repeat(half_width, 2)
    thickness = np.maximum(np.rint(half_width[:-1] + half_width[1:]).astype(int), 1)
    for run in np.split(np.arange(len(thickness)), np.flatnonzero(np.diff(thickness)) + 1):
        line = at[run[0] : run[-1] + 2].reshape(-1, 1, 2).astype(np.int32)
        cv2.polylines(canvas, [line], False, colour, int(thickness[run[0]]), cv2.LINE_AA, _SHIFT)


def _write(image: Image, text: str, at: tuple[int, int], colour: list[int]) -> None:
    """Text with a white rim, so that it reads above lines."""
    for ink, thickness in (([255, 255, 255], 3), (colour, 1)):
        cv2.putText(image, text, at, cv2.FONT_HERSHEY_SIMPLEX, 0.38, ink, thickness, cv2.LINE_AA)
