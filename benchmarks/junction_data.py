"""Drawings with known strokes, traced by the front end, and which branches of each junction truly are one stroke."""

from __future__ import annotations

import warnings
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np
import svgelements
from numpy.typing import NDArray

from benchmarks.junction_figures import figure, scene
from benchmarks.junction_labels import STEP, Known, label
from benchmarks.junction_parts import jointed
from benchmarks.junction_scenes import densify
from benchmarks.junction_traced import traced
from videovec.initialise.graph import Graph
from videovec.initialise.polyline import resample
from videovec.initialise.prune import Widths
from videovec.initialise.tracer import cleaned_graph

__all__ = ["Drawn", "collection", "draw", "drawings", "raster", "strokes_known", "trace_lines"]

Floats = NDArray[np.float64]
Random = np.random.Generator
Lines = list[Floats]

FOLDERS = {
    "lucide": "lucide-static/icons",
    "feather": "feather-icons/dist/icons",
    "tabler": "@tabler/icons/icons/outline",
}
"""Where each collection keeps its drawings under ``node_modules``: lucide-static is ISC, the others are MIT."""
MADE = {"figure": figure, "scene": scene, "jointed": jointed, "traced": traced}
"""Kinds of drawings that are made up."""
ICONS = "icons of "


@dataclass(frozen=True, slots=True, eq=False)
class Drawn:
    """A traced drawing and what is known of its junctions."""

    graph: Graph
    widths: Widths
    junctions: tuple[Known, ...]


def _polylines(path: Path) -> Lines:
    """Strokes of an SVG, in its own units."""
    lines = []
    for element in svgelements.SVG.parse(str(path), reify=True).elements():
        is_stroked = getattr(getattr(element, "stroke", None), "value", None) is not None
        if not isinstance(element, svgelements.Shape) or not is_stroked:
            continue
        for part in svgelements.Path(element).as_subpaths():
            points: list[tuple[float, float]] = []
            for piece in svgelements.Path(part):
                if isinstance(piece, svgelements.Move) or piece.start is None or piece.end is None:
                    continue
                count = 1 if isinstance(piece, svgelements.Line | svgelements.Close) else 24
                points += [(piece.point(t).x, piece.point(t).y) for t in np.linspace(0, 1, count + 1)[bool(points) :]]
            line = np.array(points, float).reshape(-1, 2)
            line = line[np.r_[True, np.linalg.norm(np.diff(line, axis=0), axis=1) > 1e-6]] if len(line) else line
            if len(line) >= 2:
                lines.append(line)
    return lines


def _in_unit_square(lines: Lines) -> Lines:
    points = np.concatenate(lines)
    low, high = points.min(axis=0), points.max(axis=0)
    return [(line - (low + high) / 2) / (high - low).max() for line in lines]


def collection(modules: Path, name: str, count: int, seed: int = 5) -> list[Lines]:
    """Drawings of a collection, shuffled; those of 2 to 120 strokes, none of which is drawn twice.

    Args:
        modules: A ``node_modules`` in which the collections are installed.
        name: One of ``FOLDERS``.
        count: How many to read, at most.
        seed: Of the order.
    """
    paths = sorted((modules / FOLDERS[name]).glob("*.svg"))
    found: list[Lines] = []
    for k in np.random.default_rng(seed).permutation(len(paths)):
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            lines = _polylines(paths[k])
        if not 2 <= len(lines) <= 120:
            continue
        unique = {np.r_[x[0], x[-1], x.mean(axis=0)].round(3).tobytes(): x for x in _in_unit_square(lines)}
        found.append(list(unique.values()))
        if len(found) == count:
            break
    return found


def _warped(lines: Lines, rng: Random, amount: float) -> Lines:
    """The same strokes turned, sheared, mirrored and bent a little."""
    angle = rng.uniform(0, 2 * np.pi)
    c, s = np.cos(angle), np.sin(angle)
    matrix = np.array([[c, -s], [s, c]]) @ np.diag([rng.uniform(0.75, 1.25), 1.0])
    matrix = matrix @ np.array([[1, rng.uniform(-0.25, 0.25)], [0, 1]])
    if rng.random() < 0.5:
        matrix = matrix @ np.diag([-1, 1])
    waves = rng.uniform(2, 7, (3, 2)) * rng.choice([-1, 1], (3, 2))
    phases, sizes = rng.uniform(0, 6.3, 3), rng.normal(0, 0.018 * amount, (3, 2))
    bent = []
    for line in lines:
        points = densify(line, 0.01) @ matrix.T
        bent.append(points + np.sin(points @ waves.T + phases) @ sizes)
    return _in_unit_square(bent)


