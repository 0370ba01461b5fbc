"""Pair lists on the CPU: scan lines over each chunk, then an index by pixel; drawings in parallel."""

from __future__ import annotations

from typing import Any

import numpy as np
import torch
from numpy.typing import NDArray

from videovec.compiling import compiled
from videovec.render.pairs import PIECES, SAG, Chunks, PairList
from videovec.render.scene import Scene
from videovec.threads import over_ranges

__all__ = ["find_pairs"]

Array = NDArray[Any]


def find_pairs(scene: Scene, chunks: Chunks, reach: float) -> PairList:
    """List the pixels within half-width + ``reach`` of every chunk."""
    drawings, height, width = scene.size
    shape = (height, width)
    segment, bounds, drawing_chunks = chunks.segment.numpy(), chunks.bounds.numpy(), chunks.drawing_chunks.numpy()
    curves = scene.control.detach().numpy(), scene.half_width.detach().numpy(), segment, bounds
    count, parts = np.zeros(len(segment), np.int64), {}

    def find(part: tuple[int, int]) -> None:
        parts[part[0]] = _find(curves, reach, shape, (drawing_chunks[part[0]], drawing_chunks[part[1]]), count)

    over_ranges(find, drawings)
    x, y, t = (np.concatenate([parts[first][n] for first in sorted(parts)]) for n in range(3))
    chunk_pairs = _starts(count)

    row, sizes = scene.row.numpy()[segment].astype(np.int32), np.zeros((drawings, 3), np.int64)
    active, start = np.empty(len(x), np.int64), np.empty(len(x), np.int64)
    order, order_row = np.empty(len(x), np.int32), np.empty(len(x), np.int32)
    lists, index = (drawing_chunks, chunk_pairs, row, x, y), (active, start, order, order_row)
    over_ranges(lambda part: _index(lists, shape, part, index, sizes), drawings)
    keep, drawing_pixels = _kept(chunk_pairs[drawing_chunks], sizes.sum(axis=1)), _starts(sizes.sum(axis=1))
    plain = drawing_pixels[:-1, None] + sizes.cumsum(axis=1)[:, :2]
    return PairList(
        chunks,
        *(torch.from_numpy(v) for v in (chunk_pairs, x, y, t, active[keep], np.append(start[keep], len(x)))),
        *(torch.from_numpy(v) for v in (order, order_row, drawing_pixels, plain)),
    )


def _starts(counts: Array) -> Array:
    return np.concatenate([np.zeros(1, np.int64), np.cumsum(counts, dtype=np.int64)])


def _kept(begin: Array, count: Array) -> Array:
    """The first ``count[d]`` places from ``begin[d]`` on, of every drawing."""
    return np.concatenate([np.arange(b, b + n) for b, n in zip(begin[:-1], count, strict=True)])


@compiled()
def _find(
    curves: tuple[Array, ...], reach: float, shape: tuple[int, int], part: tuple[int, int], count: Array
) -> tuple[Array, Array, Array]:
    """Column, row and t of the pixels within reach of some chunks, and how many each chunk has, into ``count``."""
    _, _, _, bounds = curves
    lines = np.empty((part[1] - part[0], PIECES + 1, 3), bounds.dtype)
    room = _polylines(curves, reach, part, lines)
    xs, ys, ts = np.empty(room, np.int16), np.empty(room, np.int16), np.empty(room, bounds.dtype)
    squared = np.empty(room, bounds.dtype)
    at = 0
    for k in range(part[0], part[1]):
        line, i = lines[k - part[0]], at
        begin, end = _lines(line, shape[0])
        for y in range(begin, end):
            x0, x1 = _columns(line, y, shape[1])
            if at + x1 - x0 > len(xs):
                room = 2 * (at + x1 - x0)
                xs, ys, ts = _longer(xs, room), _longer(ys, room), _longer(ts, room)
                squared = np.empty(room, bounds.dtype)
            for x in range(x0, x1):
                xs[at + x - x0], ys[at + x - x0] = x, y
            at += max(0, x1 - x0)
        candidates, at = at, i
        _nearest(line, xs[i:candidates], ys[i:candidates], ts[i:candidates], squared[: candidates - i])
        first, step, farthest = bounds[k, 0], bounds[k, 1] - bounds[k, 0], line[0, 2] ** 2
        for n in range(i, candidates):
            xs[at], ys[at], ts[at] = xs[n], ys[n], first + step * ts[n]
            at += squared[n - i] <= farthest
        count[k] = at - i
    return xs[:at], ys[:at], ts[:at]


