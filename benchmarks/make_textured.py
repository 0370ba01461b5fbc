"""Textured drawings with known strokes; the protocol stands in ``videovec/bench/textured.py``.

    python benchmarks/make_textured.py DIR/truth.json OUT.png --brush strip_chalk --size 512 --width 10 --seed 0

Needs the tips of Debian's ``krita-data`` and ``gimp-data`` packages.
"""

from __future__ import annotations

import argparse
import json
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from videovec.bench.textured import Drawn, draw
from videovec.bench.tips import BRUSHES

__all__ = ["BRUSHES", "Drawn", "draw", "read_truth"]

Floats = NDArray[np.float64]


def read_truth(path: Path, size: int) -> list[Floats]:
    """True control points of each stroke at a size. [3n+1, 2] px"""
    strokes = json.loads(path.read_text())["strokes"]
    return [np.concatenate([np.array(s)[:1, 0], *np.array(s)[:, 1:]]) * size for s in strokes]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("truth", type=Path)
    parser.add_argument("out", type=Path)
    parser.add_argument("--brush", choices=sorted(BRUSHES), default="strip_chalk")
    parser.add_argument("--size", type=int, default=512)
    parser.add_argument("--width", type=float, default=10.0, help="pen width, px")
    parser.add_argument("--seed", type=int, default=0)
    args = parser.parse_args()
    drawn = draw(read_truth(args.truth, args.size), BRUSHES[args.brush], args.size, args.width, args.seed)
    Image.fromarray(np.uint8(np.round(255 * (1 - drawn.coverage)))).save(args.out)


if __name__ == "__main__":
    main()
