"""What keeps strokes in the shape of strokes while their brush is fitted: rough ink would fold and bend them.

The terms are sums over segments and joints, beside a photometric term that is a sum over pixels.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor

from videovec.losses import curvature, self_intersection
from videovec.strokes import Strokes

__all__ = ["Shape", "unfairness"]

_SMOOTH_TURN = np.cos(np.radians(60.0))  # joints that turn less than this are smooth, and stay so
_CONTINUITY = 0.5
_FAIRNESS = 6.0
_SELF_INTERSECTION, _CURVATURE = 0.1, 1e-4  # supplement A, "Implementation Details"
_SHORTEST = 2.0  # px; shorter segments are held as if they were as long as this


@dataclass(frozen=True, slots=True, eq=False)
class Shape:
    """Which points the terms look at.

    Args:
        segments: Control points of every segment. int64 [G, 4]
        smooth: Control points before, at and after every inner joint at which the strokes turn little. int64 [K, 3]
        side: Longer side of the page. px
    """

    segments: Tensor
    smooth: Tensor
    side: float

    @staticmethod
    def of(strokes: Strokes, side: float) -> Shape:
        """The shape of strokes as they are now."""
        layout = strokes.layout
        return Shape(torch.as_tensor(layout.segment_points), torch.as_tensor(_smooth_joints(strokes)), side)

    def loss(self, points: Tensor) -> Tensor:
        """The weighted sum of all terms at control points [P, 2]. Scalar"""
        segments = points[self.segments]
        total = _CONTINUITY * _kink(points[self.smooth]) + _FAIRNESS * unfairness(segments)
        of_segment = _SELF_INTERSECTION * self_intersection(segments) + _CURVATURE * curvature(segments, self.side)
        return total + len(segments) * of_segment


def unfairness(segments: Tensor) -> Tensor:
    """How far segments are from even arcs: their third difference, and how unequal their three legs are.

    Both are 0 for a straight segment with even handles, and do not change when a segment is scaled; an arc costs the
    square of its angle, a fold much more.

    Args:
        segments: Control points. [G, 4, 2] px

    Returns:
        Sum over all segments. Scalar
    """
    first, second, third = (segments[:, 1:] - segments[:, :-1]).unbind(1)
    chord = segments[:, 3] - segments[:, 0]
    length = chord.detach().square().sum(1).clamp(min=_SHORTEST**2)
    twist = (third - 2 * second + first).square().sum(1)
    uneven = (second - first).square().sum(1) + (third - second).square().sum(1)
    return ((twist + 0.3 * uneven) / length).sum()


def _smooth_joints(strokes: Strokes) -> NDArray[np.intp]:
    layout = strokes.layout
    inner = np.flatnonzero(np.diff(layout.segment_row) == 0)
    triples = layout.segment_points[inner][:, 2:4]
    triples = np.concatenate([triples, layout.segment_points[inner + 1][:, 1:2]], axis=1)
    before = strokes.points[triples[:, 1]] - strokes.points[triples[:, 0]]
    after = strokes.points[triples[:, 2]] - strokes.points[triples[:, 1]]
    scale = np.maximum(np.linalg.norm(before, axis=1) * np.linalg.norm(after, axis=1), 1e-9)
    return np.asarray(triples[(before * after).sum(1) / scale > _SMOOTH_TURN])


def _kink(triples: Tensor) -> Tensor:
    """Sum of squared differences of the unit tangents at smooth joints [K, 3, 2]. Scalar"""
    before, at, after = triples.unbind(1)
    incoming = torch.nn.functional.normalize(at - before, dim=1, eps=1e-3)
    outgoing = torch.nn.functional.normalize(after - at, dim=1, eps=1e-3)
    return (incoming - outgoing).square().sum()
