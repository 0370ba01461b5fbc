"""Corrections of identities by hand, each giving new tracks that remember it as an event.

Nothing is fitted again: curves stay where they are, so that corrected tracks can be exported at once.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace
from typing import TypeVar

import numpy as np

from videovec.errors import InputError
from videovec.events import Event, EventKind
from videovec.life_edits import join_in_space, join_in_time, split_in_space, split_in_time
from videovec.stroke_track import StrokeTrack
from videovec.strokes import Strokes
from videovec.track_set import TrackSet

__all__ = ["drop", "merge", "rename", "reverse", "split"]

Tracks = TypeVar("Tracks", bound=TrackSet)
"""The same kind of tracks comes out as went in."""


def merge(tracks: Tracks, first: int, second: int) -> Tracks:
    """Make one stroke of two; see ``StrokeTracks.merge``."""
    if first == second:
        raise InputError(f"a stroke cannot be merged with itself, got {first} twice")
    a, b = tracks[first], tracks[second]
    if a.stroke.last < b.stroke.first or b.stroke.last < a.stroke.first:
        early, late = (a, b) if a.stroke.last < b.stroke.first else (b, a)
        joined = join_in_time(early.stroke, late.stroke)
        gap = np.zeros(late.stroke.first - early.stroke.last - 1)
        error = np.concatenate([early.error, gap, late.error])
        confidence = np.concatenate([early.confidence, gap, late.confidence])
        drawing = late.stroke.first
    else:
        joined = join_in_space(a.stroke, b.stroke)
        error = np.sqrt((a.error**2 + b.error**2) / 2)
        confidence = np.minimum(a.confidence, b.confidence)
        drawing = joined.first
    merged = StrokeTrack(replace(joined, id=first, layer=a.stroke.layer), tracks.timeline, error, confidence)
    event = Event(EventKind.MERGE, drawing, (first,), (first, second))
    return _with(_without_id(tracks, second), {first: [merged], second: []}, event)


def split(tracks: Tracks, stroke: int, u: float | None, frame: int | None) -> Tracks:
    """Make two strokes of one; see ``StrokeTracks.split``."""
    track = tracks[stroke]
    new_id = int(tracks.strokes.ids.max()) + 1
    if u is not None and frame is None:
        parts = split_in_space(track.stroke, u, new_id)
        pieces = [StrokeTrack(part, tracks.timeline, track.error, track.confidence) for part in parts]
        drawing = track.stroke.first
    elif frame is not None and u is None:
        tracks.check_frame(frame)
        drawing = int(tracks.timeline.drawing_of_frame[frame])
        at = drawing - track.stroke.first
        parts = split_in_time(track.stroke, drawing, new_id)
        pieces = [
            StrokeTrack(part, tracks.timeline, track.error[rows], track.confidence[rows])
            for part, rows in zip(parts, (slice(at), slice(at, None)), strict=True)
        ]
    else:
        raise InputError(f"a split needs either an arc fraction u or a frame, got u={u} and frame={frame}")
    return _with(tracks, {stroke: pieces}, Event(EventKind.SPLIT, drawing, (stroke, new_id), (stroke,)))


def rename(tracks: Tracks, old: int, new: int) -> Tracks:
    """Give a stroke another identity; see ``StrokeTracks.rename``."""
    position = tracks.position(old)
    if new < 1 or (new != old and new in tracks.strokes.ids):
        raise InputError(f"stroke {old} must be given an unused identity from 1, got {new}")
    ids = tracks.strokes.ids.copy()
    ids[position] = new
    parent = np.where(tracks.strokes.parent == old, new, tracks.strokes.parent)
    names = {old: new}
    events = tuple(
        replace(
            event,
            ids=tuple(names.get(one, one) for one in event.ids),
            parents=tuple(names.get(one, one) for one in event.parents),
        )
        for event in tracks.events
    )
    return replace(tracks, strokes=replace(tracks.strokes, ids=ids, parent=parent), events=events)


def drop(tracks: Tracks, strokes: Iterable[int]) -> Tracks:
    """Leave strokes out; see ``StrokeTracks.drop``."""
    for stroke in list(strokes):
        tracks = _with(_without_id(tracks, stroke), {stroke: []})
    return tracks


def reverse(tracks: Tracks, stroke: int) -> Tracks:
    """Run a stroke the other way; see ``StrokeTracks.reverse``."""
    whole = int(tracks.strokes.parent[tracks.position(stroke)]) or stroke
    together = [track for track in tracks if whole in (track.id, track.stroke.parent)]  # parts share arc fractions
    turned: dict[int, Sequence[StrokeTrack]] = {
        track.id: [replace(track, stroke=track.stroke.reversed())] for track in together
    }
    edited = _with(tracks, turned)
    return replace(edited, strokes=replace(edited.strokes, parent=tracks.strokes.parent))


def _without_id(tracks: Tracks, stroke: int) -> Tracks:
    """The same tracks, with events that no longer speak of a stroke; those of it alone are gone."""
    tracks.position(stroke)
    kept = []
    for event in tracks.events:
        ids = tuple(one for one in event.ids if one != stroke)
        if ids or event.kind is EventKind.CUT:
            kept.append(replace(event, ids=ids))
    return replace(tracks, events=tuple(kept))


def _with(tracks: Tracks, changed: dict[int, Sequence[StrokeTrack]], event: Event | None = None) -> Tracks:
    """The same tracks with others in the place of some, and an event more."""
    every = [one for track in tracks for one in changed.get(track.id, [track])]
    events = sorted([*tracks.events, *([event] if event else [])], key=lambda one: one.drawing)
    nothing = [np.zeros(0)]
    strokes = _on_their_own(Strokes.concatenate([track.stroke.as_strokes() for track in every]), changed)
    brushwork = tracks.brushwork
    return replace(
        tracks,
        strokes=strokes,
        brushwork=None if brushwork is None else brushwork.carried_to(tracks.strokes, strokes),
        events=tuple(events),
        error=np.concatenate([*nothing, *(track.error for track in every)]),
        confidence=np.concatenate([*nothing, *(track.confidence for track in every)]),
    )


def _on_their_own(strokes: Strokes, changed: dict[int, Sequence[StrokeTrack]]) -> Strokes:
    """The strokes, of which those that were changed share no arc fractions with the part beyond a gap any more."""
    new = [*changed, *(track.id for tracks in changed.values() for track in tracks)]
    is_apart = np.isin(strokes.ids, new) | np.isin(strokes.parent, new)
    return replace(strokes, parent=np.where(is_apart, 0, strokes.parent))
