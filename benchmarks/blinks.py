"""Closed shapes that shut onto a line and open again: is each of them one stroke, seen whole, on every drawing?

    PYTHONPATH=. python benchmarks/blinks.py [--name CLIP ...]

Clips of our own with truth: eyes that blink, a mouth that talks, a shutter that folds, a coin that turns on edge. True
strokes of the first drawing are carried. Prints a table in Markdown.
"""

from __future__ import annotations

import argparse
import math
from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import NDArray

from benchmarks.propagation import NEAR, Known, carry, known_movie, rows_of, share_right
from samples.scene import Drawing, Line, Movie, ellipse, place, polygon, rounded, spline
from videovec.clip_metrics import score_clip
from videovec.curves import arc_length, sample_by_arc
from videovec.strokes import Strokes

Floats = NDArray[np.float64]

BLACK = (0, 0, 0)
COUNT = 13
WHOLE = 0.95
"""Share of a stroke that is seen, and of places within `NEAR` each way, from which on it is right as a whole."""
QUICK, INSTANT = {5: 0.6, 6: 1.0, 7: 0.4}, {4: 1.0, 8: 1.0}
HELD = {4: 0.5, 5: 1.0, 6: 1.0, 7: 1.0, 8: 0.5}
SLOW = {3: 0.25, 4: 0.5, 5: 0.75, 6: 1.0, 7: 0.75, 8: 0.5, 9: 0.25}
TALK = (1.0, 0.4, 0.05, 0.5, 1.0, 0.8, 0.0, 0.0, 0.6, 1.0, 0.2, 0.7, 1.0)
FOLD = (1.0, 0.7, 0.3, 0.05, 0.05, 0.4, 0.9, 1.0, 1.0, 0.02, 1.0, 1.0, 1.0)


def face(d: int, blink: float, mouth: float, eye: tuple[float, float], width: float) -> Drawing:
    """A face that nods, about the middle of the page; how far its eyes are shut and its mouth is open, in [0, 1]."""
    eyes = [
        Line(f"eye {k}", ellipse((x, -20), (eye[0], max(1.0, eye[1] * (1 - blink)))), width, BLACK, is_closed=True)
        for k, x in ((1, -28), (2, 28))
    ]
    items = (
        Line("head", ellipse((0, 0), (70, 84)), width, BLACK, is_closed=True),
        *eyes,
        Line("nose", spline([(0, -8), (-5, 10), (4, 12)]), width, BLACK),
        Line("mouth", ellipse((0, 42), (24, max(1.0, 14 * mouth))), width, BLACK, is_closed=True),
        Line("hair 1", spline([(-30, -74), (-38, -92), (-30, -104)]), width, BLACK),
        Line("hair 2", spline([(-8, -83), (-6, -100), (6, -110)]), width, BLACK),
    )
    swing = math.sin(d * 0.5)
    return place(items, (128 + 4 * swing, 140 + 2 * math.sin(d * 0.9)), 5 * swing)


def bird(d: int, blink: float, eye: tuple[float, float], width: float) -> Drawing:
    """A bird that hops over the page."""
    beat = math.sin(d * 0.6)
    body = spline([(-60, 20), (-20, -30), (40, -26), (64, 4), (20, 40), (-30, 42)], is_closed=True)
    items = (
        Line("body", body, width, BLACK, is_closed=True),
        Line("beak", polygon([(64, -2), (88, 6), (62, 12)]), width, BLACK),
        Line("eye", ellipse((36, -4), (eye[0], max(0.8, eye[1] * (1 - blink)))), width, BLACK, is_closed=True),
        Line("wing", spline([(-20, 0), (0, 26), (24, 8)]), width, BLACK),
        Line("leg 1", polygon([(-4, 42), (-8, 74)]), width, BLACK),
        Line("leg 2", polygon([(14, 40), (14, 74)]), width, BLACK),
    )
    return place(items, (120 + 3 * d, 130 + 6 * beat), 6 * beat)


def shutter(d: int, turn: float) -> Drawing:
    """A pane that folds sideways, beside a post and above a sill."""
    pane = Line("pane", rounded((0, 0), (34, 46), 10), 4, BLACK, is_closed=True)
    items = (
        *place((pane,), scale=(max(FOLD[d], 0.03), 1)),
        Line("sill", polygon([(-70, 70), (70, 70)]), 4, BLACK),
        Line("post", polygon([(-60, -70), (-60, 68)]), 4, BLACK),
        Line("knob", ellipse((60, 0), (6, 6)), 4, BLACK, is_closed=True),
    )
    return place(items, (128 + 2 * math.sin(d), 128), turn)


