"""Drawings painted with a learned brush: an artist's SVG, or frames of a run."""

from __future__ import annotations

import io
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from PIL import Image
from svgelements import SVG

from videovec.brush import apply_brush, load_brush
from videovec.errors import InputError
from videovec.finished_run import FinishedRun
from videovec.reference import read_reference
from videovec.strokes import Strokes

__all__ = ["paint"]

WHITE = (1.0, 1.0, 1.0)


def paint(brush: Path, drawing: Path, frame: int = 1, seed: int = 0) -> bytes:
    """Paint a drawing with a brush.

    Args:
        brush: The brush's JSON, or the folder that holds it.
        drawing: An SVG of stroked paths, or the folder of a finished run.
        frame: Which frame of the run, from 1.
        seed: Of where along the brush each stroke begins.

    Returns:
        The picture, a PNG.

    Raises:
        InputError: One of them cannot be used.
    """
    strokes, size, page = _strokes_of_run(drawing, frame) if drawing.is_dir() else _strokes_of_svg(drawing)
    picture = apply_brush(load_brush(brush), strokes, size, page=page, seed=seed)
    return _png(picture)


def _strokes_of_svg(path: Path) -> tuple[Strokes, tuple[int, int], tuple[float, float, float]]:
    size = _page_size(path)
    return read_reference(path, size), size, WHITE


def _page_size(path: Path) -> tuple[int, int]:
    """Height and width that an SVG asks for. px"""
    try:
        document = SVG.parse(str(path))
    except Exception as error:  # the parser lets whatever its XML and number readers raise pass
        raise InputError(f"{path}: must be an SVG or the folder of a run, got neither ({error})") from error
    return max(1, round(float(document.height))), max(1, round(float(document.width)))


def _strokes_of_run(folder: Path, frame: int) -> tuple[Strokes, tuple[int, int], tuple[float, float, float]]:
    tracks = FinishedRun.open(folder).tracks()
    numbers = tracks.timeline.frame_numbers.tolist()
    if frame not in numbers:
        raise InputError(f"{folder}: frame must be one of {numbers[0]}..{numbers[-1]}, got {frame}")
    drawing = int(tracks.timeline.drawing_of_frame[numbers.index(frame)])
    red, green, blue = tracks.page.tolist()
    return tracks.strokes.at_drawing(drawing, as_drawing=0), tracks.size, (red, green, blue)


def _png(picture: NDArray[np.float64]) -> bytes:
    buffer = io.BytesIO()
    Image.fromarray((picture.clip(0, 1) * 255).round().astype(np.uint8)).save(buffer, "png")
    return buffer.getvalue()
