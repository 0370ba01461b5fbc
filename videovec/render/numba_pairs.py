"""Pair lists on the CPU: scan lines over each chunk, then a counting sort by pixel; drawings in parallel."""

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
    control, half_width = scene.control.detach().numpy(), scene.half_width.detach().numpy()
    polylines, count = np.empty((len(segment), PIECES + 1, 3), bounds.dtype), np.zeros(len(segment), np.int64)

    def measure(part: tuple[int, int]) -> None:
        chunk = drawing_chunks[part[0]], drawing_chunks[part[1]]
        _polylines((control, half_width, segment, bounds), reach, chunk, polylines)
        _count(polylines, shape, chunk, count)

    def fill(part: tuple[int, int]) -> None:
        chunk = drawing_chunks[part[0]], drawing_chunks[part[1]]
        _fill(polylines, bounds, shape, chunk, (most, x, y, t), count)

    over_ranges(measure, drawings)
    most = _starts(count)
    x, y, t = np.empty(most[-1], np.int16), np.empty(most[-1], np.int16), np.empty(most[-1], bounds.dtype)
    over_ranges(fill, drawings)
    chunk_pairs = _starts(count)
    _compact(most, chunk_pairs, x, y, t)
    x, y, t = (values[: chunk_pairs[-1]].copy() for values in (x, y, t))

    row, found = scene.row.numpy()[segment].astype(np.int32), np.zeros(drawings, np.int64)
    active, start = np.empty(len(x), np.int64), np.empty(len(x), np.int64)
    order, order_row = np.empty(len(x), np.int32), np.empty(len(x), np.int32)
    lists, index = (drawing_chunks, chunk_pairs, row, x, y), (active, start, order, order_row)
    over_ranges(lambda part: _index(lists, shape, part, index, found), drawings)
    keep = _kept(chunk_pairs[drawing_chunks], found)
    return PairList(
        chunks,
        *(torch.from_numpy(v) for v in (chunk_pairs, x, y, t, active[keep], np.append(start[keep], len(x)))),
        *(torch.from_numpy(v) for v in (order, order_row, _starts(found))),
    )


def _starts(counts: Array) -> Array:
    return np.concatenate([np.zeros(1, np.int64), np.cumsum(counts, dtype=np.int64)])


def _kept(begin: Array, count: Array) -> Array:
    """The first ``count[d]`` places from ``begin[d]`` on, of every drawing."""
    return np.concatenate([np.arange(b, b + n) for b, n in zip(begin[:-1], count, strict=True)])


@compiled()
def _polylines(curves: tuple[Array, Array, Array, Array], reach: float, part: tuple[int, int], out: Array) -> None:
    """Vertices of some chunks and how far around them their pixels lie, into ``out`` [K, PIECES + 1, 3]. px"""
    control, half_width, segment, bounds = curves
    for k in range(part[0], part[1]):
        p, h = control[segment[k]], half_width[segment[k]]
        widest = 0.0
        for j in range(PIECES + 1):
            t = bounds[k, 0] + (bounds[k, 1] - bounds[k, 0]) * j / PIECES
            s = 1 - t
            b0, b1, b2, b3 = s * s * s, 3 * s * s * t, 3 * s * t * t, t * t * t
            for axis in range(2):
                out[k, j, axis] = b0 * p[0, axis] + b1 * p[1, axis] + b2 * p[2, axis] + b3 * p[3, axis]
            widest = max(widest, s * h[0] + t * h[1])
        out[k, :, 2] = widest + reach + SAG


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


@compiled()
def _count(polylines: Array, shape: tuple[int, int], part: tuple[int, int], count: Array) -> None:
    """The most pixels that some chunks can reach, into ``count`` [K]."""
    for k in range(part[0], part[1]):
        begin, end = _lines(polylines[k], shape[0])
        total = 0
        for y in range(begin, end):
            x0, x1 = _columns(polylines[k], y, shape[1])
            total += max(0, x1 - x0)
        count[k] = total


@compiled()
def _fill(
    polylines: Array, bounds: Array, shape: tuple[int, int], part: tuple[int, int], out: tuple[Array, ...], count: Array
) -> None:
    """Write the pixels within reach of some chunks, of each from its ``most`` on, and how many there are."""
    most, xs, ys, ts = out
    for k in range(part[0], part[1]):
        line, at = polylines[k], most[k]
        begin, end = _lines(line, shape[0])
        for y in range(begin, end):
            x0, x1 = _columns(line, y, shape[1])
            for x in range(x0, x1):
                xs[at], ys[at] = x, y
                at += 1
        i, j = most[k], at
        squared = np.empty(j - i, line.dtype)
        _nearest(line, xs[i:j], ys[i:j], ts[i:j], squared)
        first, step = bounds[k, 0], bounds[k, 1] - bounds[k, 0]
        farthest, at = line[0, 2] ** 2, i
        for n in range(j - i):
            xs[at], ys[at], ts[at] = xs[i + n], ys[i + n], first + step * ts[i + n]
            at += squared[n] <= farthest
        count[k] = at - i


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
def _compact(most: Array, starts: Array, x: Array, y: Array, t: Array) -> None:
    """Close the gaps between the chunks' pairs, in place."""
    for k in range(len(starts) - 1):
        for i in range(starts[k + 1] - starts[k]):
            x[starts[k] + i] = x[most[k] + i]
            y[starts[k] + i] = y[most[k] + i]
            t[starts[k] + i] = t[most[k] + i]


@compiled()
def _index(
    lists: tuple[Array, ...], shape: tuple[int, int], part: tuple[int, int], out: tuple[Array, ...], found: Array
) -> None:
    """Sort the pairs of some drawings by pixel, keeping the chunks' order; how many pixels each drawing has.

    The active pixels of a drawing are written from its first pair's place on.
    """
    drawing_chunks, chunk_pairs, row, x, y = lists
    active, start, order, order_row = out
    height, width = shape
    next_free = np.zeros(height * width, np.int32)
    for d in range(part[0], part[1]):
        k0, k1 = drawing_chunks[d], drawing_chunks[d + 1]
        i0, i1 = chunk_pairs[k0], chunk_pairs[k1]
        top, bottom = height, 0
        for i in range(i0, i1):
            top, bottom = min(top, y[i]), max(bottom, y[i] + 1)
            next_free[y[i] * width + x[i]] += 1
        at, a = i0, i0
        for pixel in range(top * width, bottom * width):
            if next_free[pixel] > 0:
                active[a], start[a] = np.int64(d) * (height * width) + pixel, at
                at, next_free[pixel] = at + next_free[pixel], at
                a += 1
        for k in range(k0, k1):
            for i in range(chunk_pairs[k], chunk_pairs[k + 1]):
                pixel = y[i] * width + x[i]
                slot = next_free[pixel]
                order[slot], order_row[slot] = i, row[k]
                next_free[pixel] = slot + 1
        found[d] = a - i0
        next_free[top * width : bottom * width] = 0
