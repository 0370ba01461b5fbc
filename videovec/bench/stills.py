"""Drawings with true strokes: how close initialisation and fit come, beside other tracers.

A folder of drawings holds one folder for each: ``truth.json`` (``strokes``: for each a list of cubic segments [n, 4, 2]
in the unit square) and images ``SET_SIZE.png``, such as ``w3_512.png``. A set is any way of drawing the strokes, with a
brush too; those whose names begin with ``textured`` stand beside the supplement's textured rows. Drawings of the sets
in `WIDTHS` are made from the truth where there is no image of a size.
"""

from __future__ import annotations

import json
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from fractions import Fraction
from pathlib import Path

import numpy as np
import torch
from numpy.typing import NDArray

from videovec.bench.exact import draw_area
from videovec.bench.peers import TRACERS, installed
from videovec.clip import Clip, Timeline
from videovec.decode import decode
from videovec.errors import InputError
from videovec.ink import Ink, extract_ink
from videovec.metrics import chamfer, length_difference, psnr, ssim, topology
from videovec.parameters import Parameters
from videovec.perceptual import Perceptual
from videovec.progress import Progress, Silent
from videovec.render import render_image, resolve_backend
from videovec.settings import Config
from videovec.strokes import Strokes

__all__ = ["Result", "Still", "StillScore", "bench_stills", "read_stills"]

Floats = NDArray[np.float64]

COVER = 2.0
"""Distance within which a stroke covers another. px at 512"""
WIDTHS = {"w3": 3.0 / 512.0, "hairline": 0.001}
"""Sets that can be drawn from the truth, and their line width in long edges."""
_NAN = float("nan")


@dataclass(frozen=True, slots=True, eq=False)
class Still:
    """A drawing and the strokes that made it.

    Args:
        name: Its folder's name.
        set_name: How it was drawn: the file's name without its size.
        size: Long edge. px
        path: Its image; none where it is drawn from the truth.
        truth: Its true strokes, of half-width 1 unless they are to be drawn. px
    """

    name: str
    set_name: str
    size: int
    path: Path | None
    truth: Strokes

    def clip(self) -> Clip:
        """The drawing, read or drawn."""
        if self.path is not None:
            return decode(self.path)
        grey = np.rint(255.0 * (1.0 - draw_area(self.truth, (self.size, self.size)))).astype(np.uint8)
        one = np.zeros(1, np.intp)
        timeline = Timeline(one, (Fraction(0),), Fraction(1), one + 1)
        return Clip(self.name, (np.repeat(grey[..., None], 3, axis=2),), timeline)


@dataclass(frozen=True, slots=True)
class StillScore:
    """How one tracer did on one drawing; figures are NaN where there are none.

    Args:
        name: The drawing.
        set_name: How it was drawn.
        size: Long edge. px
        method: Who traced it.
        success: Whether strokes came out.
        true_strokes: Number of true strokes.
        strokes: Number of strokes, or outlines.
        segments: Number of cubics.
        chamfer: Chamfer distance. px
        length_difference: Of total length, over the true one.
        covered: See `videovec.metrics.Topology`, as for the next three.
        matched: Strict.
        fragments: Parts of true strokes.
        merges: Strokes of several true ones.
        psnr: Of the image, grey. dB
        ssim: Of the image, grey.
        lpips: Of the image, AlexNet.
        seconds: CPU time from ink to strokes.
    """

    name: str
    set_name: str
    size: int
    method: str
    success: bool
    true_strokes: int
    strokes: int = 0
    segments: int = 0
    chamfer: float = _NAN
    length_difference: float = _NAN
    covered: float = _NAN
    matched: float = _NAN
    fragments: float = _NAN
    merges: float = _NAN
    psnr: float = _NAN
    ssim: float = _NAN
    lpips: float = _NAN
    seconds: float = _NAN


@dataclass(frozen=True, slots=True, eq=False)
class Result:
    """A score and what it is the score of.

    Args:
        score: The figures.
        image: The drawing, grey. [H, W] in [0, 1]
        strokes: What the tracer made of it.
        drawn: The strokes' picture, grey. [H, W] in [0, 1]
    """

    score: StillScore
    image: Floats
    strokes: Strokes = field(default_factory=Strokes.empty)
    drawn: Floats | None = None


