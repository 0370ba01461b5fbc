"""Discs that turn on edge: strokes whose ink runs together come apart as they went."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from test_propagate import draw, ink_of, line, run

from samples.scene import ellipse
from videovec.curves import sample_by_arc
from videovec.propagate.momentum import affine_part, merged_nodes
from videovec.propagate.nodes import Nodes, bases_of, gather
from videovec.propagate.stretch import stretched
from videovec.strokes import Strokes

Floats = NDArray[np.float64]


def nodes_of(curves: list[Floats], *, is_closed: bool = False) -> tuple[Nodes, Floats]:
    strokes = Strokes.from_curves(
        curves, [np.ones((len(c) + 2) // 3) for c in curves], is_closed=[is_closed] * len(curves)
    )
    nodes = gather(bases_of(strokes, 4.0))
    return nodes, nodes.positions(strokes.points)


def test_lines_without_paper_between_run_together_and_crossing_ones_do_not() -> None:
    curves = [line(20, 50, 100, 50), line(20, 54, 60, 54), line(80, 20, 80, 80)]
    nodes, positions = nodes_of(curves)
    down = np.where(nodes.stroke[:, None] == 1, [0.0, 2.0], 0.0)
    merged = merged_nodes(nodes, positions, down, np.full(3, 2.0), np.ones(len(nodes), bool))
    x, y = positions.T
    assert merged[(nodes.stroke == 1)].all()
    assert merged[(y == 50) & (x < 60)].all()
    assert not merged[(y == 50) & (x > 66)].any()
    assert not merged[nodes.stroke == 2].any()
    hidden = merged_nodes(nodes, positions, down, np.full(3, 2.0), nodes.stroke != 1)
    assert not hidden.any()


def test_lines_that_go_side_by_side_do_not_run_together() -> None:
    nodes, positions = nodes_of([line(20, 50, 100, 50), line(100, 54, 20, 54)])
    along = np.where(nodes.stroke[:, None] == 1, [9.0, 3.0], [0.0, 3.0])
    assert not merged_nodes(nodes, positions, along, np.full(2, 2.0), np.ones(len(nodes), bool)).any()


def test_both_sides_of_a_narrow_ring_run_together() -> None:
    nodes, positions = nodes_of([ellipse((80, 80), (2, 50))], is_closed=True)
    closing = 0.5 * (80 - positions) * [1.0, 0.0]
    merged = merged_nodes(nodes, positions, closing, np.full(1, 2.0), np.ones(len(nodes), bool))
    assert merged[np.abs(positions[:, 1] - 80) < 35].all()
    wide, apart = nodes_of([ellipse((80, 80), (20, 50))], is_closed=True)
    closing = 0.5 * (80 - apart) * [1.0, 0.0]
    assert not merged_nodes(wide, apart, closing, np.full(1, 2.0), np.ones(len(wide), bool)).any()


def test_an_affine_motion_is_its_own_affine_part() -> None:
    _, positions = nodes_of([ellipse((80, 80), (40, 50))], is_closed=True)
    velocity = (positions - 80) @ np.array([[-0.2, 0.1], [-0.1, 0.0]]) + np.array([3.0, -1.0])
    np.testing.assert_allclose(affine_part(positions, velocity), velocity, atol=0.1)
    bent = velocity + np.sin(positions[:, :1])
    np.testing.assert_allclose(affine_part(positions, bent), velocity, atol=0.3)


def test_a_squeeze_is_shape_and_a_dent_is_not() -> None:
    nodes, rest = nodes_of([ellipse((80, 80), (40, 50))], is_closed=True)
    squeezed = (rest - 80) * [0.8, 1.0] + 80
    dented = squeezed + np.where(np.abs(rest[:, 1:] - 80) < 8, [3.0, 0.0], 0.0)
    everything, apart = np.ones(len(nodes)), np.zeros(len(nodes), bool)
    np.testing.assert_allclose(stretched(nodes, rest, squeezed, everything, apart), squeezed, atol=0.5)
    np.testing.assert_allclose(stretched(nodes, rest, dented, everything, apart), squeezed, atol=1.0)
    np.testing.assert_array_equal(stretched(nodes, rest, squeezed, everything, ~apart), rest)
    half = (rest[:, 0] > 80).astype(float)  # too little is seen to know its shape
    np.testing.assert_array_equal(stretched(nodes, rest, squeezed, half, apart), rest)
    bent = rest + np.where(rest[:, 1:] > 120, [6.0, 0.0], 0.0)  # a bend of a part is no squeeze of the whole
    np.testing.assert_array_equal(stretched(nodes, rest, bent, everything, apart), rest)


def disc(turn: float) -> list[Floats]:
    """A disc of two rings that turns about its upright axis, seen from its front at first."""
    return [ellipse((80, 80), (radius * np.cos(turn), radius)) for radius in (60.0, 36.0)]


def test_a_disc_that_turns_on_edge_and_on_keeps_its_rings() -> None:
    drawings = [disc(turn) for turn in np.linspace(0.9, 2.24, 11)]
    first = Strokes.from_curves(drawings[0], [np.full(5, 1.5)] * 2, is_closed=[True, True])
    strokes = run(ink_of([draw(curves) for curves in drawings]), first).strokes
    assert len(strokes) == 2
    for s, curve in enumerate(drawings[-1]):
        found = sample_by_arc(strokes.points_of(strokes.row(s, 10)), 200)
        gap = np.linalg.norm(sample_by_arc(curve, 50)[:, None] - found, axis=2).min(axis=1)
        assert gap.max() < 1.5