@compiled()
def _longer(values: Array, room: int) -> Array:
    more = np.empty(room, values.dtype)
    more[: len(values)] = values
    return more


@compiled()
def _polylines(curves: tuple[Array, ...], reach: float, part: tuple[int, int], out: Array) -> int:
    """Vertices of some chunks and how far around them their pixels lie, px; about how many pixels that are, at most.

    Into ``out`` [K, PIECES + 1, 3].
    """
    control, half_width, segment, bounds = curves
    room = 64.0
    for n in range(part[1] - part[0]):
        k = part[0] + n
        p, h = control[segment[k]], half_width[segment[k]]
        widest = 0.0
        for j in range(PIECES + 1):
            t = bounds[k, 0] + (bounds[k, 1] - bounds[k, 0]) * j / PIECES
            s = 1 - t
            b0, b1, b2, b3 = s * s * s, 3 * s * s * t, 3 * s * t * t, t * t * t
            for axis in range(2):
                out[n, j, axis] = b0 * p[0, axis] + b1 * p[1, axis] + b2 * p[2, axis] + b3 * p[3, axis]
            widest = max(widest, s * h[0] + t * h[1])
        out[n, :, 2] = widest + reach + SAG
        length = np.abs(out[n, 1:, :2] - out[n, :-1, :2]).sum()
        room += min(length + 2 * out[n, 0, 2] + 2, 200.0) * (2 * out[n, 0, 2] + 2)
    return int(room)


@compiled(inline=True)
def _span(polyline: Array, y: float) -> tuple[float, float]:
    """The stretch of a scan line that may lie within reach of a polyline; empty if the first exceeds the second. px"""
    left, right = np.inf, -np.inf
    reach = polyline[0, 2]
    for j in range(PIECES):
        ax, ay, bx, by = polyline[j, 0], polyline[j, 1], polyline[j + 1, 0], polyline[j + 1, 1]
        low, high = min(ay, by) - reach, max(ay, by) + reach
        if y < low or y > high:
            continue
        slope = (bx - ax) / (by - ay) if abs(by - ay) > 1e-3 else np.inf
        # Points of the piece within reach of the scan line lie between these two heights.
        top, bottom = max(min(ay, by), y - reach), min(max(ay, by), y + reach)
        if abs(slope) < 1e6:
            x0, x1 = ax + slope * (top - ay), ax + slope * (bottom - ay)
        else:
            x0, x1 = ax, bx
        gap = max(0.0, max(min(ay, by) - y, y - max(ay, by)))
        aside = np.sqrt(max(0.0, reach * reach - gap * gap))
        left, right = min(left, min(x0, x1) - aside), max(right, max(x0, x1) + aside)
    return left, right


@compiled(inline=True)
def _lines(polyline: Array, height: int) -> tuple[int, int]:
    """First scan line of a polyline, and the one after its last."""
    reach = polyline[0, 2]
    low, high = polyline[:, 1].min() - reach, polyline[:, 1].max() + reach
    return int(max(0.0, np.floor(low - 0.5))), int(min(height - 1.0, np.ceil(high - 0.5))) + 1


@compiled(inline=True)
def _columns(polyline: Array, y: int, width: int) -> tuple[int, int]:
    """First column of a scan line that may be within reach, and the one after the last."""
    left, right = _span(polyline, y + 0.5)
    if not left <= right:
        return 0, 0
    return int(max(0.0, np.ceil(left - 0.5))), int(min(width - 1.0, np.floor(right - 0.5))) + 1