def read_stills(directory: Path, sets: Sequence[str] = (), sizes: Sequence[int] = ()) -> list[Still]:
    """Find the drawings of a folder.

    Args:
        directory: The folder.
        sets: Which sets; all if none is named.
        sizes: Which long edges; all if none is named.

    Returns:
        The drawings, by set, size and name.

    Raises:
        InputError: There is none.
    """
    found = []
    for truth in sorted(directory.glob("*/truth.json")):
        segments = [np.array(stroke, dtype=float) for stroke in json.loads(truth.read_text("utf-8"))["strokes"]]
        unit = [np.concatenate([stroke[0, :1], stroke[:, 1:].reshape(-1, 2)]) for stroke in segments]
        images = _images(truth.parent)
        missing = [(name, size) for name in WIDTHS for size in sizes if name in (sets or WIDTHS)]
        for set_name, size in [*images, *(drawn for drawn in missing if drawn not in images)]:
            if (sets and set_name not in sets) or (sizes and size not in sizes):
                continue
            path = images.get((set_name, size))
            half_width = 1.0 if path else 0.5 * WIDTHS[set_name] * size
            curves = [points * size for points in unit]
            strokes = Strokes.from_curves(curves, [np.full((len(points) + 2) // 3, half_width) for points in curves])
            found.append(Still(truth.parent.name, set_name, size, path, strokes))
    if not found:
        raise InputError(f"{directory}: must hold NAME/truth.json beside NAME/SET_SIZE.png, found none")
    return sorted(found, key=lambda still: (still.set_name, still.size, still.name))


def _images(directory: Path) -> dict[tuple[str, int], Path]:
    """The images of a drawing by set and long edge."""
    found = {}
    for image in sorted(directory.glob("*_*.png")):
        set_name, _, size = image.stem.rpartition("_")
        if size.isdigit():
            found[set_name, int(size)] = image
    return found


def _draw(strokes: Strokes, ink: Ink, config: Config) -> Floats:
    """The picture of strokes on their page, grey. [H, W] in [0, 1]"""
    backend = resolve_backend(config.render)
    with torch.no_grad():
        free = Parameters.of(strokes, backend.device)
        stroke = strokes.layout.row_stroke[free.index.rows.cpu().numpy()]
        color = torch.as_tensor(strokes.color[stroke], dtype=torch.float32, device=backend.device)
        scene = replace(free.scene((1, *ink.size), free.intervals()), color=color)
        image = render_image(scene, torch.as_tensor(ink.page, dtype=torch.float32), backend=backend.name)
    return np.asarray(image[0].mean(-1).clamp(0, 1).cpu().numpy(), dtype=np.float64)


def _lpips(network: Perceptual, one: Floats, two: Floats) -> float:
    """Perceptual distance of two grey images."""
    with torch.no_grad():
        a, b = (torch.as_tensor(image, dtype=torch.float32).expand(1, 3, *image.shape) for image in (one, two))
        return float(network.distance(a, b))


def _trace(still: Still, method: str, config: Config, network: Perceptual) -> Result:
    """Trace one drawing by one method and score what came out."""
    clip = still.clip()
    pixels = clip.drawings[0]
    image: Floats = pixels.astype(np.float64).mean(axis=2) / np.iinfo(pixels.dtype).max
    ink = extract_ink(clip, config.ink)
    begin = time.process_time()
    tracing = TRACERS[method].trace(ink, config)
    seconds = time.process_time() - begin
    strokes = tracing.strokes
    if not len(strokes):
        failed = StillScore(still.name, still.set_name, still.size, method, False, len(still.truth))
        return Result(failed, image)
    if tracing.coverage is None:
        drawn = _draw(strokes, ink, config)
    else:
        drawn = ink.page.mean() + tracing.coverage * (ink.palette[0].mean() - ink.page.mean())
    shape = topology(still.truth, strokes, COVER * still.size / 512)
    score = StillScore(
        name=still.name,
        set_name=still.set_name,
        size=still.size,
        method=method,
        success=True,
        true_strokes=len(still.truth),
        strokes=len(strokes),
        segments=int(strokes.layout.segments.sum()),
        chamfer=chamfer(still.truth, strokes),
        length_difference=length_difference(still.truth, strokes),
        covered=shape.covered,
        matched=shape.matched,
        fragments=shape.fragments,
        merges=shape.merges,
        psnr=psnr(image, drawn),
        ssim=ssim(image, drawn),
        lpips=_lpips(network, image, drawn),
        seconds=seconds,
    )
    return Result(score, image, strokes, drawn)


def bench_stills(
    stills: Sequence[Still],
    config: Config,
    methods: Sequence[str] = ("ours",),
    watch: Callable[[Result], None] | None = None,
    progress: Progress | None = None,
) -> list[StillScore]:
    """Trace drawings by several methods and compare them with the truth.

    Args:
        stills: The drawings.
        config: How ours works.
        methods: Names of `videovec.bench.peers.TRACERS`; what is not installed is left out with a note.
        watch: Given every result, for pictures.
        progress: Told of every tracing.

    Returns:
        One score for each drawing and method.

    Raises:
        InputError: There is no such method.
    """
    progress = progress or Silent()
    unknown = [method for method in methods if method not in TRACERS]
    if unknown:
        raise InputError(f"a method must be one of {', '.join(TRACERS)}, got {unknown[0]!r}")
    present = [method for method in methods if installed(TRACERS[method])]
    for method in set(methods) - set(present):
        progress.note(f"{method} is left out: {TRACERS[method].needs} is not installed")
    progress.stage("bench", len(stills) * len(present))
    network, scores = Perceptual.load(), []
    for still in stills:
        for method in present:
            result = _trace(still, method, config, network)
            scores.append(result.score)
            if watch:
                watch(result)
            progress.advance()
    return scores
