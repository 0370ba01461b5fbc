"""Strokes seen over time: what a run knows of every stroke at every frame.

In the examples ``tracks`` are those of two strokes on eight frames, on twos: a line from (20, 20) to (60, 20) that
sinks by 2 px from drawing to drawing and is hidden on the last, and another 30 px below that is gone then.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from videovec import track_edits, track_layouts
from videovec.brushwork import Brushwork
from videovec.clip import Clip
from videovec.errors import InputError
from videovec.events import Event
from videovec.files import write_file
from videovec.fit import FitResult
from videovec.ink import Ink
from videovec.stroke_shape import StrokeShape, shape_of_row
from videovec.track_archive import (
    pack,
    pack_brushwork,
    pack_events,
    pack_strokes,
    pack_timeline,
    unpack,
    unpack_brushwork,
    unpack_events,
    unpack_strokes,
    unpack_timeline,
)
from videovec.track_layouts import NapariTracks, TapVid
from videovec.track_set import TrackSet

__all__ = ["StrokeTracks"]

Floats = NDArray[np.float64]


@dataclass(frozen=True, slots=True, eq=False)
class StrokeTracks(TrackSet):
    """S strokes with their identities over a clip, and what can be asked of them; arguments as of `TrackSet`."""

    @staticmethod
    def of(
        clip: Clip, ink: Ink, result: FitResult, events: tuple[Event, ...] = (), brushwork: Brushwork | None = None
    ) -> StrokeTracks:
        """What a fit found in a clip.

        Args:
            clip: The clip.
            ink: Its ink, for the colour of the page.
            result: The fitted strokes and their evidence.
            events: What happened to them.
            brushwork: What draws them, if they are textured.
        """
        evidence = result.evidence
        return StrokeTracks(
            name=clip.name,
            size=clip.size,
            page=ink.page,
            timeline=clip.timeline,
            strokes=result.strokes,
            events=events,
            error=evidence.error,
            confidence=evidence.support,
            brushwork=brushwork,
            is_finished=result.is_finished,
        )

    def at_frame(self, frame: int) -> list[StrokeShape]:
        """The strokes alive on a frame, hidden ones too, from the lowest layer to the highest.

        >>> [shape.id for shape in tracks.at_frame(4) if shape.is_visible]
        [1, 2]

        Args:
            frame: Position of the frame, from 0.

        Raises:
            InputError: The clip has no such frame.
        """
        self.check_frame(frame)
        drawing = int(self.timeline.drawing_of_frame[frame])
        return [shape_of_row(self.strokes, int(row)) for row in self.strokes.rows_at(drawing)]

    def query(self, x: float, y: float, frame: int, search_range: float = np.inf) -> tuple[int, float] | None:
        """Which stroke lies at a place, and where along it.

        >>> stroke, u = tracks.query(30, 20, frame=0)
        >>> stroke, round(u, 2)
        (1, 0.25)

        Args:
            x: Right of the page's left edge. px
            y: Down from its upper edge. px
            frame: Position of the frame, from 0.
            search_range: How far from a stroke's edge the place may lie. px

        Returns:
            Identity and arc fraction of the visible stroke with the nearest edge, of several whose ink lies there
            the uppermost; none where nothing is visible within the range.

        Raises:
            InputError: The clip has no such frame.
        """
        best: tuple[float, int, float] | None = None
        for shape in self.at_frame(frame):
            beyond = np.maximum(shape.points.min(0) - (x, y), np.subtract((x, y), shape.points.max(0)))
            reach = float(np.linalg.norm(np.maximum(beyond, 0))) - float(shape.half_width.max())  # it is no nearer
            if shape.is_visible and reach <= min(search_range, best[0] if best else np.inf):
                u, distance = shape.nearest(np.array([x, y], dtype=np.float64))
                outside = max(distance - shape.half_width_at(u), 0.0)
                if outside <= search_range and (best is None or outside <= best[0]):
                    best = outside, shape.id, u
        return best and best[1:]

    def follow(self, stroke: int, u: ArrayLike, frame: int | None = None) -> Floats:
        """Where material points of a stroke are on every frame, also those beyond a gap in it.

        >>> tracks.follow(1, 0.5)[:3].round(1).tolist()
        [[40.0, 20.0], [40.0, 20.0], [40.0, 22.0]]
        >>> stroke, u = tracks.query(30, 22, frame=2)
        >>> tracks.follow(stroke, u, frame=2)[[0, 2]].round(1).tolist()
        [[30.0, 20.0], [30.0, 22.0]]

        Args:
            stroke: Its identity.
            u: Arc fractions. [...]
            frame: Where they are those fractions, as of a query; if none, on the drawing on which most of the stroke is
                seen, the first of several.

        Returns:
            x and y, NaN where the stroke is not alive or the point is hidden. [..., T, 2] px

        Raises:
            InputError: There is no such stroke, or it is not alive on that frame.
        """
        segment, t = self[stroke].places(u, frame)
        followed = self[stroke].follow_places(segment, t)
        for part, whole in self.parents.items():
            if whole == stroke:
                beyond = self[part].follow_places(segment, t)
                followed = np.where(np.isnan(followed), beyond, followed)
        return followed.reshape(*np.shape(u), self.timeline.frame_count, 2)

    @property
    def parents(self) -> dict[int, int]:
        """For each stroke that is the part of another beyond a gap in it, that other; they share their arc fractions.

        >>> tracks.parents
        {}
        """
        ids, parents = self.strokes.ids.tolist(), self.strokes.parent.tolist()
        return {one: parent for one, parent in zip(ids, parents, strict=True) if parent in ids}

    def events_of(self, stroke: int) -> tuple[Event, ...]:
        """The events in which a stroke takes part, as one of their ids or parents.

        >>> [(str(event.kind), tracks.frame_of(event)) for event in tracks.events_of(1)]
        [('occlusion', 6)]
        """
        return tuple(event for event in self.events if stroke in event.ids or stroke in event.parents)

    def over_frames(self, of_rows: Floats) -> Floats:
        """A number for every row, such as ``error``, as a matrix over strokes and frames.

        >>> tracks.over_frames(tracks.confidence).shape
        (2, 8)

        Args:
            of_rows: One for each row of ``strokes``. [R]

        Returns:
            NaN where a stroke is not alive. [S, T]
        """
        layout = self.strokes.layout
        of_drawings = np.full((len(self), self.timeline.drawing_count), np.nan)
        of_drawings[layout.row_stroke, layout.row_drawing] = of_rows
        return np.asarray(of_drawings[:, self.timeline.drawing_of_frame])

    @property
    def visibility(self) -> Floats:
        """The share of its arc that is seen of every stroke on every frame, NaN where it is not alive. [S, T]"""
        seen = np.where(self.strokes.opacity > 0, np.ptp(self.strokes.visible, axis=1), 0.0)
        return self.over_frames(seen)

    def merge(self, first: int, second: int) -> StrokeTracks:
        """Make one stroke of two; it keeps the identity, layer and colour of the first.

        Two whose lives do not overlap become one over time, hidden in between. Two of the same life become one line,
        joined where their ends are nearest to each other.

        >>> one = tracks.split(2, frame=3).merge(2, 3)
        >>> one[2].life == tracks[2].life
        True

        Raises:
            InputError: There is no such stroke, or lives overlap without being the same.
        """
        return track_edits.merge(self, first, second)

    def split(self, stroke: int, *, u: float | None = None, frame: int | None = None) -> StrokeTracks:
        """Make two strokes of one: along its line at an arc fraction, or over time from a frame on.

        The first part keeps the identity, the second gets the next free one.

        >>> [track.id for track in tracks.split(1, u=0.4)]
        [1, 3, 2]

        Raises:
            InputError: There is no such stroke, or the cut does not lie inside it.
        """
        return track_edits.split(self, stroke, u, frame)

    def rename(self, old: int, new: int) -> StrokeTracks:
        """Give a stroke another identity, in its events too.

        Raises:
            InputError: There is no such stroke, or the new identity is taken or less than 1.
        """
        return track_edits.rename(self, old, new)

    def drop(self, *strokes: int) -> StrokeTracks:
        """Leave strokes out, and the events that are of them alone.

        >>> len(tracks.drop(2))
        1

        Raises:
            InputError: There is no such stroke.
        """
        return track_edits.drop(self, strokes)

    def reverse(self, stroke: int) -> StrokeTracks:
        """Run a stroke the other way, on all of its drawings.

        Raises:
            InputError: There is no such stroke.
        """
        return track_edits.reverse(self, stroke)

    def save(self, path: str | Path) -> Path:
        """Write everything to an ``.npz`` without pickle, from which all can be exported again.

        Raises:
            OutputError: The place cannot be written to.
        """
        return write_file(Path(path), self.to_bytes())

    def to_bytes(self) -> bytes:
        """What :meth:`save` writes."""
        arrays = {
            "name": np.array(self.name),
            "size": np.array(self.size, dtype=np.int64),
            "page": self.page,
            "error": self.error,
            "confidence": self.confidence,
            "is_finished": np.array(self.is_finished),
        }
        parts = (
            pack_timeline(self.timeline),
            pack_strokes(self.strokes),
            pack_events(self.events),
            pack_brushwork(self.brushwork),
        )
        for part in parts:
            arrays |= part
        return pack(arrays)

    @staticmethod
    def load(path: str | Path) -> StrokeTracks:
        """Read what :meth:`save` wrote.

        Raises:
            InputError: There is no such file, or it holds no tracks of this version.
        """
        try:
            data = Path(path).read_bytes()
        except OSError as error:
            raise InputError(f"cannot read tracks {path}: {error.strerror or error}") from error
        arrays = unpack(data, str(path))
        height, width = arrays["size"].tolist()
        strokes = unpack_strokes(arrays)
        return StrokeTracks(
            name=str(arrays["name"]),
            size=(height, width),
            page=arrays["page"].astype(np.float64),
            timeline=unpack_timeline(arrays),
            strokes=strokes,
            events=unpack_events(arrays),
            error=arrays["error"].astype(np.float64),
            confidence=arrays["confidence"].astype(np.float64),
            brushwork=unpack_brushwork(arrays, strokes.layout),
            is_finished=bool(arrays.get("is_finished", True)),
        )

    def to_json(self) -> str:
        """Everything as JSON, for other programs; see :func:`videovec.track_layouts.json_text`."""
        return track_layouts.json_text(self)

    def to_dataframe(self) -> Any:
        """A pandas table with a row for every stroke on every frame; see :func:`videovec.track_layouts.table`.

        >>> frame = tracks.to_dataframe()
        >>> frame.groupby("id").confidence.min().tolist()
        [1.0, 1.0]

        Raises:
            ImportError: pandas is not installed; ``pip install 'videovec[table]'`` brings it.
        """
        try:
            import pandas
        except ImportError as error:
            raise ImportError("to_dataframe needs pandas: pip install 'videovec[table]'") from error
        return pandas.DataFrame(track_layouts.table(self))

    def to_parquet(self, path: str | Path) -> Path:
        """Write the table of :meth:`to_dataframe` as a Parquet file.

        Raises:
            ImportError: pandas or pyarrow is not installed; ``pip install 'videovec[table]'`` brings both.
            OutputError: The place cannot be written to.
        """
        return write_file(Path(path), self.to_dataframe().to_parquet(None, engine="pyarrow"))

    def to_tapvid(self, spacing: float = 8.0) -> TapVid:
        """Material points about ``spacing`` px apart on every stroke, as TAP-Vid stores them.

        >>> tracks.to_tapvid(spacing=20).points.shape
        (4, 8, 2)
        """
        return track_layouts.tapvid_layout(self, spacing)

    def to_napari(self, spacing: float = 8.0) -> NapariTracks:
        """Material points about ``spacing`` px apart on every stroke, as a napari ``Tracks`` layer takes them."""
        return track_layouts.napari_layout(self, spacing)
