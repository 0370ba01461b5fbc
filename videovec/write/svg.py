"""One SVG document per frame: a path for every visible stroke, under the same name in every frame.

SVG 1.1 presentation attributes, absolute coordinates, no transforms, clips or style sheets, so that every drawing
program opens the frames aligned. SVG knows no line of variable width; such a stroke is its outline, or an Inkscape
PowerStroke, which is an outline that remembers its centre line and widths.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass

import numpy as np
import svgwrite
from numpy.typing import NDArray
from svgwrite.base import BaseElement

from videovec.errors import ConfigError
from videovec.stroke_shape import StrokeShape, hex_colour, shape_of_row
from videovec.strokes import Strokes
from videovec.tracks import StrokeTracks
from videovec.write.heads import svg_page, svg_text
from videovec.write.outline import outline, plan_outline
from videovec.write.style import is_constant_width

__all__ = ["SVG_STYLES", "number", "path_data", "svg_frame", "svg_frames"]

SVG_STYLES = ("auto", "stroke", "outline", "powerstroke")

Floats = NDArray[np.float64]

_DOT = 0.05  # px of extent up to which Inkscape makes nothing of a centre line
_INKSCAPE = "http://www.inkscape.org/namespaces/inkscape"


def svg_frame(tracks: StrokeTracks, frame: int, style: str = "auto") -> str:
    """A frame as an SVG document; see :func:`svg_frames`."""
    return next(svg_frames(tracks, style, frames=[frame]))


def svg_frames(
    tracks: StrokeTracks, style: str = "auto", line_tolerance: float = 0.25, frames: Iterable[int] | None = None
) -> Iterator[str]:
    """Frames as SVG documents.

    Args:
        tracks: The strokes of a clip.
        style: ``stroke`` draws centre lines of each stroke's mean width, ``outline`` filled outlines, ``powerstroke``
            outlines that Inkscape opens as centre lines with widths, ``auto`` centre lines where these do
            well, powerstrokes elsewhere.
        line_tolerance: How far the edge of a line of mean width may lie from 95 % of a stroke's in ``auto``. px
        frames: Positions of the frames, from 0; all unless given.

    Yields:
        A document for each frame; a held drawing is the same document again.

    Raises:
        ConfigError: There is no such style.
    """
    if style not in SVG_STYLES:
        raise ConfigError(f"svg style must be one of {', '.join(SVG_STYLES)}, got {style!r}")
    strokes = tracks.strokes
    is_line = (
        is_constant_width(strokes, line_tolerance) if style == "auto" else np.full(len(strokes), style == "stroke")
    )
    wanted = tracks.timeline.drawing_of_frame[range(tracks.timeline.frame_count) if frames is None else list(frames)]
    sketch = _Sketch(tracks, is_line, style in ("auto", "powerstroke"), _outlines(strokes, ~is_line, wanted))
    documents: dict[int, str] = {}
    for drawing in wanted.tolist():
        if drawing not in documents:
            documents = {drawing: _document(sketch, drawing)}
        yield documents[drawing]


@dataclass(frozen=True, slots=True, eq=False)
class _Sketch:
    """What the documents of a clip share.

    Args:
        tracks: The strokes.
        is_line: Whether each stroke is written as a centre line. bool [S]
        is_live: Whether outlines remember their centre lines for Inkscape.
        outlines: The loops of each row that is written as an outline.
    """

    tracks: StrokeTracks
    is_line: NDArray[np.bool_]
    is_live: bool
    outlines: dict[int, tuple[Floats, ...]]


def _outlines(strokes: Strokes, which: NDArray[np.bool_], drawings: NDArray[np.intp]) -> dict[int, tuple[Floats, ...]]:
    """Loops of the rows that are wanted, with one plan for each stroke's whole life."""
    loops: dict[int, tuple[Floats, ...]] = {}
    for stroke in np.flatnonzero(which):
        rows = np.arange(*strokes.layout.stroke_rows[stroke : stroke + 2])
        shapes = [shape_of_row(strokes, int(row)) for row in rows]
        is_wanted = np.isin(strokes.layout.row_drawing[rows], drawings) & [shape.is_visible for shape in shapes]
        if is_wanted.any():
            drawn = outline([shapes[k] for k in np.flatnonzero(is_wanted)], plan_outline(shapes))
            loops.update(zip(rows[is_wanted].tolist(), zip(*drawn, strict=True), strict=True))
    return loops


