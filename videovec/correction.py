"""Corrections by hand: an edited SVG of one frame is put back, honoured there, and carried to its neighbours."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
from numpy.typing import NDArray

from videovec.clip import Clip
from videovec.corrected_shapes import carried_change, reshaped, widened
from videovec.errors import InputError
from videovec.events import Event, EventKind
from videovec.fit import Pin, fit
from videovec.initialise import initialise
from videovec.ink import Ink, extract_ink
from videovec.progress import Progress, Silent
from videovec.propagate import propagate
from videovec.reference import DrawnStrokes, read_drawn
from videovec.settings import Config
from videovec.stroke_life import StrokeLife
from videovec.stroke_shape import StrokeShape, shape_of_row
from videovec.strokes import Strokes
from videovec.tracks import StrokeTracks
from videovec.write.svg import svg_frame

__all__ = ["correct", "frame_of_file"]

Floats = NDArray[np.float64]

_UNMOVED = 0.05  # px by which a path may differ from the one that was written and still be the same
_WIDENED = 0.02  # px by which a half-width may differ from the one that was written and still be the same
_RECOLOURED = 1.5 / 255  # by which a channel of a colour may differ from the one that was written
_PROPORTION = 0.005  # by which the proportions of a corrected document may differ from the page's


def frame_of_file(path: Path, tracks: StrokeTracks) -> int:
    """The position of the frame that a file such as ``frame_0012.svg`` shows.

    Raises:
        InputError: Its name ends in no number, or the tracks have no such frame.
    """
    digits = "".join(c if c.isdigit() else " " for c in path.stem).split()
    numbers = tracks.timeline.frame_numbers
    if not digits or not path.stem[-1].isdigit():
        raise InputError(f"{path}: must be named for its frame, such as frame_0012.svg")
    found = np.flatnonzero(numbers == int(digits[-1]))
    if not len(found):
        raise InputError(f"{path}: must show one of the frames {numbers[0]}..{numbers[-1]}, got {int(digits[-1])}")
    return int(found[0])


def correct(
    tracks: StrokeTracks,
    clip: Clip,
    svgs: Sequence[str | Path],
    config: Config | None = None,
    progress: Progress | None = None,
) -> StrokeTracks:
    """Put edited SVG frames of a finished run back, and fit on from there.

    Strokes that were moved, reshaped or made wider are held as they were put there and carried to the drawings around;
    strokes that were recoloured are so on all of their drawings; strokes that were deleted end there, or are left out
    if they began there; paths without an identity become strokes that are followed through the clip. All other strokes
    stay as they are.

    Args:
        tracks: The strokes of the run.
        clip: Its clip.
        svgs: Edited SVG frames, named for their frames as the run wrote them: ``frame_0012.svg``.
        config: The settings of the run.
        progress: Told how far it is.

    Returns:
        The corrected strokes, fitted to the clip.

    Raises:
        InputError: A file is no SVG of a frame of the run: another size, an unknown identity, nothing stroked.
    """
    config, progress = config or Config(), progress or Silent()
    ink = extract_ink(clip, config.ink, progress)
    pins: set[Pin] = set()
    for path in map(Path, svgs):
        frame = frame_of_file(path, tracks)
        drawn = read_drawn(path, tracks.size)
        _check(path, drawn, tracks, frame)
        tracks, held = _put_back(tracks, ink, (frame, drawn), config, progress)
        pins |= held
    pins |= _untouched(tracks.strokes, {identity for identity, _ in pins})
    result = fit(ink, tracks.strokes, config.fit, config.render, progress, frozenset(pins))
    return StrokeTracks.of(clip, ink, result, tracks.events)


def _untouched(strokes: Strokes, touched: set[int]) -> set[Pin]:
    """All drawings of the strokes that no correction speaks of, nor of the stroke whose part beyond a gap they are."""
    layout = strokes.layout
    families = np.where(strokes.parent > 0, strokes.parent, strokes.ids)
    moves = np.isin(families, families[np.isin(strokes.ids, list(touched))])
    rows = np.flatnonzero(~moves[layout.row_stroke])
    return set(zip(strokes.ids[layout.row_stroke[rows]].tolist(), layout.row_drawing[rows].tolist(), strict=True))


def _check(path: Path, drawn: DrawnStrokes, tracks: StrokeTracks, frame: int) -> None:
    height, width = drawn.document
    if abs(width / height / (tracks.size[1] / tracks.size[0]) - 1) > _PROPORTION:
        page = f"{tracks.size[1]} x {tracks.size[0]}"
        raise InputError(f"{path}: must have the size of the page, {page} px, got {width:g} x {height:g}")
    alive = {shape.id for shape in tracks.at_frame(frame)}
    unknown = sorted(set(drawn.ids[drawn.ids > 0].tolist()) - alive)
    if unknown:
        raise InputError(
            f"{path}: data-stroke-id must be that of a stroke on frame {tracks.timeline.frame_numbers[frame]}, "
            f"got {', '.join(map(str, unknown))}; a new path has none"
        )


def _written(tracks: StrokeTracks, frame: int, config: Config) -> dict[int, StrokeShape]:
    """The strokes of a frame as our own file shows them, by identity."""
    with TemporaryDirectory() as folder:
        path = Path(folder) / "frame.svg"
        path.write_text(svg_frame(tracks, frame, config.export.svg_style), encoding="utf-8")
        try:
            ours = read_drawn(path, tracks.size)
        except InputError:
            return {}
    return {int(one): shape_of_row(ours.strokes, row) for row, one in enumerate(ours.ids)}


def _put_back(
    tracks: StrokeTracks, ink: Ink, shown: tuple[int, DrawnStrokes], config: Config, progress: Progress
) -> tuple[StrokeTracks, set[Pin]]:
    """The tracks with one frame's edits, not yet fitted, and the rows that are to stay."""
    frame, drawn = shown
    drawing = int(tracks.timeline.drawing_of_frame[frame])
    before = _written(tracks, frame, config)
    lives = {life.id: life for life in (StrokeLife.of(tracks.strokes, s) for s in range(len(tracks)))}
    events = list(tracks.events)
    pins: set[Pin] = set()
    named = {int(one): row for row, one in enumerate(drawn.ids) if one > 0}
    for identity, row in named.items():
        old, new, life = before.get(identity), shape_of_row(drawn.strokes, row), lives[identity]
        if old is None or np.abs(new.color - old.color).max() > _RECOLOURED:
            life = replace(life, color=new.color)  # a stroke has one ink, on all of its drawings
        if old is None or not _is_same(old.points, new.points, _UNMOVED):
            life = carried_change(life, drawing, reshaped(life, drawing, new.points), ink)
            pins.add((identity, drawing))
        if old is not None and not _is_same(old.half_width, new.half_width, _WIDENED):
            life = widened(life, drawing, old, new)
            pins.add((identity, drawing))
        lives[identity] = life
    for identity in sorted(set(before) - set(named)):
        life = lives.pop(identity)
        events = [event for event in events if event.drawing < drawing or identity not in event.ids]
        if life.first < drawing:
            lives[identity] = life.between(life.first, drawing - 1)
            events.append(Event(EventKind.DEATH, drawing, (identity,)))
    strokes = Strokes.concatenate([life.as_strokes() for life in lives.values()])
    added = drawn.strokes.select(drawn.ids == 0)
    if len(added):
        next_id = int(tracks.strokes.ids.max(initial=0)) + 1
        added = replace(
            added, ids=next_id + np.arange(len(added)), layer=strokes.layer.max(initial=0) + 1 + added.layer
        )
        grown, births = _followed(strokes, added, (drawing, ink), config, progress)
        strokes = Strokes.concatenate([strokes, grown])
        events += births
        pins |= {(int(one), drawing) for one in added.ids}
    rows = np.zeros(strokes.row_count)
    events.sort(key=lambda event: event.drawing)
    return replace(tracks, strokes=strokes, events=tuple(events), error=rows, confidence=rows), pins


def _is_same(before: Floats, after: Floats, tolerance: float) -> bool:
    return before.shape == after.shape and bool(np.abs(before - after).max() <= tolerance)


def _followed(
    strokes: Strokes, added: Strokes, place: tuple[int, Ink], config: Config, progress: Progress
) -> tuple[Strokes, list[Event]]:
    """New strokes of one drawing over all drawings, followed beside those that there are; and their events."""
    drawing, ink = place
    nearest = np.linalg.norm(added.color[:, None] - ink.palette, axis=2).argmin(axis=1)
    added = replace(added, color=ink.palette[nearest]).shifted(drawing)
    there = Strokes.concatenate([strokes.at_drawing(drawing), added])
    trace = partial(initialise, settings=config.initialise)
    carried = propagate(ink, there, config.propagate, trace, progress)
    is_new = np.isin(carried.strokes.ids, added.ids)
    events = [event for event in carried.events if set(event.ids) & set(added.ids.tolist())]
    return carried.strokes.select(is_new), events
