"""A term against sliding: how far along a stroke its material lies is what its shape at rest says.

Ink does not show how a line lies along itself, and where strokes are followed from drawing to drawing, small slips add
up: control points wander along curves that are right. A line that turns or is stretched evenly keeps the arc fraction
of each of its points, which both of its ends fix; one that is bent and sheared keeps those of the shape at rest after
the affine map that is nearest to what happened to it. Larger differences are uneven stretch, and are left alone.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor

from videovec.curves import Ruler
from videovec.strokes import Strokes

__all__ = ["Marks", "sliding"]

Floats = NDArray[np.float64]

_PARTS = 4  # marks on a segment
_SMALL = 0.5  # px; differences that are larger are uneven stretch
_SPREAD = 4.0  # px; spread of a stroke in a direction at which half of its shear or stretch there is believed
_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(3)


@dataclass(frozen=True, slots=True, eq=False)
class Marks:
    """M marks on the rows of strokes, `_PARTS` to a segment.

    Args:
        control: Control points of each segment. int [G, 4]
        begin: The number of the first mark of each mark's row. int [M]
        end: That of the first mark after the row. int [M]
        fraction: The arc fraction at which each mark belongs. float64 [M]
        basis: Velocity from the legs of a segment at all nodes after each of its marks. [3 * _PARTS, 3]
        weights: Of the nodes. [3]
    """

    control: Tensor
    begin: Tensor
    end: Tensor
    fraction: Tensor
    basis: Tensor
    weights: Tensor

    @staticmethod
    def of(strokes: Strokes, known: NDArray[np.intp] | None = None, device: torch.device | str = "cpu") -> Marks:
        """The marks of strokes.

        Args:
            strokes: About where they belong.
            known: Rows that say where material is, if their strokes have any; otherwise the first row does that shows
                most of its stroke. int [K]
            device: Where the tensors are to be.
        """
        layout = strokes.layout
        row = np.repeat(layout.segment_row, _PARTS)
        t = ((np.arange(_PARTS)[:, None] + 0.5 * (1.0 + _NODES)) / _PARTS).ravel()
        basis = 3.0 * np.stack([(1.0 - t) ** 2, 2.0 * (1.0 - t) * t, t * t], axis=-1)

        def put(values: NDArray[np.intp] | Floats) -> Tensor:
            return torch.as_tensor(values, device=device)

        return Marks(
            put(layout.segment_points),
            put(_PARTS * layout.row_segments[row]),
            put(_PARTS * layout.row_segments[row + 1]),
            put(_fractions(strokes, np.zeros(0, np.intp) if known is None else known)),
            put(basis),
            put(0.5 / _PARTS * _WEIGHTS),
        )


def sliding(points: Tensor, marks: Marks) -> Tensor:
    """How far material lies from where it belongs along its stroke.

    Args:
        points: Control points, row by row. [P, 2] px
        marks: Which material belongs where.

    Returns:
        Sum over marks, each counting for its part of a segment, of the robust square of the arc length. px². Scalar.
    """
    legs = points[marks.control].diff(dim=1)
    speed = (marks.basis.to(points) @ legs).square().sum(-1).clamp_min(1e-12).sqrt()
    lengths = speed.view(-1, len(_NODES)) @ marks.weights.to(points)
    run = lengths.double().cumsum(0)
    run = torch.cat([run.new_zeros(1), run])
    start = run[marks.begin]
    length = (run[marks.end] - start).clamp_min(1e-6)
    off = ((run[:-1] - start) / length - marks.fraction) * length.detach()
    return (_SMALL**2 * torch.log1p(off.square() / _SMALL**2)).sum().to(points.dtype) / _PARTS


def _fractions(strokes: Strokes, known: NDArray[np.intp]) -> Floats:
    """The arc fraction of each mark on the affine image of its stroke's shape at rest. [M]"""
    layout, segments = strokes.layout, strokes.segments()
    span = strokes.visible[:, 1] - strokes.visible[:, 0]
    span[known] = 2.0  # more than all
    parts = [np.zeros(0)]
    for s in range(len(strokes)):
        first, last = layout.stroke_rows[s : s + 2]
        own = segments[layout.row_segments[first] : layout.row_segments[last]].reshape(last - first, -1, 4, 2)
        rest = own[int(span[first:last].argmax())]
        parts.append(_arc_fractions(rest @ _affine_maps(rest, own)[:, None]))
    return np.concatenate(parts)


def _affine_maps(rest: Floats, rows: Floats) -> Floats:
    """The linear part of the map from a shape [n, 4, 2] to each of others [T, n, 4, 2]. [T, 2, 2]

    A similarity, and of what that leaves so much as the shape can tell.
    """
    source = rest.reshape(-1, 2) - rest.reshape(-1, 2).mean(0)
    target = rows.reshape(len(rows), -1, 2)
    target = target - target.mean(1, keepdims=True)
    z, w = source @ [1, 1j], target @ [1, 1j]
    ratio = (w @ z.conj()) / max(float((z.conj() @ z).real), 1e-9)
    similar = np.stack([ratio.real, ratio.imag, -ratio.imag, ratio.real], axis=-1).reshape(-1, 2, 2)
    normal = source.T @ source + len(source) * _SPREAD**2 * np.eye(2)
    return np.asarray(similar + np.linalg.solve(normal, source.T @ (target - source @ similar)))


def _arc_fractions(rows: Floats) -> Floats:
    """Arc fractions of the marks on rows of segments [T, n, 4, 2], row after row. [T * n * _PARTS]"""
    ruler = Ruler.of(rows.reshape(-1, 4, 2))
    arc = ruler.arc_at(np.arange(len(ruler.ends[1:]) * _PARTS) / _PARTS).reshape(len(rows), -1)
    ends = ruler.ends[:: rows.shape[1]]
    length = np.maximum(np.diff(ends), 1e-9)
    return np.asarray(((arc - ends[:-1, None]) / length[:, None]).ravel())