def coin(d: int) -> Drawing:
    """A coin that turns by 30 degrees from drawing to drawing, on a table beside a cup."""
    wide = max(1.0, 40 * abs(math.cos(math.radians(30 * d) + 0.3)))
    items = (
        Line("coin", ellipse((0, 0), (wide, 40)), 4, BLACK, is_closed=True),
        Line("table", spline([(-90, 60), (0, 63), (90, 59)]), 4, BLACK),
        Line("cup", spline([(60, 58), (62, 20), (92, 20), (96, 58)]), 4, BLACK),
    )
    return place(items, (120, 120))


def _face(
    blinks: dict[int, float], eye: tuple[float, float], width: float = 4.0, mouth: Sequence[float] = (1.0,) * COUNT
) -> Callable[[int], Drawing]:
    return lambda d: face(d, blinks.get(d, 0.0), mouth[d], eye, width)


def _tilted(d: int) -> Drawing:
    return place(face(d, QUICK.get(d, 0.0), 1.0, (16, 11), 5.0), turn=18)


def _small(d: int) -> Drawing:
    return place(face(d, 0.0, TALK[d], (10, 13), 3.0), scale=0.7, about=(128, 140))


SEEN: dict[str, Callable[[int], Drawing]] = {
    "face, quick": _face(QUICK, (10, 13)),
    "face, at once": _face(INSTANT, (10, 13), mouth=TALK),
    "face, held": _face(HELD, (12, 9), 3.0),
    "shutter, tilted": lambda d: shutter(d, 35),
}
"""Clips that were looked at, or measured, while this was made."""
UNSEEN: dict[str, Callable[[int], Drawing]] = {
    "face, slow": _face(SLOW, (15, 20)),
    "face, tilted": _tilted,
    "small mouth": _small,
    "shutter": lambda d: shutter(d, 0),
    "coin": coin,
    "bird, at once": lambda d: bird(d, INSTANT.get(d, 0.0), (7, 7), 3.0),
    "bird, held": lambda d: bird(d, HELD.get(d, 0.0), (9, 8), 4.0),
}
"""Clips on which nothing was chosen."""


def whole_share(known: Known, strokes: Strokes) -> float:
    """Share of closed strokes and drawings with all of the stroke seen, and it and the truth on one another."""
    closed = set(known.first.ids[known.first.is_closed].tolist())
    return float(
        np.mean([_is_whole(t.points, strokes, row) for t, _, row in rows_of(known, strokes) if t.id in closed])
    )


def _is_whole(true: Floats, strokes: Strokes, row: int | None) -> bool:
    if row is None or np.ptp(strokes.visible[row]) < WHOLE:
        return False
    count = max(64, round(2 * arc_length(true)))
    apart = np.linalg.norm(sample_by_arc(true, count)[:, None] - sample_by_arc(strokes.points_of(row), count), axis=2)
    return all(float(np.mean(apart.min(side) <= NEAR)) >= WHOLE for side in (0, 1))


def measure(name: str, count: int = COUNT) -> str:
    """A row of the table for one clip."""
    drawings = [{**SEEN, **UNSEEN}[name](d) for d in range(count)]
    known = known_movie(name, Movie.on_ones(name, (256, 256), drawings))
    carried, seconds = carry(known)
    right, idf1 = share_right(known, carried.strokes), score_clip(known.truth, carried.strokes).idf1
    counts = f"{len(known.first)} / {len(carried.strokes)}"
    return (
        f"| {name} | {counts} | {right:.3f} | {idf1:.3f} | {whole_share(known, carried.strokes):.3f} | {seconds:.2f} |"
    )


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--name", action="append", default=[], choices=[*SEEN, *UNSEEN])
    print("| clip | true / found | right | IDF1 | closed ones whole | s / drawing |\n|---|---|---|---|---|---|")
    for name in parser.parse_args().name or [*SEEN, *UNSEEN]:
        print(measure(name), flush=True)


if __name__ == "__main__":
    main()
