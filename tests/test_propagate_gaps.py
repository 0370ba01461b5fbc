"""Strokes over which something passes that is narrower than they are long."""

from __future__ import annotations

from dataclasses import replace
from functools import partial

import numpy as np
import pytest
from numpy.typing import NDArray

from videovec.curves import sample_by_arc
from videovec.events import EventKind
from videovec.fit import fit
from videovec.initialise import initialise
from videovec.ink import Ink
from videovec.propagate import Propagated, propagate
from videovec.settings import FitSettings, InitialiseSettings, PropagateSettings
from videovec.strokes import Strokes

Floats = NDArray[np.float64]

SIZE, HALF = 128, 3.0
SMOOTH = 4  # samples across a pixel


def wave(u: Floats) -> Floats:
    """A bent line across the page, at fractions of its width. [N, 2]"""
    return np.stack([14 + 100 * u, 64 + 14 * np.sin(2.6 * u)], axis=-1)


def ring(u: Floats) -> Floats:
    """A circle that begins at the right. [N, 2]"""
    return np.stack([64 + 36 * np.cos(2 * np.pi * u), 64 + 36 * np.sin(2 * np.pi * u)], axis=-1)


def draw(lines: list[Floats], erased: tuple[float, float, float] | None = None) -> NDArray[np.uint8]:
    """Coverage of thick polylines by supersampling, without a disc x, y, radius."""
    at = (np.arange(SIZE * SMOOTH) + 0.5) / SMOOTH
    x, y = np.meshgrid(at, at)
    inked = np.zeros(x.shape, bool)
    for line in lines:
        for px, py in line:
            inked |= (x - px) ** 2 + (y - py) ** 2 <= HALF**2
    if erased:
        inked &= (x - erased[0]) ** 2 + (y - erased[1]) ** 2 > erased[2] ** 2
    mean = inked.reshape(SIZE, SMOOTH, SIZE, SMOOTH).mean((1, 3))
    return np.asarray((255 * mean).round(), np.uint8)


def ink_of(drawings: list[NDArray[np.uint8]]) -> Ink:
    coverage = np.stack(drawings)
    return Ink(coverage, np.zeros_like(coverage), np.zeros((1, 3)), np.ones(3), 0.0)


def carried(ink: Ink) -> tuple[Propagated, Strokes]:
    """What is known after the walk, and the strokes after the joint fit."""
    trace = partial(initialise, settings=InitialiseSettings())
    result = propagate(ink, trace(ink, 0), PropagateSettings(refine_steps=18), trace)
    return result, fit(ink, result.strokes, FitSettings(joint_steps=30)).strokes


def along(strokes: Strokes, stroke: int, drawing: int) -> Floats:
    """The seen part of a stroke. [M, 2] px"""
    row = strokes.row(stroke, drawing)
    begin, end = strokes.visible[row]
    dense = sample_by_arc(strokes.points_of(row), 1001)
    return dense[round(1000 * begin) : round(1000 * end) + 1]


def off(points: Floats, line: Floats) -> float:
    """Largest distance of some points from a line. px"""
    return float(np.linalg.norm(points[:, None] - line, axis=2).min(1).max())


def kinds(result: Propagated) -> list[tuple[EventKind, int, int]]:
    return [(event.kind, event.drawing, len(event.parents)) for event in result.events]


LINE = wave(np.linspace(0, 1, 300))


@pytest.fixture(scope="module")
def passed_over() -> tuple[Propagated, Strokes]:
    """A line over which an eraser passes, there on drawings 2 to 5."""
    spots = [wave(np.array(0.45 + 0.03 * t)) for t in range(4)]
    holes = [None, None, *((float(x), float(y), 12.0) for x, y in spots), None, None]
    return carried(ink_of([draw([LINE], hole) for hole in holes]))


def test_a_gap_makes_two_strokes_while_it_is_open_and_one_afterwards(passed_over: tuple[Propagated, Strokes]) -> None:
    result, strokes = passed_over
    assert strokes.parent.tolist() == [0, strokes.ids[0]]
    assert (strokes.layout.first[1], strokes.layout.last[1]) == (2, 5)
    assert [turn for turn in kinds(result) if turn[2]] == [(EventKind.SPLIT, 2, 1), (EventKind.MERGE, 6, 2)]
    assert not {EventKind.BIRTH, EventKind.DEATH} & {kind for kind, *_ in kinds(result)}
    assert np.ptp(strokes.visible[strokes.row(0, 7)]) == 1.0


