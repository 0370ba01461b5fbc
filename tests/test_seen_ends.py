"""What is seen of strokes ends at the edge of the page."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from test_propagate import line, strokes_of

from videovec.seen_ends import measure_ends


@pytest.mark.parametrize(
    ("ends", "seen"),
    [
        ((20, 20, 80, 20), (0.0, 1.0)),
        ((-40, 20, 60, 20), (0.4, 1.0)),
        ((-40, -40, 140, 140), (2 / 9, 7 / 9)),
        ((20, 60, 20, 140), (0.0, 0.5)),
        ((10, -1, 90, -1), (0.0, 1.0)),
        ((10, -9, 90, -9), (0.0, 0.0)),
    ],
)
def test_a_stroke_is_seen_up_to_where_its_middle_leaves_the_page(
    ends: tuple[float, ...], seen: tuple[float, float]
) -> None:
    measured = measure_ends(strokes_of([line(*ends)]), (100, 100)).visible[0]
    np.testing.assert_allclose(measured, seen, atol=0.01)


def test_what_was_hidden_on_the_page_stays_hidden() -> None:
    strokes = replace(strokes_of([line(-40, 20, 60, 20)]), visible=np.array([[0.0, 0.8]]))
    np.testing.assert_allclose(measure_ends(strokes, (100, 100)).visible, [[0.4, 0.8]], atol=0.01)
