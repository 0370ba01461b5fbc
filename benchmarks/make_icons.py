"""Clips with known strokes from animated icons of others, for ``videovec bench clips``.

    PYTHONPATH=. python benchmarks/make_icons.py node_modules/react-useanimations/lib FOLDER [--name ICON ...]

Icons are read from Lottie (`lottie_strokes.py`) and drawn in black, 512 px to the side, by resvg: ``FOLDER/NAME`` holds
``0000.png ..`` and ``gt.json``. Those with fills, masks, mattes or dashes are left out, and the reason is printed.
"""

from __future__ import annotations

import argparse
import json
from pathlib import Path
from typing import Any

import numpy as np
import resvg_py

from benchmarks.lottie_strokes import DrawnStroke, UnreadableError, strokes_at
from videovec.curves import arc_length

SIDE = 512
LONGEST, FEWEST = 40, 6
"""Frames of a clip; of longer animations frames in between are left out evenly."""
SEEN = 0.5
"""Length of the shortest stroke that is seen, in widths."""


def read_icon(path: Path) -> list[list[DrawnStroke]]:
    """Strokes of an animation's frames, px of its picture.

    Raises:
        UnreadableError: It holds what the reader does not know, or too few frames, or nothing.
    """
    animation = json.loads(path.read_text("utf-8"))
    times = np.arange(np.ceil(animation["ip"]), animation["op"] - 1e-6)
    if len(times) < FEWEST:
        raise UnreadableError(f"{len(times)} frames")
    times = times[np.unique(np.linspace(0, len(times) - 1, min(LONGEST, len(times))).round().astype(int))]
    frames = [strokes_at(animation, float(time)) for time in times]
    if not any(frames):
        raise UnreadableError("no stroke")
    scale = SIDE / max(animation["w"], animation["h"])
    return [[stroke.scaled(scale) for stroke in strokes] for strokes in frames]


def svg_of(strokes: list[DrawnStroke]) -> str:
    """A frame in black on white."""
    paths = "".join(
        f'<path d="{_path_data(s)}" stroke-width="{s.width:.3f}" stroke-linecap="{s.cap}" stroke-linejoin="{s.join}"/>'
        for s in strokes
    )
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{SIDE}" height="{SIDE}"><rect width="100%" height="100%" '
        f'fill="white"/><g fill="none" stroke="black">{paths}</g></svg>'
    )


def _path_data(stroke: DrawnStroke) -> str:
    first, *rest = (f"{x:.3f} {y:.3f}" for x, y in stroke.points)
    return f"M{first}C{' '.join(rest)}{'Z' if stroke.closed else ''}"


def truth_of(frames: list[list[DrawnStroke]]) -> dict[str, Any]:
    """Frames as ``gt.json`` holds them."""
    return {
        "size": [SIDE, SIDE],
        "frames": [
            {
                "index": n,
                "strokes": [
                    {
                        "id": stroke.name,
                        "closed": stroke.closed,
                        "points": stroke.points.round(3).tolist(),
                        "width": round(stroke.width, 3),
                        "visible": float(arc_length(stroke.points) > SEEN * stroke.width),
                    }
                    for stroke in strokes
                ],
            }
            for n, strokes in enumerate(frames)
        ],
    }


def main() -> None:
    """Write every icon that can be read."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("icons", type=Path)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--name", action="append", default=[])
    options = parser.parse_args()
    for path in sorted(options.icons.glob("**/*.json")):
        if options.name and path.stem not in options.name:
            continue
        try:
            frames = read_icon(path)
        except UnreadableError as error:
            print(f"{path.stem}: left out: {error}")
            continue
        folder = options.folder / path.stem
        folder.mkdir(parents=True, exist_ok=True)
        for n, strokes in enumerate(frames):
            (folder / f"{n:04d}.png").write_bytes(bytes(resvg_py.svg_to_bytes(svg_string=svg_of(strokes))))
        (folder / "gt.json").write_text(json.dumps(truth_of(frames)), "utf-8")
        print(f"{path.stem}: {len(frames)} frames, {len({s.name for f in frames for s in f})} strokes")


if __name__ == "__main__":
    main()
