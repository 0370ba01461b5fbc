"""Which chunks of strokes can touch which pixels: the list that makes the renderer's cost grow with ink.

Segments are cut into short chunks; a chunk and a pixel within its reach are a *pair*, with a first guess of the chunk's
point nearest to the pixel's centre. A list stays valid while no point moves and no half-width grows by more than its
margin, so a fit makes a new one every ten steps or so, and whenever the kernel's scale changes.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import torch
from torch import Tensor

from videovec.render.scene import Scene

__all__ = ["Chunks", "PairList", "cut_chunks", "kernel_reach"]

CHUNK_ARC = 24.0
"""Longest chunk. px"""
CHUNK_TURN = 1.6
"""Most that the control polygon of a chunk may turn. rad"""
MOST_CHUNKS = 4096
"""Of one segment: bounds the memory of strokes that fly off the page."""
MARGIN = 1.0
"""How far points may move, or half-widths grow, before a list is stale. px"""
ARC_SAMPLES = 8
"""Pieces of the polyline that measures a segment."""
PIECES = 6
"""Straight pieces that stand for a chunk while its pixels are sought."""
SAG = 0.3
"""How far a chunk may lie from those pieces. px"""


@dataclass(frozen=True, slots=True, eq=False)
class Chunks:
    """K pieces of segments, sorted by drawing, then row, then along the stroke.

    Args:
        segment: Segment of each chunk. int64 [K]
        bounds: Its part of the segment, in t. [K, 2]
        drawing_chunks: Chunk at which each drawing begins, then K. int64 [D+1]
    """

    segment: Tensor
    bounds: Tensor
    drawing_chunks: Tensor


@dataclass(frozen=True, slots=True, eq=False)
class PairList:
    """N pairs (chunk, pixel) on A active pixels: chunk by chunk, and indexed by pixel in compositing order.

    Rendering improves ``t`` in place, as the start of the next step.

    Args:
        chunks: The chunks.
        chunk_pairs: Pair at which each chunk begins, then N. int64 [K+1]
        x: Column of each pair's pixel. int16 [N]
        y: Row of each pair's pixel. int16 [N]
        t: Parameter of the chunk's point nearest to the pixel's centre. [N]
        active: Pixels with at least one pair, as drawing * H * W + y * W + x; of each drawing first those with a single
            pair, then those with two of one row, then the others, each lot by first pair. int64 [A]
        start: Where each active pixel's pairs begin in ``order``, then N. int64 [A+1]
        order: Pairs by active pixel, lower rows first. int32 [N]
        order_row: Row of each pair in ``order``. int32 [N]
        drawing_pixels: Active pixel at which each drawing begins, then A. int64 [D+1]
        plain: One after each drawing's last active pixel with a single pair, and with two of one row. int64 [D, 2]
    """

    chunks: Chunks
    chunk_pairs: Tensor
    x: Tensor
    y: Tensor
    t: Tensor
    active: Tensor
    start: Tensor
    order: Tensor
    order_row: Tensor
    drawing_pixels: Tensor
    plain: Tensor

    def __len__(self) -> int:
        """N."""
        return int(self.t.shape[0])


def kernel_reach(scale: float) -> float:
    """How far the kernel of a pixel reaches from its centre: half the diagonal. px"""
    return scale * math.sqrt(0.5)


def cut_chunks(scene: Scene, margin: float = MARGIN) -> Chunks:
    """Cut the visible part of every segment, and ``margin`` px more, into chunks of even t."""
    control, interval = scene.control.detach(), scene.interval.detach()
    t = torch.linspace(0, 1, ARC_SAMPLES + 1, dtype=control.dtype, device=control.device)
    basis = torch.stack([(1 - t) ** 3, 3 * t * (1 - t) ** 2, 3 * t**2 * (1 - t), t**3], dim=-1)
    arc = (basis @ control).diff(dim=1).norm(dim=-1).sum(dim=1)  # [G]
    legs = control.diff(dim=1)  # [G, 3, 2]
    cross = legs[:, :-1, 0] * legs[:, 1:, 1] - legs[:, :-1, 1] * legs[:, 1:, 0]
    turn = torch.atan2(cross, (legs[:, :-1] * legs[:, 1:]).sum(-1)).abs().sum(dim=1)  # [G]

    slack = (margin / arc.clamp(min=margin))[:, None]
    first, last = (interval + slack * interval.new_tensor([-1.0, 1.0])).clamp(0, 1).unbind(-1)
    is_visible = interval[:, 1] > interval[:, 0]
    pieces = torch.maximum(arc / CHUNK_ARC, turn / CHUNK_TURN) * (last - first)
    count = pieces.ceil().clamp(1, MOST_CHUNKS).long() * is_visible

    segment_drawing = scene.drawing[scene.row]
    by_drawing = torch.argsort(segment_drawing, stable=True)
    count = count[by_drawing]
    segment = torch.repeat_interleave(by_drawing, count)
    before = torch.repeat_interleave(count.cumsum(0) - count, count)
    within = torch.arange(len(segment), device=segment.device) - before
    step = torch.repeat_interleave((last - first)[by_drawing] / count.clamp(min=1), count)
    begin = first[segment] + step * within
    drawings = torch.arange(scene.size[0] + 1, device=segment.device)
    return Chunks(
        segment=segment,
        bounds=torch.stack([begin, begin + step], dim=-1),
        drawing_chunks=torch.searchsorted(segment_drawing[segment].contiguous(), drawings),
    )
