"""Tracks as named arrays and back, without pickle: what an ``.npz`` of tracks holds."""

from __future__ import annotations

import io
import zipfile
from collections.abc import Mapping
from dataclasses import replace
from fractions import Fraction

import numpy as np
from numpy.typing import NDArray

from videovec.brushwork import Brush, BrushModel, Brushwork, Laying
from videovec.clip import Timeline
from videovec.errors import InputError
from videovec.events import Event, EventKind
from videovec.strokes import Layout, Strokes

__all__ = [
    "pack",
    "pack_brushwork",
    "pack_events",
    "pack_strokes",
    "pack_timeline",
    "unpack",
    "unpack_brushwork",
    "unpack_events",
    "unpack_strokes",
    "unpack_timeline",
]

_VERSION = 1

Arrays = dict[str, NDArray[np.generic]]

_LAYING_FIELDS = ("sign", "phase", "density", "shift")
_STROKE_FIELDS = ("ids", "is_closed", "layer", "color", "points", "half_width", "opacity", "visible", "parent")
_LAYOUT_FIELDS = ("segments", "first", "last")


def pack(arrays: Mapping[str, NDArray[np.generic]]) -> bytes:
    """Arrays and the version of this format as a compressed ``.npz``, the same bytes for the same arrays."""
    buffer = io.BytesIO()
    named = {"format_version": np.array(_VERSION), **arrays}
    with zipfile.ZipFile(buffer, "w", zipfile.ZIP_DEFLATED) as archive:
        for name in sorted(named):
            entry = zipfile.ZipInfo(f"{name}.npy")  # dated 1980, whenever it is made
            entry.compress_type = zipfile.ZIP_DEFLATED
            content = io.BytesIO()
            np.lib.format.write_array(content, np.asarray(named[name], order="C"), allow_pickle=False)
            archive.writestr(entry, content.getvalue())
    return buffer.getvalue()


def unpack(data: bytes, source: str) -> Arrays:
    """The arrays in the bytes of an ``.npz`` of tracks.

    Args:
        data: What :func:`pack` gave.
        source: What to call it in an error.

    Raises:
        InputError: It is no archive of tracks, or one of another version.
    """
    try:
        with np.load(io.BytesIO(data), allow_pickle=False) as archive:
            arrays = {name: archive[name] for name in archive.files}
        version = int(arrays["format_version"])
    except (ValueError, KeyError, EOFError, OSError, zipfile.BadZipFile) as error:
        raise InputError(f"{source} must be tracks that videovec saved, got something else: {error}") from error
    if version != _VERSION:
        raise InputError(f"{source} must be tracks of version {_VERSION}, got version {version}")
    return arrays


def pack_strokes(strokes: Strokes) -> Arrays:
    """Strokes as arrays, exactly."""
    arrays: Arrays = {name: getattr(strokes, name) for name in _STROKE_FIELDS}
    return arrays | {name: getattr(strokes.layout, name) for name in _LAYOUT_FIELDS}


def unpack_strokes(arrays: Arrays) -> Strokes:
    """The strokes that :func:`pack_strokes` took."""
    layout = Layout(*(arrays[name].astype(np.intp) for name in _LAYOUT_FIELDS))
    fields = {name: arrays[name] for name in _STROKE_FIELDS if name in arrays}  # older tracks know no gaps
    return Strokes(layout=layout, **fields)  # type: ignore[arg-type]


def pack_timeline(timeline: Timeline) -> Arrays:
    """A timeline as arrays; times are fractions, numerator and denominator, the last one the clip's duration."""
    times = [*timeline.times, timeline.duration]
    return {
        "times": np.array([(time.numerator, time.denominator) for time in times], dtype=np.int64),
        "drawing_of_frame": timeline.drawing_of_frame,
        "frame_numbers": timeline.frame_numbers,
    }


def unpack_timeline(arrays: Arrays) -> Timeline:
    """The timeline that :func:`pack_timeline` took."""
    times = tuple(Fraction(int(above), int(below)) for above, below in arrays["times"])
    return Timeline(
        arrays["drawing_of_frame"].astype(np.intp), times[:-1], times[-1], arrays["frame_numbers"].astype(np.intp)
    )


def pack_events(events: tuple[Event, ...]) -> Arrays:
    """Events as arrays; ids and parents of all events in one run each, with counts."""
    return {
        "event_kind": np.array([str(event.kind) for event in events], dtype="U16"),
        "event_drawing": np.array([event.drawing for event in events], dtype=np.int64),
        "event_score": np.array([event.score for event in events], dtype=np.float64),
        "event_ids": np.array([one for event in events for one in event.ids], dtype=np.int64),
        "event_id_count": np.array([len(event.ids) for event in events], dtype=np.int64),
        "event_parents": np.array([one for event in events for one in event.parents], dtype=np.int64),
        "event_parent_count": np.array([len(event.parents) for event in events], dtype=np.int64),
    }


def unpack_events(arrays: Arrays) -> tuple[Event, ...]:
    """The events that :func:`pack_events` took."""
    ids, parents = (
        [tuple(part.tolist()) for part in np.split(arrays[f"event_{name}s"], np.cumsum(arrays[f"event_{name}_count"]))]
        for name in ("id", "parent")
    )
    return tuple(
        Event(EventKind(str(kind)), int(drawing), ids[k], parents[k], float(score))
        for k, (kind, drawing, score) in enumerate(
            zip(arrays["event_kind"], arrays["event_drawing"], arrays["event_score"], strict=True)
        )
    )


def pack_brushwork(brushwork: Brushwork | None) -> Arrays:
    """Brushes and how they were laid as arrays; none for solid strokes."""
    if brushwork is None:
        return {}
    brushes, laying = brushwork.brushes, brushwork.laying
    arrays: Arrays = {f"brush_{k}_strip": brush.strip for k, brush in enumerate(brushes)}
    return arrays | {
        "brush_name": np.array([brush.name for brush in brushes]),
        "brush_model": np.array([brush.model.value for brush in brushes]),
        "brush_width": np.array([brush.width for brush in brushes]),
        "brush_repeat": np.array([brush.repeat for brush in brushes]),
        "brush_chosen": brushwork.chosen.astype(np.int64),
        **{f"brush_{name}": getattr(laying, name) for name in _LAYING_FIELDS},
    }


def unpack_brushwork(arrays: Arrays, layout: Layout) -> Brushwork | None:
    """The brushwork that :func:`pack_brushwork` took, of strokes of a layout."""
    if "brush_name" not in arrays:
        return None
    fields = ("name", "model", "width", "repeat")
    brushes = tuple(
        Brush(str(name), BrushModel(str(model)), arrays[f"brush_{k}_strip"].astype(np.float64), float(width), float(u))
        for k, (name, model, width, u) in enumerate(zip(*(arrays[f"brush_{field}"] for field in fields), strict=True))
    )
    laying = Laying(*(arrays[f"brush_{name}"].astype(np.float64) for name in _LAYING_FIELDS))
    if len(laying.shift) == len(layout.row_stroke):  # older tracks have one shift for all joints of a row
        laying = replace(laying, shift=laying.shift[layout.joint_row])
    return Brushwork(brushes, arrays["brush_chosen"].astype(np.intp), laying)
