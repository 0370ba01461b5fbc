"""Tracks in the layouts that other programs read: JSON, a table, TAP-Vid, napari."""

from __future__ import annotations

import json
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from videovec.curves import arc_length
from videovec.events import EventKind
from videovec.stroke_life import StrokeLife
from videovec.stroke_shape import hex_colour
from videovec.track_set import TrackSet

__all__ = ["NapariTracks", "TapVid", "json_text", "napari_layout", "table", "tapvid_layout"]

Floats = NDArray[np.float64]
Ints = NDArray[np.intp]

_JSON_VERSION = 1


@dataclass(frozen=True, slots=True, eq=False)
class TapVid:
    """N material points over T frames, as the TAP-Vid benchmark stores them.

    Args:
        points: Positions x, y as fractions of width and height; the nearest known where occluded. [N, T, 2]
        occluded: Whether each point is hidden, or its stroke not alive. bool [N, T]
        query_points: First frame on which each point is seen, then y and x there in px. [N, 3]
        ids: Stroke of each point. int [N]
        u: Arc fraction of each point. [N]

    Source:
        C. Doersch et al. 2022, "TAP-Vid: A Benchmark for Tracking Any Point in a Video".
    """

    points: Floats
    occluded: NDArray[np.bool_]
    query_points: Floats
    ids: Ints
    u: Floats


@dataclass(frozen=True, slots=True, eq=False)
class NapariTracks:
    """Material points as a napari ``Tracks`` layer: ``viewer.add_tracks(it.data, properties=it.properties, ...)``.

    Args:
        data: Track, frame, y, x of every point on every frame on which it is seen, by track, then frame. [M, 4]
        properties: For every row of ``data``: ``stroke``, the identity, and ``u``, the arc fraction.
        graph: For the points of strokes that came from others by split or merge, the tracks they came from.
    """

    data: Floats
    properties: dict[str, NDArray[Any]]
    graph: dict[int, list[int]]


def json_text(tracks: TrackSet) -> str:
    """Tracks as JSON: the page, the frames with their times, every stroke on every drawing, the events.

    Numbers are in px to three decimals. A frame names its drawing, counted from 0; a stroke lists its drawings from the
    first to the last of its life, each with control points, half-widths at the joints, opacity, the visible arc
    fractions, and error and confidence of the fit.
    """
    height, width = tracks.size
    timeline = tracks.timeline
    numbers = timeline.frame_numbers.tolist()
    frames = [
        {"frame": number, "drawing": drawing, "time": float(time)}
        for number, drawing, time in zip(numbers, timeline.drawing_of_frame.tolist(), timeline.times, strict=True)
    ]
    numbers.append(numbers[-1] + 1)  # of an event that holds only after the last frame
    events = [
        {
            "kind": str(event.kind),
            "drawing": event.drawing,
            "frame": numbers[tracks.frame_of(event)],
            "ids": list(event.ids),
            "parents": list(event.parents),
            "score": round(float(event.score), 3),
        }
        for event in tracks.events
    ]
    document = {
        "format": "videovec tracks",
        "version": _JSON_VERSION,
        "name": tracks.name,
        "width": width,
        "height": height,
        "page": hex_colour(tracks.page),
        "frame_rate": str(timeline.frame_rate),
        "duration": str(timeline.duration),
        "frames": frames,
        "strokes": [_stroke(tracks, stroke) for stroke in range(len(tracks.strokes))],
        "events": events,
    }
    return json.dumps(document, separators=(",", ":")) + "\n"


def table(tracks: TrackSet) -> dict[str, list[Any]]:
    """Columns of a table with a row for every stroke on every frame of its life, by frame, then layer.

    Returns:
        ``frame`` (from 0), ``number`` (in the source), ``time`` (s), ``drawing``, ``id``, ``layer``, ``color``,
        ``is_closed``, ``length`` (px), ``half_width`` (mean over the joints, px), ``opacity``, ``visible_from`` and
        ``visible_to`` (arc fractions), ``x``, ``y`` (middle of the arc, px), ``error``, ``confidence``, ``points``
        (control points, x and y in turn, px) and ``half_widths`` (at the joints, px).
    """
    strokes, timeline = tracks.strokes, tracks.timeline
    lives = [StrokeLife.of(strokes, stroke) for stroke in range(len(strokes))]
    of_row = [_row_columns(life, k) for life in lives for k in range(len(life.points))]
    columns: dict[str, list[Any]] = {name: [] for name in _COLUMNS}
    for frame, drawing in enumerate(timeline.drawing_of_frame.tolist()):
        when = {
            "frame": frame,
            "number": int(timeline.frame_numbers[frame]),
            "time": float(timeline.times[frame]),
            "drawing": drawing,
        }
        for row in strokes.rows_at(drawing).tolist():
            fit = {"error": float(tracks.error[row]), "confidence": float(tracks.confidence[row])}
            for name, value in (when | of_row[row] | fit).items():
                columns[name].append(value)
    return columns


