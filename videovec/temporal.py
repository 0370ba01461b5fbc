"""Terms that tie a stroke's drawings together: smooth motion, kept shape, kept width.

All are sums, unweighted, in px² unless said; the photometric term is a sum of squares over pixels, so that the balance
between them does not depend on the size of the page or the length of the clip.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor

from videovec.strokes import Layout, Strokes

__all__ = ["Neighbours", "acceleration", "anchor", "moves_far", "rigidity", "width_change"]

_HOPS = (1, 2, 4, 8)  # control points between the ends and the middle of a triple
_SMALL = 0.5  # px; differences in time that are larger are motion
_FAR = 12.0  # px; what moves farther from one drawing to the next also changes its shape
_FASTEST = 0.9  # quantile of motion above which strokes are the fastest
_SHORT = 1.0  # px²; a triple whose ends are nearer than this says nothing about shape


@dataclass(frozen=True, slots=True, eq=False)
class Neighbours:
    """Which points and joints are the same material one drawing later, and which lie side by side on a row.

    Args:
        points: Control points that have a next drawing. int [A]
        middle: Control points with a drawing before and one after; the steps to them are ``stride``. int [B]
        stride: Control points from one drawing to the next. int [B]
        joints: Joints that have a next drawing. int [C]
        next_joints: The same joints one drawing later. int [C]
        first: Control points of each stroke's first drawing. int [F]
        triples: First, middle and last point of a triple on a row that has a next drawing. int [E, 3]
        next_triples: The same triple one drawing later. int [E, 3]
        hops: Control points between the middle and the ends of each triple. [E]
    """

    points: Tensor
    middle: Tensor
    stride: Tensor
    joints: Tensor
    next_joints: Tensor
    first: Tensor
    triples: Tensor
    next_triples: Tensor
    hops: Tensor

    @staticmethod
    def of(layout: Layout, device: torch.device | str = "cpu") -> Neighbours:
        """The neighbours of every point of the strokes."""
        row, joint_row = layout.point_row, layout.joint_row
        has_next = layout.row_drawing < layout.last[layout.row_stroke]
        has_before = layout.row_drawing > layout.first[layout.row_stroke]
        stride = (3 * layout.segments + 1)[layout.row_stroke][row]
        joint_stride = (layout.segments + 1)[layout.row_stroke][joint_row]
        points = np.flatnonzero(has_next[row])
        middle = np.flatnonzero((has_next & has_before)[row])
        joints = np.flatnonzero(has_next[joint_row])
        triples, hops = _triples(layout, points)

        def put(values: NDArray[np.intp]) -> Tensor:
            return torch.as_tensor(values, device=device)

        return Neighbours(
            points=put(points),
            middle=put(middle),
            stride=put(stride[middle]),
            joints=put(joints),
            next_joints=put(joints + joint_stride[joints]),
            first=put(np.flatnonzero(~has_before[row])),
            triples=put(triples),
            next_triples=put(triples + stride[triples]),
            hops=put(hops),
        )


def _triples(layout: Layout, points: NDArray[np.intp]) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    row = layout.point_row[points]
    place, count = points - layout.row_points[row], np.diff(layout.row_points)[row]
    found, hops = [], []
    for hop in _HOPS:
        inside = points[(place >= hop) & (place + hop < count)]
        found.append(inside[:, None] + np.array([-hop, 0, hop]))
        hops.append(np.full(len(inside), hop))
    return np.concatenate(found), np.concatenate(hops)


def moves_far(strokes: Strokes) -> bool:
    """Whether the fastest tenth of control points change their shape, too, for how far they go between drawings."""
    neighbours = Neighbours.of(strokes.layout)
    here = neighbours.points.numpy()
    if not len(here):
        return False
    layout = strokes.layout
    later = here + (3 * layout.segments + 1)[layout.row_stroke][layout.point_row[here]]
    moved = np.linalg.norm(strokes.points[later] - strokes.points[here], axis=1)
    return bool(np.quantile(moved, _FASTEST) > _FAR)


def acceleration(points: Tensor, neighbours: Neighbours) -> Tensor:
    """How much strokes tremble: their second differences over drawings, as far as these are small.

    A tremble is a fraction of a pixel; what moves by more than `_SMALL` meant to, and is not held back.

    Args:
        points: Control points, row by row. [P, 2] px
        neighbours: Who follows whom.

    Returns:
        Sum over control points of the robust square. px² per drawing⁴. Scalar.
    """
    middle, stride = neighbours.middle, neighbours.stride
    return _robust(points[middle - stride] - 2 * points[middle] + points[middle + stride]).sum()


def anchor(points: Tensor, start: Tensor, neighbours: Neighbours) -> Tensor:
    """How far the strokes of their first drawings have moved.

    Ink does not show how a line lies along itself; a stroke's first drawing says which material each point is, and
    without this term all drawings could slide along their lines together.

    Args:
        points: Control points, row by row. [P, 2] px
        start: Where they were. [P, 2] px
        neighbours: Which of them are first.

    Returns:
        Sum of squared distances. px². Scalar.
    """
    return (points[neighbours.first] - start[neighbours.first]).square().sum()


def rigidity(points: Tensor, neighbours: Neighbours) -> Tensor:
    """How far strokes are from changing by local similarities only: no shear, no sliding along themselves.

    A triple of control points (a, b, c) has b = a + z (c - a) with a complex z that no similarity changes. The term
    draws b where the neighbouring drawing's z puts it, for triples of growing reach.

    Args:
        points: Control points, row by row. [P, 2] px
        neighbours: Who follows whom.

    Returns:
        Sum over triples of the robust square of the distance, weighted by one over their reach; less of those that
        move far. px². Scalar.

    Source:
        After Sorkine and Alexa 2007, "As-rigid-as-possible surface modeling", with similarities for rotations.
    """
    if not len(neighbours.triples):
        return points.new_zeros(())
    now, later = points[neighbours.triples], points[neighbours.next_triples]
    weight = _tells_shape(now) * _tells_shape(later) * _is_near(now, later) / neighbours.hops
    ahead = later[:, 1] - _transferred(now, later)
    back = now[:, 1] - _transferred(later, now)
    return 0.5 * (weight * (_robust(ahead) + _robust(back))).sum()


def _robust(differences: Tensor) -> Tensor:
    """Squared lengths that grow only as a logarithm beyond `_SMALL`: Cauchy's loss. [N]"""
    return _SMALL**2 * torch.log1p(differences.square().sum(1) / _SMALL**2)


