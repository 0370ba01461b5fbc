"""One drawing's ink to strokes, and how sure each junction's decision is."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from videovec.initialise.abreast import part_abreast
from videovec.initialise.centreline import centre_line, chains, closed_line
from videovec.initialise.crossings import bridge_gaps, is_sliver, lies_amid
from videovec.initialise.cubics import fit_spline
from videovec.initialise.graph import Graph, polyline_length, skeleton_graph
from videovec.initialise.junctions import Pairing, pair_branches, pair_by_net
from videovec.initialise.lines import line_mask
from videovec.initialise.prune import Widths, clean
from videovec.initialise.rings import find_rings
from videovec.initialise.thinning import thin
from videovec.initialise.widths import measure_widths
from videovec.ink import Ink, ink_alone
from videovec.settings import InitialiseSettings
from videovec.strokes import Strokes

__all__ = ["Junction", "Traced", "cleaned_graph", "initialise", "trace"]

Floats = NDArray[np.float64]
Coverage = NDArray[np.float32]

_LEAST_WIDTH = 1.2  # px; the rules of geometry treat thinner lines as this wide


@dataclass(frozen=True, slots=True, eq=False)
class Junction:
    """A place where branches meet, and which of them were taken to be one stroke.

    Args:
        position: Where it is. [2] px
        arms: Direction in which each branch leaves. [K, 2]
        links: Pairs of arms that are one stroke.
        runner_up: The second best decision.
        log_odds: Logarithm of the odds that the decision is right; 0 where it is as likely wrong.
    """

    position: Floats
    arms: Floats
    links: tuple[tuple[int, int], ...]
    runner_up: tuple[tuple[int, int], ...]
    log_odds: float


@dataclass(frozen=True, slots=True, eq=False)
class Traced:
    """What initialisation found on a drawing.

    Args:
        strokes: Its strokes.
        junctions: The decisions that made them.
    """

    strokes: Strokes
    junctions: tuple[Junction, ...]


@dataclass(frozen=True, slots=True, eq=False)
class _Lines:
    """The strokes of one ink, before they are splines."""

    curves: list[Floats]
    half_widths: list[Floats]
    is_closed: list[bool]
    junctions: list[Junction]


def _calibrated(graph: Graph, coverage: Coverage) -> Widths:
    """Widths by which the rules of geometry go: what the ink weighs, against the mask's mean radius.

    The ink of lines of width w and length L with n round ends is w L + n pi w^2 / 8.
    """
    radii = [branch.radius for branch in graph.branches.values()] + graph.loop_radius
    lines = [branch.line for branch in graph.branches.values()] + graph.loops
    length = sum(polyline_length(line) for line in lines)
    if length <= 0.0:
        return Widths(1.0, _LEAST_WIDTH)
    mass = float(coverage[coverage > 0.02].sum())
    caps = np.pi / 8.0 * sum(graph.degree(node) == 1 for node in graph.nodes())
    width = 2.0 * mass / (length + np.sqrt(length * length + 4.0 * caps * mass))
    radius = float(np.mean(np.concatenate(radii)))
    return Widths(float(np.clip(width / (2.0 * radius), 0.5, 1.5)), _LEAST_WIDTH)


def _junctions(graph: Graph, pairings: list[Pairing]) -> list[Junction]:
    """The decisions as others may read them."""
    result = []
    for pairing in pairings:
        arms = []
        for number, end in pairing.ends:
            line = graph.outward(number, end).line
            arm = line[min(len(line) - 1, 12)] - graph.position[pairing.node]
            arms.append(arm / max(float(np.linalg.norm(arm)), 1e-9))
        result.append(
            Junction(
                graph.position[pairing.node].copy(), np.stack(arms), pairing.links, pairing.runner_up, pairing.log_odds
            )
        )
    return result


def _dots(graph: Graph, coverage: Coverage, others: Coverage) -> tuple[list[Floats], list[Floats]]:
    """Strokes of no length for isolated round spots: control points and half-widths of each.

    A spot beside other inks is where they mix.
    """
    curves, half_widths = [], []
    for x, y, radius in graph.dots:
        reach = int(np.ceil(radius + 2.0))
        top, left = max(0, int(y) - reach), max(0, int(x) - reach)
        patch = coverage[top : int(y) + reach + 1, left : int(x) + reach + 1]
        row, column = np.mgrid[top : top + patch.shape[0], left : left + patch.shape[1]] + 0.5
        weight = np.where(np.hypot(column - x, row - y) <= radius + 1.5, patch, 0.0)
        mass = float(weight.sum())
        if mass <= 0.0 or lies_amid(np.array([[x, y]]), others):
            continue
        center = np.array([(weight * column).sum(), (weight * row).sum()]) / mass
        curves.append(np.tile(center, (4, 1)))
        half_widths.append(np.full(2, np.sqrt(mass / np.pi)))
    return curves, half_widths


def cleaned_graph(coverage: Coverage, noise: float) -> tuple[Graph, Widths] | None:
    """The graph of one ink's lines and how wide they are; nothing where there are no lines."""
    lines = line_mask(coverage, noise)
    if not lines.mask.any():
        return None
    radius = cv2.distanceTransform(np.pad(lines.mask, 1), cv2.DIST_L2, 5)[1:-1, 1:-1].astype(np.float32)
    graph = skeleton_graph(thin(lines.mask), radius, lines.scale)
    widths = _calibrated(graph, coverage)
    clean(graph, widths)
    part_abreast(graph, widths)
    return graph, widths


