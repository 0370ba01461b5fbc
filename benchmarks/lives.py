"""Movies of our own in which lines begin, end, part and run together: is that found, and when?

    python benchmarks/lives.py [--name MOVIE ...]

What turns on edge, slides behind its like, morphs as icons do, is drawn on and wiped out. `CHOSEN_ON` were looked at
while rules were made, `CONFIRMED_ON` were only measured. Strokes of the first drawing are the true ones; births and
deaths count if they are found within one drawing. Prints a table in Markdown.
"""

from __future__ import annotations

import argparse
import math
from collections.abc import Callable

import numpy as np
from numpy.typing import ArrayLike

from benchmarks.propagation import carry, known_movie
from samples.scene import Drawing, Fill, Line, Movie, ellipse, place, polygon, rounded, spline
from videovec.clip_metrics import score_clip

__all__ = ["CHOSEN_ON", "CONFIRMED_ON"]

SIDE = 512
BLACK = (20, 20, 20)
WIDTH = 10.0


def coin_movie(count: int = 22) -> Movie:
    """A thick coin turns by half a turn before two pills: its face goes, its edge comes and goes, its back comes."""
    drawings = []
    for d in range(count):
        turn = math.pi * d / (count - 1)
        squeeze, depth = abs(math.cos(turn)), 14.0 * math.sin(turn)
        near, far, sign = ("face", "back", 1.0) if math.cos(turn) >= 0 else ("back", "face", -1.0)
        x, y, radius = 300.0, 262.0, 120.0
        front, rear = (x - sign * depth, y), (x + sign * depth, y)
        lines: list[Line | Fill] = [
            _ring("pill 1", rounded((190, 190), (110, 32), 32)),
            _ring("pill 2", rounded((214, 330), (110, 32), 32)),
        ]
        if depth > 0.5 * WIDTH:
            lines.append(_ring(f"{far} rim", ellipse(rear, (radius * squeeze, radius))))
        if squeeze > 0.08:
            lines.append(Fill(ellipse(front, (radius * squeeze, radius))))
            lines.append(_ring(f"{near} rim", ellipse(front, (radius * squeeze, radius))))
            lines.append(_ring(f"{near} ring", ellipse(front, (0.6 * radius * squeeze, 0.6 * radius))))
        drawings.append(tuple(lines))
    return Movie.on_ones("coin", (SIDE, SIDE), drawings)


def stack_movie(count: int = 20) -> Movie:
    """Of four round bars two slide behind others, one until it is gone, and a fifth comes out from behind one."""
    drawings = []
    for d in range(count):
        slide = 150.0 * _ease(d / 9)
        lines: list[Line | Fill] = []
        if slide < 150.0:
            lines.append(_ring("goes", rounded((170 + slide, 120), (110, 36), 36)))
        lines += _card("stays", (320, 120), (110, 36))
        out = 190.0 * _ease((d - 7) / 10)
        if out > 0.0:
            lines.append(_ring("comes", rounded((180 + out, 270), (100, 36), 36)))
        lines += _card("holds", (180, 270), (110, 36))
        lines.append(_ring("moves", rounded((250 + 90 * math.sin(2 * math.pi * d / count), 410), (120, 40), 40)))
        drawings.append(tuple(lines))
    return Movie.on_ones("stack", (SIDE, SIDE), drawings)


def menu_movie(count: int = 20) -> Movie:
    """Three bars close up to one, which parts into a cross; later a ring is drawn round it."""
    drawings = []
    for d in range(count):
        apart, turn = 100.0 * (1.0 - _ease(d / 6)), 45.0 * _ease((d - 7) / 6)
        bar = polygon([(-110, 0), (110, 0)])
        lines: list[Line | Fill] = []
        if apart > 0.0:
            lines += [Line("top", bar + np.array([256, 256 - apart]), WIDTH, BLACK)]
            lines += [Line("bottom", bar + np.array([256, 256 + apart]), WIDTH, BLACK)]
        lines += place((Line("middle", bar, WIDTH, BLACK),), (256, 256), turn)
        if turn > 0.0:
            lines += place((Line("second", bar, WIDTH, BLACK),), (256, 256), -turn)
        drawn = _ease((d - 12) / 6)
        if drawn > 0.0:
            lines.append(Line("round", ellipse((256, 256), (190, 190), -90), WIDTH, BLACK, drawn >= 1.0, (0.0, drawn)))
        drawings.append(tuple(lines))
    return Movie.on_ones("menu", (SIDE, SIDE), drawings)


def card_movie(count: int = 22) -> Movie:
    """A card turns over before a frame: three marks go on edge, two others come."""
    drawings = []
    for d in range(count):
        turn = math.pi * _ease(d / (count - 1))
        squeeze = math.cos(turn)
        lines: list[Line | Fill] = [Line("shelf", polygon([(60, 440), (452, 440)]), WIDTH, BLACK)]
        lines.append(_ring("plate", ellipse((256, 250), (200, 150))))
        inner: list[Line | Fill] = [_ring("card", rounded((0, 0), (110, 130), 24))]
        if squeeze > 0.06:
            inner.append(_ring("face eye", ellipse((0, -50), (40, 40))))
            inner.append(Line("face smile", spline([(-60, 40), (0, 80), (60, 40)]), WIDTH, BLACK))
            inner.append(Line("face bar", polygon([(-60, 10), (60, 10)]), WIDTH, BLACK))
        if squeeze < -0.06:
            inner.append(Line("back slash", polygon([(-60, 80), (60, -80)]), WIDTH, BLACK))
            inner.append(_ring("back dot", ellipse((40, 60), (22, 22))))
        lines += place(inner, (256, 250), scale=(squeeze, 1.0))
        drawings.append(tuple(lines))
    return Movie.on_ones("card", (SIDE, SIDE), drawings)


