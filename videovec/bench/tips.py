"""Real brushes for drawings whose strokes are known: the tips of Debian's brush packages, and some that are made here.

Tips lie in Debian's ``krita-data`` and ``gimp-data``; where those are not installed, four brushes of made tips stand
for them, so that the benchmark runs anywhere.
"""

from __future__ import annotations

import struct
import zipfile
from dataclasses import dataclass
from io import BytesIO
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from PIL import Image
from scipy.ndimage import gaussian_filter

__all__ = ["BRUSHES", "MADE", "TrueBrush", "is_installed", "read_tips"]

Floats = NDArray[np.float64]
GIMP = Path("/usr/share/gimp/2.0/brushes")
KRITA = Path("/usr/share/krita/bundles")
_MADE_SIDE = 96  # px of a made tip


@dataclass(frozen=True, slots=True)
class TrueBrush:
    """A real brush: where its tip lies, how it is laid along a stroke, and what ought to explain it.

    Args:
        engine: strip, dabs or paper.
        source: File of the tip: a path below GIMP's brushes, or a name in one of Krita's bundles; ``made:`` and the
            lengths along which its grain is even, px along and across.
        rotation: For dabs: fixed, follow or random.
        is_random: For dabs: take a random cell of a pipe for each.
        explains: The model that a fit should choose.
        is_held_out: Not looked at before the final table.
    """

    engine: str
    source: str
    rotation: str = "fixed"
    is_random: bool = False
    explains: str = "grain"
    is_held_out: bool = False


BRUSHES = {
    "strip_chalk": TrueBrush("strip", "brushes/chalk.png", explains="texture"),
    "strip_charcoal": TrueBrush("strip", "Sketch/Charcoal-02.gbr", explains="texture"),
    "follow_streaks": TrueBrush("dabs", "brushes/chisel_streaks.png", "follow", explains="profile"),
    "fixed_chalk": TrueBrush("dabs", "Sketch/Chalk-02.gih"),
    "random_chalk": TrueBrush("dabs", "Sketch/Chalk-01.gih", "random", True),
    "random_acrylic": TrueBrush("dabs", "Media/Acrylic-05.gih", "fixed", True),
    "paper_grain": TrueBrush("paper", "patterns/04_paper-C-grain.png"),
    "strip_sponge": TrueBrush("strip", "Splatters/Sponge-02.gbr", explains="texture", is_held_out=True),
    "strip_graphite": TrueBrush("strip", "brushes/chalk_sparse.png", explains="texture", is_held_out=True),
    "follow_rake": TrueBrush("dabs", "brushes/rake_flat.png", "follow", explains="profile", is_held_out=True),
    "random_eroded": TrueBrush("dabs", "brushes/circle_hard_eroded.gih", "random", True, is_held_out=True),
    "random_pencil": TrueBrush("dabs", "Sketch/Pencil-01.gih", "random", True, is_held_out=True),
    "paper_torchon": TrueBrush("paper", "patterns/05_paper-torchon.png", is_held_out=True),
    "strip_freckles": TrueBrush("strip", "brushes/freckles.png", explains="texture", is_held_out=True),
    "strip_burnt": TrueBrush("strip", "Sketch/Charcoal-01.gbr", explains="texture", is_held_out=True),
    "follow_bristles": TrueBrush(
        "dabs", "brushes/bristles_chisel_dense.png", "follow", explains="profile", is_held_out=True
    ),
    "random_rock": TrueBrush("dabs", "brushes/rock_pitted.gih", "random", True, is_held_out=True),
    "random_soft_pencil": TrueBrush("dabs", "Sketch/Pencil-02.gih", "random", True, is_held_out=True),
    "paper_canvas": TrueBrush("paper", "patterns/02_rough-canvas.png", is_held_out=True),
}


MADE = {
    "made_crayon": TrueBrush("strip", "made:3:3", explains="texture"),
    "made_bristles": TrueBrush("dabs", "made:60:2", "follow", explains="profile"),
    "made_crumbs": TrueBrush("dabs", "made:5:5", "random", True),
    "made_paper": TrueBrush("paper", "made:2:2"),
}
"""Brushes that need no file."""


def is_installed() -> bool:
    """Whether Debian's brushes are there."""
    return GIMP.is_dir() and KRITA.is_dir()


def read_tips(source: str) -> list[Floats]:
    """The cells of a brush file, dark ink as 1. Raises FileNotFoundError where the Debian package is missing."""
    if source.startswith("made:"):
        return [_made(source, cell) for cell in range(3)]
    is_krita = source.startswith(("brushes/", "patterns/"))
    data = _from_bundles(source) if is_krita else (GIMP / source).read_bytes()
    if source.endswith(".gih"):
        start = data.index(b"\n", data.index(b"\n") + 1) + 1
        return _gimp_cells(data[start:])
    if source.endswith(".gbr"):
        return _gimp_cells(data)
    image = Image.open(BytesIO(data))
    if "A" in image.getbands() and np.ptp(np.asarray(image.getchannel("A"))) > 0:
        pixels = np.asarray(image.convert("LA"), dtype=float) / 255
        return [(1 - pixels[..., 0]) * pixels[..., 1] if np.ptp(pixels[..., 0]) > 0 else pixels[..., 1]]
    return [1 - np.asarray(image.convert("L"), dtype=float) / 255]


def _from_bundles(name: str) -> bytes:
    for bundle in sorted(KRITA.glob("*.bundle"), reverse=True):
        with zipfile.ZipFile(bundle) as archive:
            if name in archive.namelist():
                return archive.read(name)
    raise FileNotFoundError(f"{name} is in no bundle of {KRITA}; is krita-data installed?")


def _gimp_cells(data: bytes) -> list[Floats]:
    cells = []
    while len(data) > 28:
        header, _, width, height, depth = struct.unpack(">5I", data[:20])
        end = header + width * height * depth
        cells.append(np.frombuffer(data[header:end], np.uint8).reshape(height, width, depth)[..., -1] / 255)
        data = data[end:]
    return cells


def _made(source: str, cell: int) -> Floats:
    """A round tip of grain that is even over some px along and across. [96, 96]"""
    along, across = (float(part) for part in source.split(":")[1:])
    rng = np.random.default_rng([cell, int(along), int(across)])
    field = gaussian_filter(rng.normal(size=(_MADE_SIDE, _MADE_SIDE)), (across, along), mode="wrap")
    y, x = (np.mgrid[:_MADE_SIDE, :_MADE_SIDE] + 0.5) / _MADE_SIDE * 2 - 1
    rim = np.clip((1 - np.hypot(x, y)) * 8, 0, 1)
    return np.asarray(np.clip(0.5 + 0.8 * field / field.std(), 0, 1) * rim)
