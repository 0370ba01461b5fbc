"""Tracers that stills are compared with: ours and, where they are installed, those that people use today.

A tracer turns the ink of one drawing into strokes. The peers that trace outlines give closed outlines for strokes, and
their picture is the outlines filled, as their users see it.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from importlib import import_module
from importlib.util import find_spec
from io import BytesIO
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from videovec.bench.fitted import fit_with_diffvg, fit_with_splats
from videovec.brush import bridge, brush_coverage, drop_scraps, fit_brushes, mend, solidify
from videovec.curves import evaluate, segments_of
from videovec.fit import fit
from videovec.initialise import initialise
from videovec.initialise.cubics import fit_spline
from videovec.initialise.graph import skeleton_graph
from videovec.initialise.lines import ridge_peak
from videovec.ink import Ink
from videovec.settings import Config
from videovec.strokes import Strokes

__all__ = ["TRACERS", "Tracer", "Tracing", "installed"]

Floats = NDArray[np.float64]

AUTOTRACE_SCALE = 2
"""How many times drawings are enlarged for AutoTrace, which rounds to whole pixels; it is better for it."""
_FILL_SCALE = 8  # each pixel of a filled picture is the mean of so many squared


@dataclass(frozen=True, slots=True, eq=False)
class Tracing:
    """What a tracer made of a drawing.

    Args:
        strokes: Strokes, or outlines.
        coverage: Of the outlines filled, or of what a brush draws; none for even strokes. [H, W] in [0, 1]
    """

    strokes: Strokes
    coverage: Floats | None = None


@dataclass(frozen=True, slots=True)
class Tracer:
    """A way from ink to strokes.

    Args:
        needs: The module that it needs besides videovec's own dependencies; none if empty.
        trace: Ink of one drawing and configuration to strokes.
    """

    needs: str
    trace: Callable[[Ink, Config], Tracing]


def installed(tracer: Tracer) -> bool:
    """Whether all that a tracer needs is there."""
    return not tracer.needs or find_spec(tracer.needs) is not None


def _strokes(curves: list[Floats], ink: Ink) -> Strokes:
    """Centre lines with one width, such that they hold as much ink as the drawing."""
    curves = [points for points in curves if len(points) >= 4]
    samples = [evaluate(segments_of(points)[:, None], np.linspace(0, 1, 9)[None]).reshape(-1, 2) for points in curves]
    length = sum(float(np.linalg.norm(np.diff(line, axis=0), axis=1).sum()) for line in samples)
    half_width = 0.5 * float(ink.coverage.sum()) / 255.0 / max(length, 1e-9)
    return Strokes.from_curves(curves, [np.full((len(p) + 2) // 3, half_width) for p in curves], color=ink.palette[0])


def _filled(curves: list[Floats], size: tuple[int, int]) -> Floats:
    """Closed outlines filled by the even-odd rule. [H, W] in [0, 1]"""
    outlines = [evaluate(segments_of(p)[:, None], np.linspace(0, 1, 12)[None]).reshape(-1, 2) for p in curves]
    large = np.zeros((size[0] * _FILL_SCALE, size[1] * _FILL_SCALE), np.uint8)
    polygons = [np.rint((line * _FILL_SCALE - 0.5) * 16).astype(np.int32) for line in outlines]
    if polygons:
        cv2.fillPoly(large, polygons, 255, shift=4)
    return np.asarray(cv2.resize(large, size[::-1], interpolation=cv2.INTER_AREA) / 255.0, dtype=np.float64)


def _mask(ink: Ink, scale: int) -> NDArray[np.bool_]:
    """The lines, enlarged: what covers more than half as much as the middle of a typical line. bool [sH, sW]"""
    coverage = ink.coverage[0].astype(np.float32) / np.float32(255.0)
    level = 0.5 * ridge_peak(coverage, max(0.06, 5.0 * ink.noise))
    size = (coverage.shape[1] * scale, coverage.shape[0] * scale)
    return np.asarray(cv2.resize(coverage, size, interpolation=cv2.INTER_CUBIC) > max(level, 1e-3), dtype=np.bool_)


def _straight(start: Floats, stop: Floats) -> Floats:
    """The three further control points of a straight segment. [3, 2]"""
    return np.asarray(start + (stop - start) * np.array([[1.0], [2.0], [3.0]]) / 3.0)


def _ours(ink: Ink, config: Config) -> Tracing:
    return Tracing(fit(ink, initialise(ink, 0, config.initialise), config.fit, config.render).strokes)


def _with_brush(ink: Ink, config: Config) -> Tracing:
    solid = solidify(ink)
    traced = mend(initialise(solid, 0, config.initialise), solid, config.fit.edits)
    strokes = fit(solid, traced, config.fit, config.render).strokes
    strokes = bridge(drop_scraps(strokes), ink, config.fit.edits)
    found = fit_brushes(ink, strokes, config.brush, seed=config.seed)
    drawn = brush_coverage(found.brushwork, found.result.strokes, ink.coverage.shape)
    return Tracing(found.result.strokes, drawn[0] / 255.0)


def _initialised(ink: Ink, config: Config) -> Tracing:
    return Tracing(initialise(ink, 0, config.initialise))


def _autotrace(ink: Ink, config: Config) -> Tracing:
    autotrace: Any = import_module("autotrace")
    large = np.where(_mask(ink, AUTOTRACE_SCALE), np.uint8(0), np.uint8(255))
    vector = autotrace.Bitmap(np.repeat(large[..., None], 3, axis=2)).trace(centerline=True)
    curves = []
    for path in vector.paths:
        points = [[(p.x, p.y) for p in spline.points] for spline in path.splines]
        line = np.array([points[0][0], *(p for spline in points for p in spline[1:])], dtype=float)
        curves.append(np.stack([line[:, 0] - 0.5, len(large) - 0.5 - line[:, 1]], axis=1) / AUTOTRACE_SCALE)
    return Tracing(_strokes(curves, ink))


def _autotrace_fitted(ink: Ink, config: Config) -> Tracing:
    return Tracing(fit(ink, _autotrace(ink, config).strokes, config.fit, config.render).strokes)


def _splats(ink: Ink, config: Config) -> Tracing:
    return Tracing(fit_with_splats(ink, config))


def _diffvg(ink: Ink, config: Config) -> Tracing:
    return Tracing(fit_with_diffvg(ink, config))


def _skeleton(ink: Ink, config: Config) -> Tracing:
    morphology: Any = import_module("skimage.morphology")
    mask = _mask(ink, 1)
    radius = cv2.distanceTransform(mask.astype(np.uint8), cv2.DIST_L2, 5).astype(np.float32)
    graph = skeleton_graph(morphology.skeletonize(mask).astype(np.uint8), radius, 1)
    none = np.zeros(0, np.intp)
    tolerance = config.initialise.tolerance
    lines = [branch.line for branch in graph.branches.values()] + [np.concatenate([x, x[:1]]) for x in graph.loops]
    return Tracing(_strokes([fit_spline(line, none, tolerance, False) for line in lines], ink))


def _vtracer(ink: Ink, config: Config) -> Tracing:
    from svgelements import SVG, Move, Path

    vtracer: Any = import_module("vtracer")
    _, png = cv2.imencode(".png", np.where(_mask(ink, 1), np.uint8(0), np.uint8(255)))
    svg = vtracer.convert_raw_image_to_svg(png.tobytes(), img_format="png", colormode="binary")
    curves = []
    for path in SVG.parse(BytesIO(svg.encode())).elements(lambda element: isinstance(element, Path)):
        for outline in path.as_subpaths():
            pieces = [piece for piece in outline if not isinstance(piece, Move) and piece.length() > 0]
            if pieces:
                curves.append(_control_points(pieces))
    return Tracing(_strokes(curves, ink), _filled(curves, ink.size))


def _control_points(pieces: list[Any]) -> Floats:
    """Control points of svgelements' pieces, lines made cubics. [3n+1, 2]"""
    points = [np.array([[pieces[0].start.x, pieces[0].start.y]])]
    for piece in pieces:
        stop = np.array([piece.end.x, piece.end.y])
        if hasattr(piece, "control1"):
            cubic = np.array([(piece.control1.x, piece.control1.y), (piece.control2.x, piece.control2.y), stop])
        else:
            cubic = _straight(points[-1][-1], stop)
        points.append(cubic)
    return np.concatenate(points)