def sketch_movie(count: int = 24) -> Movie:
    """A house is drawn line by line beside a bouncing ball; then its window goes, and its chimney is wiped out."""
    parts = (
        ("walls", polygon([(130, 260), (130, 430), (330, 430), (330, 260)]), 0, 4),
        ("roof", polygon([(105, 265), (230, 150), (355, 265)]), 4, 7),
        ("door", polygon([(250, 430), (250, 340), (300, 340), (300, 430)]), 7, 9),
        ("window", rounded((180, 330), (26, 26), 8), 9, 12),
        ("chimney", polygon([(290, 200), (290, 140), (320, 140), (320, 225)]), 3, 6),
    )
    drawings = []
    for d in range(count):
        lines: list[Line | Fill] = [Line("ground", spline([(40, 462), (256, 468), (472, 460)]), WIDTH, BLACK)]
        lines.append(_ring("ball", ellipse((425, 400 - 160 * abs(math.sin(math.pi * d / 8))), (34, 34))))
        for name, points, begin, end in parts:
            drawn = _clamp((d + 1 - begin) / (end - begin))
            left = _clamp((d - 16) / 4) if name == "chimney" else 0.0
            if drawn > left and not (name == "window" and d >= 18):
                lines.append(Line(name, points, WIDTH, BLACK, name == "window" and drawn >= 1.0, (left, drawn)))
        drawings.append(tuple(lines))
    return Movie.on_ones("sketch", (SIDE, SIDE), drawings)


def bars_movie(count: int = 22) -> Movie:
    """A bar parts in two, one of them again; two others run together; a ring shrinks to nothing, a square grows."""
    drawings = []
    for d in range(count):
        first, second, meet = 60.0 * _ease((d - 2) / 6), 50.0 * _ease((d - 10) / 6), 70.0 * (1.0 - _ease((d - 3) / 8))
        lines: list[Line | Fill] = [_bar("bar", 60, 120 - first), _bar("low", 300, 400)]
        lines += [_bar("lower", 60, 120 + first + second)] if first > 0.0 else []
        lines += [_bar("between", 60, 120 + first - second)] if second > 0.0 else []
        lines += [_bar("lowest", 300, 400 + meet)] if meet > 0.0 else []
        shrunk, grown = 60.0 * (1.0 - _ease(d / 9)), 50.0 * _ease((d - 8) / 8)
        lines += [_ring("ring", ellipse((400, 120), (shrunk, shrunk)))] if shrunk > 2.0 else []
        lines += [_ring("square", rounded((140, 400), (grown, grown), 0.3 * grown))] if grown > 2.0 else []
        drawings.append(tuple(lines))
    return Movie.on_ones("bars", (SIDE, SIDE), drawings)


def _ring(name: str, points: ArrayLike) -> Line:
    return Line(name, np.asarray(points), WIDTH, BLACK, is_closed=True)


def _card(name: str, center: tuple[float, float], half: tuple[float, float]) -> Drawing:
    """A round bar that hides what is behind it."""
    outline = rounded(center, half, half[1])
    return Fill(outline), _ring(name, outline)


def _bar(name: str, x: float, y: float) -> Line:
    return Line(name, polygon([(x, y), (x + 160, y)]), WIDTH, BLACK)


def _clamp(share: float) -> float:
    return min(max(share, 0.0), 1.0)


def _ease(share: float) -> float:
    """From 0 to 1, slowly at both ends."""
    return 0.5 - 0.5 * math.cos(math.pi * _clamp(share))


CHOSEN_ON: dict[str, Callable[[], Movie]] = {"coin": coin_movie, "stack": stack_movie, "menu": menu_movie}
CONFIRMED_ON: dict[str, Callable[[], Movie]] = {"card": card_movie, "sketch": sketch_movie, "bars": bars_movie}


def main(arguments: list[str] | None = None) -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--name", action="append", default=[])
    names = parser.parse_args(arguments).name
    print("| movie | true / found | IDF1 | births | deaths | flicker | s / drawing |\n|---|---|---|---|---|---|---|")
    for name, make in {**CHOSEN_ON, **CONFIRMED_ON}.items():
        if names and name not in names:
            continue
        known = known_movie(name, make())
        carried, seconds = carry(known)
        score = score_clip(known.truth, carried.strokes)
        true = len({stroke.id for drawing in known.truth for stroke in drawing})
        print(
            f"| {name} | {true} / {len(carried.strokes)} | {score.idf1:.3f} | {score.births:.2f} | {score.deaths:.2f} "
            f"| {score.flicker:.2f} | {seconds:.2f} |",
            flush=True,
        )


if __name__ == "__main__":
    main()
