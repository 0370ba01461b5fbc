"""The last fraction of a pixel: move strokes until their rendering is the drawing, and keep their shape."""

from __future__ import annotations

import cv2
import numpy as np
import torch
from numpy.typing import NDArray

from videovec.curves import arc_length, sample_by_arc
from videovec.optimise import Schedule, Term, optimise
from videovec.parameters import Parameters
from videovec.strokes import Strokes

__all__ = ["refine"]

_HOPS = (1, 2, 4, 8)
"""Control points between the middle and the ends of a triple."""
_NEARBY = 4.0
"""How far beyond the edge of a stroke ink may be its own. px"""
_STUB = 4.0
"""Widths of the longest stroke that keeps its length: its ends would follow the ink of what it touches."""
_STIFF = 1.0
"""Weight of the length of such a stroke, against 1 of a squared coverage error. 1/px²"""
_SHORT = 1.0
"""Squared distance of the ends below which a triple has no direction. px²"""


def refine(
    strokes: Strokes, rest: NDArray[np.float64], coverage: NDArray[np.uint8], steps: int, rigidity: float
) -> Strokes:
    """Optimise the control points of one drawing.

    Args:
        strokes: Strokes of one drawing, about where they belong; the drawing's number is 0.
        rest: Their control points on the drawing before, whose shape they keep. [P, 2] px
        coverage: Ink. uint8 [H, W]
        steps: Optimiser updates.
        rigidity: Weight of the shape against the sum of squared coverage errors.

    Returns:
        The strokes with other control points.
    """
    coverage = _near(strokes, coverage) if len(strokes) else coverage
    if not len(strokes) or not coverage.any():
        return strokes
    schedule = Schedule(steps=steps, rate=0.25, width_rate=0.0, scale=3.0, coarse=0.45, rebuild=9)
    terms = [_keep_shape(strokes, rest, rigidity), _keep_length(strokes)]
    return optimise(strokes, coverage[None], schedule, terms).strokes


def _near(strokes: Strokes, coverage: NDArray[np.uint8]) -> NDArray[np.uint8]:
    """The ink around strokes alone: none of them should bend to ink that belongs to a stroke which is not known yet."""
    mask = np.zeros_like(coverage)
    for s in range(len(strokes)):
        points = strokes.points_of(s)
        places = sample_by_arc(points, max(2, round(arc_length(points) / 4.0)))
        thickness = round(2.0 * (float(strokes.half_width_of(s).max()) + _NEARBY))
        cv2.polylines(mask, [np.rint(places - 0.5).astype(np.int32)], False, 255, thickness)
    return np.asarray(np.where(mask > 0, coverage, 0), np.uint8)


def _keep_shape(strokes: Strokes, rest: NDArray[np.float64], weight: float) -> Term:
    """Draws the middle of every triple of control points where a similarity of its ends puts it."""
    triples, share = _triples(strokes, rest)
    shape = _ratio(rest, triples)
    index = torch.from_numpy(triples)
    real, imaginary = torch.from_numpy(shape.real.astype(np.float32)), torch.from_numpy(shape.imag.astype(np.float32))
    balance = torch.from_numpy((weight * share).astype(np.float32))

    def keep_shape(parameters: Parameters) -> torch.Tensor:
        a, b, c = parameters.points[index].unbind(1)
        span = c - a
        turned = torch.stack([-span[:, 1], span[:, 0]], dim=1)
        gap = b - a - real[:, None] * span - imaginary[:, None] * turned
        return (balance * gap.square().sum(1)).sum()

    return keep_shape


def _keep_length(strokes: Strokes) -> Term:
    """Draws the ends of short strokes to the distance from each other that they had at first."""
    ends = strokes.layout.row_points[:-1], strokes.layout.row_points[1:] - 1
    lengths = np.array([arc_length(strokes.points_of(s)) for s in range(len(strokes))])
    widths = np.array([2.0 * strokes.half_width_of(s).mean() for s in range(len(strokes))])
    short = (lengths <= _STUB * widths) & ~strokes.is_closed
    first, last = (torch.from_numpy(end[short].astype(np.int64)) for end in ends)
    start = np.linalg.norm(strokes.points[ends[1][short]] - strokes.points[ends[0][short]], axis=1)
    wanted = torch.from_numpy(start.astype(np.float32))

    def keep_length(parameters: Parameters) -> torch.Tensor:
        span = torch.linalg.vector_norm(parameters.points[last] - parameters.points[first], dim=1)
        return torch.mul((span - wanted).square().sum(), _STIFF)

    return keep_length


def _triples(strokes: Strokes, rest: NDArray[np.float64]) -> tuple[NDArray[np.int64], NDArray[np.float64]]:
    """First, middle and last control points on one stroke [E, 3], and the weight of each triple [E]."""
    found, share = [np.zeros((0, 3), np.int64)], [np.zeros(0)]
    for s in range(len(strokes)):
        start, stop = strokes.layout.row_points[[s, s + 1]]
        count = stop - start
        for hop in _HOPS:
            if strokes.is_closed[s]:
                ring = count - 1
                middle = np.arange(ring if ring > 2 * hop else 0)
                local = np.stack([(middle - hop) % ring, middle, (middle + hop) % ring], axis=1)
            else:
                local = np.arange(hop, count - hop)[:, None] + np.array([-hop, 0, hop])
            found.append(start + local)
            share.append(np.full(len(local), 1.0 / hop))
    triples, weight = np.concatenate(found).astype(np.int64), np.concatenate(share)
    long = ((rest[triples[:, 2]] - rest[triples[:, 0]]) ** 2).sum(1) > _SHORT
    return triples[long], weight[long]


def _ratio(points: NDArray[np.float64], triples: NDArray[np.int64]) -> NDArray[np.complex128]:
    """Where the middle lies between the ends, as a complex number that no similarity changes. [E]"""
    z = points[:, 0] + 1j * points[:, 1]
    a, b, c = z[triples].T
    return np.asarray((b - a) / (c - a))
