"""Pair lists on any device: every pixel of each chunk's box is a candidate."""

from __future__ import annotations

import torch
from torch import Tensor

from videovec.render.pairs import PIECES, SAG, Chunks, PairList
from videovec.render.scene import Scene

__all__ = ["find_pairs"]


def find_pairs(scene: Scene, chunks: Chunks, reach: float) -> PairList:
    """List the pixels within half-width + ``reach`` of every chunk."""
    vertices, reaches = _polylines(scene, chunks, reach)
    chunk, x, y = _boxes(vertices, reaches, scene.size)
    nearest, along = _nearest(vertices, chunk, torch.stack([x, y], dim=-1) + 0.5)
    within = (nearest <= reaches[chunk] ** 2).nonzero().squeeze(1)
    chunk, x, y, along = chunk[within], x[within], y[within], along[within]
    bounds = chunks.bounds[chunk]
    return _index(scene, chunks, chunk, x, y, torch.lerp(bounds[:, 0], bounds[:, 1], along))


def _polylines(scene: Scene, chunks: Chunks, reach: float) -> tuple[Tensor, Tensor]:
    """Vertices of each chunk [K, PIECES + 1, 2] and how far around them its pixels lie [K]. px"""
    control, half_width = scene.control.detach()[chunks.segment], scene.half_width.detach()[chunks.segment]
    part = torch.linspace(0, 1, PIECES + 1, dtype=control.dtype, device=control.device)
    t = torch.lerp(chunks.bounds[:, :1], chunks.bounds[:, 1:], part)  # [K, PIECES + 1]
    s = 1 - t
    basis = torch.stack([s**3, 3 * s**2 * t, 3 * s * t**2, t**3], dim=-1)
    widest = (s * half_width[:, :1] + t * half_width[:, 1:]).max(dim=1).values
    return basis @ control, widest + reach + SAG


def _boxes(vertices: Tensor, reaches: Tensor, size: tuple[int, int, int]) -> tuple[Tensor, Tensor, Tensor]:
    """Chunk, column and row of every pixel in the box around each chunk."""
    limit = torch.tensor([size[2], size[1]], device=vertices.device)
    low = (vertices.min(dim=1).values - reaches[:, None] - 0.5).ceil().long().clamp(min=0)
    high = (vertices.max(dim=1).values + reaches[:, None] - 0.5).floor().long().add(1).minimum(limit)
    extent = (high - low).clamp(min=0)
    count = extent.prod(dim=-1)
    chunk = torch.repeat_interleave(torch.arange(len(count), device=count.device), count)
    within = torch.arange(len(chunk), device=count.device) - (count.cumsum(0) - count)[chunk]
    columns = extent[chunk, 0]
    return chunk, low[chunk, 0] + within % columns, low[chunk, 1] + within // columns


def _nearest(vertices: Tensor, chunk: Tensor, point: Tensor) -> tuple[Tensor, Tensor]:
    """Squared distance of points to their chunks' polylines, px², and how far along the nearest point lies."""
    best = vertices.new_full((len(point),), torch.inf)
    along = torch.zeros_like(best)
    for j in range(PIECES):
        begin = vertices[:, j][chunk]
        edge = vertices[:, j + 1][chunk] - begin
        r = point - begin
        part = ((r * edge).sum(-1) / (edge * edge).sum(-1).clamp(min=1e-12)).clamp(0, 1)
        distance = (r - part[:, None] * edge).square().sum(-1)
        along = torch.where(distance < best, (j + part) / PIECES, along)
        best = torch.minimum(best, distance)
    return best, along


def _index(scene: Scene, chunks: Chunks, chunk: Tensor, x: Tensor, y: Tensor, t: Tensor) -> PairList:
    drawings, height, width = scene.size
    row = scene.row[chunks.segment[chunk]]
    flat = (scene.drawing[row] * height + y) * width + x
    order = torch.argsort(flat, stable=True)
    active, count = torch.unique_consecutive(flat[order], return_counts=True)
    before = count.cumsum(0) - count
    lot = active // (height * width) * 3 + _kind(row[order], before, count)
    pixels = torch.argsort(lot * max(len(order), 1) + order[before])
    count, start = count[pixels], torch.cat([count.new_zeros(1), count[pixels].cumsum(0)])
    order = order[
        torch.repeat_interleave(before[pixels] - start[:-1], count) + torch.arange(len(order), device=x.device)
    ]
    chunk_counts = torch.bincount(chunk, minlength=len(chunks.segment))
    lots = torch.bincount(lot, minlength=3 * drawings).cumsum(0).view(drawings, 3)
    return PairList(
        chunks=chunks,
        chunk_pairs=torch.cat([chunk_counts.new_zeros(1), chunk_counts.cumsum(0)]),
        x=x.to(torch.int16),
        y=y.to(torch.int16),
        t=t,
        active=active[pixels],
        start=start,
        order=order.to(torch.int32),
        order_row=row[order].to(torch.int32),
        drawing_pixels=torch.cat([lots.new_zeros(1), lots[:, 2]]),
        plain=lots[:, :2].contiguous(),
    )


def _kind(row: Tensor, begin: Tensor, count: Tensor) -> Tensor:
    """0 for pixels with a single pair, 1 for those with two of one row, 2 for the others."""
    if not len(row):
        return torch.zeros_like(begin)
    second = row[(begin + 1).clamp(max=len(row) - 1)]
    return torch.where(count == 1, 0, torch.where((count == 2) & (row[begin] == second), 1, 2))