def raster(lines: Lines, size: int, width: float) -> NDArray[np.float32]:
    """Ink coverage of round pen strokes, supersampled."""
    scale = 4 if width >= 1.5 else 8
    page = np.zeros((size * scale, size * scale), np.uint8)
    for line in lines:
        points = np.rint((line * scale - 0.5) * 8).astype(np.int32).reshape(-1, 1, 2)
        cv2.polylines(page, [points], False, 255, max(1, round(width * scale)), cv2.LINE_8, 3)
    small = cv2.resize(page, (size, size), interpolation=cv2.INTER_AREA)
    return np.asarray(small.astype(np.float32) / np.float32(255))


def _degraded(coverage: NDArray[np.float32], rng: Random) -> NDArray[np.float32]:
    """A third of the pages blurred a little, or compressed."""
    if rng.random() < 0.65:
        return coverage
    if rng.random() < 0.5:
        coverage = cv2.GaussianBlur(coverage, (0, 0), rng.uniform(0.3, 0.8)).astype(np.float32)
    if rng.random() < 0.6:
        page = 255 - np.rint(coverage * 255).astype(np.uint8)
        quality = [cv2.IMWRITE_JPEG_QUALITY, int(rng.integers(60, 96))]
        read = np.asarray(cv2.imdecode(cv2.imencode(".jpg", page, quality)[1], cv2.IMREAD_GRAYSCALE))
        coverage = 1 - read.astype(np.float32) / np.float32(255)
        coverage[coverage < 0.06] = 0
    return np.clip(coverage, 0, 1).astype(np.float32)


def _pen(rng: Random, is_icon: bool) -> tuple[int, float]:
    """Size of a page and width of its pen. px"""
    size, kind = int(rng.choice([192, 256, 320, 384, 512, 640], p=[0.1, 0.25, 0.2, 0.2, 0.2, 0.05])), rng.random()
    if kind < 0.6:
        width = size / 512 * rng.uniform(2.0, 4.5)
    else:
        width = size * 0.001 * rng.uniform(0.9, 1.8) if kind < 0.85 else rng.uniform(4, 8) * size / 512
    if is_icon:
        size = int(rng.choice([128, 192, 256]))
        width = size / 24 * rng.uniform(0.3, 1)
    return size, max(width, 0.25)


def trace_lines(lines: Lines, coverage: NDArray[np.float32], noise: float = 0.0) -> Drawn | None:
    """Trace a drawing whose true strokes are known, up to its junctions; nothing if there is no ink.

    Args:
        lines: True strokes, ``STEP`` between samples. px
        coverage: Its ink. [H, W]
        noise: Of the page, in coverage.
    """
    cleaned = cleaned_graph(coverage, noise)
    if cleaned is None:
        return None
    return Drawn(*cleaned, label(*cleaned, [line for line in lines if len(line) > 2]))


def _overlaid(known: list[Lines], lines: Lines, rng: Random) -> Lines:
    """One drawing in five with another over it."""
    if rng.random() >= 0.2:
        return lines
    other = _warped(known[rng.integers(len(known))], rng, 1.0)
    return _in_unit_square(lines + [line * rng.uniform(0.4, 0.9) + rng.uniform(-0.25, 0.25, 2) for line in other])


def strokes_known(kind: str, count: int, modules: Path | None) -> list[Lines]:
    """Drawings that a kind starts from: of a collection, or none for a made-up kind."""
    return [] if modules is None or kind in MADE else collection(modules, kind.removeprefix(ICONS), count)


def draw(kind: str, number: int, seed: int, known: list[Lines]) -> Drawn | None:
    """One traced drawing of a kind; nothing where it has no lines.

    Args:
        kind: One of ``MADE``, or the name of a collection, warped unless "icons of" stands before it.
        number: Which of them.
        seed: Of the drawings, or of what is done to them.
        known: What ``strokes_known`` found.
    """
    rng = np.random.default_rng([seed, len(kind), number])
    is_icon = kind.startswith(ICONS)
    if kind in MADE:
        lines = _warped(MADE[kind](rng), rng, 0.5)
    else:
        lines = known[number % len(known)]
        lines = lines if is_icon else _overlaid(known, _warped(lines, rng, 1.0), rng)
    size, width = _pen(rng, is_icon)
    placed = [resample(densify((line * 0.88 + 0.5) * size, 0.6), STEP) for line in lines]
    drawn = trace_lines(placed, _degraded(raster(placed, size, width), rng))
    return drawn if drawn is not None and drawn.graph.branches else None


def drawings(kind: str, count: int, seed: int, modules: Path | None) -> Iterator[Drawn]:
    """Traced drawings of one kind.

    Args:
        kind: See ``draw``.
        count: How many to make, at most.
        seed: Of the drawings, or of what is done to them.
        modules: A ``node_modules`` in which the collections are installed; only made-up ones do without.
    """
    known = strokes_known(kind, count, modules)
    for number in range(count):
        drawn = draw(kind, number, seed, known)
        if drawn is not None:
            yield drawn
