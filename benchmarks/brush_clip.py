"""Whether a texture swims: a brush learned from a clip of strokes that move rigidly, each drawing started on its own.

    python benchmarks/brush_clip.py DIR/truth.json --brush strip_chalk --drawings 12

The strokes turn by 1 degree and move by (1.3, 0.7) px from drawing to drawing; every drawing is textured by
``make_textured.py`` with the same phases, and starts from its truth with its own N(0, 1 px). At 40 places along each
stroke the texture coordinate u of the fit is read at the point nearest to the true one; *jitter* is the standard
deviation over the drawings of its change from drawing to drawing, in texels (1/12 of a width).
"""

from __future__ import annotations

import argparse
import time
from pathlib import Path

import numpy as np
import torch
from brushes import ink_of, noisy_start
from make_textured import BRUSHES, Drawn, draw, read_truth
from numpy.typing import NDArray

from videovec.brush import BrushFit, apply_brush, fit_brush
from videovec.brush.coordinates import sample_rows
from videovec.brush.strips import TEXELS_PER_WIDTH
from videovec.brushwork import stroke_joints
from videovec.curves import sample_by_arc
from videovec.ink import Ink
from videovec.metrics import psnr
from videovec.settings import BrushSettings
from videovec.strokes import Layout, Strokes

Floats = NDArray[np.float64]
PLACES = 40


def moved(curves: list[Floats], drawing: int, size: int) -> list[Floats]:
    """The curves turned and shifted as a whole."""
    angle = np.radians(drawing)
    turn = np.array([[np.cos(angle), np.sin(angle)], [-np.sin(angle), np.cos(angle)]])
    return [(curve - size / 2) @ turn + size / 2 + drawing * np.array([1.3, 0.7]) for curve in curves]


def as_clip(parts: list[Strokes]) -> Strokes:
    """Strokes of single drawings, of the same topology, as strokes that live through all of them."""
    count, drawings = len(parts[0]), len(parts)
    rows = [(parts[k], s) for s in range(count) for k in range(drawings)]
    return Strokes(
        ids=parts[0].ids,
        layout=Layout(parts[0].layout.segments, np.zeros(count, np.intp), np.full(count, drawings - 1)),
        is_closed=parts[0].is_closed,
        layer=parts[0].layer,
        color=parts[0].color,
        points=np.concatenate([part.points_of(s) for part, s in rows]),
        half_width=np.concatenate([part.half_width_of(s) for part, s in rows]),
        opacity=np.ones(len(rows)),
        visible=np.tile([0.0, 1.0], (len(rows), 1)),
    )


def jitter(fit: BrushFit, drawn: list[Drawn]) -> Floats:
    """Standard deviation of the change of u between drawings, for each stroke and place. [S, 40] texels"""
    strokes, samples = fit.strokes, sample_rows(fit.strokes)
    layout, starts = strokes.layout, stroke_joints(fit.strokes.layout)
    found = np.zeros((len(strokes), PLACES, len(drawn)))
    for stroke in range(len(strokes)):
        phase = fit.laying.phase[starts[stroke] : starts[stroke + 1]]
        for k, one in enumerate(drawn):
            row = strokes.row(stroke, k)
            part = slice(samples.starts[row], samples.starts[row + 1])
            true = sample_by_arc(one.curves[stroke], PLACES)
            distance = ((true[:, None] - samples.points[None, part]) ** 2).sum(2)
            near = distance.argmin(1) + part.start
            place = samples.segment[near] - layout.row_segments[row] + samples.t[near]
            u = fit.laying.sign[stroke] * samples.arc[near] / fit.brush.width
            laid = phase + fit.laying.shift[layout.row_joints[row] : layout.row_joints[row + 1]]
            found[stroke, :, k] = u + np.interp(place, np.arange(len(phase)), laid)
    return np.diff(found, axis=2).std(axis=2)[:, 1:-1] * TEXELS_PER_WIDTH


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("truth", type=Path)
    parser.add_argument("--brush", choices=sorted(BRUSHES), default="strip_chalk")
    parser.add_argument("--drawings", type=int, default=12)
    parser.add_argument("--size", type=int, default=512)
    parser.add_argument("--width", type=float, default=10.0, help="pen width, px")
    args = parser.parse_args()
    torch.set_num_threads(1)
    curves = read_truth(args.truth, args.size)
    brush = BRUSHES[args.brush]
    drawn = [draw(moved(curves, k, args.size), brush, args.size, args.width, 0) for k in range(args.drawings)]
    pages = np.stack([np.round(255 * (1 - one.coverage)).astype(np.uint8) for one in drawn])
    ways = np.random.default_rng(1).random(len(curves)) < 0.5
    starts = []
    for k, one in enumerate(drawn):
        start = noisy_start(one, k + 1)
        starts.append(_turned_alike(start, one, ways))
    parts = [ink_of(page) for page in pages]
    ink = Ink(
        np.concatenate([part.coverage for part in parts]),
        np.zeros(pages.shape, np.uint8),
        parts[0].palette,
        parts[0].page,
        0.0,
    )
    began = time.process_time()
    fit = fit_brush(ink, as_clip(starts), BrushSettings())
    seconds = time.process_time() - began
    scores = []
    for k in range(args.drawings):
        strokes = fit.strokes.at_drawing(k, 0)
        picture = apply_brush(fit.brush, strokes, (args.size, args.size), fit.laying.at_drawing(fit.strokes.layout, k))
        scores.append(psnr(pages[k] / 255.0, picture.mean(axis=2)))
    moving = jitter(fit, drawn) if args.drawings > 1 else np.zeros((1, 1))
    print(
        f"{args.brush}, {args.drawings} drawings: {fit.evidence.model.value}, agreement {fit.evidence.agreement:.2f}, "
        f"PSNR {np.median(scores):.2f} dB (least {min(scores):.2f}), jitter of u median {np.median(moving):.2f}, "
        f"90 % {np.quantile(moving, 0.9):.2f} texels, texels/ink {fit.texels / fit.ink_pixels:.3f}, {seconds:.0f} CPU s"
    )


def _turned_alike(start: Strokes, drawn: Drawn, ways: NDArray[np.bool_]) -> Strokes:
    """The noisy strokes run the same way on every drawing: the true one, or against it where ``ways`` says so."""
    curves, widths = [], []
    for s in range(len(start)):
        points, half_width = start.points_of(s), start.half_width_of(s)
        is_reversed = np.linalg.norm(points[0] - drawn.curves[s][0]) > np.linalg.norm(points[-1] - drawn.curves[s][0])
        step = -1 if is_reversed != ways[s] else 1
        curves.append(points[::step])
        widths.append(half_width[::step])
    return Strokes.from_curves(curves, widths)


if __name__ == "__main__":
    main()
