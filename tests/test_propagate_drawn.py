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


@pytest.mark.parametrize("widths", [1.0, 2.5])
def test_a_line_that_begins_slowly_and_crosses_another_is_one_stroke(widths: float) -> None:
    count, pen = len(HESITANT), WIDTH * widths
    ends = np.array([[24.0, 24.0], [170.0, 150.0]])
    scale = 4

    def page(t: int) -> NDArray[np.uint8]:
        image = np.zeros((SIZE * scale, SIZE * scale), np.uint8)
        lines = [np.array([[20.0, 160.0], [176.0, 40.0]])]
        lines += [np.stack([ends[0], ends[0] + HESITANT[t] * (ends[1] - ends[0])])] if HESITANT[t] else []
        for one in lines:
            at = np.round((one * scale - 0.5) * 16).astype(np.int32)
            cv2.polylines(image, [at], False, 255, round(pen * scale), cv2.LINE_AA, 4)
        return np.asarray(cv2.resize(image, (SIZE, SIZE), interpolation=cv2.INTER_AREA), np.uint8)

    coverage = np.stack([page(t) for t in range(count)])
    ink = Ink(coverage, np.zeros_like(coverage), np.zeros((1, 3)), np.ones(3), 0.0)
    trace = partial(initialise, settings=InitialiseSettings())
    strokes = propagate(ink, trace(ink, 0), PropagateSettings(refine_steps=12), trace).strokes
    assert len(strokes) == 2
    drawn = strokes.points_of(strokes.row(1, count - 1))
    gaps = [np.linalg.norm(drawn[[0, -1]][::way] - ends, axis=1).max() for way in (1, -1)]
    assert min(gaps) < pen / 2
