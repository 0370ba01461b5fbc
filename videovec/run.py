"""The main job: a clip in, strokes with identities out, and a folder of everything that is written of them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import asdict, dataclass, field, replace
from importlib import import_module
from importlib.resources import files
from pathlib import Path
from typing import TypedDict

import numpy as np

from videovec.clip import Clip
from videovec.config import suggestion, validate
from videovec.correction import correct
from videovec.decode import decode
from videovec.doctor import library_versions
from videovec.errors import ConfigError, InputError
from videovec.export import FORMATS, export
from videovec.progress import Progress, Silent
from videovec.quality import Quality, measure
from videovec.render import prepare_backend, resolve_backend
from videovec.run_folder import TRACKS, RunFolder, RunRecord, default_folder, hash_of_clip, hash_of_config
from videovec.settings import Config
from videovec.stopwatch import Stopwatch
from videovec.tracks import StrokeTracks

__all__ = ["Outcome", "Plan", "Request", "carry_out", "find_pipeline", "prepare", "run", "track"]

GOES_ON = frozenset({"solid"})
"""Pipelines whose last stage is the fit, which can go on from strokes that it was interrupted with."""

Pipeline = Callable[[Clip, Config, Progress], StrokeTracks]


@dataclass(frozen=True, slots=True)
class Request:
    """What is to be done.

    Args:
        source: A video, an image, a folder of numbered images, or a pattern of them such as ``walk_%04d.png``.
        out: Folder to write to; ``NAME_videovec`` beside the clip unless told.
        config: All settings.
        frames: Which frames, counted from 0 and half-open as in Python.
        resume: Use the strokes of an earlier run of this clip with these settings.
        force: Write even into a folder that holds files of others.
        formats: What to write.
        correct: Edited SVG frames of the finished run, to be put back and fitted from there.
    """

    source: str | Path
    out: Path | None = None
    config: Config = field(default_factory=Config)
    frames: slice | None = None
    resume: bool = True
    force: bool = False
    formats: tuple[str, ...] = FORMATS
    correct: tuple[Path, ...] = ()


@dataclass(frozen=True, slots=True)
class Outcome:
    """What was done: the strokes, where they were written, and the record beside them."""

    tracks: StrokeTracks
    folder: RunFolder
    record: RunRecord


def run(
    path: str | Path,
    out: str | Path | None = None,
    *,
    config: Config | None = None,
    frames: slice | None = None,
    progress: Progress | None = None,
) -> StrokeTracks:
    """Vectorise a clip and write everything: SVG frames, Lottie, tracks and a preview.

    Args:
        path: A video, an image, a folder of numbered images, or a pattern of them such as ``walk_%04d.png``.
        out: Folder to write to; ``NAME_videovec`` beside the clip unless told.
        config: All settings; see ``configure``.
        frames: Which frames, counted from 0 and half-open as in Python; all unless told.
        progress: Told how far it is.

    Returns:
        The strokes of the clip, with their identities.

    Raises:
        InputError: The clip cannot be used.
        ConfigError: A setting does not fit.
        OutputError: The folder cannot be written to.
    """
    request = Request(path, None if out is None else Path(out), config or Config(), frames)
    return carry_out(request, progress).tracks


def track(
    path: str | Path,
    *,
    config: Config | None = None,
    frames: slice | None = None,
    progress: Progress | None = None,
) -> StrokeTracks:
    """Vectorise a clip and write nothing.

    Args:
        path: A video, an image, a folder of numbered images, or a pattern of them.
        config: All settings; see ``configure``.
        frames: Which frames, counted from 0 and half-open as in Python; all unless told.
        progress: Told how far it is.

    Returns:
        The strokes of the clip, with their identities.

    Raises:
        InputError: The clip cannot be used.
        ConfigError: A setting does not fit.
    """
    config, progress = config or Config(), progress or Silent()
    validate(config)
    backend = resolve_backend(config.render)
    pipeline = find_pipeline(config.pipeline)
    clip = decode(path, config.decode, frames, progress)
    prepare_backend(backend, progress)
    return pipeline(clip, config, progress)


def carry_out(request: Request, progress: Progress | None = None) -> Outcome:
    """Do what is asked; whenever it ends, what is finished is kept.

    A fit that Ctrl-C ends is written as far as it came, and the next run of the same goes on from there.

    Raises:
        UserError: The clip, a setting or the folder cannot be used.
        KeyboardInterrupt: The user wanted it to end.
    """
    watch = Stopwatch(progress or Silent())
    plan = prepare(request, watch)
    folder = plan.folder
    if request.correct:
        tracks, record = _corrected(plan, watch)
    elif plan.is_fitted:
        watch.note("neither clip nor settings have changed: the strokes of the last run are used again")
        tracks, record = StrokeTracks.load(folder.path / TRACKS), replace(plan.record, status="fitted")
    else:
        tracks, record = _fit(plan, watch)
    outputs = export(tracks, plan.clip, folder.path, request.config.export, request.formats, watch)
    written = {path.relative_to(folder.path).as_posix() for path in outputs}
    if plan.is_fitted:
        written |= set(plan.record.outputs)
    else:
        folder.remove_stale(set(plan.record.outputs) - written)
    record = replace(
        record,
        status="done" if tracks.is_finished else "unfinished",
        outputs=tuple(sorted(written)),
        seconds={**record.seconds, **watch.seconds()},
    )
    folder.write_record(record)
    if not tracks.is_finished:
        raise KeyboardInterrupt
    return Outcome(tracks, folder, record)


@dataclass(frozen=True, slots=True, eq=False)
class Plan:
    """A request that was found possible: the decoded clip, where results go, and what run.json says before it runs.

    The folder may hold the strokes (``is_fitted``), or what an interrupted fit had made of them (``is_begun``).
    """

    request: Request
    clip: Clip
    pipeline: Pipeline
    folder: RunFolder
    record: RunRecord
    is_fitted: bool
    is_begun: bool = False


def prepare(request: Request, progress: Progress) -> Plan:
    """Find out whether a request is possible, and decode the clip; nothing is written.

    Raises:
        UserError: The clip, a setting or the folder cannot be used.
    """
    validate(request.config)
    resolve_backend(request.config.render)
    pipeline = find_pipeline(request.config.pipeline)
    folder = RunFolder.claim(request.out or default_folder(request.source), force=request.force)
    clip = decode(request.source, request.config.decode, request.frames, progress)
    before = folder.record()
    record = _record_of(request, clip)
    is_fitted = request.resume and before is not None and before.is_fitted_as(record) and folder.has_tracks()
    if before is not None:
        kept = before if is_fitted else replace(record, outputs=before.outputs)
        record = replace(kept, config=record.config)
    is_begun = request.resume and before is not None and before.is_begun_as(record) and folder.has_tracks()
    return Plan(request, clip, pipeline, folder, record, is_fitted, is_begun)


def find_pipeline(name: str) -> Pipeline:
    """The pipeline of a name: the function ``run`` of the module ``videovec.pipelines.NAME``.

    Raises:
        ConfigError: There is none.
    """
    module = f"videovec.pipelines.{name}"
    try:
        return import_module(module).run  # type: ignore[no-any-return]
    except ModuleNotFoundError as error:
        if error.name != module:
            raise
    entries = (entry.name for entry in files("videovec.pipelines").iterdir())
    names = sorted(entry[:-3] for entry in entries if entry.endswith(".py") and not entry.startswith("_"))
    raise ConfigError(f"unknown pipeline {name}{suggestion(name, names) or '; there are ' + ', '.join(names)}")


def _fit(plan: Plan, watch: Stopwatch) -> tuple[StrokeTracks, RunRecord]:
    """Run the pipeline, and save its strokes before anything else is done with them."""
    folder, record = plan.folder, plan.record
    folder.write_record(record)
    try:
        prepare_backend(resolve_backend(plan.request.config.render), watch)
        if plan.is_begun and plan.request.config.pipeline in GOES_ON:
            watch.note("the last run was interrupted while it fitted: this one goes on from its strokes")
            tracks = correct(StrokeTracks.load(folder.path / TRACKS), plan.clip, (), plan.request.config, watch)
        else:
            tracks = plan.pipeline(plan.clip, plan.request.config, watch)
    except BaseException as error:
        status = "interrupted" if isinstance(error, KeyboardInterrupt) else "failed"
        folder.write_record(replace(record, status=status, seconds=watch.seconds()))
        raise
    if not tracks.is_finished:
        watch.note("interrupted: the strokes are kept and written as far as they are fitted; run it again to go on")
    tracks.save(folder.path / TRACKS)
    quality = measure(plan.clip, tracks, plan.request.config.render, watch)
    status = "fitted" if tracks.is_finished else "unfinished"
    record = replace(record, status=status, seconds=watch.seconds(), **_figures(tracks, quality))
    folder.write_record(record)
    return tracks, record


def _corrected(plan: Plan, watch: Stopwatch) -> tuple[StrokeTracks, RunRecord]:
    """Put edited frames back into the strokes of the finished run, and save what comes of it."""
    folder = plan.folder
    if not plan.is_fitted:
        raise InputError(f"{folder.path} must hold a finished run of this clip with these settings; run it first")
    prepare_backend(resolve_backend(plan.request.config.render), watch)
    before = StrokeTracks.load(folder.path / TRACKS)
    tracks = correct(before, plan.clip, plan.request.correct, plan.request.config, watch)
    tracks.save(folder.path / TRACKS)
    quality = measure(plan.clip, tracks, plan.request.config.render, watch)
    record = replace(plan.record, status="fitted", **_figures(tracks, quality))
    folder.write_record(record)
    return tracks, record


def _record_of(request: Request, clip: Clip) -> RunRecord:
    versions, chosen = library_versions(), request.frames or slice(None)
    height, width = clip.size
    timeline = clip.timeline
    facts = {"frames": timeline.frame_count, "drawings": timeline.drawing_count, "height": height, "width": width}
    return RunRecord(
        status="running",
        source=str(Path(request.source).absolute()),
        frames=(chosen.start, chosen.stop, chosen.step),
        clip={**facts, "seconds": float(timeline.duration), "frame_rate": float(timeline.frame_rate)},
        clip_hash=hash_of_clip(clip),
        config_hash=hash_of_config(request.config, versions["videovec"]),
        config=asdict(request.config),
        versions=versions,
    )


class _Figures(TypedDict):
    metrics: dict[str, float]
    frame_errors: tuple[float, ...]


def _figures(tracks: StrokeTracks, quality: Quality) -> _Figures:
    """What run.json says of the strokes: how many there are, how long they live and how well they draw the clip."""
    layout = tracks.strokes.layout
    metrics = {
        "strokes": len(tracks.strokes),
        "mean_life_drawings": round(float((layout.last - layout.first + 1).mean()), 2) if len(tracks.strokes) else 0.0,
        "psnr_median_db": round(float(np.median(quality.psnr)), 2),
        "psnr_worst_db": round(float(quality.psnr.min()), 2),
    }
    errors = quality.error[tracks.timeline.drawing_of_frame]
    return {"metrics": metrics, "frame_errors": tuple(round(float(error), 4) for error in errors)}
