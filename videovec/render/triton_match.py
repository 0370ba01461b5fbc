"""The step of a fit on a GPU: what `videovec.render.triton_kernels` needs, and what it gives."""

from __future__ import annotations

import torch
import triton
from torch import Tensor

from videovec.render.pairs import PairList
from videovec.render.scene import Scene
from videovec.render.triton_kernels import cover_chunks, gather_segments, match_pixels

__all__ = ["match_with_triton"]

_BLOCK = 128
"""Pairs or pixels that a program takes at once."""


def match_with_triton(
    scene: Scene, pairs: PairList, scale: float, target: Tensor, extra: Tensor | None = None
) -> tuple[Tensor, ...]:
    """The fields of `videovec.render.fused.CoverageMatch`, computed in float32 on a CUDA device.

    Args:
        scene: The strokes.
        pairs: Its pair list, whose ``t`` is improved in place.
        scale: Width of the kernel in pixels.
        target: Ink coverage, 255 is full. uint8 [D, H, W]
        extra: Derivative of other losses by each active pixel's value. [A]
    """
    control, half_width, interval, opacity = (
        v.detach().float().contiguous() for v in (scene.control, scene.half_width, scene.interval, scene.opacity)
    )
    chunks, device = pairs.chunks, control.device
    bounds, segments, pixels = chunks.bounds.float().contiguous(), len(control), len(pairs.active)
    coverage, value, squared = (torch.empty(n, device=device) for n in (len(pairs), pixels, pixels))
    weight, slope_opacity = torch.zeros(2, len(pairs), device=device)
    grads = [torch.zeros(segments, n, device=device) for n in (8, 2, 2, 1)]
    if len(pairs):
        cover_chunks[(len(chunks.segment),)](
            control, half_width, interval, chunks.segment, bounds, pairs.chunk_pairs, pairs.x, pairs.y, pairs.t,
            coverage, scale, BLOCK=_BLOCK,
        )  # fmt: skip
        added = value if extra is None else extra.detach().float().contiguous()
        match_pixels[(triton.cdiv(pixels, _BLOCK),)](
            opacity, pairs.start, pairs.order, pairs.order_row, pairs.active, target.reshape(-1), added, coverage,
            weight, value, squared, slope_opacity, pixels, HAS_EXTRA=extra is not None, BLOCK=_BLOCK,
        )  # fmt: skip
        first, count = _chunks_of(chunks.segment, segments)
        gather_segments[(segments,)](
            control, half_width, interval, bounds, pairs.chunk_pairs, first, count, pairs.x, pairs.y, pairs.t, weight,
            slope_opacity, *grads, scale, BLOCK=_BLOCK,
        )  # fmt: skip
    control, half_width, interval, opacity = (
        v.to(scene.control.dtype) for v in (*grads[:3], _sums(grads[3][:, 0], _rows(scene)))
    )
    return _sums(squared, pairs.drawing_pixels), value, control.view(-1, 4, 2), half_width, interval, opacity


def _chunks_of(segment: Tensor, segments: int) -> tuple[Tensor, Tensor]:
    """First chunk and number of chunks of every segment; the chunks of one stand together."""
    place = torch.arange(len(segment), device=segment.device)
    first = torch.full((segments,), len(segment), device=segment.device).scatter_reduce(0, segment, place, "amin")
    return first, torch.zeros_like(first).index_add_(0, segment, torch.ones_like(segment))


def _rows(scene: Scene) -> Tensor:
    """Segment at which each row begins, then their number. [R+1]"""
    return torch.searchsorted(scene.row, torch.arange(len(scene.opacity) + 1, device=scene.row.device))


def _sums(values: Tensor, begin: Tensor) -> Tensor:
    """Sum of each of the parts that begin there, by differences of a running sum: the same at every call. float64"""
    running = torch.cat([values.new_zeros(1, dtype=torch.float64), values.double().cumsum(0)])
    return running[begin[1:]] - running[begin[:-1]]
