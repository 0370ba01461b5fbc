"""What comes out: pure functions from tracks to text, bytes and pictures."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from functools import cached_property

from videovec.brush import brush_files, solid_strokes
from videovec.config import suggestion
from videovec.errors import ConfigError
from videovec.files import OutputFile
from videovec.settings import ExportSettings
from videovec.tracks import StrokeTracks
from videovec.write.animated_svg import animated_svg_text
from videovec.write.lottie import dotlottie_bytes, lottie_text
from videovec.write.motion import StrokeMotion, stroke_motions
from videovec.write.svg import svg_frames
from videovec.write.textured import lottie_of_pictures, picture_frames
from videovec.write.time_base import time_base

__all__ = ["WRITERS", "Draft", "Writer", "get_writer"]


@dataclass(frozen=True, eq=False)
class Draft:
    """What is to be written, and what several formats make of it on the way.

    Args:
        tracks: The strokes of a clip.
        settings: How to write.
    """

    tracks: StrokeTracks
    settings: ExportSettings

    @cached_property
    def even(self) -> StrokeTracks:
        """The tracks with textured strokes as even ones of the same mean density, for formats that know no texture."""
        brushwork = self.tracks.brushwork
        if brushwork is None:
            return self.tracks
        return replace(self.tracks, strokes=solid_strokes(brushwork, self.tracks.strokes), brushwork=None)

    @property
    def keeps_texture(self) -> bool:
        """Whether strokes are to be written as pictures of themselves."""
        return self.tracks.brushwork is not None and self.settings.texture == "image"

    @cached_property
    def motions(self) -> tuple[StrokeMotion, ...]:
        """The strokes as moving paths."""
        return tuple(stroke_motions(self.even, time_base(self.tracks.timeline), self.settings))

    @cached_property
    def lottie(self) -> str:
        """The clip as a Lottie document."""
        if self.keeps_texture:
            return lottie_of_pictures(self.tracks)
        return lottie_text(self.even, self.settings, self.motions)


Writer = Callable[[Draft], Iterator[OutputFile]]


def get_writer(format_name: str) -> Writer:
    """The writer of a format, by its name.

    Raises:
        ConfigError: There is no such format.
    """
    if format_name not in WRITERS:
        hint = suggestion(format_name, WRITERS)
        raise ConfigError(f"unknown format {format_name}{hint}; there are {', '.join(WRITERS)}")
    return WRITERS[format_name]


def _svg(draft: Draft) -> Iterator[OutputFile]:
    numbers = draft.tracks.timeline.frame_numbers.tolist()
    if draft.keeps_texture:
        documents = picture_frames(draft.tracks)
    else:
        documents = svg_frames(draft.even, draft.settings.svg_style, draft.settings.line_tolerance)
    for number, document in zip(numbers, documents, strict=True):
        yield OutputFile(f"svg/frame_{number:04d}.svg", document.encode())


def _lottie(draft: Draft) -> Iterator[OutputFile]:
    yield OutputFile("clip.json", draft.lottie.encode())


def _dotlottie(draft: Draft) -> Iterator[OutputFile]:
    yield OutputFile("clip.lottie", dotlottie_bytes(draft.lottie))


def _animated_svg(draft: Draft) -> Iterator[OutputFile]:
    yield OutputFile("clip.svg", animated_svg_text(draft.even, draft.settings, draft.motions).encode())


def _brush(draft: Draft) -> Iterator[OutputFile]:
    brushwork = draft.tracks.brushwork
    for brush in brushwork.brushes if brushwork else ():
        yield from (OutputFile(f"brush/{name}", data) for name, data in brush_files(brush))


def _npz(draft: Draft) -> Iterator[OutputFile]:
    yield OutputFile("tracks.npz", draft.tracks.to_bytes())


def _json(draft: Draft) -> Iterator[OutputFile]:
    yield OutputFile("tracks.json", draft.tracks.to_json().encode())


WRITERS: dict[str, Writer] = {
    "svg": _svg,
    "lottie": _lottie,
    "dotlottie": _dotlottie,
    "animated_svg": _animated_svg,
    "npz": _npz,
    "json": _json,
    "brush": _brush,
}
