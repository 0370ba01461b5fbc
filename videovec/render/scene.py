"""What the renderer is given: a flat batch of cubic segments over several drawings."""

from __future__ import annotations

from dataclasses import dataclass

from torch import Tensor

__all__ = ["Scene"]


@dataclass(frozen=True, slots=True, eq=False)
class Scene:
    """G segments of R rows on D pages of H x W px.

    A row is one stroke on one drawing. Rows are composited in their order, the later ones above.

    Args:
        control: Control points of each segment. [G, 4, 2] px
        half_width: Half-width at both ends of each segment, linear in t between them. [G, 2] px
        interval: The part of each segment that is visible, in t; equal ends draw nothing. [G, 2] in [0, 1]
        row: Row of each segment, not decreasing. int64 [G]
        opacity: Plateau coverage of each row. [R] in [0, 1]
        color: Ink of each row. [R, C]
        drawing: Page of each row. int64 [R]
        size: D, H and W.
    """

    control: Tensor
    half_width: Tensor
    interval: Tensor
    row: Tensor
    opacity: Tensor
    color: Tensor
    drawing: Tensor
    size: tuple[int, int, int]
