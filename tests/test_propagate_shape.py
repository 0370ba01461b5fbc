"""Strokes keep their shape: neither zigzags nor foreign ink become part of it."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from test_propagate import arc, draw, ink_of, line, run, strokes_of

from videovec.events import EventKind
from videovec.propagate.nodes import bases_of, gather
from videovec.propagate.refine import refine
from videovec.propagate.registration import Source, recall, source_of
from videovec.propagate.target import make_target
from videovec.strokes import Strokes


def _straight() -> tuple[Source, NDArray[np.float64]]:
    """A horizontal stroke of 400 px, and its nodes."""
    points = np.linspace((20.0, 100.0), (420.0, 100.0), 34 * 3 + 1)
    strokes = Strokes.from_curves([points], [np.ones(35)])
    nodes = gather(bases_of(strokes, 4.0))
    rest = nodes.positions(points)
    return source_of(nodes, rest, make_target(np.zeros((200, 440), np.uint8), 640)), rest


def test_a_zigzag_is_not_the_rest_shape_of_the_next_step() -> None:
    source, shape = _straight()
    bent = shape + [0.0, 1.0] * (3.0 * np.sin(2 * np.pi * shape[:, :1] / 16.0))
    rest = recall(source_of(source.nodes, bent, make_target(np.zeros((200, 440), np.uint8), 640)), shape).rest
    assert np.abs(rest[4:-4, 1] - 100.0).max() < 0.5


def test_a_long_bend_is_and_so_are_turns_and_motion() -> None:
    source, shape = _straight()
    empty = make_target(np.zeros((200, 440), np.uint8), 640)
    bent = shape + [0.0, 1.0] * (20.0 * np.sin(np.pi * (shape[:, :1] - 20.0) / 400.0))
    np.testing.assert_allclose(recall(source_of(source.nodes, bent, empty), shape).rest, bent, atol=1.5)
    turned = (shape - 200.0) @ np.array([[0.8, 0.6], [-0.6, 0.8]]) + [210.0, 190.0]
    np.testing.assert_allclose(recall(source_of(source.nodes, turned, empty), shape).rest, turned, atol=0.3)


def test_ink_beyond_a_stroke_does_not_pull_it() -> None:
    points = line(20, 80, 140, 80)
    coverage = draw([points, line(40, 89, 120, 89)])
    fitted = refine(strokes_of([points + np.array([0.0, 0.7])]), points, coverage, 45, 0.5)
    np.testing.assert_allclose(fitted.points[:, 1], 80.0, atol=0.3)


def test_a_line_that_appears_across_others_is_one_stroke() -> None:
    others = [line(20, 60, 140, 60), line(20, 100, 140, 100)]
    new = arc(20, 140, 120, -80, -10)
    result = run(ink_of([draw(others)] * 2 + [draw([*others, new])] * 4), strokes_of(others))
    births = [event for event in result.events if event.kind == EventKind.BIRTH]
    assert [event.drawing for event in births] == [2]
    assert len(result.strokes) == 3
