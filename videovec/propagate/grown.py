"""Lines that were drawn on for so long that they came in pieces: what grows on from the end of a growing line is it."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from videovec.curves import arc_length, sample_by_arc
from videovec.ink import Ink
from videovec.life_edits import join_ends
from videovec.propagate.record import Life, Row
from videovec.propagate.target import sample
from videovec.stroke_life import StrokeLife

__all__ = ["join_grown"]

Floats = NDArray[np.float64]

_TOUCH = 1.25
"""Widths, and 2 px, between two ends that are one place."""
_CROSSED = 2.5
"""Times that distance, where a straight line between the two ends goes on as both pieces do:"""
_STRAIGHT = 20.0
"""up to this turn. degrees"""
_SAMPLES = 16
"""Places on that line,"""
_INKED = 128
"""and the least coverage on them, of 255."""
_WIDTH = 1.6
"""Factor between the widths of two pieces of one line."""
_COLOR = 0.25
"""Largest difference of a channel between two pieces of one line."""
_GROWN = 0.9
"""Share of a piece's length that is seen on an earlier drawing, if it has grown since."""
_CRUMB = 1.5
"""Widths up to which a piece is only the last bit of a line that slows down as it is drawn."""
_LOOK = 4
"""Drawings from the birth of a piece over which its end must stay where the other's is."""
_MERGED = 2.5
"""Widths between two ends that are drawn together; a wider gap gets a straight segment."""


@dataclass(frozen=True, slots=True)
class _Contact:
    """The end of an older life (0 its start, 1 its end) at which an end of a younger one was born."""

    older: Life
    younger: Life
    ends: tuple[int, int]
    gap: float


def join_grown(lives: list[Life], ink: Ink) -> list[Life]:
    """Make one life of those that a line was drawn on in.

    Args:
        lives: All lives of one ink.
        ink: That ink.

    Returns:
        The lives; those that others grew on from have their rows, and the others are gone.
    """
    left = sorted(lives, key=lambda life: (life.first, life.id))
    while True:
        contacts = [c for a in left for b in left if (c := _contact(a, b, ink)) is not None]
        if not contacts:
            return left
        best = min(contacts, key=lambda contact: (contact.younger.first, contact.gap))
        joined = _joined(best)
        left = sorted([joined, *(x for x in left if x.id not in (best.older.id, best.younger.id))], key=_order)


def _order(life: Life) -> tuple[int, int]:
    return life.first, life.id


def _contact(older: Life, younger: Life, ink: Ink) -> _Contact | None:
    """Where the younger of two lives grew on from the older one, if it did."""
    birth = younger.first
    if older.id == younger.id or older.is_closed or younger.is_closed or not older.first < birth <= older.last:
        return None
    if np.abs(older.color - younger.color).max() > _COLOR or older.has_gaps or younger.has_gaps:
        return None
    widths = [float(life.rows[birth].half_width.mean()) for life in (older, younger)]
    if not 1 / _WIDTH <= widths[0] / max(widths[1], 1e-9) <= _WIDTH:
        return None
    reach = _TOUCH * 2 * max(widths) + 2.0
    together = range(birth, min(birth + _LOOK, older.last, younger.last) + 1)
    found = []
    for a in (0, 1):
        for b in (0, 1):
            gaps = [float(np.linalg.norm(_end(older, d, a) - _end(younger, d, b))) for d in together]
            far = _CROSSED if _runs_on(older, younger, (a, b), ink) else 1.0
            if max(gaps) <= far * reach and _grows(older, younger, a, b):
                found.append(_Contact(older, younger, (a, b), max(gaps)))
    return min(found, key=lambda contact: contact.gap, default=None)


def _end(life: Life, drawing: int, end: int) -> Floats:
    return np.asarray(life.rows[drawing].points[-end])


def _runs_on(older: Life, younger: Life, ends: tuple[int, int], ink: Ink) -> bool:
    """Whether the straight line between two ends goes on as both strokes do and is inked: by a line that they cross."""
    drawing = younger.first
    start, stop = (_end(life, drawing, end) for life, end in zip((older, younger), ends, strict=True))
    leave, meet = (_outward(life, drawing, end) for life, end in zip((older, younger), ends, strict=True))
    across = (stop - start) / max(float(np.linalg.norm(stop - start)), 1e-9)
    if min(leave @ across, -meet @ across) < np.cos(np.radians(_STRAIGHT)):
        return False
    between = start + np.linspace(0.0, 1.0, _SAMPLES)[:, None] * (stop - start)
    return bool(sample(ink.coverage[drawing], between).min() > _INKED)


def _outward(life: Life, drawing: int, end: int) -> Floats:
    """Unit direction in which a stroke leaves one of its ends, over its last third."""
    points = sample_by_arc(life.rows[drawing].points, 4)
    step = points[0] - points[1] if end == 0 else points[-1] - points[-2]
    return np.asarray(step / max(float(np.linalg.norm(step)), 1e-9))


def _grows(older: Life, younger: Life, a: int, b: int) -> bool:
    """Whether the older one grew to its end until then, the younger one grows away from it, or is next to nothing."""
    birth = younger.first
    before, now = older.rows.get(birth - 1), younger.rows[birth]
    if not any(row is not None and _reaches(row, a) for row in (before, older.rows[birth])):
        return False  # what is hidden there did not grow on
    was_drawn = before is not None and _reaches(before, a) and not _reaches(older.rows[older.first], a, _GROWN)
    is_drawn = _reaches(now, b) and not _reaches(now, 1 - b, _GROWN)
    return was_drawn or is_drawn or _is_crumb(younger)


def _is_crumb(life: Life) -> bool:
    """Whether a life was never long enough to be more than the last bit of another."""
    return all(arc_length(row.points) <= _CRUMB * 2.0 * float(row.half_width.mean()) for row in life.rows.values())


def _reaches(row: Row, end: int, share: float = 0.98) -> bool:
    """Whether a row is seen up to so near one of its ends, as a share of its length from the other one."""
    begin, stop = row.visible
    return stop > begin and (stop if end else 1.0 - begin) >= share


def _joined(contact: _Contact) -> Life:
    """One life of two, with the older one's identity, over all drawings of both."""
    older, younger = contact.older, contact.younger
    drawings = range(min(older.first, younger.first), max(older.last, younger.last) + 1)
    a, b = (_stretched(life, other, drawings) for life, other in ((older, younger), (younger, older)))
    a = a if contact.ends[0] == 1 else a.reversed()
    b = b if contact.ends[1] == 0 else b.reversed()
    width = 2 * float(max(a.half_width.mean(), b.half_width.mean()))
    both = join_ends(a, b, _MERGED * width)
    both = both if contact.ends[0] == 1 else both.reversed()
    return older.becoming(both, (older, younger))


def _stretched(life: Life, guide: Life, drawings: range) -> StrokeLife:
    """A life over more drawings: hidden, and carried along by another, where it has no rows."""
    rows = {}
    for drawing in drawings:
        near = min(life.rows, key=lambda d: abs(d - drawing))
        row = life.rows[near]
        if near != drawing:
            shift = 0.0
            if drawing in guide.rows and near in guide.rows:
                shift = guide.rows[drawing].points.mean(0) - guide.rows[near].points.mean(0)
            row = replace(row, points=row.points + shift, visible=(0.0, 0.0), opacity=_opacity(guide, drawing, row))
        rows[drawing] = row
    return replace(life, rows=rows).whole()


def _opacity(guide: Life, drawing: int, row: Row) -> float:
    return guide.rows[drawing].opacity if drawing in guide.rows else row.opacity
