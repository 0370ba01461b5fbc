"""How the joints of strokes move when drawings are fitted alone and together: a picture of their paths.

    python benchmarks/joint_paths.py FOLDER CLIP PICTURE

FOLDER is what ``joint.py --keep`` wrote. The busiest part of a drawing in the middle, each stroke in the colour of its
identity, and thin lines along which their joints go over all drawings: left fitted each alone, right all together.
"""

from __future__ import annotations

import argparse
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from videovec.strokes import Strokes
from videovec.tracks import StrokeTracks
from videovec.write.colours import identity_colours
from videovec.write.preview import draw_strokes

WAYS = ("each_alone", "1")
ZOOM, PART, SIDE = 8, 0.3, 640
"""Of the drawing; how large a part of the page is shown; side of its picture. px"""


def paths(strokes: Strokes) -> list[tuple[int, NDArray[np.float64]]]:
    """The path of every joint over the drawings of its stroke, and the stroke's identity. [T, 2] px each"""
    found = []
    for s, identity in enumerate(strokes.ids.tolist()):
        rows = range(*strokes.layout.stroke_rows[s : s + 2].tolist())
        joints = np.stack([strokes.points_of(row)[::3] for row in rows], axis=1)
        found += [(identity, joint) for joint in joints]
    return found


def drawn(tracks: StrokeTracks) -> NDArray[np.uint8]:
    """A drawing in the middle, faint, under the paths of all joints. uint8 [H, W, 3]"""
    strokes = tracks.strokes
    image = draw_strokes(strokes, int(strokes.layout.last.max()) // 2, tracks.size, ZOOM)
    image = (255 - 0.3 * (255.0 - image)).astype(np.uint8)
    for identity, path in paths(strokes):
        colour = tuple((180 * identity_colours([identity])[0]).round().tolist())
        places = np.rint(16 * (path * ZOOM - 0.5)).astype(np.int32)
        cv2.polylines(image, [places], False, colour, ZOOM // 4, cv2.LINE_AA, shift=4)
    return image


def closest(tracks: StrokeTracks) -> tuple[int, int, int]:
    """Left, top and side of the part of the page with most joints. px"""
    side = round(PART * max(tracks.size))
    places = np.concatenate([path[[len(path) // 2]] for _, path in paths(tracks.strokes)])
    counts = [(np.abs(places - place) <= side / 2).all(1).sum() for place in places]
    left, top = places[int(np.argmax(counts))] - side / 2
    height, width = tracks.size
    return int(np.clip(left, 0, width - side)), int(np.clip(top, 0, height - side)), side


def main() -> None:
    """Draw and write."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=Path)
    parser.add_argument("clip")
    parser.add_argument("picture", type=Path)
    arguments = parser.parse_args()
    both = [StrokeTracks.load(arguments.folder / f"{arguments.clip}_{way}.npz") for way in WAYS]
    left, top, side = closest(both[0])
    columns = []
    for tracks in both:
        part = drawn(tracks)[ZOOM * top : ZOOM * (top + side), ZOOM * left : ZOOM * (left + side)]
        columns.append(cv2.resize(part, (SIDE, SIDE), interpolation=cv2.INTER_AREA))
    image = np.concatenate(columns, axis=1)
    cv2.imwrite(str(arguments.picture), image[:, :, ::-1])


if __name__ == "__main__":
    main()
