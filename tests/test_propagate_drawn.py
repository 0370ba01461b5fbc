"""Lines that are drawn on, erased away and revealed from their middle stay one stroke each."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

import cv2
import numpy as np
import pytest
from numpy.typing import NDArray

from videovec.curves import sample_by_arc
from videovec.events import EventKind
from videovec.initialise import initialise
from videovec.ink import Ink
from videovec.propagate import propagate
from videovec.propagate.grown import join_grown
from videovec.propagate.record import Life, Row
from videovec.settings import InitialiseSettings, PropagateSettings
from videovec.strokes import Strokes

Floats = NDArray[np.float64]
Drawn = Callable[[int], tuple[float, float]]

SIZE, WIDTH, COUNT = 200, 6.0, 13


def line(number: int, u: Floats) -> Floats:
    """Three bent lines, one of them with a corner, at fractions of their courses. [N, 2]"""
    if number == 0:
        return np.stack([20 + 150 * u, 40 + 22 * np.sin(3.0 * u)], axis=-1)
    if number == 1:
        return np.stack([40 + 55 * np.cos(3 * u - 1.2), 120 + 55 * np.sin(3 * u - 1.2)], axis=-1)
    x = 105 + 70 * u
    return np.stack([x, 110 + np.abs(x - 135) * 1.2], axis=-1)


def draw(parts: list[tuple[int, float, float]]) -> NDArray[np.uint8]:
    """Coverage of parts of lines, by supersampling."""
    scale = 4
    image = np.zeros((SIZE * scale, SIZE * scale), np.uint8)
    for number, begin, end in parts:
        if end > begin:
            at = np.round((line(number, np.linspace(begin, end, 120)) * scale - 0.5) * 16).astype(np.int32)
            cv2.polylines(image, [at], False, 255, round(WIDTH * scale), cv2.LINE_AA, 4)
    return np.asarray(cv2.resize(image, (SIZE, SIZE), interpolation=cv2.INTER_AREA), np.uint8)


def eased(t: float) -> float:
    """Slow at both ends, as animators draw lines on."""
    return float(np.clip(t, 0, 1) ** 2 * (3 - 2 * np.clip(t, 0, 1)))


def drawn_on(t: int) -> tuple[float, float]:
    return 0.0, eased(t / (COUNT - 1))


def erased(t: int) -> tuple[float, float]:
    return 0.0, 1.0 - 0.7 * eased(t / (COUNT - 1))


def from_the_middle(t: int) -> tuple[float, float]:
    return 0.5 - 0.5 * eased(t / (COUNT - 1)), 0.5 + 0.5 * eased(t / (COUNT - 1))


def share_of_one(strokes: Strokes, drawing: int, number: int, part: tuple[float, float]) -> dict[int, float]:
    """How much of a seen line, in px, lies nearest to the seen part of each stroke, and at most 3 px from it."""
    points = line(number, np.linspace(*part, 60))
    seen = []
    for row in strokes.rows_at(drawing).tolist():
        begin, end = strokes.visible[row]
        if end > begin:
            dense = sample_by_arc(strokes.points_of(row), 401)[round(400 * begin) : round(400 * end) + 1]
            gap = np.linalg.norm(points[:, None] - dense, axis=2).min(1)
            seen.append((int(strokes.ids[strokes.layout.row_stroke[row]]), gap))
    if not seen:
        return {}
    nearest = np.argmin([gap for _, gap in seen], axis=0)
    length = float(np.linalg.norm(np.diff(points, axis=0), axis=1).sum()) / len(points)
    return {identity: length * float(np.sum((nearest == k) & (gap <= 3.0))) for k, (identity, gap) in enumerate(seen)}


def identity_score(strokes: Strokes, shown: Drawn) -> float:
    """Share of all seen ink that carries the identity that its line carries most. In [0, 1]"""
    kept = total = 0.0
    for number in range(3):
        of_line: dict[int, float] = {}
        for drawing in range(COUNT):
            part = shown(drawing)
            for identity, length in share_of_one(strokes, drawing, number, part).items():
                of_line[identity] = of_line.get(identity, 0.0) + length
            total += float(np.linalg.norm(np.diff(line(number, np.linspace(*part, 60)), axis=0), axis=1).sum())
        kept += max(of_line.values(), default=0.0)
    return kept / total


@pytest.mark.parametrize(("shown", "patience"), [(drawn_on, 24), (drawn_on, 5), (erased, 24), (from_the_middle, 24)])
def test_three_lines_stay_three_strokes(shown: Drawn, patience: int) -> None:
    coverage = np.stack([draw([(number, *shown(t)) for number in range(3)]) for t in range(COUNT)])
    ink = Ink(coverage, np.zeros_like(coverage), np.zeros((1, 3)), np.ones(3), 0.0)
    trace = partial(initialise, settings=InitialiseSettings())
    result = propagate(ink, trace(ink, 0), PropagateSettings(refine_steps=12, patience=patience), trace)
    assert len(result.strokes) == 3
    assert EventKind.CUT not in [event.kind for event in result.events]
    assert identity_score(result.strokes, shown) > 0.95


def erased_and_drawn_again(t: int) -> list[tuple[int, float, float]]:
    """A bent line is erased to nothing, the page is blank for two drawings, and it is drawn on again."""
    if t < 6:
        return [(2, 0.17 * t, 1.0)]
    return [(2, 0.0, 0.2 * (t - 7))] if t >= 8 else []


@pytest.mark.parametrize("memory", [8, 1])
def test_a_line_that_is_erased_and_drawn_again_is_one_stroke_if_it_is_remembered(memory: int) -> None:
    coverage = np.stack([draw(erased_and_drawn_again(t)) for t in range(COUNT)])
    ink = Ink(coverage, np.zeros_like(coverage), np.zeros((1, 3)), np.ones(3), 0.0)
    trace = partial(initialise, settings=InitialiseSettings())
    result = propagate(ink, trace(ink, 0), PropagateSettings(refine_steps=12, memory=memory), trace)
    strokes = result.strokes
    assert len(strokes) == (1 if memory == 8 else 2)
    assert not any(event.kind == EventKind.CUT for event in result.events)
    for t in (0, 2, 4, 9, 10, 12):
        [(_, begin, end)] = erased_and_drawn_again(t)
        whole = float(np.linalg.norm(np.diff(line(2, np.linspace(begin, end, 60)), axis=0), axis=1).sum())
        on_one = max(share_of_one(strokes, t, 2, (begin, end)).values(), default=0.0)
        assert on_one > 0.85 * whole - 3.0, t
    for t in (6, 7):
        shown = [float(np.ptp(strokes.visible[row])) for row in strokes.rows_at(t).tolist()]
        assert sum(shown) == 0.0


HESITANT = np.array([0, 0, 0.01, 2, 4, 6, 8, 10, 13, 30, 60, 100, 140, 170, 185, 190, 192, 193]) / 193
"""How much of a line is drawn that begins as a dot, and slows down at its end."""


def page_of(lines: list[tuple[Floats, float]]) -> NDArray[np.uint8]:
    """Coverage of polylines of given widths, by supersampling."""
    scale = 4
    image = np.zeros((SIZE * scale, SIZE * scale), np.uint8)
    for points, width in lines:
        at = np.round((points * scale - 0.5) * 16).astype(np.int32)
        cv2.polylines(image, [at], False, 255, round(width * scale), cv2.LINE_AA, 4)
    return np.asarray(cv2.resize(image, (SIZE, SIZE), interpolation=cv2.INTER_AREA), np.uint8)


def carried(pages: list[NDArray[np.uint8]]) -> Strokes:
    """Strokes of the first of some drawings over all of them."""
    coverage = np.stack(pages)
    ink = Ink(coverage, np.zeros_like(coverage), np.zeros((1, 3)), np.ones(3), 0.0)
    trace = partial(initialise, settings=InitialiseSettings())
    return propagate(ink, trace(ink, 0), PropagateSettings(refine_steps=12), trace).strokes


def part_of(ends: Floats, begin: float, end: float) -> Floats:
    return np.stack([ends[0] + share * (ends[1] - ends[0]) for share in (begin, end)])


@pytest.mark.parametrize(("width", "crossed"), [(6.0, 6.0), (15.0, 15.0), (10.0, 20.0)])
def test_a_line_that_begins_slowly_and_crosses_another_is_one_stroke(width: float, crossed: float) -> None:
    ends, standing = np.array([[24.0, 24.0], [170.0, 150.0]]), np.array([[30.0, 160.0], [150.0, 20.0]])
    drawn = [[(part_of(ends, 0.0, share), width)] if share else [] for share in HESITANT]
    strokes = carried([page_of([(standing, crossed), *lines]) for lines in drawn])
    assert len(strokes) == 2
    points = strokes.points_of(strokes.row(1, len(HESITANT) - 1))
    assert min(np.linalg.norm(points[[0, -1]][::way] - ends, axis=1).max() for way in (1, -1)) < width / 2


def test_dashes_that_are_drawn_one_after_the_other_stay_dashes() -> None:
    ends, standing = np.array([[24.0, 24.0], [170.0, 150.0]]), np.array([[30.0, 160.0], [60.0, 180.0]])
    early, late = np.minimum(HESITANT, 0.45), HESITANT[HESITANT > 0.52]
    drawn = [[(0.0, share)] if share else [] for share in early] + [[(0.0, 0.45), (0.52, share)] for share in late]
    pages = [page_of([(standing, 6.0), *((part_of(ends, *part), 6.0) for part in parts)]) for parts in drawn]
    assert len(carried(pages)) == 3


@pytest.mark.parametrize(("is_seen", "strokes"), [(True, 1), (False, 2)])
def test_what_appears_at_the_end_of_a_hidden_stroke_does_not_grow_on_from_it(is_seen: bool, strokes: int) -> None:
    """A line is revealed bit by bit where the end of another one is, which may be hidden then."""
    older, younger = np.linspace([20.0, 60.0], [80.0, 60.0], 4), np.linspace([84.0, 60.0], [150.0, 60.0], 4)
    shown = [(0.0, 1.0)] * 4 if is_seen else [(0.0, 1.0), (0.0, 0.6), (0.0, 0.0), (0.0, 0.0)]
    half = np.full(2, 3.0)
    rows = {d: Row(older, half, 1.0, part, 1.0) for d, part in enumerate(shown)}
    born = {d: Row(younger, half, 1.0, (0.0, share), 1.0) for d, share in ((2, 0.3), (3, 0.7))}
    lives = [Life(n, False, n, np.zeros(3), part) for n, part in ((1, rows), (2, born))]
    blank = np.zeros((4, SIZE, SIZE), np.uint8)
    ink = Ink(blank, blank, np.zeros((1, 3)), np.ones(3), 0.0)
    assert len(join_grown(lives, ink)) == strokes


@pytest.mark.parametrize("gap", [12.0, 24.0])
def test_a_line_of_one_drawing_alone_is_a_stroke_if_it_lies_away_from_all_others(gap: float) -> None:
    long, short = np.array([(30.0, 60.0), (170.0, 60.0)]), np.array([(70.0, 60.0 + gap), (100.0, 64.0 + gap)])
    pages = [page_of([(long, 4.0), (short, 4.0)] if t == 3 else [(long, 4.0)]) for t in range(6)]
    strokes = carried(pages)
    lives = list(zip(strokes.layout.first.tolist(), strokes.layout.last.tolist(), strict=True))
    assert lives == [(0, 5), (3, 3)]
    dense = sample_by_arc(strokes.points_of(strokes.row(1, 3)), 64)
    assert np.linalg.norm(part_of(short, 0.05, 0.95)[:, None] - dense, axis=2).min(1).max() < 1.5


def test_ink_of_one_drawing_beside_a_line_is_none() -> None:
    long, beside = np.array([(30.0, 60.0), (170.0, 60.0)]), np.array([(70.0, 68.0), (100.0, 68.0)])
    strokes = carried([page_of([(long, 4.0), (beside, 4.0)] if t == 3 else [(long, 4.0)]) for t in range(6)])
    assert len(strokes) == 1