def _tells_shape(triples: Tensor) -> Tensor:
    """1 for triples whose ends are far enough apart to give a direction, else 0. [E]"""
    return ((triples[:, 2] - triples[:, 0]).square().sum(1) > _SHORT).to(triples.dtype)


def _is_near(now: Tensor, later: Tensor) -> Tensor:
    """1 for triples that hardly move, falling to 0 for those that move far. [E]"""
    moved = (later[:, 1] - now[:, 1]).square().sum(1)
    return 1.0 / (1.0 + (moved / _FAR**2).square())


def _transferred(source: Tensor, target: Tensor) -> Tensor:
    """The middle of each target triple where the shape of the source triple puts it. [E, 2]"""
    span, arm = source[:, 2] - source[:, 0], source[:, 1] - source[:, 0]
    length = span.square().sum(1).clamp_min(_SHORT)
    real = (arm * span).sum(1) / length
    imaginary = (span[:, 0] * arm[:, 1] - span[:, 1] * arm[:, 0]) / length
    new = target[:, 2] - target[:, 0]
    turned = torch.stack([-new[:, 1], new[:, 0]], dim=1)
    return target[:, 0] + real[:, None] * new + imaginary[:, None] * turned


def width_change(log_half_width: Tensor, neighbours: Neighbours) -> Tensor:
    """Sum of squared changes of the logarithm of the half-width from drawing to drawing.

    Args:
        log_half_width: Of every joint, row by row. [J]
        neighbours: Who follows whom.

    Returns:
        Sum over joints, without unit. Scalar.
    """
    return (log_half_width[neighbours.next_joints] - log_half_width[neighbours.joints]).square().sum()
