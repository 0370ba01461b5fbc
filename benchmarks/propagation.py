"""Strokes carried from drawing to drawing, from true first strokes: are they still the right ones, and where are they?

    python benchmarks/propagation.py moved DIR [--every N] [--name CLIP ...]
    python benchmarks/propagation.py movies [--name MOVIE ...]

``moved`` chains the true strokes of the first drawing of each ``DIR/CLIP/gt.npz`` over all its drawings, then fits
jointly. ``movies`` does the same with the movies of ``samples/``, with `foreshortened_movie` and with `FAR_KEYS`, whose
truth knows what is hidden. Prints tables in Markdown.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import partial
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from benchmarks.far_keys import FAR_KEYS
from benchmarks.foreshortened import foreshortened_movie
from samples.make_samples import ball_movie, cat_movie, occluder_movie, robot_movie, turning_movie
from samples.scene import Line, Movie, paint
from samples.truth import movie_truth
from videovec.bench.clip_truth import read_clips
from videovec.clip import Clip, Timeline
from videovec.clip_metrics import TrueStroke, score_clip
from videovec.curves import arc_length, evaluate, parameter_at, sample_by_arc, segments_of
from videovec.decode import decode
from videovec.fit import fit
from videovec.initialise import initialise
from videovec.ink import Ink, extract_ink
from videovec.propagate import Propagated, propagate
from videovec.settings import Config, FitSettings, InitialiseSettings, PropagateSettings
from videovec.strokes import Strokes

Floats = NDArray[np.float64]

NEAR = 2.0
"""Distance within which a point lies on its own true stroke. px"""
MOVIES: dict[str, Callable[[], Movie]] = {
    "turning 30": partial(turning_movie, 30.0),
    "turning 45": partial(turning_movie, 45.0),
    "occluder": occluder_movie,
    "robot": robot_movie,
    "cat": cat_movie,
    "ball": ball_movie,
    "foreshortened": foreshortened_movie,
    **FAR_KEYS,
}


@dataclass(frozen=True, slots=True, eq=False)
class Known:
    """Drawings and the strokes that are on them."""

    name: str
    ink: Ink
    truth: list[list[TrueStroke]]
    first: Strokes


def moved_clips(directory: Path, names: list[str], every: int) -> Iterator[Known]:
    """Hand-drawn strokes that a script moved; points correspond."""
    for true in read_clips(directory, names):
        if not (true.path.parent / "gt.npz").exists():
            continue
        clip = decode(true.path)
        ink = extract_ink(clip, Config().ink)
        with np.load(true.path.parent / "gt.npz") as archive:
            half = float(archive["stroke_width"]) / 2
        kept = np.arange(0, ink.drawing_count, every)
        ink = replace(ink, coverage=ink.coverage[kept], label=ink.label[kept])
        truth = [true.frames[int(clip.timeline.first_frames()[k])] for k in kept]
        yield Known(true.name, ink, truth, _strokes_of(truth[0], dict.fromkeys((s.id for s in truth[0]), half)))


def known_movie(name: str, movie: Movie) -> Known:
    """A movie of the samples, with the ink that is extracted from its frames."""
    data = movie_truth(movie)
    lines = {item.name: item for drawing in movie.drawings for item in drawing if isinstance(item, Line)}
    truth = [
        [TrueStroke(s["id"], np.array(s["points"], float), tuple(map(tuple, s["visible"]))) for s in drawing]
        for drawing in data["drawings"]
    ]
    count = len(movie.drawings)
    times = tuple(Fraction(k, movie.frame_rate) for k in range(count))
    timeline = Timeline(np.arange(count), times, Fraction(count, movie.frame_rate), np.arange(1, count + 1))
    ink = extract_ink(Clip(name, tuple(paint(d, movie.size) for d in movie.drawings), timeline), Config().ink)
    info = {stroke["id"]: lines[stroke["name"]] for stroke in data["strokes"]}
    seen = [stroke for stroke in truth[0] if stroke.visible]
    first = _strokes_of(seen, {s.id: info[s.id].width / 2 for s in seen})
    color = np.array([info[s.id].color for s in seen]) / 255
    nearest = np.linalg.norm(color[:, None] - ink.palette, axis=2).argmin(axis=1)
    visible = np.array([(s.visible[0][0], s.visible[-1][1]) for s in seen])
    closed = np.array([info[s.id].is_closed for s in seen])
    return Known(name, ink, truth, replace(first, color=ink.palette[nearest], visible=visible, is_closed=closed))


def _strokes_of(true: list[TrueStroke], half_width: dict[int, float]) -> Strokes:
    widths = [np.full((len(s.points) - 1) // 3 + 1, half_width[s.id]) for s in true]
    strokes = Strokes.from_curves([s.points for s in true], widths)
    return replace(strokes, ids=np.array([s.id for s in true], np.intp))


def carry(known: Known) -> tuple[Propagated, float]:
    """Propagate, and the processor seconds for each drawing."""
    begin = time.process_time()
    trace = partial(initialise, settings=InitialiseSettings())
    carried = propagate(known.ink, known.first, PropagateSettings(), trace)
    return carried, (time.process_time() - begin) / max(known.ink.drawing_count - 1, 1)


def rows_of(known: Known, strokes: Strokes) -> Iterator[tuple[TrueStroke, int, int | None]]:
    """Every true stroke with an identity from the first drawing, later on; the drawing; and its row if it has one."""
    place = {int(identity): s for s, identity in enumerate(strokes.ids)}
    begun = {int(identity) for identity in known.first.ids}
    for drawing, true in enumerate(known.truth):
        for stroke in true if drawing else []:
            s = place.get(stroke.id)
            if stroke.id in begun:
                lives = s is not None and strokes.layout.first[s] <= drawing <= strokes.layout.last[s]
                yield stroke, drawing, strokes.row(s, drawing) if s is not None and lives else None


def share_right(known: Known, strokes: Strokes) -> float:
    """Share of strokes and drawings with more than half of what is to be seen within `NEAR` of the right place."""
    right = []
    for true, _, row in rows_of(known, strokes):
        if not true.visible:
            continue
        if row is None or strokes.visible[row, 1] <= strokes.visible[row, 0]:
            right.append(False)
            continue
        count = max(8, round(arc_length(true.points)))
        u = np.linspace(0, 1, count)
        shown = np.any([(u >= a) & (u <= b) for a, b in true.visible], axis=0)
        found = sample_by_arc(strokes.points_of(row), 2 * count)
        gap = np.linalg.norm(sample_by_arc(true.points, count)[:, None] - found, axis=2).min(1)
        right.append(bool(np.mean(gap[shown] <= NEAR) > 0.5) if shown.any() else True)
    return float(np.mean(right))


def interval_errors(known: Known, strokes: Strokes) -> Floats:
    """Distance of the ends of what is seen from the truth, where the truth is one interval and not all. px"""
    errors = []
    for true, _, row in rows_of(known, strokes):
        if row is None or len(true.visible) != 1 or true.visible[0] == (0.0, 1.0):
            continue
        ends = np.array(true.visible[0]) - strokes.visible[row]
        errors.append(arc_length(true.points) * float(np.abs(ends).max()))
    return np.array(errors)


def end_errors(known: Known, strokes: Strokes) -> Floats:
    """As `interval_errors`, but measured on the page, where a stroke is cut off: of where along it does not matter. px

    A line that leaves the page at both ends could slide along itself, and no drawing would show it; a closed line
    begins where it is hidden, which may be elsewhere than in the truth. An end of an open line that is not cut off
    counts as before.
    """
    errors = []
    closed = set(known.first.ids[known.first.is_closed].tolist())
    for true, _, row in rows_of(known, strokes):
        if row is None or len(true.visible) != 1 or true.visible[0] == (0.0, 1.0):
            continue
        ends, found = true.visible[0], strokes.visible[row]
        length = arc_length(true.points)
        if found[1] <= found[0]:
            errors.append(length * (ends[1] - ends[0]))
            continue
        apart = np.linalg.norm(_places(true.points, ends) - _places(strokes.points_of(row), found), axis=1)
        slid = length * np.abs(np.array(ends) - found)
        is_tip = [u in (0.0, 1.0) and true.id not in closed for u in ends]
        errors.append(float(np.where(is_tip, slid, apart).max()))
    return np.array(errors)


def _places(points: Floats, u: tuple[float, float] | Floats) -> Floats:
    """Where arc fractions lie. [2, 2]"""
    segment, t = parameter_at(points, u)
    return evaluate(segments_of(points)[segment], t)


def hidden_known(known: Known, strokes: Strokes) -> float:
    """Share of strokes and drawings on which it is known whether anything of the stroke is seen."""
    knows = []
    for true, _, row in rows_of(known, strokes):
        seen = row is not None and strokes.visible[row, 1] > strokes.visible[row, 0]
        knows.append(seen == bool(true.visible))
    return float(np.mean(knows))


def report_moved(arguments: argparse.Namespace) -> None:
    """Chains over moved strokes."""
    print(
        "| clip | drawings | strokes | right | carried error px | fitted error px | within 1 px "
        "| jitter px | s / drawing |"
    )
    print("|---|---|---|---|---|---|---|---|---|")
    rows = []
    for known in moved_clips(arguments.directory, arguments.name, arguments.every):
        carried, seconds = carry(known)
        before = score_clip(known.truth, carried.strokes)
        fitted = fit(known.ink, carried.strokes, FitSettings()).strokes
        after = score_clip(known.truth, fitted)
        row = (share_right(known, fitted), before.error, after.error, after.position[0], after.jitter, seconds)
        rows.append(row)
        print(f"| {known.name} | {known.ink.drawing_count} | {len(fitted)} | {_cells(row)} |", flush=True)
    print(f"| mean | | | {_cells(np.mean(rows, axis=0))} |")


def _cells(values: tuple[float, ...] | Floats) -> str:
    return " | ".join(f"{value:.3f}" for value in values)


def report_movies(arguments: argparse.Namespace) -> None:
    """Chains over the movies of the samples."""
    print(
        "| movie | true / found | right | IDF1 | full life | interval error px, median / 90 % | within 3 px "
        "| on the page | hidden known | PSNR median / worst | s / drawing |\n"
        "|---|---|---|---|---|---|---|---|---|---|---|"
    )
    for name, make in MOVIES.items():
        if arguments.name and name not in arguments.name:
            continue
        known = known_movie(name, make())
        carried, seconds = carry(known)
        fitted = fit(known.ink, carried.strokes, FitSettings())
        score = score_clip(known.truth, fitted.strokes)
        ends, page = interval_errors(known, fitted.strokes), end_errors(known, fitted.strokes)
        ends = ends if len(ends) else np.array([np.nan])
        median, most = np.percentile(ends, [50, 90])
        true = len({stroke.id for drawing in known.truth for stroke in drawing})
        print(
            f"| {name} | {true} / {len(fitted.strokes)} | {share_right(known, fitted.strokes):.3f} | {score.idf1:.3f} "
            f"| {score.full_life:.2f} | {median:.1f} / {most:.1f} | {np.mean(ends[np.isfinite(ends)] <= 3.0):.2f} "
            f"| {np.mean(page <= 3.0) if len(page) else np.nan:.2f} | {hidden_known(known, fitted.strokes):.3f} "
            f"| {np.median(fitted.psnr):.1f} / {fitted.psnr.min():.1f} "
            f"| {seconds:.2f} |",
            flush=True,
        )


def main(arguments: list[str] | None = None) -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    sections = parser.add_subparsers(required=True)
    moved = sections.add_parser("moved")
    moved.add_argument("directory", type=Path)
    moved.add_argument("--every", type=int, default=1)
    moved.add_argument("--name", action="append", default=[])
    moved.set_defaults(report=report_moved)
    movies = sections.add_parser("movies")
    movies.add_argument("--name", action="append", default=[])
    movies.set_defaults(report=report_movies)
    told = parser.parse_args(arguments)
    told.report(told)


if __name__ == "__main__":
    main()
