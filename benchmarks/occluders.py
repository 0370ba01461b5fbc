"""Things that pass before characters: do strokes that are hidden in part, or altogether, keep their identity?

    PYTHONPATH=. python benchmarks/occluders.py [--name CLIP ...]

Clips of our own with truth: four characters that move by themselves, behind bars, a disc, a card and a trunk of
several sizes, directions and speeds. True strokes of the first drawing are carried through each clip and fitted
jointly. Prints a table in Markdown; "on the page" is what is within 3 px by `end_errors`.
"""

from __future__ import annotations

import argparse
import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from propagation import (
    NEAR,
    Known,
    carry,
    end_errors,
    hidden_known,
    interval_errors,
    known_movie,
    rows_of,
    share_right,
)

from samples.scene import Drawing, Fill, Line, Movie, ellipse, place, polygon, rounded, spline
from videovec.clip_metrics import score_clip
from videovec.curves import arc_length, sample_by_arc
from videovec.fit import fit
from videovec.settings import FitSettings
from videovec.strokes import Strokes

Floats = NDArray[np.float64]

BLACK = (0, 0, 0)
SIZE = (256, 256)
COUNT = 14
HALF, WHOLE = 0.5, 0.9
"""Shares of a stroke: less is seen of one that is lost, more of one that is back."""


def person(time: float) -> Drawing:
    """Somebody who sways."""
    swing = math.sin(time / 2)
    items = (
        *_closed("head", (128, 70), (20, 22)),
        *_closed("eye", (120, 66), (4, 4)),
        _line("smile", (118, 80), (128, 84), (138, 79)),
        _line("body", (128, 92), (124, 120), (130, 150)),
        _line("arm 1", (122, 104), (100, 118), (84, 108)),
        _line("arm 2", (130, 104), (150, 112), (172, 92)),
        _line("leg 1", (126, 152), (112, 180), (100, 214)),
        _line("leg 2", (132, 152), (146, 182), (150, 214)),
    )
    return (
        _line("ground", (8, 216), (90, 222), (180, 214), (250, 220)),
        *place(items, (3 * swing, 0), 4 * swing, 1.0, (128, 200)),
    )


def fish(time: float) -> Drawing:
    """A fish that swims on the spot among weeds."""
    beat, bob = 9 * math.sin(time * 0.8), 3 * math.sin(time * 0.5)
    tail = place((_line("tail", (74, 126), (46, 96), (54, 128), (44, 160), (74, 134)),), turn=beat, about=(74, 130))
    body = (
        _line("back", (204, 130), (168, 90), (116, 92), (74, 126)),
        _line("belly", (204, 130), (166, 166), (116, 164), (74, 134)),
        *_closed("eye", (176, 120), (6, 6)),
        _line("gill", (156, 106), (146, 128), (156, 150)),
        _line("fin", (128, 92), (116, 66), (96, 74), (100, 94)),
        _line("mouth", (200, 136), (190, 138), (184, 144)),
    )
    sway = 4 * math.sin(time * 0.4)
    weeds = [
        _line(f"weed {k}", (x, 246), (x + 8 + sway, 216), (x - 6 - sway, 190)) for k, x in enumerate((30, 52, 214, 238))
    ]
    return (*place((*body, *tail), (0, bob)), *weeds)


def flower(time: float) -> Drawing:
    """A flower in a pot, in the wind."""
    bend = 5 * math.sin(time * 0.6)
    petals = [place((_line(f"petal {k}", (0, -12), (-18, -34), (0, -48), (18, -34), (0, -12)),), turn=72 * k)[0]
              for k in range(5)]  # fmt: skip
    bloom = place((*_closed("heart", (0, 0), (11, 11)), *petals), (128 + 3 * bend, 82), bend)
    return (
        *bloom,
        _line("stem", (128 + 3 * bend, 96), (126 + bend, 140), (128, 186)),
        _line("leaf 1", (127 + bend, 150), (98, 128 + bend), (82, 138), (127 + bend, 158)),
        _line("leaf 2", (127, 168), (152, 150 - bend), (174, 154), (128, 176)),
        Line("rim", rounded((128, 192), (42, 7), 4), 4, BLACK, is_closed=True),
        _line("pot", (94, 200), (102, 240), (128, 243), (154, 240), (162, 200)),
    )