@compiled(fastmath=True)
def _nearest(line: Array, columns: Array, rows: Array, along: Array, squared: Array) -> None:
    """Squared distance of pixels to a polyline, px², and how far along it the nearest points lie, in [0, 1]."""
    real = line.dtype.type
    zero, half, one, pieces = real(0), real(0.5), real(1), real(PIECES)
    squared[:] = real(1e30)
    for j in range(PIECES):
        x0, y0 = line[j, 0] - half, line[j, 1] - half
        ex, ey, offset = line[j + 1, 0] - line[j, 0], line[j + 1, 1] - line[j, 1], real(j)
        scale = one / max(ex * ex + ey * ey, real(1e-12))
        for i in range(len(columns)):
            rx, ry = real(columns[i]) - x0, real(rows[i]) - y0
            part = min(one, max(zero, (rx * ex + ry * ey) * scale))
            dx, dy = rx - part * ex, ry - part * ey
            distance = dx * dx + dy * dy
            along[i] = (offset + part) / pieces if distance < squared[i] else along[i]
            squared[i] = min(squared[i], distance)


@compiled()
def _index(
    lists: tuple[Array, ...], shape: tuple[int, int], part: tuple[int, int], out: tuple[Array, ...], sizes: Array
) -> None:
    """Sort the pairs of some drawings by pixel, keeping the chunks' order; how many pixels of each kind there are.

    The active pixels of a drawing are written from its first pair's place on. Nothing here costs more on a larger page.
    """
    drawing_chunks, chunk_pairs, row, _, _ = lists
    active, start, order, order_row = out
    width = shape[1]
    place_of = np.zeros(shape[0] * width, np.int32)  # of a pixel, from 1 on
    most = 0
    for d in range(part[0], part[1]):
        most = max(most, chunk_pairs[drawing_chunks[d + 1]] - chunk_pairs[drawing_chunks[d]])
    found, place = np.empty((4, most), np.int32), np.empty(most, np.int32)
    for d in range(part[0], part[1]):
        k0, k1 = drawing_chunks[d], drawing_chunks[d + 1]
        i0 = chunk_pairs[k0]
        pixels = _pixels(lists, width, (k0, k1), place_of, found, place)
        _arrange(found[:, :pixels], (i0, d * shape[0] * width), active, start, sizes[d])
        free = found[1]
        for k in range(k0, k1):
            for i in range(chunk_pairs[k], chunk_pairs[k + 1]):
                slot = free[place[i - i0]]
                free[place[i - i0]] += 1
                order[i0 + slot], order_row[i0 + slot] = i, row[k]
        for a in range(pixels):
            place_of[found[0, a]] = 0


@compiled()
def _pixels(
    lists: tuple[Array, ...], width: int, chunks: tuple[int, int], place_of: Array, found: Array, place: Array
) -> int:
    """Number the pixels of a drawing as its pairs come to them, and each pair with its pixel's number.

    Into ``found``: pixel, pairs, kind (0 with a single pair, 1 with two of one row, 2 with others), last row.
    """
    _, chunk_pairs, row, xs, ys = lists
    pixel_of, pairs, kind, last = found[0], found[1], found[2], found[3]
    i0, count = chunk_pairs[chunks[0]], 0
    for k in range(chunks[0], chunks[1]):
        for i in range(chunk_pairs[k], chunk_pairs[k + 1]):
            pixel = np.int64(ys[i]) * width + xs[i]
            a = place_of[pixel] - 1
            if a < 0:
                a = count
                count += 1
                place_of[pixel] = count
                pixel_of[a], pairs[a], kind[a] = pixel, 1, 0
            else:
                pairs[a] += 1
                kind[a] = 1 if (kind[a] == 0) & (last[a] == row[k]) else 2
            last[a] = row[k]
            place[i - i0] = a
    return count


@compiled()
def _arrange(found: Array, origin: tuple[int, int], active: Array, start: Array, sizes: Array) -> None:
    """Write the pixels of a drawing and where their pairs begin, kind by kind; pairs give way to their free place."""
    pairs = np.zeros(3, np.int64)
    for a in range(found.shape[1]):
        sizes[found[2, a]] += 1
        pairs[found[2, a]] += found[1, a]
    at_pixel = np.array([0, sizes[0], sizes[0] + sizes[1]])
    at_pair = np.array([0, pairs[0], pairs[0] + pairs[1]])
    for a in range(found.shape[1]):
        kind, count = found[2, a], found[1, a]
        active[origin[0] + at_pixel[kind]] = origin[1] + found[0, a]
        start[origin[0] + at_pixel[kind]] = origin[0] + at_pair[kind]
        found[1, a] = at_pair[kind]
        at_pixel[kind] += 1
        at_pair[kind] += count
