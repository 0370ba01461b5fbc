"""From finished tracks to a folder of everything that is written of them."""

from __future__ import annotations

import io
from collections.abc import Iterator, Sequence
from pathlib import Path

from PIL import Image

from videovec.clip import Clip
from videovec.config import suggestion
from videovec.errors import ConfigError
from videovec.files import OutputFile, write_file, write_folder
from videovec.progress import Progress, Silent
from videovec.quality import measure
from videovec.settings import ExportSettings
from videovec.tracks import StrokeTracks
from videovec.write import WRITERS, Draft, get_writer
from videovec.write.report import report_html
from videovec.write.video import preview_image, preview_video

__all__ = ["FORMATS", "export"]

FORMATS = (*WRITERS, "preview", "report")


def export(
    tracks: StrokeTracks,
    clip: Clip | None,
    folder: Path,
    settings: ExportSettings | None = None,
    formats: Sequence[str] = FORMATS,
    progress: Progress | None = None,
) -> list[Path]:
    """Write tracks in every format asked for; each file, and the folder of frames, whole or not at all.

    Args:
        tracks: The strokes of a clip.
        clip: The clip, for preview and report; without it these show the strokes alone.
        folder: Where to; made where it is missing.
        settings: How to write.
        formats: Some of :data:`FORMATS`.
        progress: Told of every format.

    Returns:
        The files that were written.

    Raises:
        ConfigError: There is no such format.
        OutputError: The place cannot be written to.
    """
    settings, progress = settings or ExportSettings(), progress or Silent()
    for name in formats:
        if name not in FORMATS:
            raise ConfigError(f"unknown format {name}{suggestion(name, FORMATS)}; there are {', '.join(FORMATS)}")
    progress.stage("write", len(formats))
    draft = Draft(tracks, settings)
    written: list[Path] = []
    for name in formats:
        written += _write(folder, list(_files(name, draft, clip)))
        progress.advance()
    return written


def _files(name: str, draft: Draft, clip: Clip | None) -> Iterator[OutputFile]:
    """The files of a format: pictures show the clip too, everything else is made of the tracks alone."""
    if name == "preview":
        return _preview(draft.tracks, clip)
    return _report(draft.tracks, clip) if name == "report" else get_writer(name)(draft)


def _preview(tracks: StrokeTracks, clip: Clip | None) -> Iterator[OutputFile]:
    yield OutputFile("preview.mp4", preview_video(tracks, clip))
    if tracks.timeline.frame_count == 1:
        buffer = io.BytesIO()
        Image.fromarray(preview_image(tracks, clip, 0)).save(buffer, "png")
        yield OutputFile("preview.png", buffer.getvalue())


def _report(tracks: StrokeTracks, clip: Clip | None) -> Iterator[OutputFile]:
    psnr = None if clip is None else measure(clip, tracks).psnr
    yield OutputFile("report.html", report_html(tracks, clip, psnr).encode())


def _write(folder: Path, files: Sequence[OutputFile]) -> list[Path]:
    """Write files; those of a folder of their own replace it as a whole."""
    inner = {file.path.partition("/")[0] for file in files if "/" in file.path}
    for name in inner:
        own = [OutputFile(file.path.partition("/")[2], file.data) for file in files if file.path.startswith(f"{name}/")]
        write_folder(folder / name, own)
    for file in files:
        if "/" not in file.path:
            write_file(folder / file.path, file.data)
    return [folder / file.path for file in files]
