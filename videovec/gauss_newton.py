"""The fit as the least-squares problem that it is: Gauss-Newton steps, damped as Levenberg and Marquardt have it.

A pixel's value hangs on ten unknowns of one segment. Numbered along the stroke, neighbouring segments share three of
theirs, so that the normal equations of a stroke are a narrow band, factorised in a time that grows with its length.
What couples strokes, where they cross, is left out; the damping grows when that makes a step go wrong.

Source:
    Levenberg 1944, "A method for the solution of certain non-linear problems in least squares"; Marquardt 1963.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import torch
from numpy.typing import NDArray

from videovec.compiling import compiled
from videovec.parameters import Parameters
from videovec.render import NormalEquations

__all__ = ["Damping", "GaussNewton"]

Array = NDArray[Any]

REACH = 10
"""Entries of a row of the band: an unknown meets itself and the nine before it."""
PER_SEGMENT = 7
"""Unknowns from one joint of a stroke to the next."""
AT_POINT = np.array([0, 3, 5])
"""Where a joint and the two handles after it have their x among these."""
AT_WIDTH = 2
"""Where a joint has its half-width."""
RELATIVE = 1e-3
"""Share of its diagonal by which the matrix is damped besides, against rounding."""
FARTHEST, WIDEST = 1.0, 0.2
"""Longest step of a control point, px, and of the logarithm of a half-width."""


@dataclass(frozen=True, slots=True)
class Damping:
    """How much a step is held back, in squared coverage errors per px².

    Args:
        start: At first.
        least: At least.
        most: At most.
        rise: Factor after a step that made the drawing worse.
        fall: Factor after one that made it better.
        width: Of the logarithm of half-widths, in terms of that of points.
    """

    start: float = 0.1
    least: float = 0.003
    most: float = 1.0
    rise: float = 2.0
    fall: float = 0.8
    width: float = 2.0


class GaussNewton:
    """Steps of the points and half-widths of strokes, and the damping that each drawing has found.

    Args:
        parameters: What is moved.
        drawings: D.
        damping: How it is found.
    """

    def __init__(self, parameters: Parameters, drawings: int, damping: Damping | None = None) -> None:
        layout = parameters.strokes.layout
        self._parameters, self._damping = parameters, damping or Damping()
        self._held = np.full(drawings, self._damping.start)
        self._before = np.full(drawings, np.inf)
        self._drawing = layout.row_drawing
        segments = layout.segments[layout.row_stroke]
        self._row_segments = np.concatenate([[0], np.cumsum(segments)])
        self._is_closed = np.asarray(parameters.strokes.is_closed)[layout.row_stroke]
        begin = PER_SEGMENT * self._row_segments[:-1] + (REACH - PER_SEGMENT) * np.arange(len(segments))
        point = np.arange(len(parameters.points)) - layout.row_points[layout.point_row]
        joint = np.arange(len(parameters.log_half_width)) - layout.row_joints[layout.joint_row]
        self._points = begin[layout.point_row] + PER_SEGMENT * (point // 3) + AT_POINT[point % 3]
        self._widths = begin[layout.joint_row] + PER_SEGMENT * joint + AT_WIDTH

    def forget(self) -> None:
        """What is compared with the drawing has changed: the loss before says nothing of the next step."""
        self._before[:] = np.inf

    def step(self, equations: NormalEquations) -> None:
        """Move the parameters by the solution of the damped equations."""
        loss, damping = equations.loss.numpy(), self._damping
        factor = np.where(loss > self._before, damping.rise, damping.fall)
        factor[np.isinf(self._before)] = 1.0
        self._held = np.clip(self._held * factor, damping.least, damping.most)
        self._before = loss.copy()
        gradient, matrix = self._by_logarithm(equations)
        steps = np.zeros(PER_SEGMENT * self._row_segments[-1] + (REACH - PER_SEGMENT) * len(self._is_closed))
        held = self._held[self._drawing]
        _solve((self._row_segments, self._is_closed), gradient, matrix, (held, damping.width * held), steps)
        moved = np.stack([steps[self._points], steps[self._points + 1]], axis=1)
        moved *= FARTHEST / np.maximum(np.linalg.norm(moved, axis=1, keepdims=True), FARTHEST)
        widened = np.clip(steps[self._widths], -WIDEST, WIDEST)
        with torch.no_grad():
            self._parameters.points.add_(torch.as_tensor(moved, dtype=torch.float32))
            self._parameters.log_half_width.add_(torch.as_tensor(widened, dtype=torch.float32))

    def _by_logarithm(self, equations: NormalEquations) -> tuple[Array, Array]:
        """The equations by logarithms of half-widths, segments in the order of the strokes."""
        index = self._parameters.index
        place = np.empty_like(index.segments)
        place[index.segments] = np.arange(len(place))
        factor = torch.ones_like(equations.gradient)
        factor[:, [AT_WIDTH, REACH - 1]] = self._parameters.log_half_width.detach().exp()[index.joints]
        gradient = equations.gradient * factor
        matrix = equations.matrix * factor[:, :, None] * factor[:, None, :]
        return gradient.numpy()[place], matrix.numpy()[place]


@compiled()
def _solve(rows: tuple[Array, Array], gradient: Array, matrix: Array, held: tuple[Array, Array], steps: Array) -> None:
    """Solve the band of every row.

    Args:
        rows: Segment at which each row begins, then G [R+1]; whether its stroke is closed [R].
        gradient: Of each segment. [G, 10]
        matrix: Upper triangle for each segment. [G, 10, 10]
        held: Damping of the points and of the half-widths of each row. [R], [R]
        steps: The solution, row by row, written.
    """
    begin, is_closed = rows
    for r in range(len(is_closed)):
        segments = begin[r + 1] - begin[r]
        count = PER_SEGMENT * segments + REACH - PER_SEGMENT
        first = PER_SEGMENT * begin[r] + (REACH - PER_SEGMENT) * r
        band, right = np.zeros((count, REACH)), steps[first : first + count]
        for n in range(segments):
            seam = is_closed[r] and n == segments - 1
            _assemble(gradient[begin[r] + n], matrix[begin[r] + n], PER_SEGMENT * n, seam, band, right)
        for i in range(count):
            is_width = i % PER_SEGMENT == AT_WIDTH
            band[i, 0] = band[i, 0] * (1 + RELATIVE) + (held[1][r] if is_width else held[0][r])
        _factorise(band)
        _substitute(band, right)


@compiled()
def _assemble(gradient: Array, matrix: Array, base: int, seam: bool, band: Array, right: Array) -> None:
    """Add a segment to its row; the last joint of one that closes the stroke is the row's first.

    Across the seam what couples them is left out, which keeps the matrix positive.
    """
    for m in range(REACH):
        i, is_first = base + m, seam and m >= PER_SEGMENT
        if is_first:
            i = m - PER_SEGMENT
        right[i] -= gradient[m]
        for k in range(m, REACH):
            j = base + k
            if seam and k >= PER_SEGMENT:
                if not is_first:
                    continue
                j = k - PER_SEGMENT
            band[j, j - i] += matrix[m, k]


@compiled()
def _factorise(band: Array) -> None:
    """Cholesky's factor of a banded matrix, in place; entry [i, k] is that of row i and column i - k."""
    for i in range(len(band)):
        for k in range(min(i, REACH - 1), -1, -1):
            value, j = band[i, k], i - k
            for p in range(k + 1, min(REACH, i + 1)):
                value -= band[i, p] * band[j, p - k]
            band[i, k] = value / band[j, 0] if k else np.sqrt(max(value, 1e-9))


@compiled()
def _substitute(band: Array, right: Array) -> None:
    """Solve with the factor, in place."""
    for i in range(len(band)):
        for p in range(1, min(REACH, i + 1)):
            right[i] -= band[i, p] * right[i - p]
        right[i] /= band[i, 0]
    for i in range(len(band) - 1, -1, -1):
        for p in range(1, min(REACH, len(band) - i)):
            right[i] -= band[i + p, p] * right[i + p]
        right[i] /= band[i, 0]