def _trace_coverage(coverage: Coverage, others: Coverage, noise: float, settings: InitialiseSettings) -> _Lines:
    """Strokes of one ink, among those of the others."""
    cleaned = cleaned_graph(coverage, noise)
    if cleaned is None:
        return _Lines([], [], [], [])
    graph, widths = cleaned
    if settings.junctions == "learned":
        rings = find_rings(graph, widths)
        pairings = pair_by_net(graph, widths, frozenset(number for ring in rings for number, _ in ring.ends))
    else:  # ragged lines have holes, which are no rings
        rings, pairings = [], pair_branches(graph, widths, settings.max_turn)
    is_alone = not others.any()
    bridges = [] if is_alone else bridge_gaps(graph, widths, coverage + others)
    found = [centre_line(graph, chain, widths, coverage) for chain in chains(graph, pairings + bridges, rings)]
    for loop, thickness in zip(graph.loops, graph.loop_radius, strict=True):
        found.append(closed_line(loop, max(_LEAST_WIDTH, 2.0 * widths.calibration * float(np.median(thickness)))))
    if found and not is_alone:
        widest = max(line.width for line in found)
        found = [line for line in found if not is_sliver(line, widest, others)]
    curves, half_widths = [], []
    for line, half_width in zip(found, measure_widths(found, coverage), strict=True):
        points = fit_spline(line.line, line.corners, settings.tolerance, line.is_closed)
        curves.append(points)
        half_widths.append(half_width[cKDTree(line.line).query(points[::3])[1]])
    dots, dot_widths = _dots(graph, coverage, others)
    is_closed = [line.is_closed for line in found] + [False] * len(dots)
    return _Lines(curves + dots, half_widths + dot_widths, is_closed, _junctions(graph, pairings))


def trace(ink: Ink, drawing: int, settings: InitialiseSettings) -> Traced:
    """Trace the lines of one drawing.

    Args:
        ink: The ink of D drawings.
        drawing: Which of them.
        settings: How to trace.

    Returns:
        Strokes that live on that drawing alone, each of one ink, and the junctions between them.
    """
    alone = ink.at_drawing(drawing)
    inked = alone.coverage[0].astype(np.float32) / np.float32(255.0)
    parts, junctions, first_id = [], [], 1
    for label, color in enumerate(ink.palette):
        own = ink_alone(alone, label).coverage[0].astype(np.float32) / np.float32(255.0)
        if not own.any():
            continue
        lines = _trace_coverage(own, np.where(alone.label[0] == label, np.float32(0.0), inked), ink.noise, settings)
        parts.append(
            Strokes.from_curves(
                lines.curves,
                lines.half_widths,
                is_closed=lines.is_closed,
                color=color,
                drawing=drawing,
                first_id=first_id,
            )
        )
        first_id += len(lines.curves)
        junctions += lines.junctions
    return Traced(Strokes.concatenate(parts), tuple(junctions))


def initialise(ink: Ink, drawing: int, settings: InitialiseSettings) -> Strokes:
    """The strokes of one drawing; see `trace`."""
    return trace(ink, drawing, settings).strokes
