"""Clips with true strokes: how well identities hold, beside other pipelines.

A folder of clips holds, for each, a folder of one of three kinds: ``gt.npz`` (``ctrl [T, segments, 4, 2]`` px and
``seg_stroke [segments]``) beside images ``0000.png ..``; ``gt.json`` (``frames[i].strokes[j]`` with ``id``, ``points``
and ``visible``) beside ``NAME.mp4``; or ``truth/NAME.json``, as in ``samples/``, beside the clip ``NAME`` itself.
"""

from __future__ import annotations

import csv
import json
import time
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass
from io import StringIO
from pathlib import Path

import numpy as np

from videovec.clip import Clip
from videovec.clip_metrics import THRESHOLDS, ClipScore, TrueStroke, score_clip
from videovec.decode import decode
from videovec.errors import InputError
from videovec.fit import judge
from videovec.ink import extract_ink
from videovec.progress import Progress, Silent
from videovec.render import resolve_backend
from videovec.run import find_pipeline
from videovec.settings import Config
from videovec.tracks import StrokeTracks
from videovec.write.lottie import lottie_text

__all__ = ["ClipResult", "TrueClip", "bench_clips", "clips_to_csv", "clips_to_table", "read_clips"]

_HIDDEN = 0.05
"""Share of a stroke below which it counts as hidden in truth that knows no intervals."""


@dataclass(frozen=True, slots=True, eq=False)
class TrueClip:
    """A clip and the strokes that made it.

    Args:
        name: What it is called.
        path: The clip.
        frames: True strokes of each frame.
        is_drawn: Whether every true stroke is seen whole; else those count only where there is ink.
    """

    name: str
    path: Path
    frames: list[list[TrueStroke]]
    is_drawn: bool


@dataclass(frozen=True, slots=True)
class ClipResult:
    """How one pipeline did on one clip.

    Args:
        name: The clip.
        pipeline: Which pipeline.
        drawings: D.
        true_strokes: Number of true identities.
        strokes: Number of identities found.
        score: How identities held.
        psnr: Median over drawings of the rendered coverage against the seen one. dB
        seconds: CPU time for each drawing, from frames to tracks.
        lottie_bytes: Size of the Lottie file.
    """

    name: str
    pipeline: str
    drawings: int
    true_strokes: int
    strokes: int
    score: ClipScore
    psnr: float
    seconds: float
    lottie_bytes: int


def read_clips(directory: Path, names: Sequence[str] = ()) -> list[TrueClip]:
    """Find the clips of a folder.

    Args:
        directory: The folder.
        names: Which clips; all if none is named.

    Returns:
        The clips, by name.

    Raises:
        InputError: There is none.
    """
    found = [_read_moved(path) for path in directory.glob("*/gt.npz")]
    found += [_read_animation(path) for path in directory.glob("*/gt.json")]
    found += [clip for path in directory.glob("truth/*.json") if (clip := _read_sample(path))]
    found = sorted((clip for clip in found if not names or clip.name in names), key=lambda clip: clip.name)
    if not found:
        raise InputError(f"{directory}: must hold NAME/gt.npz, NAME/gt.json or truth/NAME.json, found none")
    return found


def _read_moved(path: Path) -> TrueClip:
    """Hand-drawn strokes that a script moved: every stroke is on every frame."""
    with np.load(path) as archive:
        control, stroke = archive["ctrl"], archive["seg_stroke"]
    frames = []
    for segments in control:
        curves = [segments[stroke == s] for s in np.unique(stroke)]
        points = [np.concatenate([c[0, :1], c[:, 1:].reshape(-1, 2)]) for c in curves]
        frames.append([TrueStroke(s + 1, p) for s, p in enumerate(points)])
    return TrueClip(path.parent.name, path.parent / "%04d.png", frames, True)


def _read_animation(path: Path) -> TrueClip:
    frames = json.loads(path.read_text("utf-8"))["frames"]
    names = sorted({stroke["id"] for frame in frames for stroke in frame["strokes"]})
    true = []
    for frame in frames:
        strokes = [s for s in frame["strokes"] if s["visible"] > _HIDDEN]
        true.append(
            [TrueStroke(names.index(s["id"]) + 1, np.array(s["points"], float).reshape(-1, 2)) for s in strokes]
        )
    return TrueClip(path.parent.name, path.parent / f"{path.parent.name}.mp4", true, False)