def _document(sketch: _Sketch, drawing: int) -> str:
    tracks = sketch.tracks
    document = svg_page(tracks)
    document.attribs["xmlns:inkscape"] = _INKSCAPE
    layer = document.g(id="lines", debug=False)
    layer.attribs.update({"inkscape:groupmode": "layer", "inkscape:label": "lines"})
    for row in tracks.strokes.rows_at(drawing):
        shape = shape_of_row(tracks.strokes, row)
        if shape.is_visible:
            layer.add(_path(sketch, int(row), shape, document))
    document.add(layer)
    return svg_text(document)


def _path(sketch: _Sketch, row: int, shape: StrokeShape, document: svgwrite.Drawing) -> BaseElement:
    """One stroke's element, and in the document's head what it refers to."""
    part = shape.visible_part()
    colour = hex_colour(part.color)
    centre = path_data(part.points, part.is_closed)
    if row not in sketch.outlines:
        path = document.path(centre, fill="none", stroke=colour, debug=False)
        line = {
            "stroke-width": number(2 * part.mean_half_width),
            "stroke-linecap": "round",
            "stroke-linejoin": "round",
        }
        path.attribs.update(line | _opacity("stroke-opacity", part))
    else:
        loops = (_without_points(loop) for loop in sketch.outlines[row])
        data = " ".join(path_data(loop, is_closed=True) for loop in loops if len(loop) > 1)
        path = document.path(data, fill=colour, stroke="none", debug=False)
        path.attribs.update({"fill-rule": "nonzero"} | _opacity("fill-opacity", part))
        if sketch.is_live and np.ptp(part.points, axis=0).max() > _DOT:
            effect = f"width-{part.id:04d}"
            document.defs.add(_power_stroke(effect, part.half_width))
            path.attribs.update({"inkscape:path-effect": f"#{effect}", "inkscape:original-d": centre})
    path.attribs.update({"id": f"stroke-{part.id:04d}", "data-stroke-id": str(part.id)})
    return path


def path_data(points: Floats, is_closed: bool = False) -> str:
    """A spline as SVG path data, absolute, to a thousandth of a pixel.

    Args:
        points: Control points. [3n+1, 2] px
        is_closed: Whether it ends where it begins.
    """
    words = [f"{number(x)},{number(y)}" for x, y in points.tolist()]
    curves = "".join(f" C {' '.join(words[k : k + 3])}" for k in range(1, len(words), 3))
    return f"M {words[0]}{curves}{' Z' if is_closed else ''}"


def _power_stroke(name: str, half_width: Floats) -> BaseElement:
    """Inkscape's live effect of variable width, linear between joints as ours is."""
    effect = BaseElement(debug=False)
    effect.elementname = "inkscape:path-effect"
    effect.attribs = {
        "effect": "powerstroke",
        "id": name,
        "is_visible": "true",
        "lpeversion": "1.3",
        "offset_points": " | ".join(f"{k},{number(width)}" for k, width in enumerate(half_width.tolist())),
        "not_jump": "true",
        "sort_points": "true",
        "interpolator_type": "Linear",
        "interpolator_beta": "0.2",
        "start_linecap_type": "round",
        "linejoin_type": "round",
        "end_linecap_type": "round",
        "miter_limit": "4",
        "scale_width": "1",
    }
    return effect


def _without_points(loop: Floats) -> Floats:
    """A loop without the cubics that have shrunk to a point."""
    cubics = loop[1:].reshape(-1, 3, 2)
    starts = np.concatenate([loop[:1], cubics[:-1, 2]])
    is_kept = np.abs(cubics - starts[:, None]).max((1, 2)) > 5e-4
    return np.concatenate([loop[:1], cubics[is_kept].reshape(-1, 2)])


def _opacity(name: str, shape: StrokeShape) -> dict[str, str]:
    return {name: number(shape.opacity)} if shape.opacity < 0.9995 else {}


def number(value: float, decimals: int = 3) -> str:
    """A number to so many decimals, without trailing zeros or a negative zero."""
    text = f"{value:.{decimals}f}".rstrip("0").rstrip(".")
    return "0" if text == "-0" else text
