"""What comes out: pure functions from tracks to text, bytes and pictures."""

from __future__ import annotations

from collections.abc import Callable, Iterator

from videovec.config import suggestion
from videovec.errors import ConfigError
from videovec.files import OutputFile
from videovec.settings import ExportSettings
from videovec.tracks import StrokeTracks
from videovec.write.animated_svg import animated_svg_text
from videovec.write.lottie import dotlottie_bytes, lottie_text
from videovec.write.svg import svg_frames

__all__ = ["WRITERS", "Writer", "get_writer"]

Writer = Callable[[StrokeTracks, ExportSettings], Iterator[OutputFile]]


def get_writer(format_name: str) -> Writer:
    """The writer of a format, by its name.

    Raises:
        ConfigError: There is no such format.
    """
    if format_name not in WRITERS:
        hint = suggestion(format_name, WRITERS)
        raise ConfigError(f"unknown format {format_name}{hint}; there are {', '.join(WRITERS)}")
    return WRITERS[format_name]


def _svg(tracks: StrokeTracks, settings: ExportSettings) -> Iterator[OutputFile]:
    numbers = tracks.timeline.frame_numbers.tolist()
    for number, document in zip(numbers, svg_frames(tracks, settings.svg_style, settings.line_tolerance), strict=True):
        yield OutputFile(f"svg/frame_{number:04d}.svg", document.encode())


def _lottie(tracks: StrokeTracks, settings: ExportSettings) -> Iterator[OutputFile]:
    yield OutputFile("clip.json", lottie_text(tracks, settings).encode())


def _dotlottie(tracks: StrokeTracks, settings: ExportSettings) -> Iterator[OutputFile]:
    yield OutputFile("clip.lottie", dotlottie_bytes(lottie_text(tracks, settings)))


def _animated_svg(tracks: StrokeTracks, settings: ExportSettings) -> Iterator[OutputFile]:
    yield OutputFile("clip.svg", animated_svg_text(tracks, settings).encode())


def _npz(tracks: StrokeTracks, settings: ExportSettings) -> Iterator[OutputFile]:
    yield OutputFile("tracks.npz", tracks.to_bytes())


def _json(tracks: StrokeTracks, settings: ExportSettings) -> Iterator[OutputFile]:
    yield OutputFile("tracks.json", tracks.to_json().encode())


WRITERS: dict[str, Writer] = {
    "svg": _svg,
    "lottie": _lottie,
    "dotlottie": _dotlottie,
    "animated_svg": _animated_svg,
    "npz": _npz,
    "json": _json,
}
