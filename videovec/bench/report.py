"""Tables, CSV and pictures of benchmarks on stills."""

from __future__ import annotations

import csv
from collections.abc import Sequence
from dataclasses import asdict, fields
from io import StringIO
from itertools import groupby

import cv2
import numpy as np
from numpy.typing import NDArray

from videovec.bench.stills import Result, StillScore
from videovec.write.preview import draw_strokes

__all__ = ["PROTOCOL", "SUPPLEMENT", "picture_file", "scores_to_csv", "scores_to_table", "sheet"]

Image = NDArray[np.uint8]

PROTOCOL = """\
How these figures differ from the supplement's rows: its drawings are those of Yan et al. 2024 (and it gives means),
these are the folder's (medians; counts are sums); its line width is not stated (probably 0.001 of the long edge), ours
is in the set's name (w3: 3 px at 512; hairline: 0.001 of the long edge; texturedN: a brush of N thousandths of the long
edge at full pressure, which varies along every stroke, as does the ink); its rasteriser is not stated, the drawings
here are area-coverage images and our strokes are drawn by videovec's own renderer; its LPIPS network is not stated,
ours is AlexNet; SSIM is that of Wang et al. 2004 (11 x 11 Gaussian of sigma 1.5) on grey; CPU time is from ink to
strokes, without decoding."""

SUPPLEMENT = {
    ("clean", 256): (2.91, 4.94, 114.59, 14.84, 37.30, 98.39),
    ("clean", 384): (2.65, 2.48, 88.25, 8.12, 38.24, 99.25),
    ("clean", 512): (0.94, 1.40, 113.65, 5.15, 39.70, 99.62),
    ("clean", 768): (1.15, 1.23, 108.02, 3.26, 38.98, 99.75),
    ("clean", 1024): (0.89, 0.84, 108.40, 1.80, 40.13, 99.87),
    ("textured", 256): (4.20, 10.89, 56.96, 22.85, 26.84, 98.23),
    ("textured", 384): (3.14, 6.81, 72.99, 21.49, 29.16, 98.75),
    ("textured", 512): (1.13, 5.08, 121.85, 18.43, 29.02, 98.77),
    ("textured", 768): (1.21, 3.12, 101.78, 18.96, 32.54, 99.35),
    ("textured", 1024): (1.02, 2.45, 110.58, 17.22, 33.93, 99.49),
}
"""Tables 1 and 2, "Ours": Chamfer px, length difference %, strokes (mean), LPIPS e-3, PSNR dB, SSIM e-2."""

_HEAD = (
    f"{'set':<16}{'method':<24}{'ok %':>5}{'strokes/true':>14}{'segm.':>7}{'Chamfer':>9}{'length %':>9}"
    f"{'LPIPS e-3':>10}{'PSNR':>7}{'SSIM e-2':>9}{'c90':>6}{'strict':>7}{'fragm.':>7}{'merges':>7}{'s':>6}"
)


def _figure(value: float, digits: int, width: int) -> str:
    return f"{'-' if np.isnan(value) else f'{value:.{digits}f}':>{width}}"


def _row(scores: Sequence[StillScore]) -> str:
    """One method on one set and size."""
    first = scores[0]
    good = [score for score in scores if score.success]

    def median(name: str) -> float:
        return float(np.median([getattr(score, name) for score in good])) if good else float("nan")

    counts = f"{sum(score.strokes for score in scores)}/{sum(score.true_strokes for score in scores)}"
    return (
        f"{f'{first.set_name} {first.size}':<16}{first.method:<24}{100 * len(good) / len(scores):>5.0f}{counts:>14}"
        f"{sum(score.segments for score in scores):>7}{_figure(median('chamfer'), 3, 9)}"
        f"{_figure(100 * median('length_difference'), 2, 9)}{_figure(1e3 * median('lpips'), 2, 10)}"
        f"{_figure(median('psnr'), 2, 7)}{_figure(100 * median('ssim'), 2, 9)}{_figure(median('covered'), 2, 6)}"
        f"{_figure(median('matched'), 2, 7)}{sum(score.fragments for score in good):>7.0f}"
        f"{sum(score.merges for score in good):>7.0f}{_figure(median('seconds'), 2, 6)}"
    )


def _supplement_row(set_name: str, size: int) -> str | None:
    kind = "textured" if set_name.startswith("textured") else "clean"
    row = SUPPLEMENT.get((kind, size))
    if row is None:
        return None
    distance, length, count, lpips, psnr, ssim = row
    return (
        f"{f'{kind} {size}':<16}{'supplement, ours':<24}{100:>5}{count:>14.2f}{'-':>7}{distance:>9.2f}{length:>9.2f}"
        f"{lpips:>10.2f}{psnr:>7.2f}{ssim:>9.2f}"
    )


def scores_to_table(scores: Sequence[StillScore]) -> str:
    """The table that is printed: medians over the drawings of each set, size and method, by the supplement's rows."""
    ordered = sorted(scores, key=lambda score: (score.set_name, score.size))
    lines = [_HEAD]
    for (set_name, size), group in groupby(ordered, key=lambda score: (score.set_name, score.size)):
        supplement = _supplement_row(set_name, size)
        lines += [supplement] if supplement else []
        of_set = list(group)
        for method in dict.fromkeys(score.method for score in of_set):
            lines.append(_row([score for score in of_set if score.method == method]))
    return "\n".join([*lines, "", PROTOCOL])


def scores_to_csv(scores: Sequence[StillScore]) -> str:
    """One line for each drawing and method."""
    text = StringIO()
    writer = csv.DictWriter(text, [field.name for field in fields(StillScore)], lineterminator="\n")
    writer.writeheader()
    writer.writerows(asdict(score) for score in scores)
    return text.getvalue()


def picture_file(result: Result) -> tuple[str, bytes]:
    """Name and content of the PNG that shows a tracing; see `sheet`."""
    score = result.score
    method = "".join(c if c.isalnum() else "-" for c in score.method)
    data = cv2.imencode(".png", sheet(result)[..., ::-1])[1].tobytes()
    return f"{score.name}_{score.set_name}_{score.size}_{method}.png", data


def sheet(result: Result, zoom: int = 2) -> Image:
    """Input, strokes in colours of their own, and error (blue: too little ink, red: too much), side by side.

    Args:
        result: A tracing.
        zoom: Pixels of the picture per px.

    Returns:
        uint8 [zoom * H, 3 * zoom * W, 3]
    """
    height, width = result.image.shape
    drawn = np.ones_like(result.image) if result.drawn is None else result.drawn
    error = result.image - drawn
    shown = np.stack([1 - np.maximum(-error, 0), 1 - np.abs(error), 1 - np.maximum(error, 0)], axis=2)
    parts = [np.repeat(result.image[..., None], 3, axis=2), shown]
    source, wrong = (
        cv2.resize(np.rint(255 * part).astype(np.uint8), (zoom * width, zoom * height), interpolation=cv2.INTER_CUBIC)
        for part in parts
    )
    strokes = draw_strokes(result.strokes, 0, (height, width), zoom)
    return np.concatenate([source, strokes, wrong], axis=1)
