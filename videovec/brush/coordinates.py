"""Stroke coordinates of pixels: how far along a stroke a pixel lies, and how far to its side.

A pixel near a row has one *pair* with each pass of the row near it: with the nearest point of that pass. Two passes
are two if the pixel is out of reach between them for more than a few widths of arc, so that a stroke that crosses
itself is drawn twice there, as a pen does.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from videovec.compiling import compiled
from videovec.curves import derivative, evaluate
from videovec.strokes import Strokes

__all__ = ["Coordinates", "RowSamples", "find_coordinates", "sample_rows"]

Floats = NDArray[np.float64]
Ints = NDArray[np.intp]

_STEP = 0.6  # px of arc between the samples among which the nearest is sought
_PASS_GAP = 3.0  # widths of arc out of reach after which a stroke that comes back is another pass
_RADIAL = 0.2  # px off the foot of the normal beyond which distance is measured to the point itself: caps, corners


@dataclass(frozen=True, slots=True, eq=False)
class RowSamples:
    """Points along the visible parts of all rows, row by row, at most 0.6 px apart.

    Args:
        starts: Where each row begins, then M. int [R+1]
        segment: Segment of each sample. int [M]
        t: Parameter on its segment. [M]
        points: Where it lies. [M, 2] px
        arc: Arc length from the beginning of the row, hidden parts included. [M] px
        half_width: Half-width there. [M] px
        lengths: Arc length of each row. [R] px
    """

    starts: Ints
    segment: Ints
    t: Floats
    points: Floats
    arc: Floats
    half_width: Floats
    lengths: Floats


@dataclass(frozen=True, slots=True, eq=False)
class Coordinates:
    """N pairs of a pixel and the nearest point of a pass of a row.

    Args:
        pixel: Index of the pixel in [D, H, W], flat. int [N]
        segment: Segment of the nearest point. int [N]
        t: Its parameter. [N]
        arc: Arc length there from the row's beginning, extended beyond the ends. [N] px
        direction: Unit vector along which the pixel's distance to that point is signed. [N, 2]
        distance: Signed distance, positive to the right of the stroke as seen on the page. [N] px
    """

    pixel: Ints
    segment: Ints
    t: Floats
    arc: Floats
    direction: Floats
    distance: Floats

    def select(self, which: NDArray[np.bool_]) -> Coordinates:
        """Some of the pairs, by mask."""
        return Coordinates(
            self.pixel[which],
            self.segment[which],
            self.t[which],
            self.arc[which],
            self.direction[which],
            self.distance[which],
        )


def sample_rows(strokes: Strokes) -> RowSamples:
    """Sample the visible part of every row for `find_coordinates`."""
    control = strokes.segments()
    layout = strokes.layout
    reach = np.linalg.norm(np.diff(control, axis=1), axis=2).sum(1)  # at least the length
    counts = np.ceil(reach / _STEP).astype(np.intp) + 1
    counts += np.diff(layout.segment_row, append=-1) != 0  # the last of a row has its end too
    segment = np.repeat(np.arange(len(counts)), counts)
    begin = np.concatenate([[0], np.cumsum(counts)])
    place = np.arange(len(segment)) - begin[segment]
    is_last = np.diff(layout.segment_row, append=-1) != 0
    t = place / (counts - is_last)[segment]
    points = evaluate(control[segment], t)
    row = layout.segment_row[segment]
    chords = np.concatenate([[0.0], np.linalg.norm(np.diff(points, axis=0), axis=1)])
    chords[np.flatnonzero(np.diff(row, prepend=-1))] = 0.0
    total = np.cumsum(chords)
    first = np.searchsorted(row, np.arange(strokes.row_count))
    last = np.searchsorted(row, np.arange(strokes.row_count), side="right") - 1
    arc = total - total[first][row]
    lengths = total[last] - total[first]
    joints = strokes.half_width[layout.segment_joints[segment]]
    half_width = (1 - t) * joints[:, 0] + t * joints[:, 1]
    seen = strokes.visible[row]
    fraction = arc / np.maximum(lengths[row], 1e-9)
    keep = (fraction >= seen[:, 0] - 1e-9) & (fraction <= seen[:, 1] + 1e-9) & (seen[:, 1] > seen[:, 0])
    starts = np.searchsorted(row[keep], np.arange(strokes.row_count + 1))
    return RowSamples(starts, segment[keep], t[keep], points[keep], arc[keep], half_width[keep], lengths)


def find_coordinates(strokes: Strokes, size: tuple[int, int, int], reach: float, margin: float = 1.0) -> Coordinates:
    """Coordinates of all pixels near the strokes.

    Args:
        strokes: S strokes over D drawings.
        size: D, H and W of the pages.
        reach: How far from the centre line a pixel counts as near, in half-widths.
        margin: What is added to it. px

    Returns:
        N pairs, row by row.
    """
    samples = sample_rows(strokes)
    widest = np.array(
        [2 * half.max() if len(half) else 0 for half in np.split(samples.half_width, samples.starts[1:-1])]
    )
    pixel, sample = _list_pairs(
        samples.points,
        samples.half_width * reach + margin,
        samples.arc,
        samples.starts,
        strokes.layout.row_drawing,
        np.where(strokes.is_closed[strokes.layout.row_stroke], samples.lengths, np.inf),
        _PASS_GAP * widest,
        size[1],
        size[2],
    )
    return _refine(strokes, samples, pixel, sample, size)


@compiled()
def _list_pairs(points, reach, arc, starts, drawing, closed_length, gap, height, width):  # type: ignore[no-untyped-def]
    """Nearest sample of every pass for every pixel in reach; gap [R] px, closed_length [R] px, inf where open."""
    capacity = 1024
    pixel = np.empty(capacity, np.int64)
    sample = np.empty(capacity, np.int64)
    nearest = np.empty(capacity)
    last_arc = np.empty(capacity)
    count = 0
    owner = np.full(height * width, -1, np.int64)  # row that last came near each pixel of a page
    newest = np.empty(height * width, np.int64)  # its latest pair there
    oldest = np.empty(height * width, np.int64)  # and its first
    for r in range(len(starts) - 1):
        row_begin = count
        for k in range(starts[r], starts[r + 1]):
            x, y, radius = points[k, 0], points[k, 1], reach[k]
            for j in range(max(int(np.floor(y - radius)), 0), min(int(np.ceil(y + radius)), height)):
                for i in range(max(int(np.floor(x - radius)), 0), min(int(np.ceil(x + radius)), width)):
                    square = (i + 0.5 - x) ** 2 + (j + 0.5 - y) ** 2
                    if square > radius * radius:
                        continue
                    place = j * width + i
                    n = newest[place]
                    if owner[place] != r or arc[k] - last_arc[n] > gap[r]:
                        if count == capacity:
                            capacity *= 2
                            pixel = _grown(pixel)
                            sample = _grown(sample)
                            nearest = _grown(nearest)
                            last_arc = _grown(last_arc)
                        n = count
                        count += 1
                        if owner[place] != r:
                            owner[place], oldest[place] = r, n
                        newest[place] = n
                        pixel[n] = drawing[r] * height * width + place
                        nearest[n] = np.inf
                    last_arc[n] = arc[k]
                    if square < nearest[n]:
                        nearest[n] = square
                        sample[n] = k
        if closed_length[r] < np.inf:
            page = drawing[r] * height * width
            count = _join_seam(
                pixel, sample, nearest, arc, (row_begin, count), (closed_length[r], gap[r]), oldest, page
            )
    return pixel[:count], sample[:count]


@compiled()
def _grown(values):  # type: ignore[no-untyped-def]
    larger = np.empty(2 * len(values), values.dtype)
    larger[: len(values)] = values
    return larger


@compiled()
def _join_seam(pixel, sample, nearest, arc, pairs, seam, oldest, page):  # type: ignore[no-untyped-def]
    """Drop the farther of two pairs of a pixel on either side of a closed row's seam; returns the new count."""
    (begin, count), (length, gap) = pairs, seam
    for n in range(begin, count):
        first = oldest[pixel[n] - page]
        if n != first and arc[sample[first]] + length - arc[sample[n]] < gap:
            if nearest[n] < nearest[first]:
                nearest[first], sample[first] = nearest[n], sample[n]
            nearest[n] = -1.0
    kept = begin
    for n in range(begin, count):
        if nearest[n] >= 0.0:
            pixel[kept], sample[kept], nearest[kept] = pixel[n], sample[n], nearest[n]
            kept += 1
    return kept


