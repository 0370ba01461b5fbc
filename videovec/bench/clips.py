"""How well strokes hold through clips with known ones, beside the baselines of the field."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np
import torch

from videovec.bench.clip_methods import LINKED, METHODS, present_methods, vectorise_by
from videovec.bench.clip_truth import TrueClip
from videovec.clip import Clip
from videovec.clip_metrics import ClipScore, score_clip
from videovec.decode import decode
from videovec.ink import extract_ink
from videovec.metrics import psnr, ssim
from videovec.perceptual import Perceptual
from videovec.picture import render_strokes
from videovec.progress import Progress, Silent
from videovec.settings import Config
from videovec.tracks import StrokeTracks
from videovec.write.lottie import lottie_text

__all__ = ["ClipResult", "ClipRun", "PictureScore", "bench_clips"]


@dataclass(frozen=True, slots=True)
class PictureScore:
    """How close the picture of strokes is to its source.

    Args:
        psnr: Over all pixels and channels. dB
        ssim: Of the grey images.
        lpips: AlexNet.
    """

    psnr: float
    ssim: float
    lpips: float


@dataclass(frozen=True, slots=True)
class ClipResult:
    """How one method did on one clip.

    Args:
        name: The clip.
        method: Who vectorised it.
        drawings: D.
        true_strokes: Number of true identities.
        strokes: Number of identities found.
        score: How identities held.
        pictures: How close each of D drawings is.
        seconds: CPU time for each drawing, from frames to tracks.
        lottie_bytes: Size of the Lottie file.
    """

    name: str
    method: str
    drawings: int
    true_strokes: int
    strokes: int
    score: ClipScore
    pictures: tuple[PictureScore, ...]
    seconds: float
    lottie_bytes: int

    def median(self, figure: str) -> float:
        """The median over the drawings of ``psnr``, ``ssim`` or ``lpips``."""
        return float(np.median([getattr(picture, figure) for picture in self.pictures]))


@dataclass(frozen=True, slots=True, eq=False)
class ClipRun:
    """What one method made of one clip.

    Args:
        method: Who vectorised it.
        clip: The clip.
        tracks: The strokes.
        seconds: CPU time from frames to tracks.
    """

    method: str
    clip: Clip
    tracks: StrokeTracks
    seconds: float


def bench_clips(
    clips: Sequence[TrueClip],
    config: Config,
    methods: Sequence[str] = METHODS,
    watch: Callable[[ClipRun, ClipResult], None] | None = None,
    progress: Progress | None = None,
) -> list[ClipResult]:
    """Vectorise clips by several methods and compare the strokes with the truth.

    Args:
        clips: The clips.
        config: How they work; which pipeline it names is of no account.
        methods: See `videovec.bench.clip_methods`; what is not installed is left out with a note.
        watch: Given every run and its result, for pictures.
        progress: Told of every run.

    Returns:
        One result for each clip and method.

    Raises:
        ConfigError: There is no such method.
    """
    progress = progress or Silent()
    present = present_methods(methods, progress)
    progress.stage("bench", len(clips) * len(present))
    network, results = Perceptual.load(), []
    for true in clips:
        clip = decode(true.path)
        for method in present:
            begin = time.process_time()
            tracks = vectorise_by(method, clip, config)
            run = ClipRun(method, clip, tracks, time.process_time() - begin)
            results.append(_measure(true, run, config, network))
            if watch:
                watch(run, results[-1])
            progress.advance()
    return results


def _measure(true: TrueClip, run: ClipRun, config: Config, network: Perceptual) -> ClipResult:
    """All figures of a run."""
    timeline, strokes = run.clip.timeline, run.tracks.strokes
    drawings = [true.frames[frame] for frame in timeline.first_frames()]
    ink = None if true.is_drawn else extract_ink(run.clip, config.ink).coverage
    return ClipResult(
        name=true.name,
        method=run.method,
        drawings=timeline.drawing_count,
        true_strokes=len({stroke.id for frame in true.frames for stroke in frame}),
        strokes=len(strokes),
        score=score_clip(drawings, strokes, ink, by_arc=run.method in LINKED),
        pictures=tuple(_picture_scores(run, config, network)),
        seconds=run.seconds / timeline.drawing_count,
        lottie_bytes=len(lottie_text(run.tracks, config.export).encode()),
    )


def _picture_scores(run: ClipRun, config: Config, network: Perceptual) -> Iterator[PictureScore]:
    """How close each drawing is to its picture, in colour."""
    tracks = run.tracks
    for drawing, pixels in enumerate(run.clip.drawings):
        source = pixels.astype(np.float64) / np.iinfo(pixels.dtype).max
        drawn = render_strokes(tracks.strokes, tracks.size, drawing, tracks.page, config.render).astype(np.float64)
        with torch.no_grad():
            pair = (torch.as_tensor(image, dtype=torch.float32).movedim(-1, 0)[None] for image in (source, drawn))
            distance = float(network.distance(*pair))
        yield PictureScore(psnr(source, drawn), ssim(source.mean(-1), drawn.mean(-1)), distance)
