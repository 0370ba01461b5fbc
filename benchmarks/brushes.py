"""Brushes learned from drawings whose strokes are known: the table and the figure of textured line art.

    python benchmarks/brushes.py DIR OUT --drawings pointing_hand dancer --brushes strip_chalk random_chalk

``DIR`` holds NAME/truth.json. Drawings are made by ``make_textured.py``, where the protocol stands; pen width 10 px at
512 px. The start is the truth with N(0, 1 px) on control points and half-widths and half of the strokes reversed
(``--start noise``), or the automatic trace of the solidified ink (``--start traced``). Columns: *solid*, the start
after 200 steps of solid strokes; *fit*; *ceiling*, the same fit from the true strokes and widths; *again*, the brush
drawn once more with another seed, which is as near as statistics can come to random grain (0 where there is no chance).
LPIPS is AlexNet v0.1; SSIM Gaussian of 1.5 px; both on the picture, black on white.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from pathlib import Path

import numpy as np
import torch
from make_textured import BRUSHES, Drawn, draw, read_truth
from numpy.typing import NDArray
from PIL import Image

from videovec.brush import BrushFit, apply_brush, bridge, drop_scraps, fit_brush, mend, solidify
from videovec.clip import Clip, Timeline
from videovec.config import configure
from videovec.fit import fit as fit_solid
from videovec.initialise import initialise
from videovec.ink import Ink, extract_ink
from videovec.metrics import chamfer, length_difference, psnr, ssim
from videovec.optimise import Schedule, optimise
from videovec.perceptual import Perceptual
from videovec.settings import BrushSettings
from videovec.strokes import Strokes

Floats = NDArray[np.float64]
HEADER = (
    "| drawing | brush | held out | wanted | chosen | solid dB / SSIM / LPIPS e-3 / Chamfer | fit | length % | ceiling "
    "dB / LPIPS | again LPIPS | explained - null | lean | texels / ink | CPU s |\n" + "|---" * 14 + "|"
)


@dataclass(frozen=True, slots=True, eq=False)
class Judge:
    """Compares pictures [H, W] in [0, 1] with a drawing."""

    picture: Floats
    truth: Strokes
    network: Perceptual

    def lpips(self, picture: Floats) -> float:
        """LPIPS, e-3."""
        both = [torch.as_tensor(p, dtype=torch.float32).expand(1, 3, *p.shape) for p in (self.picture, picture)]
        with torch.no_grad():
            return 1e3 * float(self.network.distance(both[0], both[1])[0])

    def line(self, picture: Floats, strokes: Strokes) -> str:
        """PSNR, SSIM, LPIPS and Chamfer distance as one cell."""
        similarity = 100 * ssim(self.picture, picture)
        distance = chamfer(self.truth, strokes)
        return f"{psnr(self.picture, picture):.2f} / {similarity:.2f} / {self.lpips(picture):.1f} / {distance:.3f}"


def ink_of(picture: NDArray[np.uint8]) -> Ink:
    """Ink of black strokes on white, as it is."""
    coverage = (255 - picture)[None]
    return Ink(coverage, np.zeros_like(coverage), np.zeros((1, 3)), np.ones(3), 0.0)


def noisy_start(drawn: Drawn, seed: int) -> Strokes:
    """The truth with N(0, 1 px), half of the strokes reversed."""
    rng = np.random.default_rng(seed)
    curves, widths = [], []
    for curve, half_width in zip(drawn.curves, drawn.half_widths, strict=True):
        step = 1 if rng.random() < 0.5 else -1
        curves.append((curve + rng.normal(size=curve.shape))[::step])
        widths.append(np.maximum(half_width + rng.normal(size=half_width.shape), 1.0)[::step])
    return Strokes.from_curves(curves, widths)


def traced_start(picture: NDArray[np.uint8]) -> tuple[Ink, Strokes]:
    """What ``--preset textured`` starts its brush from: the ink, and the solid fit of its solidified version."""
    timeline = Timeline(np.zeros(1, np.intp), (Fraction(0),), Fraction(1), np.ones(1, np.intp))
    config = configure("textured", ())
    ink = extract_ink(Clip("still", (np.repeat(picture[..., None], 3, axis=2),), timeline), config.ink)
    solid = solidify(ink)
    traced = mend(initialise(solid, 0, config.initialise), solid, config.fit.edits)
    strokes = fit_solid(solid, traced, config.fit).strokes
    return ink, bridge(drop_scraps(strokes), ink, config.fit.edits)


def painted(fit: BrushFit, size: tuple[int, int], ink: Ink) -> Floats:
    """What the fit draws, grey."""
    strokes = replace(fit.strokes, color=np.tile(ink.palette[0], (len(fit.strokes), 1)))
    page = (float(ink.page[0]), float(ink.page[1]), float(ink.page[2]))
    return apply_brush(fit.brush, strokes, size, fit.laying, page=page).mean(axis=2)


def solid_picture(strokes: Strokes, size: tuple[int, int]) -> Floats:
    """Solid strokes, black on white, from their distance to pixels."""
    from videovec.brush.coordinates import find_coordinates

    found = find_coordinates(strokes, (1, *size), 1.0, 1.0)
    joints = strokes.half_width[strokes.layout.segment_joints[found.segment]]
    half = (1 - found.t) * joints[:, 0] + found.t * joints[:, 1]
    alpha = np.clip(half - np.abs(found.distance) + 0.5, 0, 1)
    clear = np.ones(size[0] * size[1])
    np.multiply.at(clear, found.pixel, 1 - alpha)
    return clear.reshape(size)


def run(truth: Path, name: str, args: argparse.Namespace, network: Perceptual) -> tuple[str, list[Floats]]:
    """One row of the table, and the pictures of the figure."""
    brush = BRUSHES[name]
    curves = read_truth(truth, args.size)
    drawn, again = (draw(curves, brush, args.size, args.width, args.seed, other) for other in (0, 1))
    picture = np.round(255 * (1 - drawn.coverage)).astype(np.uint8)
    judge = Judge(picture / 255.0, Strokes.from_curves(drawn.curves, drawn.half_widths), network)
    if args.start == "traced":
        ink, start = traced_start(picture)
        solid = start
    else:
        ink, start = ink_of(picture), noisy_start(drawn, args.seed + 1)
        solid = optimise(start, solidify(ink).coverage, Schedule(steps=200)).strokes
    began = time.process_time()
    fit = fit_brush(ink, start, BrushSettings(), seed=args.seed)
    seconds = time.process_time() - began
    result = painted(fit, picture.shape, ink)
    best = fit_brush(ink_of(picture), judge.truth, BrushSettings(), seed=args.seed)
    ceiling = painted(best, picture.shape, ink_of(picture))
    other = judge.lpips(1 - again.coverage)
    evidence = fit.evidence
    cells = (
        truth.parent.name,
        name,
        "yes" if brush.is_held_out else "",
        brush.explains,
        evidence.model.value,
        judge.line(solid_picture(solid, picture.shape), solid),
        judge.line(result, fit.strokes),
        f"{100 * length_difference(judge.truth, fit.strokes):.1f}",
        f"{psnr(judge.picture, ceiling):.2f} / {judge.lpips(ceiling):.1f}",
        f"{other:.1f}",
        f"{evidence.explained:.2f} - {evidence.null:.2f}",
        f"{evidence.lean:.2f}",
        f"{fit.texels / fit.ink_pixels:.2f}",
        f"{seconds:.0f}",
    )
    applied = apply_brush(fit.brush, _samples(args.size), picture.shape, seed=args.seed).mean(axis=2)
    return "| " + " | ".join(cells) + " |", [judge.picture, result, _strip_picture(fit, args.size), applied]


def _samples(size: int) -> Strokes:
    """A flourish and two lines, to see a brush elsewhere."""
    flourish = np.array(
        [[0.1, 0.3], [0.3, -0.1], [0.45, 0.5], [0.3, 0.45], [0.1, 0.4], [0.6, -0.1], [0.9, 0.25]], dtype=float
    )
    line = np.array([[0.1, 0.6], [0.4, 0.5], [0.6, 0.7], [0.9, 0.6]])
    curves = [flourish * size, line * size, (line + np.array([0.0, 0.2])) * size]
    widths = [np.array([4.0, 7.0, 3.0]), np.array([6.0, 6.0]), np.array([2.5, 11.0])]
    return Strokes.from_curves(curves, [w * size / 512 for w in widths])


def _strip_picture(fit: BrushFit, size: int) -> Floats:
    """The strip, enlarged, in rows as long as the page."""
    strip = 1 - fit.brush.strip.T
    if strip.shape[1] < 8:
        strip = np.repeat(strip, size // 3, axis=1)
    page = np.ones((size, size))
    enlarged = np.repeat(np.repeat(strip, 3, axis=0), 3, axis=1)
    step = enlarged.shape[0] + 8
    for k in range(min(size // step, -(-enlarged.shape[1] // size))):
        part = enlarged[:, k * size : (k + 1) * size]
        page[k * step : k * step + part.shape[0], : part.shape[1]] = part
    return page


def figure(rows: Sequence[list[Floats]]) -> Image.Image:
    """One row for each brush: drawing, rendering after the fit, learned texture, applied elsewhere."""
    lines = [np.concatenate([np.pad(p, 2, constant_values=0.5) for p in row], axis=1) for row in rows]
    return Image.fromarray(np.round(255 * np.clip(np.concatenate(lines), 0, 1)).astype(np.uint8))


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("dir", type=Path)
    parser.add_argument("out", type=Path, help="folder for brushes.md and brushes.png")
    parser.add_argument("--drawings", nargs="+", default=["pointing_hand"])
    parser.add_argument("--brushes", nargs="+", choices=sorted(BRUSHES), default=list(BRUSHES))
    parser.add_argument("--start", choices=("noise", "traced"), default="noise")
    parser.add_argument("--size", type=int, default=512)
    parser.add_argument("--width", type=float, default=10.0, help="pen width, px")
    parser.add_argument("--seed", type=int, default=0)
    args = parser.parse_args()
    torch.set_num_threads(1)
    network = Perceptual.load()
    args.out.mkdir(parents=True, exist_ok=True)
    lines, pictures = [HEADER], []
    print(HEADER)
    for drawing in args.drawings:
        for name in args.brushes:
            line, row = run(args.dir / drawing / "truth.json", name, args, network)
            print(line, flush=True)
            lines.append(line)
            pictures.append(row)
    about = f"size {args.size} px, pen {args.width} px, start {args.start}, seed {args.seed}"
    (args.out / "brushes.md").write_text(about + "\n\n" + "\n".join(lines) + "\n")
    figure(pictures).save(args.out / "brushes.png")


if __name__ == "__main__":
    main()
