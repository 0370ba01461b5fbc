"""Material along strokes: what turns or is stretched evenly keeps it, and what has slipped is brought back."""

from __future__ import annotations

import numpy as np
import pytest
import torch
from numpy.typing import NDArray

from videovec.material import Marks, sliding
from videovec.strokes import Layout, Strokes

Floats = NDArray[np.float64]

BEND = np.array([[0, 0], [20, -30], [35, 30], [50, 5], [65, -20], [80, 10], [90, 40]], float)


def _rows(rows: list[Floats]) -> Strokes:
    """One stroke, a row for each drawing."""
    count, segments = len(rows), (len(rows[0]) - 1) // 3
    return Strokes(
        ids=np.array([1]),
        layout=Layout(np.array([segments]), np.array([0]), np.array([count - 1])),
        is_closed=np.array([False]),
        layer=np.array([0]),
        color=np.zeros((1, 3)),
        points=np.concatenate(rows),
        half_width=np.ones(count * (segments + 1)),
        opacity=np.ones(count),
        visible=np.tile([0.0, 1.0], (count, 1)),
        parent=np.array([0]),
    )


def _turn(degrees: float) -> Floats:
    angle = np.radians(degrees)
    return np.array([[np.cos(angle), np.sin(angle)], [-np.sin(angle), np.cos(angle)]])


def _loss(rows: list[Floats], known: list[int] | None = None) -> float:
    strokes = _rows(rows)
    marks = Marks.of(strokes, None if known is None else np.array(known))
    return float(sliding(torch.as_tensor(strokes.points), marks))


def test_a_stroke_that_turns_grows_and_shears_has_not_slid() -> None:
    shear = np.array([[1.0, 0.15], [0.0, 0.9]])
    assert _loss([BEND, BEND @ _turn(40) + 7, 1.4 * BEND]) < 1e-3  # the two measure lengths with other sums
    assert _loss([BEND, BEND @ shear]) < 0.02  # the spread believed in keeps a little of it back


def test_a_stroke_that_is_longer_at_one_end_has_slid() -> None:
    longer = BEND.copy()
    longer[4:] += np.array([[3.0, 1.0], [6.0, 2.0], [9.0, 3.0]])
    assert _loss([BEND, longer]) > 0.1


def test_control_points_that_slipped_along_a_line_are_brought_back() -> None:
    line = np.linspace([0.0, 0.0], [60.0, 20.0], 7)
    slipped = line.copy()
    slipped[1:6] += np.array([0.3, 0.7, 1.0, 0.6, 0.3])[:, None] * np.array([0.95, 0.31])
    strokes = _rows([line, slipped])
    points = torch.as_tensor(strokes.points).requires_grad_()
    marks = Marks.of(strokes)
    optimiser = torch.optim.SGD([points], lr=0.3)
    for _ in range(300):
        optimiser.zero_grad()
        sliding(points, marks).backward()  # type: ignore[no-untyped-call]
        optimiser.step()
    found = points.detach().numpy()
    gap = np.linalg.norm(found[10] - found[7]) / np.linalg.norm(found[13] - found[7])
    assert gap == pytest.approx(0.5, abs=0.004)
    assert np.abs(found[:7] - line).max() < 0.3


def test_rows_that_are_known_say_where_material_is() -> None:
    slipped = BEND.copy()
    slipped[2:5] += [2.0, -1.0]
    strokes = _rows([BEND, slipped, slipped])
    points = torch.as_tensor(strokes.points)
    from_first, from_last = Marks.of(strokes), Marks.of(strokes, np.array([2]))
    per_row = from_first.fraction.reshape(3, -1)
    assert not torch.allclose(per_row[2], from_last.fraction.reshape(3, -1)[2], atol=1e-3)
    assert float(sliding(points[14:], Marks.of(_rows([slipped])))) == pytest.approx(0.0, abs=1e-3)
    assert float(sliding(points, from_last)) > 0.01
