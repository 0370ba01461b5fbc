"""Lines that run side by side until the ink between them closes; rasters by supersampling, as in `test_initialise`."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree
from test_initialise import SETTINGS, ink, paint, straight

from videovec.curves import arc_length, sample_by_arc
from videovec.initialise import initialise
from videovec.strokes import Strokes

Floats = NDArray[np.float64]


def bowed(y: float, bow: float) -> Floats:
    """A line that comes from one side, runs straight at a height, and leaves to the same side again. [10, 2]"""
    middle = np.linspace((34, y), (94, y), 4)
    come = np.array([(8, y - bow), (16, y - bow), (22, y)], float)
    return np.concatenate([come, middle, [(106, y), (112, y - bow), (120, y - bow)]])


def off(true: Floats, strokes: Strokes) -> float:
    """How far the middle of a true line lies from the traced stroke that is nearest there. px"""
    drawn = np.concatenate([sample_by_arc(strokes.points_of(s), 800) for s in range(len(strokes))])
    samples = sample_by_arc(true, 200)
    return float(cKDTree(drawn).query(samples[(samples[:, 0] > 42) & (samples[:, 0] < 86)])[0].max())


def test_lines_whose_gap_closes_are_two_again() -> None:
    upper, lower = bowed(63.0, 25.0), bowed(65.0, -25.0)
    traced = initialise(ink(paint([upper, lower], 2.0)), 0, SETTINGS)
    lengths = [arc_length(traced.points_of(s)) for s in range(len(traced))]
    assert len(traced) == 2
    assert np.allclose(lengths, arc_length(upper), atol=2.0)
    assert max(off(upper, traced), off(lower, traced)) < 0.5


def test_a_line_that_is_thick_itself_stays_one() -> None:
    thick = np.linspace((34, 64), (94, 64), 4)
    coverage = np.maximum(paint([straight((8, 64), (120, 64))], 2.0), paint([thick], 4.2))
    traced = initialise(ink(coverage), 0, SETTINGS)
    assert len(traced) == 1
