"""Drawings whose strokes are known, read from a folder or drawn from their truth.

A folder of drawings holds one folder for each: ``truth.json`` (``strokes``: for each a list of cubic segments [n, 4, 2]
in the unit square) and images ``SET_SIZE.png``, such as ``w3_512.png``. A set is any way of drawing the strokes, with a
brush too; those whose names begin with ``textured`` stand beside the supplement's textured rows. Drawings of the sets
in `WIDTHS` are made from the truth where there is no image of a size; `textured_stills` draws the truth with brushes.
"""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from videovec.bench.exact import draw_area
from videovec.bench.textured import draw
from videovec.bench.tips import BRUSHES, MADE, TrueBrush, is_installed
from videovec.clip import Clip, Timeline
from videovec.decode import decode
from videovec.errors import InputError
from videovec.strokes import Strokes

__all__ = ["PEN", "SIZES", "Still", "read_stills", "textured_stills"]

Floats = NDArray[np.float64]

WIDTHS = {"w3": 3.0 / 512.0, "hairline": 0.001}
"""Sets that can be drawn from the truth, and their line width in long edges."""
PEN = 0.01
"""Width of the pen of textured drawings. Long edges"""
SIZES = (256, 384, 512, 768, 1024)
"""The supplement's long edges. px"""
MIXED = ("strip_chalk", "random_rock", "follow_streaks", "strip_sponge", "random_chalk", "paper_canvas")
"""Of the real brushes, two that repeat, one of bristles, two of chance, one of the paper's grain."""


@dataclass(frozen=True, slots=True, eq=False)
class Still:
    """A drawing and the strokes that made it.

    Args:
        name: Its folder's name.
        set_name: How it was drawn: the file's name without its size.
        size: Long edge. px
        path: Its image; none where it is drawn from the truth.
        truth: Its true strokes, of half-width 1 unless they are to be drawn. px
        brush: What it is drawn with; even ink if none.
    """

    name: str
    set_name: str
    size: int
    path: Path | None
    truth: Strokes
    brush: TrueBrush | None = None

    def clip(self) -> Clip:
        """The drawing, read or drawn."""
        if self.path is not None:
            return decode(self.path)
        grey = np.rint(255.0 * (1.0 - self._ink())).astype(np.uint8)
        one = np.zeros(1, np.intp)
        timeline = Timeline(one, (Fraction(0),), Fraction(1), one + 1)
        return Clip(self.name, (np.repeat(grey[..., None], 3, axis=2),), timeline)

    def _ink(self) -> Floats:
        """The true strokes drawn. [H, W] in [0, 1]"""
        if self.brush is None:
            return draw_area(self.truth, (self.size, self.size))
        curves = [self.truth.points_of(row) for row in range(len(self.truth))]
        return draw(curves, self.brush, self.size, 2 * float(self.truth.half_width[0]), seed=0).coverage


def read_stills(directory: Path, sets: Sequence[str] = (), sizes: Sequence[int] = ()) -> list[Still]:
    """Find the drawings of a folder.

    Args:
        directory: The folder.
        sets: Which sets; all if none is named.
        sizes: Which long edges; all if none is named.

    Returns:
        The drawings, by set, size and name.

    Raises:
        InputError: There is none.
    """
    found = []
    for truth in sorted(directory.glob("*/truth.json")):
        segments = [np.array(stroke, dtype=float) for stroke in json.loads(truth.read_text("utf-8"))["strokes"]]
        unit = [np.concatenate([stroke[0, :1], stroke[:, 1:].reshape(-1, 2)]) for stroke in segments]
        images = _images(truth.parent)
        missing = [(name, size) for name in WIDTHS for size in sizes if name in (sets or WIDTHS)]
        for set_name, size in [*images, *(drawn for drawn in missing if drawn not in images)]:
            if (sets and set_name not in sets) or (sizes and size not in sizes):
                continue
            path = images.get((set_name, size))
            half_width = 1.0 if path else 0.5 * WIDTHS[set_name] * size
            curves = [points * size for points in unit]
            strokes = Strokes.from_curves(curves, [np.full((len(points) + 2) // 3, half_width) for points in curves])
            found.append(Still(truth.parent.name, set_name, size, path, strokes))
    if not found:
        raise InputError(f"{directory}: must hold NAME/truth.json beside NAME/SET_SIZE.png, found none")
    return sorted(found, key=lambda still: (still.set_name, still.size, still.name))


def textured_stills(
    directory: Path, sizes: Sequence[int], brushes: Sequence[str] = (), width: float = PEN
) -> list[Still]:
    """The drawings of a folder drawn with brushes, each with another in turn.

    Args:
        directory: The folder.
        sizes: Long edges.
        brushes: Names of `videovec.bench.tips.BRUSHES` and `MADE`; `MIXED`, or made ones, if none is named.
        width: Of the pen at full pressure. Long edges

    Returns:
        The drawings, by size and name, of a set whose name holds the pen's width in thousandths of the long edge.

    Raises:
        InputError: There is no drawing, or no such brush.
    """
    known = {**BRUSHES, **MADE}
    names = brushes or (MIXED if is_installed() else tuple(MADE))
    if unknown := [name for name in names if name not in known]:
        raise InputError(f"a brush must be one of {', '.join(known)}, got {unknown[0]!r}")
    found = []
    for size in sizes:
        for k, still in enumerate(_even(directory, size)):
            half_width = np.full_like(still.truth.half_width, 0.5 * width * size)
            name = names[k % len(names)]
            found.append(
                replace(
                    still,
                    name=f"{still.name}-{name}",
                    set_name=f"textured{round(1000 * width)}",
                    truth=replace(still.truth, half_width=half_width),
                    brush=known[name],
                )
            )
    return found


def _even(directory: Path, size: int) -> list[Still]:
    """The drawings of a folder to be drawn from their truth."""
    return [replace(still, path=None) for still in read_stills(directory, ("w3",), (size,))]


def _images(directory: Path) -> dict[tuple[str, int], Path]:
    """The images of a drawing by set and long edge."""
    found = {}
    for image in sorted(directory.glob("*_*.png")):
        set_name, _, size = image.stem.rpartition("_")
        if size.isdigit():
            found[set_name, int(size)] = image
    return found
