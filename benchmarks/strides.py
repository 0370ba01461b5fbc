"""Clips without truth, from nothing: how much ink has no stroke, how many strokes have no ink, and pictures to look at.

    python benchmarks/strides.py gifs FILE ... [--every N ...] [--pictures FOLDER]
    python benchmarks/strides.py keys FOLDER [--name SEQUENCE ...] [--pictures FOLDER]

``gifs`` takes every N-th drawing alone, so that motion between drawings is N times as large. ``keys`` runs the
sequences ``SEQUENCE-0.png ..`` of a folder from the artist's strokes ``SEQUENCE-0.svg``. Pictures show every drawing
above its strokes in the colours of their identities. Prints tables in Markdown.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from videovec.clip import Clip, Timeline
from videovec.curves import arc_length, sample_by_arc
from videovec.decode import decode
from videovec.events import EventKind
from videovec.fit import judge
from videovec.ink import Ink, extract_ink
from videovec.progress import Silent
from videovec.propagate import make_target
from videovec.reference import read_reference
from videovec.render import resolve_backend
from videovec.run import find_pipeline
from videovec.settings import Config
from videovec.strokes import Strokes
from videovec.tracks import StrokeTracks
from videovec.write.preview import contact_sheet, draw_strokes

Floats = NDArray[np.float64]

FAR = 3.5
"""Distance from which ink has no stroke, and a stroke no ink. px"""
COLUMNS, COLUMN_WIDTH, ZOOM = 7, 280, 2
"""Of a sheet of pictures: drawings in a row, px of one, and how much larger strokes are drawn first."""


@dataclass(frozen=True, slots=True, eq=False)
class Outcome:
    """A clip without truth and what was made of it.

    Args:
        clip: The clip.
        tracks: The strokes.
        psnr: Of each drawing. [D] dB
        bare: Share of each drawing's ink without strokes. [D]
        empty: Share of each drawing's stroke length without ink. [D]
        seconds: Processor time for each drawing.
    """

    clip: Clip
    tracks: StrokeTracks
    psnr: Floats
    bare: Floats
    empty: Floats
    seconds: float

    HEADER = (
        "| clip | drawings | strokes | births | deaths | ink without strokes %, mean / worst "
        "| strokes without ink %, mean / worst | PSNR median / worst | s / drawing |"
    )

    def cells(self) -> str:
        """A row of the table, without what begins and ends it."""
        count = {kind: sum(e.kind == kind for e in self.tracks.events) for kind in EventKind}
        return (
            f"{len(self.clip.drawings)} | {len(self.tracks.strokes)} | {count[EventKind.BIRTH]} "
            f"| {count[EventKind.DEATH]} | {100 * self.bare.mean():.2f} / {100 * self.bare.max():.2f} "
            f"| {100 * self.empty.mean():.2f} / {100 * self.empty.max():.2f} "
            f"| {np.median(self.psnr):.1f} / {self.psnr.min():.1f} | {self.seconds:.2f}"
        )


def outcome(clip: Clip, config: Config) -> Outcome:
    """Vectorise a clip and measure what can be measured without truth."""
    begin = time.process_time()
    tracks = find_pipeline("solid")(clip, config, Silent())
    seconds = (time.process_time() - begin) / len(clip.drawings)
    ink = extract_ink(clip, config.ink)
    psnr = judge(ink, tracks.strokes, resolve_backend(config.render)).psnr
    return Outcome(clip, tracks, psnr, *unexplained(tracks.strokes, ink), seconds)


def unexplained(strokes: Strokes, ink: Ink) -> tuple[Floats, Floats]:
    """Share of each drawing's ink without strokes, and of its stroke length without ink. [D] each"""
    bare, empty = [], []
    for drawing in range(ink.drawing_count):
        target = make_target(ink.coverage[drawing], max(ink.size))
        seen = [strokes.visible[row] for row in strokes.rows_at(drawing)]
        points = [
            _part(strokes.points_of(row), (float(v[0]), float(v[1])))
            for row, v in zip(strokes.rows_at(drawing), seen, strict=True)
            if v[1] > v[0]
        ]
        drawn = np.concatenate([np.zeros((0, 2)), *points])
        gap = _gaps(target.points, drawn)
        reach = np.maximum(FAR, target.half_width + 1)
        bare.append(float(np.mean(gap > reach)) if len(gap) else 0.0)
        empty.append(float(np.mean(target.distance_at(drawn) > FAR)) if len(drawn) else 0.0)
    return np.array(bare), np.array(empty)


def _part(points: Floats, visible: tuple[float, float]) -> Floats:
    samples = sample_by_arc(points, max(16, round(arc_length(points))))
    u = np.linspace(0, 1, len(samples))
    return np.asarray(samples[(u >= visible[0]) & (u <= visible[1])])


def _gaps(points: Floats, others: Floats) -> Floats:
    return np.asarray(cKDTree(others).query(points)[0]) if len(others) else np.full(len(points), np.inf)


