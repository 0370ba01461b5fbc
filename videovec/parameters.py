"""Strokes as the unconstrained tensors that an optimiser moves, and back."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor

from videovec.render import CoverageMatch, Scene
from videovec.strokes import Strokes
from videovec.visibility import visible_intervals

__all__ = ["Parameters"]

MIN_HALF_WIDTH = 0.05  # px; thinner ink cannot be told from noise
_OPAQUE_LOGIT = 9.0  # opacity 1 - 1.2e-4 and all above counts as opaque


@dataclass(frozen=True, slots=True, eq=False)
class _Index:
    """Where the renderer's rows and segments, in layer order, find their parameters.

    Points and joints that close a stroke stand for the first of their row.
    """

    points: Tensor  # [G, 4]
    joints: Tensor  # [G, 2]
    row: Tensor  # [G], rank of the row
    rows: Tensor  # [R], row of each rank
    drawing: Tensor  # [R], by rank
    segments: NDArray[np.intp]  # [G], segment of the strokes behind each


@dataclass(frozen=True, slots=True, eq=False)
class Parameters:
    """The free tensors of a fit, changed in place by an optimiser.

    Args:
        strokes: Where they started: topology, identities, and all that is not fitted.
        points: Control points. [P, 2] px
        log_half_width: Logarithm of the half-width at joints. [J]
        logit_opacity: Logit of each row's opacity. [R]
        index: How the renderer reads them.
    """

    strokes: Strokes
    points: Tensor
    log_half_width: Tensor
    logit_opacity: Tensor
    index: _Index

    @staticmethod
    def of(strokes: Strokes, device: torch.device | str = "cpu") -> Parameters:
        """Free tensors that start at the given strokes. float32"""

        def leaf(values: NDArray[np.float64]) -> Tensor:
            return torch.as_tensor(values, dtype=torch.float32, device=device).requires_grad_()

        opacity = np.clip(strokes.opacity, 1e-4, 1 - 1e-4)
        return Parameters(
            strokes=strokes,
            points=leaf(strokes.points.copy()),
            log_half_width=leaf(np.log(np.maximum(strokes.half_width, MIN_HALF_WIDTH))),
            logit_opacity=leaf(np.log(opacity / (1 - opacity))),
            index=_index(strokes, device),
        )

    def intervals(self) -> Tensor:
        """The visible part of each of the renderer's segments, for the points as they are now. [G, 2] in t"""
        intervals = visible_intervals(replace(self.strokes, points=_numpy(self.points)))
        return torch.as_tensor(intervals[self.index.segments], dtype=self.points.dtype, device=self.points.device)

    def scene(self, size: tuple[int, int, int], intervals: Tensor) -> Scene:
        """What the renderer draws: coverage alone, in one channel.

        Args:
            size: D, H and W of the pages.
            intervals: The visible part of each segment. [G, 2] in t
        """
        index = self.index
        opacity = torch.sigmoid(self.logit_opacity)
        opacity = torch.where(self.logit_opacity > _OPAQUE_LOGIT, torch.ones_like(opacity), opacity)
        return Scene(
            control=self.points[index.points],
            half_width=self.log_half_width.exp()[index.joints],
            interval=intervals,
            row=index.row,
            opacity=opacity[index.rows],
            color=opacity.new_zeros((len(index.rows), 0)),
            drawing=index.drawing,
            size=size,
        )

    def accumulate(self, gradients: CoverageMatch) -> None:
        """Add the renderer's gradients of segments and rows to those of the free tensors."""
        index = self.index
        with torch.no_grad():
            half_width = self.log_half_width.exp()[index.joints]
            opacity = torch.sigmoid(self.logit_opacity)[index.rows]
            for tensor, where, gradient in (
                (self.points, index.points, gradients.control),
                (self.log_half_width, index.joints, gradients.half_width * half_width),
                (self.logit_opacity, index.rows, gradients.opacity * opacity * (1 - opacity)),
            ):
                if tensor.grad is None:
                    tensor.grad = torch.zeros_like(tensor)
                tensor.grad.index_add_(0, where.flatten(), gradient.reshape(-1, *tensor.shape[1:]))

    def to_strokes(self) -> Strokes:
        """The strokes that the tensors stand for now."""
        point, joint = _ties(self.strokes)
        opacity = _numpy(torch.sigmoid(self.logit_opacity))
        return replace(
            self.strokes,
            points=_numpy(self.points)[point],
            half_width=np.exp(_numpy(self.log_half_width))[joint],
            opacity=np.where(_numpy(self.logit_opacity) > _OPAQUE_LOGIT, 1.0, opacity),
        )


def _numpy(tensor: Tensor) -> NDArray[np.float64]:
    return tensor.detach().cpu().numpy().astype(np.float64)


def _index(strokes: Strokes, device: torch.device | str) -> _Index:
    layout = strokes.layout
    point, joint = _ties(strokes)
    rows = np.lexsort((strokes.layer[layout.row_stroke], layout.row_drawing))
    rank = np.empty_like(rows)
    rank[rows] = np.arange(len(rows))
    segments = np.argsort(rank[layout.segment_row], kind="stable")

    def put(values: NDArray[np.intp]) -> Tensor:
        return torch.as_tensor(values, dtype=torch.int64, device=device)

    return _Index(
        points=put(point[layout.segment_points[segments]]),
        joints=put(joint[layout.segment_joints[segments]]),
        row=put(rank[layout.segment_row[segments]]),
        rows=put(rows),
        drawing=put(layout.row_drawing[rows]),
        segments=segments,
    )


def _ties(strokes: Strokes) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """The point [P] and the joint [J] that stand behind each one.

    Itself, or its row's first where a stroke closes; for a part beyond a gap, that of its parent.
    """
    layout = strokes.layout
    point = np.arange(int(layout.row_points[-1]))
    joint = np.arange(int(layout.row_joints[-1]))
    rows = np.flatnonzero(strokes.is_closed[layout.row_stroke])
    point[layout.row_points[rows + 1] - 1] = layout.row_points[rows]
    joint[layout.row_joints[rows + 1] - 1] = layout.row_joints[rows]
    for row, other in _rows_of_parents(strokes):
        for behind, starts in ((point, layout.row_points), (joint, layout.row_joints)):
            behind[starts[row] : starts[row + 1]] = behind[starts[other] : starts[other + 1]]
    return point, joint


def _rows_of_parents(strokes: Strokes) -> Iterator[tuple[int, int]]:
    """Each row of a part beyond a gap, and its parent's on the same drawing if that is there."""
    layout = strokes.layout
    position = {identity: s for s, identity in enumerate(strokes.ids.tolist())}
    for child in np.flatnonzero(strokes.parent).tolist():
        parent = position.get(int(strokes.parent[child]))
        if parent is None or layout.segments[parent] != layout.segments[child]:
            continue
        first, last = (int(f(x[[child, parent]])) for f, x in ((np.max, layout.first), (np.min, layout.last)))
        for drawing in range(first, last + 1):
            yield strokes.row(child, drawing), strokes.row(parent, drawing)