def dog(time: float) -> Drawing:
    """A dog that walks on the spot."""
    step, bob = 10 * math.sin(time * 0.9), 2 * math.sin(time * 1.8)
    body = (
        _line("back", (70, 120), (110, 108), (150, 110), (176, 118)),
        _line("belly", (78, 152), (120, 158), (168, 150)),
        _line("tail", (70, 120), (50, 104), (44, 84 + step / 2)),
        _line("neck", (176, 118), (190, 96), (196, 80)),
        *_closed("head", (206, 74), (18, 14)),
        *_closed("eye", (210, 70), (3.5, 3.5)),
        _line("ear", (196, 64), (188, 50), (182, 66)),
    )
    legs = (
        _line("leg 1", (82, 152), (80 + step / 2, 184), (84 + step, 214)),
        _line("leg 2", (98, 156), (98 - step / 2, 186), (96 - step, 214)),
        _line("leg 3", (150, 154), (150 - step / 2, 184), (152 - step, 214)),
        _line("leg 4", (166, 150), (168 + step / 2, 182), (166 + step, 214)),
    )
    return (_line("ground", (6, 220), (128, 216), (250, 222)), *place((*body, *legs), (0, bob)))


def _line(name: str, *points: tuple[float, float]) -> Line:
    return Line(name, spline(points), 4.0, BLACK)


def _closed(name: str, center: tuple[float, float], radius: tuple[float, float]) -> tuple[Line]:
    return (Line(name, ellipse(center, radius), 4.0, BLACK, is_closed=True),)


def _bar(left: float, width: float, tilt: float, angle: float = 0.0) -> Drawing:
    """A page-coloured bar with two edges, from beyond one side of the page to beyond the other."""
    a, b, c, d = (left, -60.0), (left + width, -60.0), (left + width + tilt, 320.0), (left + tilt, 320.0)
    items = (
        Fill(polygon([a, b, c, d, a])),
        Line("bar 1", polygon([a, d]), 3.0, BLACK),
        Line("bar 2", polygon([b, c]), 3.0, BLACK),
    )
    return place(items, turn=angle, about=(128, 128))


def _disc(x: float, y: float, radius: float) -> Drawing:
    shape = ellipse((x, y), (radius, radius))
    return (Fill(shape), Line("disc", shape, 4.0, BLACK, is_closed=True))


def _card(x: float, y: float, turn: float) -> Drawing:
    shape = rounded((0, 0), (44, 30), 8)
    items = (
        Fill(shape),
        Line("card", shape, 4.0, BLACK, is_closed=True),
        _line("text 1", (-28, -8), (28, -8)),
        _line("text 2", (-28, 8), (10, 8)),
    )
    return place(items, (x, y), turn)


def _movie(
    name: str, character: Callable[[float], Drawing], cover: Callable[[int], Drawing], pace: float = 1.0
) -> Movie:
    drawings = [(*character(pace * d), *cover(d)) for d in range(COUNT)]
    return Movie.on_ones(name, SIZE, drawings)


def _behind_trunk() -> Movie:
    """The character walks and what hides it stands."""
    drawings = [
        (*place(person(1.4 * d)[1:], (-86 + 13 * d, 0)), _line("ground", (2, 222), (90, 224), (180, 220), (254, 223)),
         *_bar(112, 40, 6))
        for d in range(COUNT)
    ]  # fmt: skip
    return Movie.on_ones("person, trunk", SIZE, drawings)


def _past_trunk() -> Movie:
    """Another one who walks, the other way."""
    drawings = [
        (*place(dog(1.1 * d)[1:], (110 - 16 * d, 0)), _line("ground", (2, 224), (128, 221), (254, 224)),
         *_bar(96, 46, -8))
        for d in range(COUNT)
    ]  # fmt: skip
    return Movie.on_ones("dog, trunk", SIZE, drawings)


