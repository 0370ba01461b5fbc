"""The pair list of a scene, by the back end of its device."""

from __future__ import annotations

import torch

from videovec.errors import FitError
from videovec.render.pairs import MARGIN, PairList, cut_chunks, kernel_reach
from videovec.render.scene import Scene

__all__ = ["list_pairs"]


@torch.no_grad()
def list_pairs(scene: Scene, scale: float, *, margin: float = MARGIN) -> PairList:
    """List the (chunk, pixel) pairs within reach, on the device of the scene.

    Args:
        scene: The strokes. Its tensors are read, never kept.
        scale: Width of the kernel in pixels, 1 for the pixel itself.
        margin: How far points may move before the list is stale. px

    Returns:
        All pairs nearer than half-width + kernel + margin.

    Raises:
        FitError: A control point is not a number; looked for on the CPU alone, where looking costs nothing.
    """
    if scene.control.device.type == "cpu" and not bool(scene.control.isfinite().all()):
        lost = (~scene.control.isfinite()).flatten(1).any(1).nonzero()[0, 0]
        raise FitError(f"scene.control must be finite, got {scene.control[lost].tolist()} in segment {int(lost)}")
    chunks = cut_chunks(scene, margin)
    if scene.control.device.type == "cpu":
        from videovec.render.numba_pairs import find_pairs
    else:
        from videovec.render.torch_pairs import find_pairs
    return find_pairs(scene, chunks, kernel_reach(scale) + margin)
