"""A page for people: how good each frame is, who lives when, and what the worst frames look like."""

from __future__ import annotations

import base64
import io
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from html import escape

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from videovec.clip import Clip
from videovec.stroke_shape import hex_colour
from videovec.tracks import StrokeTracks
from videovec.write.colours import identity_colours
from videovec.write.video import preview_image

__all__ = ["FrameFigures", "report_html"]

Floats = NDArray[np.float64]

_WORST = 4  # frames that are shown
_PICTURE = 1200  # px, the largest width of their pictures
_WIDTH, _HEIGHT, _BAR = 960, 120, 9  # px of a chart, and of one stroke in the chart of lives
_STYLE = (
    "body{font:15px/1.5 system-ui,sans-serif;max-width:1000px;margin:2em auto;padding:0 1em;color:#222}"
    "table{border-collapse:collapse}td,th{padding:2px 12px;text-align:right}tr:nth-child(even){background:#f4f4f4}"
    "img,svg{max-width:100%}figure{margin:1em 0}figcaption{color:#666}"
)


@dataclass(frozen=True, slots=True, eq=False)
class FrameFigures:
    """What the report says of every frame.

    Args:
        strokes: How many strokes are visible. int [T]
        error: Root mean square coverage error over the strokes. [T]
        worst: The stroke of the largest error, 0 where there is none. int [T]
        psnr: Of our picture against the source; none where the clip was not at hand. dB [T]
    """

    strokes: NDArray[np.intp]
    error: Floats
    worst: NDArray[np.intp]
    psnr: Floats | None

    @staticmethod
    def of(tracks: StrokeTracks, psnr: Floats | None) -> FrameFigures:
        """The figures of tracks.

        Args:
            tracks: The strokes of a clip.
            psnr: Of each drawing, where it is known. dB [D]
        """
        error = tracks.over_frames(tracks.error)
        is_seen = np.nan_to_num(tracks.visibility) > 0
        seen = np.where(is_seen, error, 0.0)
        count = is_seen.sum(0)
        worst = tracks.strokes.ids[seen.argmax(0)] if len(tracks) else np.zeros(len(count), np.intp)
        return FrameFigures(
            strokes=count,
            error=np.sqrt((seen**2).sum(0) / np.maximum(count, 1)),
            worst=np.where(count > 0, worst, 0),
            psnr=None if psnr is None else psnr[tracks.timeline.drawing_of_frame],
        )


def report_html(tracks: StrokeTracks, clip: Clip | None, psnr: Floats | None) -> str:
    """A report in one file that needs nothing else.

    Args:
        tracks: The strokes of a clip.
        clip: The clip, to show beside its strokes.
        psnr: Of each drawing's picture against its source, where it was measured. dB [D]
    """
    figures = FrameFigures.of(tracks, psnr)
    title = escape(f"{tracks.name}: videovec report")
    head = f'<!doctype html><html lang="en"><meta charset="utf-8"><title>{title}</title><style>{_STYLE}</style>'
    parts = [
        f"<h1>{title}</h1>",
        _summary(tracks, figures),
        _charts(figures),
        "<h2>Lives</h2><p>One bar for each stroke, in the colour it has in the preview; paler where it is hidden.</p>",
        _lives(tracks),
        *_events(tracks),
        *_worst_frames(tracks, clip, figures),
        "<h2>Frames</h2>",
        _table(tracks, figures),
    ]
    return head + "<body>" + "\n".join(parts) + "</body></html>\n"


def _summary(tracks: StrokeTracks, figures: FrameFigures) -> str:
    timeline, layout = tracks.timeline, tracks.strokes.layout
    height, width = tracks.size
    life = float(np.mean(layout.last - layout.first + 1)) if len(tracks) else 0.0
    facts = [
        f"{width} x {height} px, {timeline.frame_count} frames, {timeline.drawing_count} drawings, "
        f"{float(timeline.frame_rate):.3g} frames a second",
        f"{len(tracks)} strokes, which live for {life:.1f} drawings on average",
    ]
    if figures.psnr is not None:
        facts.append(f"PSNR {np.median(figures.psnr):.1f} dB in the median, {figures.psnr.min():.1f} dB at worst")
    return "<ul>" + "".join(f"<li>{fact}</li>" for fact in facts) + "</ul>"


def _charts(figures: FrameFigures) -> str:
    charts = [] if figures.psnr is None else [_chart("PSNR, dB", figures.psnr)]
    charts += [_chart("coverage error under strokes", figures.error), _chart("visible strokes", figures.strokes)]
    return "".join(charts)


