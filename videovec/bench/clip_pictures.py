"""Pictures of benchmarks on clips: drawings with strokes coloured by identity, and figures over time."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from videovec.bench.chart import Panel, chart_svg
from videovec.bench.clips import ClipResult, ClipRun
from videovec.write.preview import contact_sheet, draw_strokes

__all__ = ["curves_svg", "picture_files", "strip"]

Image = NDArray[np.uint8]

_COLUMNS = 6  # drawings in a row
_WIDTH, _HEIGHT = 300, 200  # px of a picture, at most
_BAND = 24  # px of the text above a row
_ZOOM = 2  # at which strokes are drawn, before they are shown at any size
_MARGIN = 12  # px around what is drawn
_DIFFERS = 40  # of 255, from the page


def picture_files(runs: Sequence[ClipRun], results: Sequence[ClipResult]) -> list[tuple[str, bytes]]:
    """Names and contents of the pictures of one clip: a strip (PNG) and curves over time (SVG).

    Args:
        runs: Those of each method on the clip.
        results: Theirs.
    """
    name = results[0].name
    png = cv2.imencode(".png", strip(runs, results)[..., ::-1])[1].tobytes()
    return [(f"{name}_strip.png", png), (f"{name}_curves.svg", curves_svg(results).encode("utf-8"))]


def strip(runs: Sequence[ClipRun], results: Sequence[ClipResult]) -> Image:
    """Drawings of a clip above, the strokes of each method in the colours of their identities below.

    Args:
        runs: Those of each method on one clip.
        results: Theirs.

    Returns:
        uint8 [H, W, 3]
    """
    clip = runs[0].clip
    count = clip.timeline.drawing_count
    drawings = np.unique(np.linspace(0, count - 1, min(count, _COLUMNS)).round().astype(int)).tolist()
    sources = [_eight_bit(clip.drawings[d]) for d in drawings]
    view = _View.of(sources)
    rows = [
        _row(
            f"{results[0].name}, drawings {', '.join(str(d + 1) for d in drawings)} of {count}",
            [view.show(image, 1) for image in sources],
        )
    ]
    for run, result in zip(runs, results, strict=True):
        score = result.score
        title = (
            f"{result.method}: {result.strokes} strokes for {result.true_strokes}, IDF1 {score.idf1:.2f}, "
            f"jitter {score.jitter:.2f} px"
        )
        rows.append(
            _row(title, [view.show(draw_strokes(run.tracks.strokes, d, clip.size, _ZOOM), _ZOOM) for d in drawings])
        )
    return np.concatenate(rows)


def curves_svg(results: Sequence[ClipResult]) -> str:
    """Error, identity and fidelity of each method over the drawings of one clip, as an SVG document."""
    methods = {result.method: result for result in results}
    return chart_svg(
        [
            Panel(
                f"{results[0].name}: error of followed points that are not lost, px",
                {name: result.score.error_over_time for name, result in methods.items()},
                is_log=True,
            ),
            Panel(
                "share of true stroke length on its own identity",
                {name: result.score.identity_over_time for name, result in methods.items()},
                shown=(0.0, 1.0),
            ),
            Panel(
                "PSNR of the drawing, dB",
                {name: [picture.psnr for picture in result.pictures] for name, result in methods.items()},
            ),
        ]
    )


@dataclass(frozen=True, slots=True)
class _View:
    """The part of a page, from its corner (x, y) on, that is shown, and its width and height. px"""

    x: int
    y: int
    width: int
    height: int

    @staticmethod
    def of(images: Sequence[Image]) -> _View:
        """What holds all that differs from the page, with a margin."""
        shown = np.zeros(images[0].shape[:2], bool)
        for image in images:
            away = np.abs(image.astype(np.int16) - np.median(image, axis=(0, 1)).astype(np.int16)).max(axis=2)
            shown |= away > _DIFFERS
        height, width = images[0].shape[:2]
        rows, columns = np.flatnonzero(shown.any(axis=1)), np.flatnonzero(shown.any(axis=0))
        if not len(rows):
            return _View(0, 0, width, height)
        y, x = max(int(rows[0]) - _MARGIN, 0), max(int(columns[0]) - _MARGIN, 0)
        bottom, right = min(int(rows[-1]) + _MARGIN, height), min(int(columns[-1]) + _MARGIN, width)
        return _View(x, y, right - x, bottom - y)

    def show(self, image: Image, zoom: int) -> Image:
        """That part of a page drawn at ``zoom`` times its size, as large as a row of pictures allows."""
        y, x = slice(zoom * self.y, zoom * (self.y + self.height)), slice(zoom * self.x, zoom * (self.x + self.width))
        scale = min(_WIDTH / self.width, _HEIGHT / self.height)
        size = (max(1, round(scale * self.width)), max(1, round(scale * self.height)))
        return np.asarray(cv2.resize(image[y, x], size, interpolation=cv2.INTER_AREA), dtype=np.uint8)


def _row(title: str, images: Sequence[Image]) -> Image:
    """Images side by side below a line of text."""
    sheet = contact_sheet(images, len(images))
    band = np.full((_BAND, sheet.shape[1], 3), 255, np.uint8)
    cv2.putText(band, title, (6, _BAND - 8), cv2.FONT_HERSHEY_SIMPLEX, 0.45, (40, 40, 40), 1, cv2.LINE_AA)
    return np.concatenate([band, sheet])


def _eight_bit(image: NDArray[np.integer]) -> Image:
    return np.asarray(image >> 8 if image.dtype == np.uint16 else image, dtype=np.uint8)