def every_nth(clip: Clip, every: int) -> Clip:
    """Some of a clip's drawings, each for one frame."""
    drawings = clip.drawings[::every]
    rate = clip.timeline.frame_rate
    times = tuple(k / rate for k in range(len(drawings)))
    numbers = np.arange(1, len(drawings) + 1)
    return Clip(clip.name, drawings, Timeline(np.arange(len(drawings)), times, len(drawings) / rate, numbers))


def kept(reference: Strokes, strokes: Strokes) -> tuple[int, int, int]:
    """How many of an artist's strokes are there in their order and direction, with all their control points, on the
    first drawing; and how many of those live and are seen up to the last.

    Args:
        reference: The artist's strokes.
        strokes: What was made of them.

    Returns:
        How many there are, how many are kept, and how many of those are seen on the last drawing.
    """
    is_kept, seen_last = [], []
    last = int(strokes.layout.last.max())
    for s in range(len(reference)):
        position = np.flatnonzero(strokes.ids == reference.ids[s])
        if not len(position) or strokes.layout.first[position[0]] > 0:
            is_kept.append(False)
            continue
        found = strokes.points_of(strokes.row(int(position[0]), 0))
        points = reference.points_of(s)
        same = found.shape == points.shape
        forwards, backwards = (float(np.linalg.norm(found - p, axis=1).mean()) if same else np.inf
                               for p in (points, points[::-1]))  # fmt: skip
        is_kept.append(same and forwards <= backwards)
        lives = int(strokes.layout.last[position[0]]) == last
        seen_last.append(lives and bool(np.ptp(strokes.visible[strokes.row(int(position[0]), last)]) > 0))
    return len(reference), sum(is_kept), sum(seen_last)


def sheet(clip: Clip, strokes: Strokes) -> NDArray[np.uint8]:
    """Every drawing above its strokes in the colours of their identities. uint8 [H, W, 3]"""
    size = (COLUMN_WIDTH, max(1, round(COLUMN_WIDTH * clip.size[0] / clip.size[1])))
    images = []
    for drawing, pixels in enumerate(clip.drawings):
        eight_bit = pixels >> 8 if pixels.dtype == np.uint16 else pixels
        source = np.asarray(eight_bit[..., :3], np.uint8)
        drawn = draw_strokes(strokes, drawing, clip.size, ZOOM)
        pair = [cv2.resize(image, size, interpolation=cv2.INTER_AREA) for image in (source, drawn)]
        images.append(np.asarray(np.concatenate(pair), np.uint8))
    return contact_sheet(images, COLUMNS)


def report_gifs(arguments: argparse.Namespace) -> None:
    """Clips, whole and thinned out."""
    print(Outcome.HEADER + "\n|" + "---|" * 9)
    for path in arguments.files:
        for every in arguments.every:
            found = outcome(every_nth(decode(path), every), Config())
            name = f"{found.clip.name}_{every}"
            print(f"| {found.clip.name}, every {every} | {found.cells()} |", flush=True)
            _keep(arguments.pictures, name, found)


def report_keys(arguments: argparse.Namespace) -> None:
    """Key drawings from an artist's strokes."""
    print(Outcome.HEADER + " the artist's / kept / seen on the last |\n|" + "---|" * 10)
    names = arguments.name or sorted(path.stem.removesuffix("-0") for path in arguments.folder.glob("*-0.svg"))
    config = Config()
    for name in names:
        path = arguments.folder / f"{name}-0.svg"
        reference = replace(config.initialise, reference=str(path))
        found = outcome(decode(arguments.folder / f"{name}-%d.png"), replace(config, initialise=reference))
        counts = kept(read_reference(path, found.clip.size), found.tracks.strokes)
        print(f"| {name} | {found.cells()} | {' / '.join(map(str, counts))} |", flush=True)
        _keep(arguments.pictures, f"keys_{name}", found)


def _keep(folder: Path | None, name: str, found: Outcome) -> None:
    """The sheet and the tracks of a clip."""
    if folder:
        folder.mkdir(parents=True, exist_ok=True)
        cv2.imwrite(str(folder / f"{name}.png"), sheet(found.clip, found.tracks.strokes)[..., ::-1])
        found.tracks.save(folder / f"{name}.npz")


def main(arguments: list[str] | None = None) -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    sections = parser.add_subparsers(required=True)
    gifs = sections.add_parser("gifs")
    gifs.add_argument("files", nargs="+", type=Path)
    gifs.add_argument("--every", type=int, nargs="+", default=[1])
    keys = sections.add_parser("keys")
    keys.add_argument("folder", type=Path)
    keys.add_argument("--name", action="append", default=[])
    reports: list[tuple[argparse.ArgumentParser, Callable[[argparse.Namespace], None]]] = [
        (gifs, report_gifs),
        (keys, report_keys),
    ]
    for section, report in reports:
        section.add_argument("--pictures", type=Path, help="folder for sheets of pictures and tracks")
        section.set_defaults(report=report)
    told = parser.parse_args(arguments)
    told.report(told)


if __name__ == "__main__":
    main()