CLIPS: dict[str, Callable[[], Movie]] = {
    "person, bar": lambda: _movie("person, bar", person, lambda d: _bar(244 - 20 * d, 60, -51)),
    "person, bar back": lambda: _movie("person, bar back", person, lambda d: _bar(-24 + 21 * d, 40, 32)),
    "person, disc": lambda: _movie("person, disc", person, lambda d: _disc(-30 + 22 * d, 60 + 9 * d, 38)),
    "person, trunk": _behind_trunk,
    "fish, bar": lambda: _movie("fish, bar", fish, lambda d: _bar(-90 + 26 * d, 76, 0)),
    "fish, card": lambda: _movie("fish, card", fish, lambda d: _card(300 - 24 * d, 100 + 4 * d, 8 * d)),
    "flower, beam": lambda: _movie("flower, beam", flower, lambda d: _bar(-44 + 21 * d, 34, 30, 90)),
    "flower, thin bar": lambda: _movie("flower, thin bar", flower, lambda d: _bar(30 + 12 * d, 18, 20)),
    "flower, disc": lambda: _movie("flower, disc", flower, lambda d: _disc(128 + 8 * d, 300 - 24 * d, 52)),
}
HELD: dict[str, Callable[[], Movie]] = {
    "dog, bar": lambda: _movie("dog, bar", dog, lambda d: _bar(-80 + 24 * d, 56, 14)),
    "dog, trunk": _past_trunk,
    "dog, disc": lambda: _movie("dog, disc", dog, lambda d: _disc(290 - 25 * d, 190 - 5 * d, 34)),
    "person, thin slant": lambda: _movie(
        "person, thin slant", lambda t: person(t + 4), lambda d: _bar(270 - 22 * d, 26, -80)
    ),
    "flower, card": lambda: _movie(
        "flower, card", lambda t: flower(t + 2), lambda d: _card(-50 + 25 * d, 130 - 3 * d, 90 - 7 * d)
    ),
}
"""Clips made before strokes in front were told apart, and neither looked at nor measured until that was done."""


@dataclass(frozen=True, slots=True)
class Row:
    """What became of one clip; lengths in px."""

    clip: str
    true: int
    found: int
    right: float
    idf1: float
    back: float
    intervals: int
    within: float
    cut: float
    known: float
    psnr: float
    worst: float
    seconds: float


def came_back(known: Known, strokes: Strokes) -> float:
    """Share of the strokes seen again, after less than half of them was, that are then found under their identity.

    NaN if there are none.
    """
    lost: set[int] = set()
    back: dict[int, bool] = {}
    for true, _, row in rows_of(known, strokes):
        seen = sum(end - begin for begin, end in true.visible)
        if seen < HALF:
            lost.add(true.id)
            back.pop(true.id, None)
        elif true.id in lost and seen > WHOLE:
            back[true.id] = row is not None and _is_there(true.points, strokes, row)
    return float(np.mean(list(back.values()))) if back else float("nan")


def _is_there(true: Floats, strokes: Strokes, row: int) -> bool:
    """Whether most of a row is seen, and most of a true stroke lies on it."""
    found = sample_by_arc(strokes.points_of(row), max(65, round(2 * arc_length(true))))
    gap = np.linalg.norm(sample_by_arc(true, 33)[:, None] - found, axis=2).min(1)
    return bool(np.mean(gap <= NEAR) > HALF and np.ptp(strokes.visible[row]) > HALF)


def measure(name: str) -> Row:
    """Carry and fit one clip."""
    known = known_movie(name, {**CLIPS, **HELD}[name]())
    carried, seconds = carry(known)
    fitted = fit(known.ink, carried.strokes, FitSettings())
    ends, cut = interval_errors(known, fitted.strokes), end_errors(known, fitted.strokes)
    return Row(
        clip=name,
        true=len({stroke.id for drawing in known.truth for stroke in drawing}),
        found=len(fitted.strokes),
        right=share_right(known, fitted.strokes),
        idf1=score_clip(known.truth, fitted.strokes).idf1,
        back=came_back(known, fitted.strokes),
        intervals=len(ends),
        within=float(np.mean(ends <= 3.0)) if len(ends) else float("nan"),
        cut=float(np.mean(cut <= 3.0)) if len(cut) else float("nan"),
        known=hidden_known(known, fitted.strokes),
        psnr=float(np.median(fitted.psnr)),
        worst=float(fitted.psnr.min()),
        seconds=seconds,
    )


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--name", action="append", default=[], choices=[*CLIPS, *HELD])
    names = parser.parse_args().name or [*CLIPS, *HELD]
    print(
        "| clip | true / found | right | IDF1 | came back | within 3 px, of | on the page | hidden known "
        "| PSNR median / worst | s / drawing |\n|---|---|---|---|---|---|---|---|---|---|"
    )
    for name in names:
        row = measure(name)
        print(
            f"| {row.clip} | {row.true} / {row.found} | {row.right:.3f} | {row.idf1:.3f} | {row.back:.2f} "
            f"| {row.within:.2f}, {row.intervals} | {row.cut:.2f} | {row.known:.3f} | {row.psnr:.1f} / {row.worst:.1f} "
            f"| {row.seconds:.2f} |",
            flush=True,
        )


if __name__ == "__main__":
    main()
