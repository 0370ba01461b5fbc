from dataclasses import replace

import numpy as np
import pytest

from videovec.strokes import Strokes
from videovec.visibility import visible_intervals


def straight(segments: int, length: float = 30.0) -> Strokes:
    x = np.linspace(0.0, length, 3 * segments + 1)
    return Strokes.from_curves([np.stack([x, 0 * x], axis=1)], [np.ones(segments + 1)])


@pytest.mark.parametrize(
    ("visible", "expected"),
    [
        ((0.0, 1.0), [(0, 1), (0, 1), (0, 1)]),
        ((0.5, 1.0), [(0, 0), (0.5, 1), (0, 1)]),
        ((0.1, 0.2), [(0.3, 0.6), (0, 0), (0, 0)]),
        ((0.25, 0.75), [(0.75, 1), (0, 1), (0, 0.25)]),
        ((0.4, 0.4), [(0, 0), (0, 0), (0, 0)]),
    ],
)
def test_arc_fractions_of_a_straight_stroke_are_parameters_of_its_segments(
    visible: tuple[float, float], expected: list[tuple[float, float]]
) -> None:
    strokes = replace(straight(3), visible=np.array([visible]))
    np.testing.assert_allclose(visible_intervals(strokes), expected, atol=1e-9)


def test_a_dot_is_visible_or_not() -> None:
    dot = Strokes.from_curves([np.full((4, 2), 5.0)], [np.ones(2)])
    begin, end = visible_intervals(replace(dot, visible=np.array([[0.0, 0.5]])))[0]
    assert end > begin
    begin, end = visible_intervals(replace(dot, visible=np.array([[0.5, 0.5]])))[0]
    assert begin == end
