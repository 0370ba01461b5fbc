"""Drawings as they come from scanners and the web: how many strokes more, and how close, against the clean drawing.

    python benchmarks/stills_noise.py DIR/*.png --out benchmarks/stills_noise.md

Every drawing is disturbed, traced and fitted. PSNR is of the grey image that the strokes make against the disturbed
input; "allowed" is that of the clean drawing itself against it: no tracer that does not follow the noise does better.
"""

from __future__ import annotations

import argparse
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray
from timing import machine

from videovec.clip import Clip
from videovec.decode import decode
from videovec.fit import draw_coverage, fit
from videovec.initialise import initialise
from videovec.ink import extract_ink
from videovec.metrics import psnr
from videovec.render import resolve_backend
from videovec.settings import FitSettings, InitialiseSettings, RenderSettings
from videovec.threads import configure_threads

Image = NDArray[np.uint8]
SIGMA, QUALITY, SHADE = 6.0, 50, 0.25
"""Page noise, 8-bit levels; JPEG quality; how much darker the page is at its right edge."""


def noisy(image: Image) -> Image:
    noise = np.random.default_rng(0).normal(0.0, SIGMA, image.shape)
    return np.asarray(np.clip(image + noise, 0, 255).round(), np.uint8)


def compressed(image: Image) -> Image:
    _, data = cv2.imencode(".jpg", image, [cv2.IMWRITE_JPEG_QUALITY, QUALITY])
    return np.asarray(cv2.imdecode(data, cv2.IMREAD_GRAYSCALE), np.uint8)


def shaded(image: Image) -> Image:
    return np.asarray((image * np.linspace(1.0, 1.0 - SHADE, image.shape[1])).round(), np.uint8)


DISTURBANCES: dict[str, Callable[[Image], Image]] = {
    "clean": lambda image: image,
    f"JPEG quality {QUALITY}": compressed,
    f"noise of {SIGMA:g}/255": noisy,
    "both": lambda image: compressed(noisy(image)),
    f"shading of {100 * SHADE:g} %": shaded,
    "16 bits": lambda image: image,
}


@dataclass(frozen=True, slots=True)
class Outcome:
    """Strokes, and PSNR of their picture and of the clean drawing against the disturbed input. dB"""

    strokes: int
    psnr: float
    allowed: float


def measure(clip: Clip, disturb: Callable[[Image], Image], sixteen: bool = False) -> Outcome:
    """Trace and fit one drawing, disturbed."""
    clean = clip.drawings[0][..., 0]
    seen = disturb(clean)
    pixels = seen.astype(np.uint16) * np.uint16(257) if sixteen else seen
    ink = extract_ink(Clip(clip.name, (np.repeat(pixels[..., None], 3, axis=2),), clip.timeline))
    strokes = fit(ink, initialise(ink, 0, InitialiseSettings()), FitSettings()).strokes
    coverage = draw_coverage(strokes, ink.coverage.shape, resolve_backend(RenderSettings()))[0] / 255.0
    if disturb is shaded:  # the shading is no ink: compare what is left when it is divided out
        page = np.linspace(1.0, 1.0 - SHADE, clean.shape[1])
        seen_grey, true_grey = seen / 255.0 / page, clean / 255.0
    else:
        seen_grey, true_grey = seen / 255.0, clean / 255.0
    return Outcome(len(strokes), psnr(seen_grey, 1.0 - coverage), psnr(seen_grey, true_grey))


def table(paths: Sequence[Path]) -> str:
    """One row for each disturbance: sums of strokes, and the least margin over what the noise allows."""
    rows = ["| | strokes | of the clean run's | PSNR median | allowed | worst against allowed |", "|---" * 6 + "|"]
    clips = [decode(path) for path in paths]
    clean = 0
    for name, disturb in DISTURBANCES.items():
        found = [measure(clip, disturb, name == "16 bits") for clip in clips]
        count = sum(outcome.strokes for outcome in found)
        clean = clean or count
        margin = min(outcome.psnr - outcome.allowed for outcome in found)
        allowed = float(np.median([outcome.allowed for outcome in found]))
        rows.append(
            f"| {name} | {count} | {100 * count / clean:.0f} % | {np.median([o.psnr for o in found]):.2f} "
            f"| {allowed:.2f} | {margin:+.2f} |"
        )
    return "\n".join(rows)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("drawings", nargs="+", type=Path)
    parser.add_argument("--out", type=Path, default=Path("stills_noise.md"))
    told = parser.parse_args()
    configure_threads(1)
    sets = sorted({path.stem for path in told.drawings})
    text = ["# Stills with noise, JPEG and shading", f"`python benchmarks/stills_noise.py DIR/*.png`; {machine()}"]
    for name in sets:
        text += [f"## {name}", table([path for path in told.drawings if path.stem == name])]
    told.out.write_text("\n\n".join(text) + "\n", encoding="utf-8")
    print("\n\n".join(text))


if __name__ == "__main__":
    main()
