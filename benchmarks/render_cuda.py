"""The renderer on a CUDA device: a step and its list of pairs, what bounds them, and fits.

    python benchmarks/render_cuda.py [--sample samples/robot.mp4] [--out benchmarks/render_cuda.md]

A step is forward, squared residual and backward to all leaves. Times are wall times of one call between two
synchronisations, median and quartiles of at least 20; beside them numba on one thread of the same machine's CPU.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Callable, Iterator
from dataclasses import fields, replace
from functools import partial
from pathlib import Path

import numpy as np
import torch
from drawings import random_drawing
from timing import Timing, machine, write_report

from videovec.decode import decode
from videovec.fit import fit
from videovec.initialise import initialise
from videovec.ink import Ink, extract_ink
from videovec.propagate import propagate
from videovec.render import Scene, coverage_loss_and_gradients, list_pairs
from videovec.render.fused import match_with_torch
from videovec.settings import Config, RenderSettings
from videovec.strokes import Strokes
from videovec.threads import configure_threads

Call = Callable[[], object]


def on_device(scene: Scene, device: str) -> Scene:
    """The same scene with all tensors there."""
    moved = {f.name: getattr(scene, f.name).to(device) for f in fields(scene) if f.name != "size"}
    return replace(scene, **moved)


def timed(call: Call, seconds: float = 0.5) -> Timing:
    """Wall time of a call that leaves nothing running. ms"""
    for _ in range(3):
        call()
    torch.cuda.synchronize()
    taken: list[float] = []
    while len(taken) < 20 or (sum(taken) < seconds and len(taken) < 500):
        begin = time.perf_counter()
        call()
        torch.cuda.synchronize()
        taken.append(time.perf_counter() - begin)
    return Timing(*(1e3 * np.quantile(taken, [0.5, 0.25, 0.75])).tolist())


def step_of(scene: Scene, match: Callable[..., object]) -> Call:
    pairs = list_pairs(scene, 1.0)
    target = torch.zeros(scene.size, dtype=torch.uint8, device=scene.control.device)
    return lambda: match(scene, pairs, 1.0, target)


def table(scenes: dict[str, Scene]) -> Iterator[str]:
    yield "| scene | pairs | step | step by autograd | list of pairs | numba step | numba list |"
    yield "|---|---|---|---|---|---|---|"
    for name, scene in scenes.items():
        there = on_device(scene, "cuda")
        cells = [
            timed(step_of(there, coverage_loss_and_gradients)),
            timed(step_of(there, match_with_torch)),
            timed(lambda there=there: list_pairs(there, 1.0)),  # type: ignore[misc]
            timed(step_of(scene, coverage_loss_and_gradients)),
            timed(lambda scene=scene: list_pairs(scene, 1.0)),  # type: ignore[misc]
        ]
        yield f"| {name} | {len(list_pairs(there, 1.0))} | " + " | ".join(map(str, cells)) + " |"


def work(name: str, call: Call) -> str:
    """Kernels of a call, the time that they take on the device, and the time of the call."""
    wall = timed(call)
    with torch.profiler.profile(activities=[torch.profiler.ProfilerActivity.CUDA]) as profile:
        call()
        torch.cuda.synchronize()
    events = [event for event in profile.events() if event.device_type == torch.autograd.DeviceType.CUDA]
    busy = sum(event.time_range.elapsed_us() for event in events) / 1e3
    return f"| {name} | {len(events)} | {busy:.3f} | {wall} |"


def bounds(drawings: int) -> Iterator[str]:
    scene = on_device(random_drawing(100, 512, drawings=drawings), "cuda")
    calls = {
        "step": step_of(scene, coverage_loss_and_gradients),
        "step by autograd": step_of(scene, match_with_torch),
        "list of pairs": lambda: list_pairs(scene, 1.0),
    }
    yield f"\n## What bounds it, 512 px, 100 strokes, {drawings} drawings\n"
    yield "| call | kernels and copies | ms busy | ms for the call |\n|---|---|---|---|"
    for name, call in calls.items():
        yield work(name, call)


def fits(name: str, ink: Ink, strokes: Strokes) -> Iterator[str]:
    """The whole fit on both devices, from the same start."""
    settings = Config().fit
    for device in ("cuda", "cpu"):
        render = RenderSettings(device=device)
        fit(ink, strokes, replace(settings, steps=12, joint_steps=12), render)
        begin = time.perf_counter()
        found = fit(ink, strokes, settings, render)
        seconds = time.perf_counter() - begin
        figures = f"{len(strokes)} | {device} | {seconds:.2f} | {np.median(found.psnr):.1f}"
        yield f"| {name} | {ink.drawing_count} | {figures} |"


def starts(clip: Path) -> Iterator[tuple[str, Ink, Strokes]]:
    """What the fits start from: a clip's strokes as they were propagated, and those of its first drawing as traced."""
    config = Config()
    ink = extract_ink(decode(clip), config.ink)
    first = initialise(ink, 0, config.initialise)
    yield f"{clip.name}, first drawing", ink.at_drawing(0), first
    trace = partial(initialise, settings=config.initialise)
    yield clip.name, ink, propagate(ink, first, config.propagate, trace).strokes


def memory(drawings: int, height: int, width: int) -> str:
    scene = random_drawing(100, min(height, width), drawings=drawings)
    scene = on_device(replace(scene, size=(drawings, height, width)), "cuda")
    torch.cuda.reset_peak_memory_stats()
    call = step_of(scene, coverage_loss_and_gradients)
    for _ in range(3):
        call()
    return f"| {drawings} | {width} x {height} | {torch.cuda.max_memory_allocated() / 2**20:.0f} |"


def report(sample: Path) -> Iterator[str]:
    yield f"# The renderer on a GPU\n\n`python benchmarks/render_cuda.py`; {machine()}"
    yield "\n## ms, median (quartiles)\n"
    scenes = {f"{n} px, 100 strokes": random_drawing(100, n) for n in (256, 512, 1024, 2048)}
    scenes |= {f"512 px, {n} strokes": random_drawing(n, 512) for n in (10, 500, 2000)}
    scenes |= {f"512 px, 100 strokes, {n} drawings": random_drawing(100, 512, drawings=n) for n in (10, 100)}
    yield from table(scenes)
    yield from bounds(1)
    yield from bounds(100)
    yield "\n## Most memory of three steps and a list. MB\n\n| drawings | page | MB |\n|---|---|---|"
    for case in ((100, 512, 512), (20, 1080, 1920), (100, 1080, 1920)):
        yield memory(*case)
    yield "\n## Fits\n\n| | drawings | strokes | device | s | median PSNR dB |\n|---|---|---|---|---|---|"
    for start in starts(sample):
        yield from fits(*start)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--sample", type=Path, default=Path("samples/robot.mp4"), help="clip for the fits")
    parser.add_argument("--out", type=Path, help="Markdown file to write beside printing")
    arguments = parser.parse_args()
    configure_threads(1)
    write_report(report(arguments.sample), arguments.out)


if __name__ == "__main__":
    main()
