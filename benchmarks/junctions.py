"""Which branches of a junction are one stroke: train the network that decides it, and compare it with geometry.

    PYTHONPATH=. python benchmarks/junctions.py train --modules node_modules --out FILE
    PYTHONPATH=. python benchmarks/junctions.py test --modules node_modules [--stills DIR] [--clips DIR]

``train`` draws figures and scenes whose outlines hide each other, and takes drawings of the training collections; it
writes the weights and says their sha256. ``test`` asks both about the junctions of drawings that training never saw:
other made-up ones, whole collections that are kept apart, folders of drawings with true strokes as
``videovec bench stills`` reads them, and the first drawings of clips with them. Prints tables in Markdown.
"""

from __future__ import annotations

import argparse
import hashlib
import math
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import torch
from numpy.typing import NDArray

from benchmarks.junction_data import MADE, Drawn, drawings, trace_lines
from benchmarks.junction_labels import STEP
from benchmarks.junction_training import Example, accuracy, prepare, to_bytes, train
from videovec.bench.drawings import read_stills
from videovec.curves import evaluate, segments_of
from videovec.decode import decode
from videovec.initialise.junctions import Pairing, pair_branches, pair_by_net
from videovec.initialise.polyline import resample
from videovec.ink import extract_ink
from videovec.settings import Config

TRAINED = {
    "icons of tabler": (1500, 3),
    "tabler": (800, 1),
    "jointed": (900, 1),
    "figure": (500, 1),
    "scene": (700, 1),
}
"""Drawings of each kind to learn from, of which ``KEPT`` are kept to validate, and how often each is taken: an icon has
two junctions, a figure thirty."""
KEPT = 0.06
EPOCHS = 12
SEEDS = 0, 1
"""Of the networks whose scores are averaged."""
TESTED = {"figure": 100, "scene": 100, "jointed": 100, "icons of lucide": 300, "icons of feather": 200}
"""Drawings of each kind to compare on; made-up ones with another seed, and two collections kept apart."""


@dataclass(frozen=True, slots=True)
class Row:
    """Junctions of one set, those that geometry and the network get wholly right, and the same of four or more arms."""

    name: str
    count: int
    geometry: int
    learned: int
    wide: tuple[int, int, int]


def _links(pairings: list[Pairing]) -> dict[int, set[frozenset[int]]]:
    return {p.node: {frozenset(pair) for pair in p.links} for p in pairings}


def compare(name: str, known: Iterable[Drawn]) -> Row:
    """Ask geometry and the network about every junction whose truth is clear."""
    right = []
    for drawn in known:
        geometry = _links(pair_branches(drawn.graph, drawn.widths, Config().initialise.max_turn))
        learned = _links(pair_by_net(drawn.graph, drawn.widths))
        for junction in drawn.junctions:
            if junction.is_clear:
                truth = {frozenset(pair) for pair in junction.links}
                node = junction.node
                right.append((len(junction.ends) > 3, geometry[node] == truth, learned[node] == truth))
    table = np.array(right, bool).reshape(-1, 3)
    wide = table[table[:, 0]]
    return Row(name, len(table), *table[:, 1:].sum(axis=0).tolist(), (len(wide), *wide[:, 1:].sum(axis=0).tolist()))


def _sampled(points: NDArray[np.float64]) -> NDArray[np.float64]:
    """A true stroke, from its control points. px"""
    t = np.linspace(0, 1, 60)[None]
    return resample(np.concatenate([evaluate(s[None], t).reshape(-1, 2) for s in segments_of(points)]), STEP)


def _traced(path: Path, lines: list[NDArray[np.float64]]) -> Drawn:
    ink = extract_ink(decode(path), Config().ink)
    drawn = trace_lines(lines, ink.coverage[0].astype(np.float32) / np.float32(255), ink.noise)
    assert drawn is not None, path
    return drawn


def still_sets(directory: Path) -> dict[str, Iterator[Drawn]]:
    """Drawings of a folder of stills, by set and size."""
    found = {f"{s.set_name} {s.size}" for s in read_stills(directory, (), ())}

    def of(name: str) -> Iterator[Drawn]:
        for still in read_stills(directory, (), ()):
            if f"{still.set_name} {still.size}" == name:
                yield _traced(still.path, [_sampled(still.truth.points_of(k)) for k in range(still.truth.row_count)])

    return {name: of(name) for name in sorted(found)}


def first_drawings(directory: Path) -> Iterator[Drawn]:
    """The first drawing of every clip that has a ``gt.npz``."""
    for path in sorted(directory.glob("*/gt.npz")):
        with np.load(path) as truth:
            control, owner = truth["ctrl"][0].astype(float), truth["seg_stroke"]
        lines = []
        for stroke in np.unique(owner):
            own = control[owner == stroke]
            lines.append(_sampled(np.concatenate([own[:, :3].reshape(-1, 2), own[-1, 3:]])))
        yield _traced(min(path.parent.glob("*.png")), lines)


def _print(rows: Iterable[Row]) -> None:
    names = ("set", "junctions", "geometry", "learned", "of 4 or more arms", "geometry", "learned")
    print("|", " | ".join(names), "|")
    print("|---" * len(names) + "|")
    for row in rows:
        count, geometry, learned = row.wide
        shares = [f"{n / max(of, 1):.3f}" for n, of in ((row.geometry, row.count), (row.learned, row.count))]
        wide = [f"{n / count:.3f}" if count else "" for n in (geometry, learned)]
        print("|", " | ".join([row.name, str(row.count), *shares, str(count), *wide]), "|", flush=True)


def learn(kinds: dict[str, tuple[int, int]], modules: Path | None, out: Path) -> None:
    """Train, validate, and write the weights."""
    torch.set_num_threads(1)
    known: list[Example] = []
    kept: dict[str, list[Example]] = {}
    for kind, (count, times) in kinds.items():
        examples = [prepare(drawn) for drawn in drawings(kind, count, 1, modules)]
        examples = [example for example in examples if example.junctions]
        first = round((1 - KEPT) * len(examples))
        known += examples[:first] * times
        kept[kind] = examples[first:]
    nets = [train(known, EPOCHS, seed) for seed in SEEDS]
    for kind, examples in kept.items():
        print(f"{kind}: {accuracy(nets, examples)[0]:.3f} of the junctions kept to validate are right")
    data = to_bytes(nets)
    out.write_bytes(data)
    print(f"{out}: {len(data)} bytes, sha256 {hashlib.sha256(data).hexdigest()}")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("command", choices=("train", "test"))
    parser.add_argument("--modules", type=Path)
    parser.add_argument("--stills", type=Path)
    parser.add_argument("--clips", type=Path)
    parser.add_argument("--out", type=Path, default=Path("junctions_fp16.safetensors"))
    parser.add_argument("--share", type=float, default=1.0, help="of the drawings to learn from, to try the script")
    given = parser.parse_args()
    if given.command == "train":
        share = {kind: (math.ceil(given.share * count), times) for kind, (count, times) in TRAINED.items()}
        known = {kind: many for kind, many in share.items() if given.modules or kind in MADE}
        learn(known, given.modules, given.out)
        return
    tested = {kind: count for kind, count in TESTED.items() if given.modules or kind in MADE}
    sets = {kind: drawings(kind, count, 99, given.modules) for kind, count in tested.items()}
    if given.stills:
        sets |= still_sets(given.stills)
    if given.clips:
        sets |= {"first drawings of clips": first_drawings(given.clips)}
    _print(compare(name, known) for name, known in sets.items())


if __name__ == "__main__":
    main()