def _refine(
    strokes: Strokes, samples: RowSamples, pixel: Ints, sample: Ints, size: tuple[int, int, int]
) -> Coordinates:
    """From the nearest sample to the nearest point, by Newton's method on the squared distance."""
    place = pixel % (size[1] * size[2])
    centre = np.stack([place % size[2] + 0.5, place // size[2] + 0.5], axis=1)
    segment, start = samples.segment[sample], samples.t[sample]
    control = strokes.segments()[segment]
    speed = np.maximum(np.linalg.norm(derivative(control, start), axis=1), 1e-6)
    most = np.minimum(1.5 * _STEP / speed, 0.5)
    t = start
    for _ in range(3):
        offset, first = evaluate(control, t) - centre, derivative(control, t)
        slope = (offset * first).sum(1)
        bend = (first * first).sum(1)
        t = np.clip(np.clip(t - slope / np.maximum(bend, 1e-9), start - most, start + most), 0.0, 1.0)
    tangent = derivative(control, t)
    speed = np.linalg.norm(tangent, axis=1)
    tangent = np.where(speed[:, None] > 1e-6, tangent / np.maximum(speed, 1e-6)[:, None], np.array([1.0, 0.0]))
    offset = centre - evaluate(control, t)
    along = (offset * tangent).sum(1)
    normal = np.stack([-tangent[:, 1], tangent[:, 0]], axis=1)
    side = np.where((offset * normal).sum(1) >= 0, 1.0, -1.0)
    radius = np.linalg.norm(offset, axis=1)
    is_radial = (np.abs(along) > _RADIAL) & (radius > _RADIAL)
    outward = offset * (side / np.maximum(radius, 1e-9))[:, None]
    direction = np.where(is_radial[:, None], outward, normal)
    arc = samples.arc[sample] + (t - start) * speed + along
    return Coordinates(pixel, segment, t, arc, direction, (offset * direction).sum(1))