def _chart(name: str, values: Sequence[float] | NDArray[np.generic]) -> str:
    """A line over the frames, with its least and largest value written beside it."""
    array = np.asarray(values, dtype=np.float64)
    low, high = float(array.min()), float(array.max())
    x = np.linspace(40, _WIDTH - 10, len(array)) if len(array) > 1 else np.array([_WIDTH / 2])
    y = _HEIGHT - 15 - (array - low) / max(high - low, 1e-9) * (_HEIGHT - 30)
    points = " ".join(f"{a:.1f},{b:.1f}" for a, b in zip(x, y, strict=True))
    dots = "".join(f'<circle cx="{a:.1f}" cy="{b:.1f}" r="1.5"/>' for a, b in zip(x, y, strict=True))
    return (
        f'<figure><figcaption>{escape(name)}</figcaption><svg width="{_WIDTH}" height="{_HEIGHT}" font-size="11">'
        f'<text x="0" y="18">{high:.3g}</text><text x="0" y="{_HEIGHT - 12}">{low:.3g}</text>'
        f'<polyline points="{points}" fill="none" stroke="#36c"/><g fill="#36c">{dots}</g></svg></figure>'
    )


def _lives(tracks: StrokeTracks) -> str:
    """A bar for each stroke over the frames; every run of equal visibility is one rectangle."""
    count = tracks.timeline.frame_count
    step = (_WIDTH - 60) / count
    visibility = tracks.visibility
    rows = []
    for line, (stroke, colour) in enumerate(
        zip(tracks.strokes.ids.tolist(), identity_colours(tracks.strokes.ids), strict=True)
    ):
        state = np.where(np.isnan(visibility[line]), 0, np.where(visibility[line] > 0, 2, 1))
        starts = np.flatnonzero(np.diff(state, prepend=-1))
        y = line * _BAR
        rows.append(f'<text x="0" y="{y + _BAR - 1}">{stroke}</text>')
        for start, end in zip(starts, np.append(starts[1:], count), strict=True):
            if state[start]:
                opacity = "" if state[start] == 2 else ' opacity=".25"'
                x, width = 50 + start * step, (end - start) * step
                rows.append(
                    f'<rect x="{x:.1f}" y="{y}" width="{width:.1f}" height="{_BAR - 2}" '
                    f'fill="{hex_colour(colour)}"{opacity}/>'
                )
    return f'<svg width="{_WIDTH}" height="{max(len(tracks), 1) * _BAR}" font-size="8">{"".join(rows)}</svg>'


def _events(tracks: StrokeTracks) -> Iterator[str]:
    """What happened, frame by frame."""
    if not tracks.events:
        return
    numbers = np.append(tracks.timeline.frame_numbers, tracks.timeline.frame_numbers[-1] + 1)
    rows = "".join(
        f"<tr><td>{numbers[tracks.frame_of(event)]}<td>{event.kind}<td>{_names(event.ids)}<td>{_names(event.parents)}"
        f"<td>{event.score:.2f}</tr>"
        for event in tracks.events
    )
    yield "<h2>Events</h2><table><tr><th>frame<th>event<th>strokes<th>from<th>score</tr>" + rows + "</table>"


def _worst_frames(tracks: StrokeTracks, clip: Clip | None, figures: FrameFigures) -> Iterator[str]:
    """Pictures of the worst drawings, each by its first frame."""
    yield "<h2>Worst frames</h2>"
    badness = figures.error if figures.psnr is None else -figures.psnr
    first = tracks.timeline.first_frames()
    for frame in first[np.argsort(-badness[first], kind="stable")][:_WORST].tolist():
        picture = Image.fromarray(preview_image(tracks, clip, frame))
        picture.thumbnail((_PICTURE, _PICTURE))
        buffer = io.BytesIO()
        picture.save(buffer, "png", optimize=True)
        data = base64.b64encode(buffer.getvalue()).decode()
        quality = "" if figures.psnr is None else f", {figures.psnr[frame]:.1f} dB"
        yield (
            f"<figure><figcaption>frame {tracks.timeline.frame_numbers[frame]}{quality}; the largest error lies under "
            f'stroke {figures.worst[frame]}</figcaption><img src="data:image/png;base64,{data}"></figure>'
        )


def _table(tracks: StrokeTracks, figures: FrameFigures) -> str:
    timeline = tracks.timeline
    rows = []
    for frame in range(timeline.frame_count):
        psnr = "" if figures.psnr is None else f"{figures.psnr[frame]:.2f}"
        rows.append(
            f"<tr><td>{timeline.frame_numbers[frame]}<td>{float(timeline.times[frame]):.3f}"
            f"<td>{timeline.drawing_of_frame[frame]}<td>{figures.strokes[frame]}<td>{psnr}"
            f"<td>{figures.error[frame]:.4f}<td>{figures.worst[frame] or ''}</tr>"
        )
    names = ("frame", "time, s", "drawing", "strokes", "PSNR, dB", "error", "worst stroke")
    return "<table><tr>" + "".join(f"<th>{name}" for name in names) + "</tr>" + "".join(rows) + "</table>"


def _names(ids: Sequence[int]) -> str:
    return ", ".join(map(str, ids))
