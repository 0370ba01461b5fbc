"""What fitting all drawings together is worth: jitter, position and size against the weight of the temporal terms.

    python benchmarks/joint.py [DIR] [--name CLIP ...] [--csv joint.csv] [--picture joint.png] [--keep FOLDER]

True strokes of the first drawing are carried through every clip of DIR (NAME/gt.npz, as `videovec bench clips` reads
them) and through clips of our own, on which nothing was chosen. The same carried strokes are then fitted to each
drawing alone, and jointly with the temporal terms at several multiples of their default weights. Prints Markdown; keeps
the tracks of both fits that are compared.
"""

from __future__ import annotations

import argparse
import csv
from collections.abc import Iterator
from dataclasses import asdict, dataclass, replace
from functools import partial
from pathlib import Path

import numpy as np
from moving import MOTIONS, moving_clip
from timing import machine

from videovec.bench.clip_truth import read_clips
from videovec.clip import Clip
from videovec.clip_metrics import TrueStroke, score_clip
from videovec.decode import decode
from videovec.fit import fit
from videovec.initialise import initialise
from videovec.ink import Ink, extract_ink
from videovec.propagate import propagate
from videovec.settings import Config, FitSettings
from videovec.strokes import Strokes
from videovec.tracks import StrokeTracks
from videovec.write.lottie import lottie_text

Truth = list[list[TrueStroke]]

ALONE = "each alone"
FACTORS = (0.0, 0.1, 0.3, 1.0, 3.0, 10.0)
COMPARED = (ALONE, "1")
TEMPORAL = ("acceleration", "rigidity", "sliding", "width_change")


@dataclass(frozen=True, slots=True)
class Row:
    """One fit of one clip; lengths in px."""

    clip: str
    kind: str
    weights: str
    error: float
    within_1px: float
    jitter: float
    psnr: float
    lottie_kib: float


def fits(config: Config) -> dict[str, FitSettings]:
    """Every way to fit, by name."""
    base = config.fit.weights
    nothing = dict.fromkeys((*TEMPORAL, "anchor"), 0.0)
    ways = {ALONE: replace(config.fit, weights=replace(base, **nothing))}
    for factor in FACTORS:
        scaled = {name: factor * getattr(base, name) for name in TEMPORAL}
        ways[f"{factor:g}"] = replace(config.fit, weights=replace(base, **scaled))
    return ways


def clips(folder: Path | None, names: list[str]) -> Iterator[tuple[str, Clip, Truth]]:
    """Kind, clip and true strokes: those of the folder, then our own."""
    for true in read_clips(folder, names) if folder else []:
        clip = decode(true.path)
        yield "folder", replace(clip, name=true.name), [true.frames[frame] for frame in clip.timeline.first_frames()]
    for seed, name in enumerate(MOTIONS):
        clip, truth = moving_clip(name, seed=seed)
        yield "own", clip, truth


def first_strokes(truth: Truth, ink: Ink) -> Strokes:
    """The true strokes of the first drawing, as wide as the ink says they are on the mean."""
    curves = [stroke.points for stroke in truth[0]]
    length = sum(float(np.linalg.norm(np.diff(curve[::3], axis=0), axis=1).sum()) for curve in curves)
    half_width = 0.5 * float(ink.coverage[0].sum()) / 255 / length
    widths = [np.full((len(curve) + 2) // 3, half_width) for curve in curves]
    return Strokes.from_curves(curves, widths, color=ink.palette[0])


def measure(kind: str, clip: Clip, truth: Truth, config: Config) -> Iterator[tuple[Row, StrokeTracks]]:
    """All fits of one clip."""
    ink = extract_ink(clip, config.ink)
    trace = partial(initialise, settings=config.initialise)
    alone = fit(
        ink.at_drawing(0), first_strokes(truth, ink), replace(config.fit, edits=replace(config.fit.edits, every=0))
    )
    first = replace(alone.strokes, points=first_strokes(truth, ink).points)
    carried = propagate(ink, first, config.propagate, trace).strokes
    for weights, settings in fits(config).items():
        result = fit(ink, carried, settings, config.render)
        score = score_clip(truth, result.strokes)
        tracks = StrokeTracks.of(clip, ink, result)
        yield (
            Row(
                clip.name,
                kind,
                weights,
                score.error,
                score.position[0],
                score.jitter,
                float(np.median(result.psnr)),
                len(lottie_text(tracks, config.export).encode()) / 1024,
            ),
            tracks,
        )


def table(rows: list[Row], kind: str) -> str:
    """Means over the clips of a kind, a line for each way to fit."""
    lines = [
        "| temporal weights | error px | within 1 px | jitter px | PSNR dB | Lottie KiB |",
        "|---|---|---|---|---|---|",
    ]
    for weights in dict.fromkeys(row.weights for row in rows):
        own = [row for row in rows if row.kind == kind and row.weights == weights]
        if own:
            mean = {name: float(np.mean([getattr(row, name) for row in own])) for name in Row.__slots__[3:]}
            lines.append(
                f"| {weights if weights == ALONE else 'x ' + weights} | {mean['error']:.3f} | {mean['within_1px']:.3f} "
                f"| {mean['jitter']:.3f} | {mean['psnr']:.1f} | {mean['lottie_kib']:.0f} |"
            )
    return "\n".join(lines)


def picture(rows: list[Row], path: Path) -> None:
    """Jitter and error over the weight, a line for each clip."""
    import matplotlib

    matplotlib.use("Agg")
    from matplotlib import pyplot

    figure, axes = pyplot.subplots(1, 2, figsize=(10, 3.6), constrained_layout=True)
    names = [f"{factor:g}" for factor in FACTORS]
    for clip in dict.fromkeys(row.clip for row in rows):
        own = {row.weights: row for row in rows if row.clip == clip}
        style = "-" if own[names[0]].kind == "folder" else "--"
        for axis, value in zip(axes, ("jitter", "error"), strict=True):
            axis.plot(names, [getattr(own[name], value) for name in names], style, marker=".", label=clip)
            axis.set(xlabel="multiple of the default temporal weights", ylabel=f"{value} (px)", yscale="log")
    axes[1].legend(fontsize=7, ncols=2)
    figure.savefig(path, dpi=110)


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=Path, metavar="DIR", nargs="?", help="none: our own clips alone")
    parser.add_argument("--name", action="append", default=[], help="only this clip of the folder; may be repeated")
    parser.add_argument("--csv", type=Path)
    parser.add_argument("--picture", type=Path)
    parser.add_argument("--keep", type=Path, metavar="FOLDER", help="where tracks of both fits go")
    arguments = parser.parse_args()
    print(machine())
    rows = []
    for kind, clip, truth in clips(arguments.folder, arguments.name):
        for row, tracks in measure(kind, clip, truth, Config()):
            rows.append(row)
            print(row, flush=True)
            if arguments.keep and row.weights in COMPARED:
                arguments.keep.mkdir(parents=True, exist_ok=True)
                tracks.save(arguments.keep / f"{clip.name}_{row.weights.replace(' ', '_')}.npz")
    for kind, title in (("folder", "Clips of the folder"), ("own", "Our own clips")):
        print(f"\n{title}, means over clips\n\n{table(rows, kind)}")
    if arguments.csv:
        with arguments.csv.open("w", encoding="utf-8", newline="") as file:
            writer = csv.DictWriter(file, Row.__slots__, lineterminator="\n")
            writer.writeheader()
            writer.writerows(asdict(row) for row in rows)
    if arguments.picture:
        picture(rows, arguments.picture)


if __name__ == "__main__":
    main()
