"""Strokes that an artist drew: an SVG of one frame, as strokes in the page's own pixels."""

from __future__ import annotations

import re
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from svgelements import SVG, Close, CubicBezier, Matrix, Move, Shape
from svgelements import Path as SvgPath

from videovec.errors import InputError
from videovec.strokes import Strokes

__all__ = ["DrawnStrokes", "read_drawn", "read_reference"]

Floats = NDArray[np.float64]

_INKSCAPE = "{http://www.inkscape.org/namespaces/inkscape}"
_THIRDS = (np.arange(4) / 3)[:, None]


@dataclass(frozen=True, slots=True, eq=False)
class DrawnStrokes:
    """The stroked paths of an SVG.

    Args:
        strokes: Strokes of drawing 0, with identities of their own where the file has none, or has one twice.
        ids: What the file says: the identity of each stroke, 0 where it says none or another has it. int [S]
        document: Height and width of the document. px
    """

    strokes: Strokes
    ids: NDArray[np.intp]
    document: tuple[float, float]


def read_reference(path: str | Path, size: tuple[int, int]) -> Strokes:
    """Read the stroked paths of an SVG, in their order and direction.

    Transforms, viewBox, groups and ``use`` are flattened and the document is fitted into the page as a viewer would.
    Every subpath is a stroke. Identities are those of our own files (``data-stroke-id``) where there are any.

    Args:
        path: The SVG.
        size: Height and width of the page. px

    Returns:
        Strokes of drawing 0, opaque, with their own colour and width.

    Raises:
        InputError: It is not an SVG, or nothing in it is stroked.
    """
    return read_drawn(path, size).strokes


def read_drawn(path: str | Path, size: tuple[int, int]) -> DrawnStrokes:
    """Read the stroked paths of an SVG, and which identities it gives them; see `read_reference`."""
    path = Path(path)
    try:
        document = SVG.parse(str(path), reify=True)
        text = path.read_text(encoding="utf-8", errors="replace")
    except OSError as error:
        raise InputError(f"{path}: must be an SVG that can be read, got {error.strerror or error}") from error
    except Exception as error:  # the parser lets whatever its XML and number readers raise pass
        raise InputError(f"{path}: must be an SVG, got a file that is none ({error})") from error
    widths = dict(_power_strokes(text))
    to_page = _page_matrix(document, size)
    found = [stroke for shape in document.select(_is_drawn) for stroke in _strokes_of(shape, to_page, widths)]
    if not found:
        raise InputError(f"{path}: must hold stroked paths, got none")
    curves, half_widths, colors, closed, ids = zip(*found, strict=True)
    strokes = Strokes.from_curves(list(curves), list(half_widths), is_closed=closed, color=np.array(colors))
    named = [0 if identity in ids[:place] else identity for place, identity in enumerate(ids)]
    document_size = (float(document.height), float(document.width))
    return DrawnStrokes(_with_ids(strokes, list(ids)), np.array(named, dtype=np.intp), document_size)


def _is_drawn(element: object) -> bool:
    if not isinstance(element, Shape):
        return False
    values = element.values
    hidden = values.get("display") == "none" or values.get("visibility") == "hidden"
    return not hidden and (_has_paint(element.stroke) or f"{_INKSCAPE}original-d" in values)


def _has_paint(paint: object) -> bool:
    return paint is not None and getattr(paint, "value", None) is not None


def _page_matrix(document: SVG, size: tuple[int, int]) -> Matrix:
    """From the document's px to the page's: the largest that fits, in the middle."""
    width, height = float(document.width), float(document.height)
    scale = min(size[1] / width, size[0] / height)
    return Matrix(scale, 0, 0, scale, (size[1] - scale * width) / 2, (size[0] - scale * height) / 2)


def _strokes_of(
    shape: Shape, to_page: Matrix, widths: dict[str, Floats]
) -> list[tuple[Floats, Floats, Floats, bool, int]]:
    """Control points, half-widths, colour, whether closed, and identity (0 for none) of each subpath."""
    values = shape.values
    centre_line = values.get(f"{_INKSCAPE}original-d")
    if centre_line:
        drawn, color = SvgPath(centre_line) * shape.transform, shape.fill
    else:
        drawn, color = SvgPath(shape), shape.stroke
    drawn = (drawn * to_page).reify()
    drawn.approximate_arcs_with_cubics()
    scale = float(np.sqrt(abs(to_page.a * to_page.d - to_page.b * to_page.c)))
    half_width = 0.5 * scale * float(shape.stroke_width or 1.0)
    identity = str(values.get("data-stroke-id", ""))
    profile = widths.get(str(values.get(f"{_INKSCAPE}path-effect", "")).removeprefix("#"))
    found = []
    for subpath in drawn.as_subpaths():
        points, is_closed = _control_points(subpath)
        if not len(points):
            continue
        joints = np.arange((len(points) - 1) // 3 + 1)
        width = np.full(len(joints), half_width)
        if profile is not None:
            width = scale * np.interp(joints, profile[:, 0], profile[:, 1])
        ink = np.array([color.red, color.green, color.blue]) / 255 if _has_paint(color) else np.zeros(3)
        found.append((points, width, ink, is_closed, int(identity) if identity.isdigit() else 0))
    return found


def _control_points(subpath: SvgPath) -> tuple[Floats, bool]:
    """One subpath as cubics [3n+1, 2], and whether it closes; empty where nothing is drawn."""
    points: list[Floats] = []
    is_closed = False
    for piece in subpath:
        if isinstance(piece, Move):
            points = [np.array([[piece.end.x, piece.end.y]])]
            continue
        is_closed |= isinstance(piece, Close)
        if piece.end is None:
            continue
        begin, end = points[-1][-1], np.array([piece.end.x, piece.end.y])
        if isinstance(piece, Close) and np.allclose(begin, end):
            continue
        if isinstance(piece, CubicBezier):
            inner = np.array([[piece.control1.x, piece.control1.y], [piece.control2.x, piece.control2.y]])
        elif hasattr(piece, "control"):  # a parabola, raised to a cubic
            middle = np.array([piece.control.x, piece.control.y])
            inner = np.stack([begin + 2 * (middle - begin) / 3, end + 2 * (middle - end) / 3])
        else:
            inner = (begin + _THIRDS * (end - begin))[1:3]
        points.append(np.concatenate([inner, end[None]]))
    curve = np.concatenate(points) if len(points) > 1 else np.zeros((0, 2))
    if is_closed and len(curve):
        curve[-1] = curve[0]
    return curve, is_closed and len(curve) > 0


def _power_strokes(text: str) -> list[tuple[str, Floats]]:
    """The width profile of each PowerStroke: its id, and (joint, half-width) pairs. [n, 2]"""
    found = []
    for effect in re.findall(r"<inkscape:path-effect[^>]*>", text):
        name = re.search(r'\bid="([^"]*)"', effect)
        offsets = re.search(r'offset_points="([^"]*)"', effect)
        if name and offsets:
            pairs = [pair.split(",") for pair in offsets[1].split("|")]
            found.append((name[1], np.array([[float(a), float(b)] for a, b in pairs])))
    return found


def _with_ids(strokes: Strokes, ids: list[int]) -> Strokes:
    """The strokes with the identities they came with; those without one get the next that is free."""
    taken: set[int] = set()
    following = max([0, *ids]) + 1
    result = []
    for identity in ids:
        if identity <= 0 or identity in taken:
            identity, following = following, following + 1
        taken.add(identity)
        result.append(identity)
    return replace(strokes, ids=np.array(result, dtype=np.intp))
