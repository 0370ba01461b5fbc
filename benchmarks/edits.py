"""What edits buy: fidelity against simplicity, for prices of a control point and, without edits, tolerances of tracing.

    python benchmarks/edits.py DIR/*.png --out benchmarks/edits.md

Every drawing is traced and fitted with 200 steps on one thread. PSNR is of coverage; control points, strokes and
segments are summed over the drawings. The first table also is a picture, ``edits.png`` beside the Markdown. The second
says what LPIPS (AlexNet) in the loss buys; its column is the distance of the fitted drawing from the input.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import cv2
import numpy as np
import torch
from numpy.typing import NDArray
from timing import machine

from videovec.decode import decode
from videovec.fit import draw_coverage, fit
from videovec.initialise import initialise
from videovec.ink import Ink, extract_ink
from videovec.perceptual import Perceptual
from videovec.render import resolve_backend
from videovec.settings import EditSettings, FitSettings, InitialiseSettings, RenderSettings, Weights
from videovec.threads import configure_threads

PRICES = (0.0005, 0.001, 0.002, 0.005, 0.01, 0.02, 0.05, 0.1, 0.2)
TOLERANCES = (0.2, 0.35, 0.6, 1.0)
PLAIN = FitSettings(edits=EditSettings(every=0))


@dataclass(frozen=True, slots=True)
class Point:
    """A place on a curve: sums over drawings, median and mean PSNR (dB), median LPIPS, seconds of CPU a drawing."""

    name: str
    strokes: int
    segments: int
    control_points: int
    median: float
    mean: float
    lpips: float
    seconds: float

    def row(self) -> str:
        """As a row of the table."""
        return (
            f"| {self.name} | {self.strokes} | {self.segments} | {self.control_points} | {self.median:.2f} "
            f"| {self.mean:.2f} | {1e3 * self.lpips:.3f} | {self.seconds:.2f} |"
        )


def measure(
    name: str,
    inks: Sequence[Ink],
    settings: FitSettings,
    tolerance: float | None = None,
    network: Perceptual | None = None,
) -> Point:
    """Trace and fit every drawing."""
    trace = InitialiseSettings() if tolerance is None else InitialiseSettings(tolerance=tolerance)
    sums, psnr, distance, seconds = np.zeros(3, int), [], [], []
    for ink in inks:
        begin = time.process_time()
        result = fit(ink, initialise(ink, 0, trace), settings)
        seconds.append(time.process_time() - begin)
        layout = result.strokes.layout
        sums += (len(result.strokes), int(layout.segments.sum()), len(result.strokes.points))
        psnr.append(float(result.psnr[0]))
        if network is not None:
            drawn = draw_coverage(result.strokes, ink.coverage.shape, resolve_backend(RenderSettings()))
            with torch.no_grad():
                distance.append(float(network.distance(_image(drawn), _image(ink.coverage))))
    lpips = float(np.median(distance)) if distance else float("nan")
    return Point(name, *sums.tolist(), float(np.median(psnr)), float(np.mean(psnr)), lpips, float(np.median(seconds)))


def _image(coverage: NDArray[np.uint8]) -> torch.Tensor:
    return (1 - torch.from_numpy(coverage).float() / 255)[:, None].expand(-1, 3, -1, -1)


def table(points: Sequence[Point]) -> str:
    head = "| | strokes | segments | control points | PSNR median | mean, dB | LPIPS e-3 | s |"
    return "\n".join([head, "|---" * 8 + "|", *(point.row() for point in points)])


def picture(curves: Sequence[Sequence[Point]]) -> NDArray[np.uint8]:
    """Mean PSNR over control points; the first curve black, the second red."""
    page = np.full((480, 720, 3), 255, np.uint8)
    every = [point for curve in curves for point in curve]
    x = np.array([point.control_points for point in every], float)
    y = np.array([point.mean for point in every])
    low, span = np.array([x.min(), y.min()]), np.maximum(np.array([np.ptp(x), np.ptp(y)]), 1e-9)
    for curve, color in zip(curves, ((0, 0, 0), (0, 0, 220)), strict=False):
        where = (np.array([[p.control_points, p.mean] for p in curve]) - low) / span * [600, -400] + [60, 440]
        cv2.polylines(page, [where.round().astype(np.int32)], False, color, 2, cv2.LINE_AA)
        for point, (a, b) in zip(curve, where.round().astype(int).tolist(), strict=True):
            cv2.circle(page, (a, b), 4, color, -1, cv2.LINE_AA)
            cv2.putText(page, point.name.split()[-1], (a + 6, b - 6), 0, 0.4, color, 1, cv2.LINE_AA)
    label = f"mean PSNR {y.min():.1f}..{y.max():.1f} dB over {x.min():.0f}..{x.max():.0f} control points"
    cv2.putText(page, label, (60, 470), 0, 0.45, (0, 0, 0), 1, cv2.LINE_AA)
    return page


def run(
    inks: Sequence[Ink], prices: Sequence[float] = PRICES, tolerances: Sequence[float] = TOLERANCES
) -> list[list[Point]]:
    """The two curves: edits at several prices, and no edits at several tolerances."""
    network = Perceptual.load()
    fit(inks[0], initialise(inks[0], 0, InitialiseSettings()), FitSettings(steps=101))  # compiles
    edited = [
        measure(f"price {price:g}", inks, FitSettings(edits=EditSettings(price=price)), network=network)
        for price in prices
    ]
    plain = [measure(f"no edits, tolerance {limit:g}", inks, PLAIN, limit, network) for limit in tolerances]
    return [edited, plain]


def perceptual(inks: Sequence[Ink], weights: Sequence[float] = (0.0, 2e-4, 2e-3)) -> list[Point]:
    """The fit with LPIPS in its loss."""
    network = Perceptual.load()
    settings = [(weight, replace(FitSettings(), weights=Weights(perceptual=weight))) for weight in weights]
    return [measure(f"LPIPS weight {weight:g}", inks, told, network=network) for weight, told in settings]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("drawings", nargs="+", type=Path)
    parser.add_argument("--out", type=Path, default=Path("edits.md"))
    parser.add_argument("--prices", nargs="+", type=float, default=PRICES)
    parser.add_argument("--tolerances", nargs="+", type=float, default=TOLERANCES)
    told = parser.parse_args()
    configure_threads(1)
    inks = [extract_ink(decode(path)) for path in told.drawings]
    curves = run(inks, told.prices, told.tolerances)
    text = [
        "# Edits: fidelity against simplicity",
        f"`python benchmarks/edits.py DIR/*.png`, {len(inks)} drawings; {machine()}",
        table([point for curve in curves for point in curve]),
        "![mean PSNR over control points: black with edits, red without](edits.png)",
        "## LPIPS in the loss, evaluated every 10 steps",
        table(perceptual(inks[:2])),
    ]
    told.out.write_text("\n\n".join(text) + "\n", encoding="utf-8")
    cv2.imwrite(str(told.out.with_suffix(".png")), picture(curves))
    print("\n\n".join(text))


if __name__ == "__main__":
    main()
