"""Strokes that something passes before: what of them lies under it, and what is tied to it."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray
from test_propagate import draw, line

from videovec.propagate.covered import find_covered
from videovec.propagate.nodes import Nodes, basis_of, gather
from videovec.propagate.registration import parted, source_of
from videovec.propagate.target import make_target

Floats = NDArray[np.float64]

WHOLE = line(20, 80, 140, 80)
POST = line(100, 20, 100, 140)


def nodes_of(curves: list[Floats]) -> tuple[Nodes, Floats]:
    nodes = gather([basis_of(curve, 4.0, False) for curve in curves])
    return nodes, np.asarray(nodes.weights @ np.concatenate(curves))


@pytest.mark.parametrize(
    ("drawn", "is_covered"), [([line(20, 80, 100, 80), POST], True), ([line(20, 80, 100, 80)], False)]
)
def test_only_what_ends_at_a_line_lies_under_it(drawn: list[Floats], is_covered: bool) -> None:
    nodes, positions = nodes_of([WHOLE])
    beyond = positions[:, 0] > 104
    covered = find_covered(nodes, positions, beyond, make_target(draw(drawn), 160))
    assert (covered == (beyond & is_covered)).all()


def test_a_stroke_of_which_hardly_anything_is_left_is_not_said_to_be_covered() -> None:
    nodes, positions = nodes_of([WHOLE])
    target = make_target(draw([line(90, 80, 100, 80), POST]), 160)
    assert not find_covered(nodes, positions, np.abs(positions[:, 0] - 95) > 6, target).any()


def test_strokes_that_pass_each_other_lose_their_ties_and_those_that_turn_together_keep_them() -> None:
    nodes, positions = nodes_of([WHOLE, line(20, 90, 140, 90)])
    source = source_of(nodes, positions, make_target(draw([WHOLE, line(20, 90, 140, 90)]), 160))
    angle = np.radians(20)
    turn = np.array([[np.cos(angle), np.sin(angle)], [-np.sin(angle), np.cos(angle)]])
    np.testing.assert_allclose(parted(source, positions @ turn + 7.0).across, source.across, atol=1e-9)
    passed = positions + np.where(nodes.stroke == 1, 16.0, 0.0)[:, None] * (1.0, 0.0)
    own = np.repeat(np.arange(len(nodes)), np.diff(source.indptr))
    between = (nodes.stroke[own] != nodes.stroke[source.index]) & (source.across > 0)
    assert (parted(source, passed).across[between] < 0.1 * source.across[between]).all()
