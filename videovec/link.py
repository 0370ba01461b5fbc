"""Strokes of drawings that were vectorised alone, linked into strokes over time: the baseline of the field.

Every drawing's strokes are matched one to one with those of the drawing before by how near their curves lie; what
finds no partner within the search range ends, or begins.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import linear_sum_assignment
from scipy.spatial.distance import cdist

from videovec.curves import reverse, sample_by_arc, segment_lengths, segments_of, split
from videovec.strokes import Layout, Strokes

__all__ = ["link"]

_SAMPLES = 16

Floats = NDArray[np.float64]


def link(drawings: list[Strokes], search_range: float) -> Strokes:
    """Link the strokes of consecutive drawings.

    Args:
        drawings: Strokes of each drawing, each with a life of that one drawing.
        search_range: Largest mean distance between two curves that may be one stroke. px

    Returns:
        Strokes with lives. A stroke whose number of segments differs between drawings gets the largest of them
        everywhere, by cuts that leave its curves as they are.
    """
    chains = _chains(drawings, search_range)
    return Strokes.concatenate([_joined(drawings, chain, k + 1) for k, chain in enumerate(chains)])


def _chains(drawings: list[Strokes], search_range: float) -> list[list[tuple[int, int]]]:
    """The (drawing, stroke) pairs of each linked stroke."""
    chains: list[list[tuple[int, int]]] = []
    open_chains: list[int] = []
    for drawing, strokes in enumerate(drawings):
        partner = _matched(drawings[drawing - 1], strokes, search_range) if drawing else {}
        now = []
        for stroke in range(len(strokes)):
            if stroke in partner:
                chain = open_chains[partner[stroke]]
                chains[chain].append((drawing, stroke))
            else:
                chain = len(chains)
                chains.append([(drawing, stroke)])
            now.append(chain)
        open_chains = now
    return chains


def _curves(strokes: Strokes) -> list[Floats]:
    return [sample_by_arc(strokes.points_of(row), _SAMPLES) for row in range(strokes.row_count)]


def _matched(before: Strokes, after: Strokes, search_range: float) -> dict[int, int]:
    """The earlier stroke of each later one that has one; open strokes do not become closed."""
    if not len(before) or not len(after):
        return {}
    later_curves = _curves(after)
    cost = np.array([[_distance(a, b) for b in later_curves] for a in _curves(before)])
    cost[before.is_closed[:, None] != after.is_closed] = np.inf
    earlier, later = linear_sum_assignment(np.minimum(cost, 2 * search_range))
    return {int(b): int(a) for a, b in zip(earlier, later, strict=True) if cost[a, b] <= search_range}


def _distance(a: Floats, b: Floats) -> float:
    """Mean of the mean nearest distances both ways. px"""
    distance = cdist(a, b)
    return float(0.5 * (distance.min(0).mean() + distance.min(1).mean()))


def _joined(drawings: list[Strokes], chain: list[tuple[int, int]], identity: int) -> Strokes:
    """One stroke over the drawings of a chain."""
    count = max(int(drawings[d].layout.segments[s]) for d, s in chain)
    shapes: list[tuple[Floats, Floats]] = []
    for drawing, stroke in chain:
        part = drawings[drawing]
        points, half_width = part.points_of(stroke), part.half_width_of(stroke)
        if shapes and _runs_against(shapes[-1][0], points):
            points, half_width = reverse(points, half_width)
        shapes.append(_with_segments(points, half_width, count))
    first = drawings[chain[0][0]].select([chain[0][1]])
    begin, end = np.array([chain[0][0]]), np.array([chain[-1][0]])
    return Strokes(
        ids=np.array([identity]),
        layout=Layout(np.array([count]), begin, end),
        is_closed=first.is_closed,
        layer=np.array([identity - 1]),
        color=first.color,
        points=np.concatenate([points for points, _ in shapes]),
        half_width=np.concatenate([half_width for _, half_width in shapes]),
        opacity=np.concatenate([drawings[d].opacity[s : s + 1] for d, s in chain]),
        visible=np.concatenate([drawings[d].visible[s : s + 1] for d, s in chain]),
    )


def _runs_against(before: Floats, after: Floats) -> bool:
    same = np.linalg.norm(before[[0, -1]] - after[[0, -1]])
    swapped = np.linalg.norm(before[[0, -1]] - after[[-1, 0]])
    return bool(swapped < same)


def _with_segments(points: Floats, half_width: Floats, count: int) -> tuple[Floats, Floats]:
    """The same curve in more segments, the longest halved first."""
    segments, widths = list(segments_of(points)), list(half_width)
    lengths = list(segment_lengths(points))
    while len(segments) < count:
        k = int(np.argmax(lengths))
        before, after = split(segments[k], 0.5)
        segments[k : k + 1] = [before, after]
        widths.insert(k + 1, 0.5 * (widths[k] + widths[k + 1]))
        lengths[k : k + 1] = [lengths[k] / 2, lengths[k] / 2]
    return np.concatenate([segments[0][:1], *(segment[1:] for segment in segments)]), np.array(widths)
