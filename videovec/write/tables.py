"""Tracks as text that people and other programs read."""

from __future__ import annotations

import json
from typing import Any

import numpy as np
from numpy.typing import NDArray

from videovec.tracks import StrokeTracks
from videovec.write.svg import hex_colour

__all__ = ["json_text"]

_VERSION = 1


def json_text(tracks: StrokeTracks) -> str:
    """Tracks as JSON: the page, the frames with their times, every stroke on every drawing, the events.

    Numbers are in px to three decimals. A frame names its drawing, counted from 0; a stroke lists its drawings from the
    first to the last of its life, each with control points, half-widths at the joints, opacity, the visible arc
    fractions, and error and confidence of the fit.
    """
    height, width = tracks.size
    timeline = tracks.timeline
    frames = [
        {"frame": int(number), "drawing": int(drawing), "time": float(time)}
        for number, drawing, time in zip(timeline.frame_numbers, timeline.drawing_of_frame, timeline.times, strict=True)
    ]
    events = [
        {
            "kind": str(event.kind),
            "drawing": event.drawing,
            "frame": int(timeline.frame_numbers[np.searchsorted(timeline.drawing_of_frame, event.drawing)]),
            "ids": list(event.ids),
            "parents": list(event.parents),
            "score": round(float(event.score), 3),
        }
        for event in tracks.events
    ]
    document = {
        "format": "videovec tracks",
        "version": _VERSION,
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


def _stroke(tracks: StrokeTracks, stroke: int) -> dict[str, Any]:
    strokes = tracks.strokes
    rows = range(*strokes.layout.stroke_rows[stroke : stroke + 2].tolist())
    return {
        "id": int(strokes.ids[stroke]),
        "closed": bool(strokes.is_closed[stroke]),
        "layer": int(strokes.layer[stroke]),
        "color": hex_colour(strokes.color[stroke]),
        "drawings": [
            {
                "drawing": int(strokes.layout.row_drawing[row]),
                "points": _rounded(strokes.points_of(row)),
                "half_width": _rounded(strokes.half_width_of(row)),
                "opacity": round(float(strokes.opacity[row]), 3),
                "visible": np.round(strokes.visible[row], 4).tolist(),
                "error": round(float(tracks.error[row]), 4),
                "confidence": round(float(tracks.confidence[row]), 4),
            }
            for row in rows
        ],
    }


def _rounded(array: NDArray[np.float64]) -> Any:
    return np.round(array, 3).tolist()