def _read_sample(path: Path) -> TrueClip | None:
    found = [p for p in path.parent.parent.glob(f"{path.stem}*") if p.is_dir() or p.suffix != ".json"]
    if not found:
        return None
    data = json.loads(path.read_text("utf-8"))
    drawings = [
        [TrueStroke(s["id"], np.array(s["points"], float), tuple(map(tuple, s["visible"]))) for s in drawing]
        for drawing in data["drawings"]
    ]
    return TrueClip(path.stem, found[0], [drawings[d] for d in data["drawing_of_frame"]], True)


def bench_clips(
    clips: Sequence[TrueClip],
    config: Config,
    pipelines: Sequence[str] = ("solid", "per_frame"),
    watch: Callable[[Clip, StrokeTracks, ClipResult], None] | None = None,
    progress: Progress | None = None,
) -> list[ClipResult]:
    """Run clips through several pipelines and compare the strokes with the truth.

    Args:
        clips: The clips.
        config: How they work; which pipeline it names is of no account.
        pipelines: Names of files in ``pipelines/``.
        watch: Given every result, for pictures.
        progress: Told of every run.

    Returns:
        One result for each clip and pipeline.
    """
    progress = progress or Silent()
    progress.stage("bench", len(clips) * len(pipelines))
    results = []
    for true in clips:
        clip = decode(true.path)
        for pipeline in pipelines:
            begin = time.process_time()
            tracks = find_pipeline(pipeline)(clip, config, Silent())
            seconds = time.process_time() - begin
            results.append(_result(true, clip, pipeline, (tracks, seconds), config))
            if watch:
                watch(clip, tracks, results[-1])
            progress.advance()
    return results


def _result(true: TrueClip, clip: Clip, pipeline: str, ran: tuple[StrokeTracks, float], config: Config) -> ClipResult:
    tracks, seconds = ran
    ink = extract_ink(clip, config.ink)
    drawings = [true.frames[frame] for frame in clip.timeline.first_frames()]
    return ClipResult(
        name=true.name,
        pipeline=pipeline,
        drawings=ink.drawing_count,
        true_strokes=len({stroke.id for frame in true.frames for stroke in frame}),
        strokes=len(tracks.strokes),
        score=score_clip(drawings, tracks.strokes, None if true.is_drawn else ink.coverage),
        psnr=float(np.median(judge(ink, tracks.strokes, resolve_backend(config.render)).psnr)),
        seconds=seconds / ink.drawing_count,
        lottie_bytes=len(lottie_text(tracks, config.export).encode()),
    )


def clips_to_csv(results: Sequence[ClipResult]) -> str:
    """All figures, a row for each clip and pipeline."""
    rows = [_flat(result) for result in results]
    text = StringIO()
    writer = csv.DictWriter(text, list(rows[0]) if rows else ["name"], lineterminator="\n")
    writer.writeheader()
    writer.writerows(rows)
    return text.getvalue()


def _flat(result: ClipResult) -> dict[str, object]:
    row = asdict(result)
    score = row.pop("score")
    within = {f"within_{limit:g}px": share for limit, share in zip(THRESHOLDS, score.pop("position"), strict=True)}
    flat: dict[str, object] = row | score | within
    return flat


def clips_to_table(results: Sequence[ClipResult]) -> str:
    """A line for each clip and pipeline."""
    head = (
        f"{'clip':<18}{'pipeline':<12}{'true/found':>11}{'IDF1':>6}{'persist':>8}{'full':>6}{'error':>7}{'<1px':>6}"
        f"{'<4px':>6}{'occl.':>6}{'jitter':>7}{'flicker':>8}{'births':>7}{'deaths':>7}{'PSNR':>6}{'s/drw':>7}{'KiB':>7}"
    )
    lines = [head]
    for result in results:
        score = result.score
        lines.append(
            f"{result.name:<18}{result.pipeline:<12}{f'{result.true_strokes}/{result.strokes}':>11}{score.idf1:>6.2f}"
            f"{score.persistence:>8.2f}{score.full_life:>6.2f}{score.error:>7.2f}{score.position[0]:>6.2f}"
            f"{score.position[2]:>6.2f}{score.occlusion:>6.2f}{score.jitter:>7.3f}{score.flicker:>8.2f}"
            f"{score.births:>7.2f}{score.deaths:>7.2f}{result.psnr:>6.1f}{result.seconds:>7.2f}"
            f"{result.lottie_bytes / 1024:>7.1f}"
        )
    return "\n".join(lines)
