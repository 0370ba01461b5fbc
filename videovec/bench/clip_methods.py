"""Ways from a clip to strokes over time: our pipelines, and tracers of single drawings linked afterwards."""

from __future__ import annotations

from collections.abc import Sequence

from videovec.bench.peers import TRACERS, installed
from videovec.clip import Clip
from videovec.fit import judge
from videovec.ink import extract_ink
from videovec.link import link
from videovec.progress import Progress, Silent
from videovec.render import resolve_backend
from videovec.run import find_pipeline
from videovec.settings import Config
from videovec.tracks import StrokeTracks

__all__ = ["DRAWING_TRACERS", "LINKED", "METHODS", "present_methods", "vectorise_by"]

METHODS = ("solid", "per_frame", "autotrace", "skeleton")
"""What is compared unless told otherwise."""
DRAWING_TRACERS = ("autotrace", "autotrace + our fit", "skeleton")
"""Tracers of centre lines, of `videovec.bench.peers.TRACERS`, that trace each drawing alone."""

LINKED = ("per_frame", *DRAWING_TRACERS)
"""Methods whose strokes are linked afterwards: control points of two drawings do not correspond."""


def present_methods(names: Sequence[str], progress: Progress) -> list[str]:
    """The methods of which everything is installed; what is left out is noted.

    Args:
        names: Of `DRAWING_TRACERS`, or files in ``pipelines/``.
        progress: Told of what is left out.

    Raises:
        ConfigError: There is no such method.
    """
    present = []
    for name in names:
        if name not in DRAWING_TRACERS:
            find_pipeline(name)
        elif not installed(TRACERS[name]):
            progress.note(f"{name} is left out: {TRACERS[name].needs} is not installed")
            continue
        present.append(name)
    return present


def vectorise_by(name: str, clip: Clip, config: Config) -> StrokeTracks:
    """Vectorise a clip by a method.

    Args:
        name: Of `DRAWING_TRACERS`, or a file in ``pipelines/``.
        clip: The clip.
        config: How videovec works, and how far apart linked strokes may lie.
    """
    if name not in DRAWING_TRACERS:
        return find_pipeline(name)(clip, config, Silent())
    ink = extract_ink(clip, config.ink)
    drawings = [
        TRACERS[name].trace(ink.at_drawing(drawing), config).strokes.shifted(drawing)
        for drawing in range(ink.drawing_count)
    ]
    strokes = link(drawings, config.propagate.search_range)
    return StrokeTracks.of(clip, ink, judge(ink, strokes, resolve_backend(config.render)))
