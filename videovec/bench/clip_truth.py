"""Folders of clips whose true strokes are known.

Each clip is one of three kinds: ``NAME/gt.npz`` (``ctrl [T, segments, 4, 2]`` px and ``seg_stroke [segments]``) beside
images ``0000.png ..``; ``NAME/gt.json`` (``frames[i].strokes[j]`` with ``id``, ``points`` and ``visible``) beside
``NAME.mp4`` or such images; or ``truth/NAME.json``, as in ``samples/``, beside the clip ``NAME`` itself.
"""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from videovec.errors import InputError
from videovec.true_strokes import TrueStroke

__all__ = ["TrueClip", "read_clips"]

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
    movie = path.with_name(f"{path.parent.name}.mp4")
    return TrueClip(path.parent.name, movie if movie.exists() else path.with_name("%04d.png"), true, False)


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
