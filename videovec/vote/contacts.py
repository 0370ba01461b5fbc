"""Where strokes of one drawing meet: places at which they could be cut, and the junctions that these make."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray
from scipy.cluster.hierarchy import fcluster, linkage
from scipy.spatial import cKDTree

from videovec.curves import arc_length, evaluate, parameter_at, segments_of
from videovec.strokes import Strokes

__all__ = ["Arm", "Branch", "Contacts", "find_contacts"]

Floats = NDArray[np.float64]
Ints = NDArray[np.intp]

_STEP = 0.75  # px between samples of a stroke
_REACH = 1.3  # widths from the end of a stroke within which it touches another
_APART = 4.0  # widths along a stroke between two places at which it may meet itself
_STUB = 1.5  # widths from the end of a stroke within which it is not cut
_MERGED = 2.0  # widths along a stroke within which several contacts are one cut
_CLUSTER = 2.0  # widths between the ends of branches that meet at one junction

Arm = tuple[int, int]
"""A branch, by its number, and its end: 0 where it starts, 1 where it stops."""


@dataclass(frozen=True, slots=True)
class Branch:
    """The part of a stroke between two junctions or ends.

    Args:
        stroke: Position of the stroke.
        order: How many branches of the stroke come before it.
        start: Where it starts, as a place on the spline: segment plus parameter.
        stop: Where it stops.
    """

    stroke: int
    order: int
    start: float
    stop: float


@dataclass(frozen=True, slots=True, eq=False)
class Contacts:
    """The branches of one drawing and the junctions at which they meet.

    Args:
        branches: All branches, stroke by stroke.
        junctions: The arms at each junction, two or more.
        width: Median width of the strokes. px
    """

    branches: tuple[Branch, ...]
    junctions: tuple[tuple[Arm, ...], ...]
    width: float

    def links(self, junction: tuple[Arm, ...]) -> frozenset[tuple[Arm, Arm]]:
        """The pairs of arms of a junction that are one stroke as it runs now."""
        here = set(junction)
        pairs = ((b, 1) for b, end in junction if end == 1)
        return frozenset((arm, (arm[0] + 1, 0)) for arm in pairs if (arm[0] + 1, 0) in here and self._continues(arm[0]))

    def _continues(self, branch: int) -> bool:
        following = self.branches[branch + 1] if branch + 1 < len(self.branches) else None
        return following is not None and following.stroke == self.branches[branch].stroke


@dataclass(frozen=True, slots=True, eq=False)
class _Samples:
    """Samples of all strokes: where [N, 2] px, of which stroke [N], how far along it [N] px, at which place [N]."""

    points: Floats
    stroke: Ints
    arc: Floats
    place: Floats
    length: dict[int, float]


def _sampled(strokes: Strokes, rows: Ints) -> _Samples:
    points, owner, arcs, places, length = [], [], [], [], {}
    for row in rows.tolist():
        control = strokes.points_of(row)
        stroke = int(strokes.layout.row_stroke[row])
        length[stroke] = arc_length(control)
        u = np.linspace(0.0, 1.0, max(8, int(np.ceil(length[stroke] / _STEP)) + 1))
        segment, t = parameter_at(control, u)
        points.append(evaluate(segments_of(control)[segment], t))
        owner.append(np.full(len(u), stroke, np.intp))
        arcs.append(u * length[stroke])
        places.append(segment + t)
    return _Samples(np.concatenate(points), np.concatenate(owner), np.concatenate(arcs), np.concatenate(places), length)


def find_contacts(strokes: Strokes, drawing: int) -> Contacts:
    """Find where the open strokes of a drawing touch and cross.

    Args:
        strokes: S strokes.
        drawing: The drawing to look at.

    Returns:
        Branches of the strokes that are alive and open there, and their junctions.
    """
    rows = np.sort(strokes.rows_at(drawing))
    rows = rows[~strokes.is_closed[strokes.layout.row_stroke[rows]]]
    rows = rows[[arc_length(strokes.points_of(row)) > 1e-3 for row in rows.tolist()]]
    if not len(rows):
        return Contacts((), (), 0.0)
    width = 2.0 * float(np.median([strokes.half_width_of(row).mean() for row in rows.tolist()]))
    samples = _sampled(strokes, rows)
    touched = np.unique(np.concatenate([_touched(samples, width), _crossed(samples, width)]))
    branches: list[Branch] = []
    for row in rows.tolist():
        stroke = int(strokes.layout.row_stroke[row])
        cuts = _cuts(samples, touched[samples.stroke[touched] == stroke], samples.length[stroke], width)
        edges = [0.0, *cuts, float(strokes.layout.segments[stroke])]
        branches += [Branch(stroke, k, a, b) for k, (a, b) in enumerate(pairwise(edges))]
    return Contacts(tuple(branches), _junctions(strokes, drawing, branches, width), width)


def _touched(samples: _Samples, width: float) -> Ints:
    """Samples at which the end of another stroke, or a far part of the same, lies on a stroke. int [K]"""
    tree = cKDTree(samples.points)
    is_end = np.diff(samples.stroke, prepend=-1) != 0
    is_end |= np.diff(samples.stroke, append=-1) != 0
    found = []
    for end in np.flatnonzero(is_end).tolist():
        near = np.array(tree.query_ball_point(samples.points[end], _REACH * width))
        own = samples.stroke[near] == samples.stroke[end]
        near = near[~own | (np.abs(samples.arc[near] - samples.arc[end]) > _APART * width)]
        gap = np.linalg.norm(samples.points[near] - samples.points[end], axis=1)
        for stroke in np.unique(samples.stroke[near]):
            here = samples.stroke[near] == stroke
            found.append(int(near[here][gap[here].argmin()]))
    return np.array(found, np.intp)


def _crossed(samples: _Samples, width: float) -> Ints:
    """Samples next to which a stroke crosses another, or itself. int [K]"""
    begin = np.flatnonzero(np.diff(samples.stroke) == 0)
    a, b = samples.points[begin], samples.points[begin + 1]
    pairs = cKDTree(0.5 * (a + b)).query_pairs(1.5 * _STEP, output_type="ndarray")
    one, two = pairs.T
    first, second = begin[one], begin[two]
    same = samples.stroke[first] == samples.stroke[second]
    far = ~same | (np.abs(samples.arc[first] - samples.arc[second]) > _APART * width)
    one, two = one[far], two[far]
    splits = _side(a[one], b[one], a[two]) * _side(a[one], b[one], b[two]) <= 0
    splits &= _side(a[two], b[two], a[one]) * _side(a[two], b[two], b[one]) <= 0
    return np.unique(np.concatenate([begin[one[splits]], begin[two[splits]]]))


def _side(a: Floats, b: Floats, c: Floats) -> Floats:
    """On which side of the line a b the point c lies. [K]"""
    return np.asarray((b - a)[:, 0] * (c - a)[:, 1] - (b - a)[:, 1] * (c - a)[:, 0])


def _cuts(samples: _Samples, touched: Ints, length: float, width: float) -> list[float]:
    """Places at which one stroke can be cut: the middles of runs of contacts, away from its ends."""
    inside = touched[(samples.arc[touched] > _STUB * width) & (samples.arc[touched] < length - _STUB * width)]
    if not len(inside):
        return []
    runs = np.split(inside, np.flatnonzero(np.diff(samples.arc[inside]) > _MERGED * width) + 1)
    return [float(samples.place[run].mean()) for run in runs]


def _junctions(strokes: Strokes, drawing: int, branches: list[Branch], width: float) -> tuple[tuple[Arm, ...], ...]:
    arms = [(number, end) for number in range(len(branches)) for end in (0, 1)]
    ends = []
    for number, end in arms:
        branch = branches[number]
        control = segments_of(strokes.points_of(strokes.row(branch.stroke, drawing)))
        place = branch.stop if end else branch.start
        k = min(int(place), len(control) - 1)
        ends.append(evaluate(control[k], place - k))
    if len(arms) < 2:
        return ()
    cluster = fcluster(linkage(np.array(ends), "single"), _CLUSTER * width, "distance")
    found = [tuple(arms[k] for k in np.flatnonzero(cluster == c)) for c in np.unique(cluster)]
    return tuple(junction for junction in found if len(junction) > 1)
