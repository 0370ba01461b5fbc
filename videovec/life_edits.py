"""Corrections of identities by hand: merge, split, reverse.

Each takes the lives of strokes and gives new ones; nothing is fitted again, and every curve stays where it is.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from videovec.curves import arc_length, parameter_at, segment_lengths, segments_of, split
from videovec.errors import InputError
from videovec.stroke_life import StrokeLife

__all__ = ["cut_at", "join_ends", "join_in_space", "join_in_time", "split_in_space", "split_in_time"]

Floats = NDArray[np.float64]

_EDGE = 1e-6  # of a segment; a cut so near to a joint is one at the joint
_TOUCHING = 1.0  # px between two ends that become one joint; farther ones are bridged by a straight segment


def join_in_time(earlier: StrokeLife, later: StrokeLife) -> StrokeLife:
    """One stroke out of two of which one ends before the other begins.

    The later one is turned round if its ends then meet the earlier one's better, and the one of fewer segments is cut
    into as many as the other has, without changing its curve. Drawings between the two lives are hidden.

    Raises:
        InputError: Only one of the two is closed.
    """
    if earlier.is_closed != later.is_closed:
        raise InputError(f"strokes {earlier.id} and {later.id} cannot be one: only one of them is closed")
    if not earlier.is_closed and _end_distance(earlier, later.reversed()) < _end_distance(earlier, later):
        later = later.reversed()
    count = max(earlier.segment_count, later.segment_count)
    before, after = _with_segments(earlier, count), _with_segments(later, count)
    share = np.arange(1, later.first - earlier.last) / (later.first - earlier.last)
    shape, width, opacity = (
        np.concatenate([a, _between(a[-1], b[0], share), b])
        for a, b in (
            (before.points, after.points),
            (before.half_width, after.half_width),
            (before.opacity, after.opacity),
        )
    )
    visible = np.concatenate([before.visible, np.zeros((len(share), 2)), after.visible])
    return replace(before, points=shape, half_width=width, opacity=opacity, visible=visible)


def join_in_space(first: StrokeLife, second: StrokeLife) -> StrokeLife:
    """One stroke out of two that live on the same drawings, joined where their ends lie nearest to each other.

    Raises:
        InputError: Their lives differ, or one of them is closed.
    """
    if (first.first, first.last) != (second.first, second.last):
        raise InputError(
            f"strokes {first.id} and {second.id} must live on the same drawings or on none in common, "
            f"got {first.first}..{first.last} and {second.first}..{second.last}"
        )
    if first.is_closed or second.is_closed:
        raise InputError(f"strokes {first.id} and {second.id} cannot be joined: one of them is closed")
    ways = [(a, b) for a in (first, first.reversed()) for b in (second, second.reversed())]
    gaps = [np.linalg.norm(a.points[:, -1] - b.points[:, 0], axis=-1) for a, b in ways]
    best = int(np.argmin([gap.mean() for gap in gaps]))  # the first on a tie: the direction of the first stroke stays
    return join_ends(*ways[best], _TOUCHING)


def join_ends(a: StrokeLife, b: StrokeLife, touching: float) -> StrokeLife:
    """One stroke out of two of the same life: the second goes on where the first ends.

    Args:
        a: The first, whose identity it gets.
        b: The second.
        touching: Gap up to which the two ends meet in their middle; a larger one is bridged by a straight segment. px
    """
    end, start = a.points[:, -1:], b.points[:, :1]
    if np.linalg.norm(end - start, axis=-1).max() <= touching:
        middle = (end + start) / 2
        handles = a.points[:, -2:-1] + (middle - end), b.points[:, 1:2] + (middle - start)
        points = np.concatenate([a.points[:, :-2], handles[0], middle, handles[1], b.points[:, 2:]], axis=1)
        joint = (a.half_width[:, -1:] + b.half_width[:, :1]) / 2
        half_width = np.concatenate([a.half_width[:, :-1], joint, b.half_width[:, 1:]], axis=1)
    else:
        points = np.concatenate([a.points, end + (start - end) / 3, end + (start - end) * 2 / 3, b.points], axis=1)
        half_width = np.concatenate([a.half_width, b.half_width], axis=1)
    return replace(
        a, points=points, half_width=half_width, opacity=(a.opacity + b.opacity) / 2, visible=_joined_view(a, b, points)
    )


def split_in_space(life: StrokeLife, u: float, new_id: int) -> tuple[StrokeLife, StrokeLife]:
    """Two strokes out of one, cut at one material point.

    The cut lies at one curve parameter on all drawings, so that both parts keep one topology: the one whose arc
    fraction is ``u`` on the drawing on which the stroke is longest.

    Args:
        life: The stroke; a closed one becomes two open ones.
        u: Arc fraction, inside (0, 1).
        new_id: Identity of the second part.

    Raises:
        InputError: The cut does not lie inside the stroke.
    """
    if not 0 < u < 1:
        raise InputError(f"a cut must lie at an arc fraction between 0 and 1, got {u:g}")
    longest = max(life.points, key=arc_length)
    segments, parameters = parameter_at(longest, np.array([u]))
    return cut_at(life, int(segments[0]) + float(parameters[0]), new_id)


def cut_at(life: StrokeLife, place: float, new_id: int) -> tuple[StrokeLife, StrokeLife]:
    """Two strokes out of one, cut at one curve parameter on all drawings.

    Args:
        life: The stroke; a closed one becomes two open ones.
        place: Segment plus parameter in it, inside the stroke.
        new_id: Identity of the second part.
    """
    k = min(int(place), life.segment_count - 1)
    t = place - k
    if t <= _EDGE and k > 0:
        k, t = k - 1, 1.0
    pieces = np.stack([segments_of(points) for points in life.points])  # [K, n, 4, 2]
    before, after = split(pieces[:, k], np.array(t))
    width = (1 - t) * life.half_width[:, k : k + 1] + t * life.half_width[:, k + 1 : k + 2]
    head = np.concatenate([pieces[:, :k], before[:, None]], axis=1)
    tail = np.concatenate([after[:, None], pieces[:, k + 1 :]], axis=1)
    head_widths = np.concatenate([life.half_width[:, : k + 1], width], axis=1)
    tail_widths = np.concatenate([width, life.half_width[:, k + 1 :]], axis=1)
    if t >= 1 - _EDGE and tail.shape[1] > 1:
        tail, tail_widths = tail[:, 1:], tail_widths[:, 1:]
    one = replace(life, points=_points_of(head), half_width=head_widths, is_closed=False)
    two = replace(life, id=new_id, points=_points_of(tail), half_width=tail_widths, is_closed=False)
    lengths = np.array([[arc_length(points) for points in part.points] for part in (one, two)])
    share = np.divide(lengths[0], lengths.sum(0), out=np.full(lengths.shape[1], 0.5), where=lengths.sum(0) > 0)[:, None]
    share = np.clip(share, 1e-9, 1 - 1e-9)
    return (
        replace(one, visible=np.clip(life.visible / share, 0, 1)),
        replace(two, visible=np.clip((life.visible - share) / (1 - share), 0, 1)),
    )


def split_in_time(life: StrokeLife, drawing: int, new_id: int) -> tuple[StrokeLife, StrokeLife]:
    """Two strokes out of one, the second from a drawing on.

    Raises:
        InputError: The drawing is not one of the stroke's life after its first.
    """
    if not life.first < drawing <= life.last:
        raise InputError(f"stroke {life.id} can be split at drawings {life.first + 1}..{life.last}, got {drawing}")
    return life.between(life.first, drawing - 1), replace(life.between(drawing, life.last), id=new_id)


def _end_distance(earlier: StrokeLife, later: StrokeLife) -> float:
    """How far the ends move from the last drawing of one to the first of the other. px"""
    return float(np.linalg.norm(earlier.points[-1, [0, -1]] - later.points[0, [0, -1]], axis=-1).sum())


def _with_segments(life: StrokeLife, count: int) -> StrokeLife:
    """The same curves in ``count`` segments: the longest is halved until there are enough."""
    while life.segment_count < count:
        k = int(np.argmax(np.mean([segment_lengths(points) for points in life.points], axis=0)))
        pieces = np.stack([segments_of(points) for points in life.points])
        halves = np.stack(split(pieces[:, k], np.array(0.5)), axis=1)
        middle = life.half_width[:, k : k + 2].mean(1, keepdims=True)
        life = replace(
            life,
            points=_points_of(np.concatenate([pieces[:, :k], halves, pieces[:, k + 1 :]], axis=1)),
            half_width=np.concatenate([life.half_width[:, : k + 1], middle, life.half_width[:, k + 1 :]], axis=1),
        )
    return life


def _points_of(segments: Floats) -> Floats:
    """Control points of splines, given their segments. [K, n, 4, 2] -> [K, 3n+1, 2]"""
    return np.concatenate([segments[:, 0, :1], segments[:, :, 1:].reshape(len(segments), -1, 2)], axis=1)


def _between(start: Floats, end: Floats, share: Floats) -> Floats:
    """Values on the way from one to another. [M, ...]"""
    return np.asarray(start + share.reshape(-1, *[1] * np.ndim(start)) * (end - start))


def _joined_view(a: StrokeLife, b: StrokeLife, points: Floats) -> Floats:
    """The visible interval of two strokes in one: from the first to the last of what is seen. [K, 2]"""
    view = np.zeros((len(points), 2))
    for k, joined in enumerate(points):
        whole = arc_length(joined)
        before, after = arc_length(a.points[k]), arc_length(b.points[k])
        parts = (a.visible[k] * before, whole - after + b.visible[k] * after)
        is_seen = (a.visible[k, 0] < a.visible[k, 1], b.visible[k, 0] < b.visible[k, 1])
        seen = [part for part, visible in zip(parts, is_seen, strict=True) if visible]
        if seen:
            view[k] = (seen[0][0], seen[-1][1]) if whole == 0 else (seen[0][0] / whole, seen[-1][1] / whole)
    return np.clip(view, 0, 1)
