"""Pair lists on the CPU: scan lines over each chunk, chunks and drawings in parallel."""

from __future__ import annotations

from typing import Any

import numpy as np
import torch
from numba import njit, prange
from numpy.typing import NDArray

from videovec.render.pairs import Chunks, PairList
from videovec.render.scene import Scene

__all__ = ["find_pairs"]

Array = NDArray[Any]

PIECES = 6
"""Straight pieces that stand for a chunk while its pixels are sought."""
SAG = 0.3
"""How far a chunk may lie from those pieces. px"""


def find_pairs(scene: Scene, chunks: Chunks, reach: float) -> PairList:
    """List the pixels within half-width + ``reach`` of every chunk."""
    size = np.array(scene.size)
    segment, drawing_chunks = chunks.segment.numpy(), chunks.drawing_chunks.numpy()
    polylines = _polylines(
        scene.control.detach().numpy(), scene.half_width.detach().numpy(), segment, chunks.bounds.numpy(), reach
    )
    most = _starts(_count(polylines, size))
    pairs = (np.empty(most[-1], np.int16), np.empty(most[-1], np.int16), np.empty(most[-1], polylines.dtype))
    chunk_pairs = _starts(_fill(polylines, chunks.bounds.numpy(), size, most, *pairs))
    x, y, t = _compact(most, chunk_pairs, *pairs)

    row = scene.row.numpy()[segment].astype(np.int32)
    drawing_pixels = _starts(_count_active(drawing_chunks, chunk_pairs, x, y, size))
    active, start, order, order_row = _index(drawing_chunks, chunk_pairs, row, x, y, drawing_pixels, size)
    as_tensor = torch.from_numpy
    return PairList(
        chunks=chunks,
        chunk_pairs=as_tensor(chunk_pairs),
        x=as_tensor(x),
        y=as_tensor(y),
        t=as_tensor(t),
        active=as_tensor(active),
        start=as_tensor(start),
        order=as_tensor(order),
        order_row=as_tensor(order_row),
        drawing_pixels=as_tensor(drawing_pixels),
    )


def _starts(counts: Array) -> Array:
    return np.concatenate([np.zeros(1, np.int64), np.cumsum(counts, dtype=np.int64)])


@njit(cache=True, parallel=True, error_model="numpy")
def _polylines(control: Array, half_width: Array, segment: Array, bounds: Array, reach: float) -> Array:
    """Vertices of each chunk and how far around them its pixels lie. [K, PIECES + 1, 3] px"""
    out = np.empty((len(segment), PIECES + 1, 3), control.dtype)
    for k in prange(len(segment)):
        p, h = control[segment[k]], half_width[segment[k]]
        widest = 0.0
        for j in range(PIECES + 1):
            t = bounds[k, 0] + (bounds[k, 1] - bounds[k, 0]) * j / PIECES
            s = 1 - t
            for axis in range(2):
                out[k, j, axis] = s * s * (s * p[0, axis] + 3 * t * p[1, axis]) + t * t * (
                    3 * s * p[2, axis] + t * p[3, axis]
                )
            widest = max(widest, s * h[0] + t * h[1])
        out[k, :, 2] = widest + reach
    return out


@njit(cache=True, inline="always", error_model="numpy")
def _span(polyline: Array, y: float) -> tuple[float, float]:
    """The stretch of a scan line that may lie within reach of a polyline; empty if the first exceeds the second. px"""
    left, right = np.inf, -np.inf
    reach = polyline[0, 2] + SAG
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


@njit(cache=True, inline="always", error_model="numpy")
def _lines(polyline: Array, height: int) -> tuple[int, int]:
    """First scan line of a polyline, and the one after its last."""
    reach = polyline[0, 2] + SAG
    low, high = polyline[:, 1].min() - reach, polyline[:, 1].max() + reach
    return int(max(0.0, np.floor(low - 0.5))), int(min(height - 1.0, np.ceil(high - 0.5))) + 1


@njit(cache=True, inline="always", error_model="numpy")
def _columns(polyline: Array, y: int, width: int) -> tuple[int, int]:
    """First column of a scan line that may be within reach, and the one after the last."""
    left, right = _span(polyline, y + 0.5)
    if not left <= right:
        return 0, 0
    return int(max(0.0, np.ceil(left - 0.5))), int(min(width - 1.0, np.floor(right - 0.5))) + 1


@njit(cache=True, parallel=True, error_model="numpy")
def _count(polylines: Array, size: Array) -> Array:
    """The most pixels that each chunk can reach."""
    count = np.zeros(len(polylines), np.int64)
    for k in prange(len(polylines)):
        begin, end = _lines(polylines[k], size[1])
        total = 0
        for y in range(begin, end):
            x0, x1 = _columns(polylines[k], y, size[2])
            total += max(0, x1 - x0)
        count[k] = total
    return count


