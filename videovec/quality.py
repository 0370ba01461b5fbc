"""How well strokes draw their clip: the figures of a run, for each frame."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from videovec.clip import Clip
from videovec.fit import draw_coverage
from videovec.ink import extract_ink
from videovec.progress import Progress
from videovec.render import resolve_backend
from videovec.settings import Config
from videovec.tracks import StrokeTracks

__all__ = ["Quality", "measure"]


@dataclass(frozen=True, slots=True, eq=False)
class Quality:
    """What was measured, by drawing.

    Args:
        psnr: Of the drawn ink against the seen ink over the page. dB [D]
        error: Root of the squared error over the squared ink: 0 is perfect, 1 is a page left empty. [D]
    """

    psnr: NDArray[np.float64]
    error: NDArray[np.float64]


def measure(clip: Clip, tracks: StrokeTracks, config: Config, progress: Progress) -> Quality:
    """Draw strokes and compare them with the ink of their clip.

    Args:
        clip: The clip.
        tracks: Its strokes.
        config: How ink is told apart, and which renderer draws.
        progress: Told of the one stage.
    """
    ink = extract_ink(clip, config.ink)
    progress.stage("measure", ink.drawing_count)
    backend = resolve_backend(config.render)
    psnr, error = np.zeros(ink.drawing_count), np.zeros(ink.drawing_count)
    for drawing, seen in enumerate(ink.coverage):
        alone = tracks.strokes.at_drawing(drawing, as_drawing=0)
        drawn = draw_coverage(alone, (1, *ink.size), backend)[0]
        squared = np.sum((drawn.astype(np.float32) - seen) ** 2, dtype=float) / 255**2
        there = np.sum(seen.astype(np.float32) ** 2, dtype=float) / 255**2
        psnr[drawing] = -10 * np.log10(max(squared / seen.size, 1e-10))
        error[drawing] = np.sqrt(squared / there) if there else float(squared > 0)
        progress.advance()
    return Quality(psnr, error)