def tapvid_layout(tracks: TrackSet, spacing: float) -> TapVid:
    """Points at equal steps along every stroke that is ever seen; see :class:`TapVid`.

    Args:
        tracks: The strokes of a clip.
        spacing: About how far neighbouring points of a stroke lie from each other. px
    """
    ids, u, paths = _material_points(tracks, spacing)
    is_seen = _is_seen(paths)
    first = is_seen.argmax(1)
    frames = np.arange(tracks.timeline.frame_count)
    last_seen = np.maximum.accumulate(np.where(is_seen, frames, -1), axis=1)
    filled = np.take_along_axis(paths, np.where(last_seen < 0, first[:, None], last_seen)[..., None], axis=1)
    start = paths[np.arange(len(paths)), first]
    height, width = tracks.size
    return TapVid(
        points=filled / [width, height],
        occluded=np.logical_not(is_seen),
        query_points=np.concatenate([first[:, None], start[:, ::-1]], axis=1).astype(np.float64),
        ids=ids,
        u=u,
    )


def napari_layout(tracks: TrackSet, spacing: float) -> NapariTracks:
    """Points at equal steps along every stroke that is ever seen; see :class:`NapariTracks`."""
    ids, u, paths = _material_points(tracks, spacing)
    track, frame = np.nonzero(_is_seen(paths))
    places = paths[track, frame]
    data = np.column_stack([track, frame, places[:, 1], places[:, 0]]).astype(np.float64)
    graph: dict[int, list[int]] = {}
    for event in tracks.events:
        if event.kind in (EventKind.SPLIT, EventKind.MERGE):
            for child in np.flatnonzero(np.isin(ids, sorted(set(event.ids) - set(event.parents)))).tolist():
                parents = [_nearest_point(ids, u, parent, float(u[child])) for parent in event.parents]
                graph[child] = [parent for parent in parents if parent is not None]
    return NapariTracks(data, {"stroke": ids[track], "u": u[track]}, {k: v for k, v in graph.items() if v})


_COLUMNS = (
    *("frame", "number", "time", "drawing", "id", "layer", "color", "is_closed", "length", "half_width", "opacity"),
    *("visible_from", "visible_to", "x", "y", "error", "confidence", "points", "half_widths"),
)


def _stroke(tracks: TrackSet, stroke: int) -> dict[str, Any]:
    life = StrokeLife.of(tracks.strokes, stroke)
    start = int(tracks.strokes.layout.stroke_rows[stroke])
    return {
        "id": life.id,
        "closed": life.is_closed,
        "layer": life.layer,
        "color": hex_colour(life.color),
        "drawings": [
            {
                "drawing": life.first + k,
                "points": np.round(life.points[k], 3).tolist(),
                "half_width": np.round(life.half_width[k], 3).tolist(),
                "opacity": round(float(life.opacity[k]), 3),
                "visible": np.round(life.visible[k], 4).tolist(),
                "error": round(float(tracks.error[start + k]), 4),
                "confidence": round(float(tracks.confidence[start + k]), 4),
            }
            for k in range(len(life.points))
        ],
    }


def _row_columns(life: StrokeLife, k: int) -> dict[str, Any]:
    """What the table says of a stroke on one drawing."""
    shape = life.at(life.first + k)
    x, y = shape.positions(np.array([0.5]))[0].tolist()
    return {
        "id": life.id,
        "layer": life.layer,
        "color": hex_colour(life.color),
        "is_closed": life.is_closed,
        "length": arc_length(shape.points),
        "half_width": float(shape.half_width.mean()),
        "opacity": shape.opacity,
        "visible_from": shape.visible[0],
        "visible_to": shape.visible[1],
        "x": x,
        "y": y,
        "points": shape.points.ravel().tolist(),
        "half_widths": shape.half_width.tolist(),
    }


def _material_points(tracks: TrackSet, spacing: float) -> tuple[Ints, Floats, Floats]:
    """Stroke [N] and arc fraction [N] of evenly spaced points, and where they are seen, NaN elsewhere [N, T, 2]."""
    ids: list[int] = []
    fractions: list[float] = []
    paths = [np.zeros((0, tracks.timeline.frame_count, 2))]
    for track in tracks:
        longest = max(arc_length(points) for points in track.stroke.points)
        u = (np.arange(max(1, round(longest / spacing))) + 0.5) / max(1, round(longest / spacing))
        path = track.follow(u)
        is_seen = np.isfinite(path).any((1, 2))
        ids += [track.id] * int(is_seen.sum())
        fractions += u[is_seen].tolist()
        paths.append(path[is_seen])
    return np.array(ids, dtype=np.intp), np.array(fractions), np.concatenate(paths)


def _is_seen(paths: Floats) -> NDArray[np.bool_]:
    """Whether each point is anywhere on each frame. [N, T, 2] -> bool [N, T]"""
    return np.asarray(np.isfinite(paths[..., 0]))


def _nearest_point(ids: Ints, u: Floats, stroke: int, fraction: float) -> int | None:
    """The point of a stroke that lies nearest to an arc fraction."""
    own = np.flatnonzero(ids == stroke)
    return int(own[np.argmin(np.abs(u[own] - fraction))]) if len(own) else None