def _potrace(ink: Ink, config: Config) -> Tracing:
    potrace: Any = import_module("potrace")
    curves = []
    for outline in potrace.Bitmap(~_mask(ink, 1)).trace():
        points = [np.array([[outline.start_point.x, outline.start_point.y]])]
        for piece in outline.segments:
            stop = np.array([piece.end_point.x, piece.end_point.y])
            if piece.is_corner:
                corner = np.array([piece.c.x, piece.c.y])
                points += [_straight(points[-1][-1], corner), _straight(corner, stop)]
            else:
                points.append(np.array([(piece.c1.x, piece.c1.y), (piece.c2.x, piece.c2.y), stop]))
        curves.append(np.concatenate(points))
    return Tracing(_strokes(curves, ink), _filled(curves, ink.size))


TRACERS = {
    "ours": Tracer("", _ours),
    "ours, with its brush": Tracer("", _with_brush),
    "ours, not fitted": Tracer("", _initialised),
    "autotrace": Tracer("autotrace", _autotrace),
    "autotrace + our fit": Tracer("autotrace", _autotrace_fitted),
    "ours, sampled Gaussians": Tracer("", _splats),
    "ours, DiffVG": Tracer("pydiffvg", _diffvg),
    "skeleton": Tracer("skimage", _skeleton),
    "vtracer (outlines)": Tracer("vtracer", _vtracer),
    "potrace (outlines)": Tracer("potrace", _potrace),
}
"""Every tracer by the name that tables show. Ours with the brush that it learned, for textured lines; AutoTrace centre
lines; our first strokes fitted with the supplement's sampled Gaussians, or with DiffVG; scikit-image's skeleton, one
stroke a branch."""
