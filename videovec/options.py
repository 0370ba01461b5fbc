"""The options that commands share, and what the exit status means."""

from __future__ import annotations

import re
from enum import IntEnum
from pathlib import Path
from typing import Annotated

import typer

from videovec.errors import ConfigError

__all__ = [
    "AsJson",
    "Correct",
    "Device",
    "DryRun",
    "Exit",
    "Force",
    "Formats",
    "Frames",
    "Fresh",
    "Init",
    "MaxError",
    "Out",
    "Preset",
    "Quiet",
    "Reference",
    "RunPath",
    "Seed",
    "Settings",
    "Source",
    "Strokes",
    "SvgStyle",
    "parse_frames",
]


class Exit(IntEnum):
    """What the exit status means."""

    DONE = 0
    OUR_FAULT = 1
    USER_FAULT = 2
    ABOVE_ERROR = 3
    INTERRUPTED = 130


Source = Annotated[
    str, typer.Argument(metavar="CLIP", help="A video, gif, image, folder of images, or pattern: walk_%04d.png.")
]
Out = Annotated[
    Path | None, typer.Option("-o", "--out", help="Folder to write to.", show_default="CLIP_videovec beside it")
]
Frames = Annotated[
    str | None, typer.Option(metavar="A:B", help="Frames A to B, both included, the first is 1.", show_default="all")
]
Preset = Annotated[str | None, typer.Option(help="A preset by name, or a YAML file; see videovec settings.")]
Settings = Annotated[
    list[str] | None, typer.Option("-s", "--set", metavar="KEY=VALUE", help="Change a setting; may be repeated.")
]
Device = Annotated[str | None, typer.Option(help="auto, cpu, cuda, cuda:1 ...")]
Seed = Annotated[int | None, typer.Option(help="Seed of all randomness.")]
AsJson = Annotated[bool, typer.Option("--json", help="Print the result as JSON on stdout.")]
Fresh = Annotated[bool, typer.Option("--fresh", help="Do not use strokes of an earlier run.")]
Force = Annotated[bool, typer.Option("--force", help="Write into a folder that holds files of others.")]
Quiet = Annotated[bool, typer.Option("-q", "--quiet", help="Show no progress.")]
DryRun = Annotated[bool, typer.Option("--dry-run", help="Say what would be done, and do nothing.")]
MaxError = Annotated[
    float | None,
    typer.Option(min=0.0, help="Exit with 3 if a frame's error is above this; 0 is perfect, 1 an empty page."),
]
SvgStyle = Annotated[str | None, typer.Option(help="auto, stroke, outline or powerstroke.")]
Reference = Annotated[
    Path | None, typer.Option(help="An artist's SVG of the first frame, whose strokes are taken.", metavar="SVG")
]
Correct = Annotated[
    list[Path] | None,
    typer.Option(metavar="SVG", help="An edited frame of the finished run, put back; may be repeated."),
]
Init = Annotated[str | None, typer.Option("--init", help="Where first strokes come from: trace or random.")]
Strokes = Annotated[int | None, typer.Option("--strokes", help="Number of random first strokes.")]
Formats = Annotated[
    list[str] | None,
    typer.Option("-f", "--format", help="svg, lottie, preview ...; may be repeated.", show_default="all"),
]
RunPath = Annotated[Path, typer.Argument(metavar="RUN", help="Folder of a finished run.")]


def parse_frames(text: str | None) -> slice | None:
    """``A:B`` of the command line, both included and counted from 1, as a slice; negative numbers count from the end.

    Raises:
        ConfigError: It is something else.
    """
    if text is None:
        return None
    match = re.fullmatch(r"(-?\d+)|(-?\d+)?:(-?\d+)?", text.strip())
    if match is None or "0" in match.groups():
        raise ConfigError(f"--frames must be A:B with frames counted from 1, such as 1:24 or 10:, got {text!r}")
    first, last = (match[1], match[1]) if match[1] else (match[2], match[3])
    start = None if first is None else int(first) - (int(first) > 0)
    stop = None if last is None else (int(last) + (int(last) < 0)) or None
    return slice(start, stop)
