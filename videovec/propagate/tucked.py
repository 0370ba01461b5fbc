"""Ends that go under a line at the same place all the time: what was never seen there does not come out by sliding.

A limb whose end lies behind a body is seen up to the body's outline. Nothing says where along itself it lies there: it
slides from drawing to drawing, and in the end all of it would be seen, its hidden end at the outline.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from videovec.curves import arc_length
from videovec.propagate.nodes import basis_of
from videovec.propagate.record import STEP, Life, Row, within

__all__ = ["hold_tucked"]

Floats = NDArray[np.float64]
Ints = NDArray[np.intp]

_Slid = tuple[float, float] | None
"""Arc fractions at which an end was under a line at first, and is now."""

_SPACING = 4.0
"""Distance of the nodes by which strokes are moved. px"""
_HIDDEN = 2.0
"""Length that was hidden at first of an end that is looked after. px"""
_AROUND = 8.0
"""How far along a stroke from where it was said to end the middle of a line is looked for. px"""
_ACROSS = 0.9
"""Cosine of the smallest angle between a stroke and the line under which it goes."""
_SLIDE = 8.0
"""Most that a stroke slides from one drawing to the next. px"""
_MOST = 0.15
"""Share of its length by which it slides at most in all."""
_OUT = 0.5
"""Drawings on which more of it is seen, for each on which it is under the line, from which on it comes out of there."""
_LEAST = 1e-3
"""Share of a stroke between its ends, in which it is not moved."""
_CHORD = 6.0
"""Length over which the direction of a stroke is measured where it goes under a line. px"""
_REPEATS = 5
"""How often nodes are brought back to control points."""


@dataclass(frozen=True, slots=True, eq=False)
class _Page:
    """What is seen on a drawing.

    Args:
        places: Points on strokes. [K, 2] px
        tangent: Directions there. [K, 2]
        half_width: Of the stroke of each. [K] px
        life: Identity of the stroke of each. int [K]
    """

    places: Floats
    tangent: Floats
    half_width: Floats
    life: Ints


@dataclass(frozen=True, slots=True)
class _Crossing:
    """Where a stroke goes under the middle of a line: its arc fraction there, and the identity of that line."""

    u: float
    line: int


def hold_tucked(lives: list[Life]) -> None:
    """Keep what is seen of strokes with a hidden end as it was at first, while that end lies under the same line.

    Args:
        lives: All lives of one ink; their rows are written anew.
    """
    tucked = [(life, ends) for life in lives if (ends := _tucked(life))]
    if not tucked:
        return
    pages = {d: _page(lives, d) for d in sorted({d for life, _ in tucked for d in life.rows})}
    for life, ends in tucked:
        home = life.rows[life.home]
        marks = [_marks(life, end, pages) if end in ends else {} for end in (0, 1)]
        for drawing in sorted({*marks[0], *marks[1]} - {life.home}):
            slid = [(mark[life.home], mark[drawing]) if drawing in mark else None for mark in marks]
            life.rows[drawing] = _slid_back(life.rows[drawing], home, (slid[0], slid[1]))


def _tucked(life: Life) -> tuple[int, ...]:
    """The ends (0 its start, 1 its end) that were hidden on the drawing on which the stroke was given."""
    home = life.rows.get(life.home)
    if home is None or life.is_closed or not home.parts or home.gaps:
        return ()
    length = arc_length(home.points)
    hidden = home.visible[0] * length, (1.0 - home.visible[1]) * length
    return tuple(end for end in (0, 1) if hidden[end] > _HIDDEN)


def _page(lives: list[Life], drawing: int) -> _Page:
    """What is seen on a drawing."""
    places, tangents, widths, names = [np.zeros((0, 2))], [np.zeros((0, 2))], [np.zeros(0)], [np.zeros(0, np.intp)]
    for life in lives:
        row = life.rows.get(drawing)
        if row is None or not row.parts:
            continue
        along, tangent = _along(row)
        seen = within(row.parts, len(along))
        places.append(along[seen])
        tangents.append(tangent[seen])
        widths.append(np.full(int(seen.sum()), float(row.half_width.mean())))
        names.append(np.full(int(seen.sum()), life.id, np.intp))
    return _Page(np.concatenate(places), np.concatenate(tangents), np.concatenate(widths), np.concatenate(names))


def _along(row: Row) -> tuple[Floats, Floats]:
    """Places and directions all along a stroke. [M, 2] px and [M, 2]"""
    places = row.along()
    step = np.gradient(places, axis=0)
    return places, step / np.maximum(np.linalg.norm(step, axis=1, keepdims=True), 1e-9)


def _marks(life: Life, end: int, pages: dict[int, _Page]) -> dict[int, float]:
    """Where one end goes under the line under which it was at first, by drawing.

    Nowhere if that is not one line, or if it comes out from under it on other drawings.
    """
    first = _crossing(life, life.home, end, pages[life.home])
    if first is None:
        return {}
    marks, is_out = {life.home: first.u}, 0
    length = arc_length(life.rows[life.home].points)
    for step in (1, -1):
        last, drawing = life.home, life.home + step
        while drawing in life.rows:
            found = _crossing(life, drawing, end, pages[drawing])
            is_same = found is not None and found.line == first.line
            if found is not None and is_same and abs(found.u - first.u) <= _MOST:
                if length * abs(found.u - marks[last]) <= _SLIDE * abs(drawing - last):
                    marks[drawing], last = found.u, drawing
            elif life.rows[drawing].parts:
                reach = (life.rows[drawing].visible[end] - first.u) * (1 if end else -1)
                is_out += reach > (_MOST if is_same else _HIDDEN / length)
            drawing += step
    return marks if is_out < _OUT * len(marks) else {}


def _crossing(life: Life, drawing: int, end: int, page: _Page) -> _Crossing | None:
    """Where an end of what is seen goes under another line."""
    row = life.rows[drawing]
    others = page.life != life.id
    if not row.parts or not others.any():
        return None
    places, tangent = _along(row)
    last = len(places) - 1
    at, reach = round(row.visible[end] * last), round(_AROUND / STEP)
    near = np.arange(max(at - reach, 0), min(at + reach, last) + 1)
    gap, which = cKDTree(page.places[others]).query(places[near])
    k = int(gap.argmin())
    other = int(which[k])
    across = abs(float(tangent[near[k]] @ page.tangent[others][other]))
    if gap[k] > page.half_width[others][other] or across >= _ACROSS:
        return None
    return _Crossing(float(near[k]) / last, int(page.life[others][other]))


def _slid_back(row: Row, home: Row, slid: tuple[_Slid, _Slid]) -> Row:
    """A row slid back: what was found at some arc fractions is where it was at first, and so are hidden ends.

    Args:
        row: The row.
        home: The stroke as it was given.
        slid: From where to where each end slid; none for one that goes under no line, or another one.
    """
    ends = [(u, u) if pair is None else pair for u, pair in zip(row.visible, slid, strict=True)]
    then, now = zip(*ends, strict=True)
    if min(now[1] - now[0], then[1] - then[0]) < _LEAST:
        return row
    basis = basis_of(home.points, _SPACING, is_closed=False)
    goal = _at(row, np.interp(basis.u, [0.0, *then, 1.0], [0.0, *now, 1.0]))
    ratio = (now[1] - now[0]) * arc_length(row.points) / ((then[1] - then[0]) * arc_length(home.points))
    for end in (end for end in (0, 1) if slid[end] is not None):
        hidden = basis.u < then[0] if end == 0 else basis.u > then[1]
        frames = _frame(home, then[end], end), _frame(row, now[end], end, ratio)
        goal[hidden] = _led(_at(home, basis.u[hidden]), *frames)
    points = row.points
    for _ in range(_REPEATS):
        points = points + basis.inverse @ (goal - basis.weights @ points)
    cuts = np.interp(row.parts, [0.0, *now, 1.0], [0.0, *then, 1.0]).ravel()
    cuts[[0, -1]] = [u if pair is None else at for u, pair, at in zip(row.visible, slid, home.visible, strict=True)]
    return replace(row, points=points).showing([(a, b) for a, b in cuts.reshape(-1, 2).tolist()])


def _at(row: Row, u: Floats) -> Floats:
    """Where arc fractions lie. [n, 2] px"""
    along = row.along()
    return np.stack([np.interp(u, np.linspace(0.0, 1.0, len(along)), along[:, k]) for k in (0, 1)], axis=1)


def _frame(row: Row, u: float, end: int, ratio: float = 1.0) -> tuple[Floats, complex]:
    """A place on a stroke [2] px, and the direction in which it leaves what is seen there, of the length of a ratio."""
    length = arc_length(row.points)
    inner = u + (1 if end == 0 else -1) * min(_CHORD / max(length, 1e-9), 0.5)
    place, before = _at(row, np.array([u, inner]))
    step = complex(*(place - before))
    return place, ratio * step / max(abs(step), 1e-9)


def _led(places: Floats, before: tuple[Floats, complex], after: tuple[Floats, complex]) -> Floats:
    """Places moved along as one frame becomes another. [n, 2] px"""
    z = (places - before[0]) @ np.array([1.0, 1.0j]) * (after[1] / before[1])
    return np.asarray(after[0] + np.stack([z.real, z.imag], axis=1))