@njit(cache=True, parallel=True, error_model="numpy")
def _fill(polylines: Array, bounds: Array, size: Array, most: Array, xs: Array, ys: Array, ts: Array) -> Array:
    """Write each chunk's pixels within reach from ``most[k]`` on; how many there are."""
    found = np.zeros(len(polylines), np.int64)
    for k in prange(len(polylines)):
        line = polylines[k]
        begin, end = _lines(line, size[1])
        farthest = (line[0, 2] + SAG) ** 2
        at = most[k]
        for y in range(begin, end):
            x0, x1 = _columns(line, y, size[2])
            for x in range(x0, x1):
                nearest, along = _nearest(line, x + 0.5, y + 0.5)
                if nearest <= farthest:
                    xs[at], ys[at] = x, y
                    ts[at] = bounds[k, 0] + (bounds[k, 1] - bounds[k, 0]) * along
                    at += 1
        found[k] = at - most[k]
    return found


@njit(cache=True, inline="always", error_model="numpy")
def _nearest(line: Array, x: float, y: float) -> tuple[float, float]:
    """Squared distance to a polyline, px², and how far along it the nearest point lies, in [0, 1]."""
    best, along = np.inf, 0.0
    for j in range(PIECES):
        ex, ey = line[j + 1, 0] - line[j, 0], line[j + 1, 1] - line[j, 1]
        rx, ry = x - line[j, 0], y - line[j, 1]
        part = min(1.0, max(0.0, (rx * ex + ry * ey) / max(ex * ex + ey * ey, 1e-12)))
        rx, ry = rx - part * ex, ry - part * ey
        distance = rx * rx + ry * ry
        if distance < best:
            best, along = distance, (j + part) / PIECES
    return best, along


@njit(cache=True, parallel=True)
def _compact(most: Array, starts: Array, x: Array, y: Array, t: Array) -> tuple[Array, Array, Array]:
    """Close the gaps between the chunks' pairs."""
    n = starts[-1]
    out_x, out_y, out_t = np.empty(n, x.dtype), np.empty(n, y.dtype), np.empty(n, t.dtype)
    for k in prange(len(starts) - 1):
        for i in range(starts[k + 1] - starts[k]):
            out_x[starts[k] + i] = x[most[k] + i]
            out_y[starts[k] + i] = y[most[k] + i]
            out_t[starts[k] + i] = t[most[k] + i]
    return out_x, out_y, out_t


@njit(cache=True, parallel=True)
def _count_active(drawing_chunks: Array, chunk_pairs: Array, x: Array, y: Array, size: Array) -> Array:
    """Number of pixels of each drawing that have a pair."""
    count = np.zeros(size[0], np.int64)
    for d in prange(size[0]):
        touched = np.zeros(size[1] * size[2], np.bool_)
        for i in range(chunk_pairs[drawing_chunks[d]], chunk_pairs[drawing_chunks[d + 1]]):
            touched[np.int64(y[i]) * size[2] + x[i]] = True
        count[d] = touched.sum()
    return count


@njit(cache=True, parallel=True)
def _index(
    drawing_chunks: Array, chunk_pairs: Array, row: Array, x: Array, y: Array, drawing_pixels: Array, size: Array
) -> tuple[Array, Array, Array, Array]:
    """Sort pairs by pixel, keeping the chunks' order: a counting sort for each drawing."""
    pixels = size[1] * size[2]
    active = np.empty(drawing_pixels[-1], np.int64)
    start = np.empty(drawing_pixels[-1] + 1, np.int64)
    order = np.empty(len(x), np.int32)
    order_row = np.empty(len(x), np.int32)
    start[-1] = len(x)
    for d in prange(size[0]):
        next_free = np.zeros(pixels, np.int32)
        k0, k1 = drawing_chunks[d], drawing_chunks[d + 1]
        for i in range(chunk_pairs[k0], chunk_pairs[k1]):
            next_free[np.int64(y[i]) * size[2] + x[i]] += 1
        at, a = chunk_pairs[k0], drawing_pixels[d]
        for pixel in range(pixels):
            count = next_free[pixel]
            if count > 0:
                active[a], start[a] = d * pixels + pixel, at
                next_free[pixel] = at
                at += count
                a += 1
        for k in range(k0, k1):
            for i in range(chunk_pairs[k], chunk_pairs[k + 1]):
                pixel = np.int64(y[i]) * size[2] + x[i]
                slot = next_free[pixel]
                order[slot], order_row[slot] = i, row[k]
                next_free[pixel] = slot + 1
    return active, start, order, order_row
