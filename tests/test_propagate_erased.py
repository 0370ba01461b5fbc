"""Thick lines that are erased and drawn on again, and what is left of them: where that is and what it is not."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

import cv2
import numpy as np
import pytest
from numpy.typing import NDArray

from videovec.curves import sample_by_arc
from videovec.initialise import initialise
from videovec.ink import Ink
from videovec.propagate import propagate
from videovec.propagate.gaps import find_ring_pieces
from videovec.propagate.hypotheses import place
from videovec.propagate.nodes import basis_of, gather
from videovec.propagate.placing import is_still
from videovec.propagate.registration import source_of
from videovec.propagate.target import make_target
from videovec.settings import InitialiseSettings, PropagateSettings
from videovec.strokes import Strokes

Floats = NDArray[np.float64]
Part = tuple[float, float]

SIZE, WIDTH = 200, 16.0


def ring(u: Floats) -> Floats:
    """A circle, from its top clockwise. [N, 2]"""
    return np.stack([100 + 70 * np.sin(2 * np.pi * u), 100 - 70 * np.cos(2 * np.pi * u)], axis=-1)


def zigzag(u: Floats) -> Floats:
    """Straight lines with sharp corners. [N, 2]"""
    corners = np.array([(25, 100), (50, 100), (75, 40), (120, 160), (145, 100), (175, 100)], float)
    along = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(corners, axis=0), axis=1))])
    return np.stack([np.interp(u * along[-1], along, corners[:, k]) for k in (0, 1)], axis=-1)


def page(curve: Callable[[Floats], Floats], parts: list[Part]) -> NDArray[np.uint8]:
    """Coverage of parts of a line with round ends, by supersampling."""
    scale = 4
    image = np.zeros((SIZE * scale, SIZE * scale), np.uint8)
    for begin, end in parts:
        at = np.round((curve(np.linspace(begin, end, 400)) * scale - 0.5) * 16).astype(np.int32)
        cv2.polylines(image, [at], False, 255, round(WIDTH * scale), cv2.LINE_AA, 4)
    return np.asarray(cv2.resize(image, (SIZE, SIZE), interpolation=cv2.INTER_AREA), np.uint8)


def carried(pages: list[NDArray[np.uint8]], seed: int = 0) -> Strokes:
    """Strokes of one of some drawings over all of them."""
    coverage = np.stack(pages)
    ink = Ink(coverage, np.zeros_like(coverage), np.zeros((1, 3)), np.ones(3), 0.0)
    trace = partial(initialise, settings=InitialiseSettings())
    return propagate(ink, trace(ink, seed), PropagateSettings(refine_steps=12), trace).strokes


def shown_points(strokes: Strokes, drawing: int) -> Floats:
    """Points half a pixel apart on all that is seen. [N, 2]"""
    found = [np.zeros((0, 2))]
    for row in strokes.rows_at(drawing).tolist():
        begin, end = strokes.visible[row]
        u = np.linspace(0.0, 1.0, 801)
        found.append(sample_by_arc(strokes.points_of(row), 801)[(u >= begin) & (u <= end) & (end > begin)])
    return np.concatenate(found)


def farthest(points: Floats, others: Floats) -> float:
    """How far some points lie from others at most."""
    return float(np.linalg.norm(points[:, None] - others, axis=2).min(axis=1).max())


ERASED = [(0.0, 1.0), (0.06, 1.0), (0.15, 1.0), (0.4, 1.0), (0.7, 1.0), (0.9, 1.0)]
AGAIN = [(0.0, 0.05), (0.0, 0.15), (0.0, 0.3), (0.0, 0.6), (0.0, 0.85), (0.0, 0.93), (0.0, 1.0)]


@pytest.mark.parametrize(
    ("drawings", "seed"),
    [(ERASED, 0), ([*ERASED, *AGAIN], 0), (AGAIN, len(AGAIN) - 1)],
    ids=["erased", "erased and drawn again", "drawn"],
)
def test_what_is_left_of_a_ring_is_seen_to_its_round_ends(drawings: list[Part], seed: int) -> None:
    strokes = carried([page(ring, [part]) for part in drawings], seed)
    assert len(strokes) == 1
    for drawing, part in enumerate(drawings):
        true, seen = ring(np.linspace(*part, 400)), shown_points(strokes, drawing)
        assert farthest(true, seen) < 3.0, drawing
        assert farthest(seen, true) < 3.0, drawing


def test_a_line_with_corners_that_is_erased_and_drawn_again_stays_where_it_was() -> None:
    drawings = [*ERASED, *AGAIN]
    strokes = carried([page(zigzag, [part]) for part in drawings])
    assert len(strokes) == 1
    for drawing in range(len(drawings)):
        whole = sample_by_arc(strokes.points_of(strokes.row(0, drawing)), 400)
        assert farthest(whole, zigzag(np.linspace(0, 1, 800))) < 4.0, drawing


def test_a_bit_that_is_left_does_not_leap_to_like_ink_across_the_page() -> None:
    """Only the end of a line was seen, it is gone, and a line like it stands where the other end was."""
    line = 2.5 * zigzag(np.linspace(0, 1, 61))
    image = np.zeros((500, 500), np.uint8)
    cv2.line(image, (60, 250), (110, 250), 255, 6)
    nodes, target = gather([basis_of(line, 4.0, False)]), make_target(image, 500)
    source = source_of(nodes, nodes.positions(line), target, (nodes.u > 0.9).astype(float))
    moved = place(source, target, target, np.zeros((len(nodes), 2)))[1] - source.rest
    assert np.linalg.norm(moved[nodes.u > 0.9], axis=1).max() < 250.0


@pytest.mark.parametrize("gap", [(5, 12), (30, 44), (52, 59), (57, 3)])
def test_pieces_of_a_ring_leave_out_its_gap_wherever_that_is(gap: tuple[int, int]) -> None:
    """What is left is one run, which may go over the seam."""
    count, width = 60, 6.0
    inside = (np.arange(count) - gap[0]) % count < (gap[1] - gap[0]) % count
    seen = np.zeros(count, bool)
    [(first, last)] = find_ring_pieces((0, count - 1), ~inside, inside, ~inside, width)
    seen[np.arange(first, last + 1) % count] = True
    np.testing.assert_array_equal(seen, ~inside)


def test_a_ring_without_a_gap_is_one_piece() -> None:
    inked = np.ones(60, bool)
    inked[20:25] = False  # another line is nearer, but there is no paper
    assert find_ring_pieces((0, 59), inked, np.zeros(60, bool), np.ones(60, bool), 6.0) == [(0, 59)]


@pytest.mark.parametrize(("shift", "erased", "still"), [(0.0, 0.2, True), (0.0, 0.0, False), (1.6, 0.2, False)])
def test_strokes_stand_still_if_some_ink_is_gone_and_the_rest_is_where_it_was(
    shift: float, erased: float, still: bool
) -> None:
    """A thin bent line; moved by more than a pixel across itself it does not stand still, whatever is gone."""
    line = np.stack([np.linspace(20, 180, 4), [60, 120, 40, 100]], axis=1)
    bases = [basis_of(line, 4.0, False)]
    nodes = gather(bases)
    curve = sample_by_arc(line, 600)
    image = np.zeros((SIZE * 4, SIZE * 4), np.uint8)
    drawn = np.add(curve[round(600 * erased) :], (0.0, shift))
    cv2.polylines(image, [np.round((drawn * 4 - 0.5) * 16).astype(np.int32)], False, 255, 12, cv2.LINE_AA, 4)
    target = make_target(np.asarray(cv2.resize(image, (SIZE, SIZE), interpolation=cv2.INTER_AREA), np.uint8), SIZE)
    source = source_of(nodes, nodes.positions(line), target, np.ones(len(nodes)))
    assert is_still(source, np.array([1.5]), target) == still
