"""Drawings with true strokes: how close initialisation and fit come, beside other tracers."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
import torch
from numpy.typing import NDArray

from videovec.bench.drawings import Still
from videovec.bench.peers import TRACERS, installed
from videovec.errors import InputError
from videovec.ink import Ink, extract_ink
from videovec.metrics import chamfer, length_difference, psnr, ssim, topology
from videovec.parameters import Parameters
from videovec.perceptual import Perceptual
from videovec.progress import Progress, Silent
from videovec.render import render_image, resolve_backend
from videovec.settings import Config
from videovec.strokes import Strokes

__all__ = ["Result", "StillScore", "bench_stills"]

Floats = NDArray[np.float64]

COVER = 2.0
"""Distance within which a stroke covers another. px at 512"""
TEXTURED_METHODS = ("ours, with its brush", "ours", "autotrace", "skeleton", "potrace (outlines)")
"""Who traces textured drawings."""
_NAN = float("nan")


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
