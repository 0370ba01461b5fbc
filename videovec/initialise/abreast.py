"""Two lines that run side by side so closely that the mask shows one thick line: parted again."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import gaussian_filter1d

from videovec.initialise.graph import Branch, Graph
from videovec.initialise.polyline import arc
from videovec.initialise.prune import Widths

__all__ = ["part_abreast"]

Floats = NDArray[np.float64]

_THIN, _THICK = 1.35, 2.2  # times the radius of the drawing's lines between which two of them lie side by side
_LEAST = 3.0  # widths that they must do so
_TAPER = 1.0  # widths at both ends at which they part
_FEWEST = 3  # branches that meet at either end


def part_abreast(graph: Graph, widths: Widths) -> None:
    """Make two branches of each that is as thick as two lines and has two or more others at either end, in place.

    Where one is not two lines but one thick one, the two branches draw it all the same.

    Args:
        graph: A clean skeleton graph.
        widths: How wide lines are.
    """
    if not graph.branches:
        return
    radii = [branch.radius for branch in graph.branches.values()] + graph.loop_radius
    typical = float(np.median(np.concatenate(radii)))
    width = max(widths.least, 2.0 * widths.calibration * typical)
    for number, branch in sorted(graph.branches.items()):
        is_between = min(graph.degree(branch.start), graph.degree(branch.stop)) >= _FEWEST
        if is_between and _is_double(branch, typical, width):
            _part(graph, number, typical, width)


def _is_double(branch: Branch, typical: float, width: float) -> bool:
    """Whether a branch is as thick as two lines all along."""
    along = arc(branch.line)
    inner = branch.radius[(along > _TAPER * width) & (along < along[-1] - _TAPER * width)]
    if branch.start == branch.stop or branch.length < _LEAST * width or not len(inner):
        return False
    low, middle = np.quantile(inner, [0.1, 0.5]) / typical
    return bool(low >= _THIN and middle <= _THICK)


def _part(graph: Graph, number: int, typical: float, width: float) -> None:
    """Replace a branch by two, as far beside it as its thickness says."""
    branch = graph.remove(number)
    along = arc(branch.line)
    sigma = width * max(len(along) - 1, 1) / max(float(along[-1]), 1e-6)
    middle = gaussian_filter1d(branch.line, sigma, axis=0, mode="nearest")
    tangent = np.gradient(middle, axis=0)
    tangent /= np.maximum(np.linalg.norm(tangent, axis=1, keepdims=True), 1e-9)
    offset = gaussian_filter1d(np.maximum(branch.radius - typical, 0.0), sigma, mode="nearest")
    aside = offset[:, None] * np.stack([tangent[:, 1], -tangent[:, 0]], axis=1)
    begin, end = graph.position[[branch.start]], graph.position[[branch.stop]]
    radius = np.full(len(along) + 2, typical)
    for beside in (middle + aside, middle - aside):
        graph.add(Branch(branch.start, branch.stop, np.concatenate([begin, beside, end]), radius))