def test_a_gap_bends_nothing_and_lies_where_the_paper_is_bare(passed_over: tuple[Propagated, Strokes]) -> None:
    _, strokes = passed_over
    for drawing in range(2, 6):
        hole = wave(np.array(0.45 + 0.03 * (drawing - 2)))
        for stroke in (0, 1):
            seen = along(strokes, stroke, drawing)
            assert off(seen, LINE) < 0.6
            inside = np.linalg.norm(seen - hole, axis=1).min()
            assert 12.0 - 2.0 < inside < 12.0 + HALF + 2.0


def test_both_sides_of_a_gap_share_their_material(passed_over: tuple[Propagated, Strokes]) -> None:
    _, strokes = passed_over
    for drawing in range(2, 6):
        whole, part = (strokes.points_of(strokes.row(stroke, drawing)) for stroke in (0, 1))
        np.testing.assert_array_equal(whole, part)


def test_a_ring_that_is_hidden_away_from_its_seam_is_one_stroke() -> None:
    circle = ring(np.linspace(0, 1, 400))
    spots = [ring(np.array(0.3 + 0.02 * t)) for t in range(3)]
    holes = [None, *((float(x), float(y), 14.0) for x, y in spots), None]
    result, strokes = carried(ink_of([draw([circle], hole) for hole in holes]))
    assert len(strokes) == 1
    assert EventKind.SPLIT not in [kind for kind, *_ in kinds(result)]
    for drawing, spot in enumerate(spots, start=1):
        seen = along(strokes, 0, drawing)
        assert off(seen, circle) < 0.6
        assert off(circle[np.linalg.norm(circle - spot, axis=1) > 14.0 + 1.0], seen) < HALF + 2.0


def test_a_ring_that_must_begin_where_it_began_shows_its_other_part_as_a_stroke_of_its_own() -> None:
    circle = ring(np.linspace(0, 1, 400))
    spots = [ring(np.array(0.3 + 0.02 * t)) for t in range(3)]
    holes = [None, *((float(x), float(y), 14.0) for x, y in spots), None]
    ink = ink_of([draw([circle], hole) for hole in holes])
    trace = partial(initialise, settings=InitialiseSettings())
    drawn = trace(ink, 0)
    strokes = propagate(ink, drawn, PropagateSettings(refine_steps=18, move_seams=False), trace).strokes
    np.testing.assert_array_equal(strokes.points_of(strokes.row(0, 0)), drawn.points)
    assert strokes.parent.tolist() == [0, strokes.ids[0]]
    for drawing, spot in enumerate(spots, start=1):
        seen = np.concatenate([along(strokes, stroke, drawing) for stroke in (0, 1)])
        assert off(circle[np.linalg.norm(circle - spot, axis=1) > 14.0 + 1.0], seen) < HALF + 2.0


def test_a_gap_over_the_seam_of_a_ring_is_seen() -> None:
    circle = ring(np.linspace(0, 1, 400))
    k = 36 * 0.5522847
    quarter = np.array([(100, 64), (100, 64 + k), (64 + k, 100), (64, 100)], float) - 64
    turned = [quarter @ np.array([[c, s], [-s, c]], float) + 64 for c, s in ((1, 0), (0, 1), (-1, 0), (0, -1))]
    points = np.concatenate([turned[0][:1], *(part[1:] for part in turned)])
    known = replace(Strokes.from_curves([points], [np.full(5, HALF)]), is_closed=np.array([True]))
    ink = ink_of([draw([circle], hole) for hole in (None, *[(100.0, 64.0 + 2 * t, 12.0) for t in range(3)])])
    trace = partial(initialise, settings=InitialiseSettings())
    strokes = propagate(ink, known, PropagateSettings(refine_steps=18), trace).strokes
    for drawing in range(1, 4):
        seen = along(strokes, 0, drawing)
        spot = np.array([100.0, 64.0 + 2 * (drawing - 1)])
        assert np.linalg.norm(seen - spot, axis=1).min() > 12.0 - 2.0
        assert off(circle[np.linalg.norm(circle - spot, axis=1) > 12.0 + 1.0], seen) < HALF + 2.0
