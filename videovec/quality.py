"""How well strokes draw their clip: the figures of a run, for each drawing."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from videovec.brush import draw_brushwork
from videovec.clip import Clip
from videovec.picture import render_strokes
from videovec.progress import Progress, Silent
from videovec.settings import RenderSettings
from videovec.tracks import StrokeTracks

__all__ = ["Quality", "draw_tracks", "measure"]


@dataclass(frozen=True, slots=True, eq=False)
class Quality:
    """What was measured, by drawing.

    Args:
        psnr: Of the picture of the strokes against the source. dB [D]
        error: Root of the squared error of that picture over that of an empty page: 0 is perfect, 1 is no better
            than nothing. [D]
    """

    psnr: NDArray[np.float64]
    error: NDArray[np.float64]


def measure(
    clip: Clip, tracks: StrokeTracks, settings: RenderSettings | None = None, progress: Progress | None = None
) -> Quality:
    """Draw strokes and compare them with their clip.

    Args:
        clip: The clip.
        tracks: Its strokes.
        settings: Which renderer draws.
        progress: Told of the one stage.
    """
    progress = progress or Silent()
    progress.stage("measure", len(clip.drawings))
    psnr, error = np.zeros(len(clip.drawings)), np.zeros(len(clip.drawings))
    for drawing, source in enumerate(clip.drawings):
        seen = source.astype(np.float32) / np.iinfo(source.dtype).max
        drawn = draw_tracks(tracks, drawing, settings)
        ours = float(np.mean((drawn - seen) ** 2, dtype=float))
        empty = float(np.mean((tracks.page - seen) ** 2, dtype=float))
        psnr[drawing] = -10 * np.log10(max(ours, 1e-10))
        error[drawing] = np.sqrt(ours / max(empty, 1e-10))
        progress.advance()
    return Quality(psnr, error)


def draw_tracks(
    tracks: StrokeTracks, drawing: int, settings: RenderSettings | None = None
) -> NDArray[np.floating[Any]]:
    """The picture of a drawing's strokes, with their texture if they have one. sRGB [H, W, 3] in [0, 1]"""
    if tracks.brushwork is None:
        return render_strokes(tracks.strokes, tracks.size, drawing, tracks.page, settings)
    alone = tracks.strokes.at_drawing(drawing, as_drawing=0)
    return draw_brushwork(tracks.brushwork.at_drawing(tracks.strokes.layout, drawing), alone, tracks.size, tracks.page)
