"""Forward and backward of every renderer: by page, strokes, drawings and threads; memory; the bars.

    python benchmarks/render_speed.py [--tiny] [--out benchmarks/render_speed.md]

The loss is the squared residual against an empty page; a step is forward, residual and backward to all leaves, without
the list of pairs unless said. DiffVG is measured where ``pydiffvg`` can be imported.
"""

from __future__ import annotations

import argparse
import importlib.util
import os
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path

import torch
from drawings import on_page, random_drawing
from timing import Timing, interleaved, machine, write_report

from videovec.render import Scene, coverage_loss_and_gradients, list_pairs
from videovec.render.fused import match_with_torch
from videovec.render.splats import draw_splats, place_splats
from videovec.threads import configure_threads, wait_passively

FLOPS_PER_PAIR, BYTES_PER_PAIR = 240, 92
"""Work of forward, compositing and backward, counted from the formulas."""
FLOPS, BYTES = 60e9, 40e9
"""What one core of a present server sustains in such code, per second."""
STEPS_PER_LIST = 10
"""Steps of a fit that share a list of pairs."""

Call = Callable[[], object]


def numba_step(scene: Scene) -> Call:
    pairs, target = list_pairs(scene, 1.0), torch.zeros(scene.size, dtype=torch.uint8)
    return lambda: coverage_loss_and_gradients(scene, pairs, 1.0, target)


def torch_step(scene: Scene) -> Call:
    pairs, target = list_pairs(scene, 1.0), torch.zeros(scene.size, dtype=torch.uint8)
    return lambda: match_with_torch(scene, pairs, 1.0, target)


def splats_step(scene: Scene, spacing: float) -> Call:
    control = scene.control.clone().requires_grad_()
    free = Scene(
        control, scene.half_width, scene.interval, scene.row, scene.opacity, scene.color, scene.drawing, scene.size
    )

    def step() -> object:
        image = draw_splats(place_splats(free, spacing), scene.size[1:], torch.zeros(1))
        return torch.autograd.grad(image.square().sum(), control)

    return step


def diffvg_step(scene: Scene) -> Call:
    import pydiffvg  # type: ignore[import-not-found]

    side, points = scene.size[1], [c.clone().requires_grad_() for c in scene.control]
    paths = [
        pydiffvg.Path(torch.tensor([2]), p, is_closed=False, stroke_width=torch.tensor(float(w[0])))
        for p, w in zip(points, scene.half_width, strict=True)
    ]
    ink = [pydiffvg.ShapeGroup(torch.tensor([n]), None, stroke_color=torch.ones(4)) for n in range(len(paths))]

    def step() -> object:
        arguments = pydiffvg.RenderFunction.serialize_scene(side, side, paths, ink)
        image = pydiffvg.RenderFunction.apply(side, side, 2, 2, 0, None, *arguments)
        return torch.autograd.grad(image[..., 3].square().sum(), points)

    return step


def back_ends(side: int, strokes: int, repeats: int) -> Iterator[str]:
    scene = random_drawing(strokes, side)
    calls = {
        "numba": numba_step(scene),
        "numba, list of pairs": lambda: list_pairs(scene, 1.0),
        "torch": torch_step(scene),
        "splats in torch, 1 px": splats_step(scene, 1.0),
        "splats in torch, 0.5 px": splats_step(scene, 0.5),
        "splats in torch, 0.25 px": splats_step(scene, 0.25),
    }
    if importlib.util.find_spec("pydiffvg"):
        calls["DiffVG, 2 x 2 samples"] = diffvg_step(scene)
    found = interleaved(calls, repeats)
    pairs = len(list_pairs(scene, 1.0))
    floor = 1e3 * pairs * max(FLOPS_PER_PAIR / FLOPS, BYTES_PER_PAIR / BYTES)
    yield f"\n## Back ends, {side} px, {strokes} strokes of 3 px, {pairs} pairs: ms for a step, median (quartiles)\n"
    yield "| renderer | ms | of numba |\n|---|---|---|"
    for name, timing in found.items():
        yield f"| {name} | {timing} | {timing.median / found['numba'].median:.1f} |"
    yield (
        f"\nRoofline of one core, {FLOPS_PER_PAIR} flop at {FLOPS / 1e9:.0f} GFLOP/s or {BYTES_PER_PAIR} B at "
        f"{BYTES / 1e9:.0f} GB/s for each listed pair: {floor:.2f} ms; numba takes "
        f"{found['numba'].median / floor:.1f} times as long (first quartile {found['numba'].low / floor:.1f})."
    )


def table(title: str, scenes: dict[str, Scene], repeats: int, unit: dict[str, float] | None = None) -> Iterator[str]:
    """Step and list of pairs of several scenes; of the first, per unit, the ratio."""
    calls: dict[str, Call] = {}
    for name, scene in scenes.items():
        calls[name] = numba_step(scene)
        calls[f"{name} list"] = partial(list_pairs, scene, 1.0)
    found = interleaved(calls, repeats)

    def whole(name: str) -> float:
        return (found[name].median + found[f"{name} list"].median / STEPS_PER_LIST) / (unit or {}).get(name, 1)

    first = next(iter(scenes))
    yield f"\n## {title}: ms, median (quartiles)\n"
    yield "| | pairs | step | list of pairs | step + list / 10, ratio |\n|---|---|---|---|---|"
    for name, scene in scenes.items():
        pairs = len(list_pairs(scene, 1.0))
        timings: tuple[Timing, Timing] = (found[name], found[f"{name} list"])
        yield f"| {name} | {pairs} | {timings[0]} | {timings[1]} | {whole(name) / whole(first):.2f} |"


def threads(drawings: int, side: int, repeats: int) -> Iterator[str]:
    scene = random_drawing(100, side, drawings=drawings)
    calls: dict[str, Call] = {}
    for count in (1, 2, 4):
        step = numba_step(scene)

        def run(step: Call = step, count: int = count) -> None:
            configure_threads(count)
            step()

        calls[f"{count}"] = run
    found = interleaved(calls, repeats, time.perf_counter)
    configure_threads(1)
    yield f"\n## Threads, {drawings} drawings of {side} px, 100 strokes each: ms for a step, wall time\n"
    yield "| threads | ms | speed-up |\n|---|---|---|"
    for name, timing in found.items():
        yield f"| {name} | {timing} | {found['1'].median / timing.median:.2f} |"


def peak_memory(drawings: int, height: int, width: int, strokes: int) -> None:
    """Print how far the peak of this process rises in three steps, with a list of pairs. MB"""
    numba_step(random_drawing(2, 64))()
    before = high_water()
    scene = random_drawing(strokes, min(height, width), drawings=drawings)
    scene = Scene(**{name: getattr(scene, name) for name in Scene.__slots__[:-1]}, size=(drawings, height, width))
    step = numba_step(scene)
    for _ in range(3):
        step()
    print(f"{high_water() - before:.0f} of {high_water():.0f}")


def high_water() -> float:
    """Most memory that this process ever had. MB; 0 where the system does not tell"""
    status = Path("/proc/self/status")
    lines = status.read_text(encoding="utf-8").splitlines() if status.exists() else []
    return sum(float(line.split()[1]) / 1024 for line in lines if line.startswith("VmHWM"))


def memory(cases: list[tuple[int, int, int, int]]) -> Iterator[str]:
    yield "\n## Memory: rise of the peak by pairs, target and three steps, of the whole process. MB\n"
    yield "| drawings | page | strokes each | MB |\n|---|---|---|---|"
    for drawings, height, width, strokes in cases:
        text = ",".join(map(str, (drawings, height, width, strokes)))
        command = [sys.executable, __file__, "--memory", text]
        done = subprocess.run(command, capture_output=True, text=True, check=True, env=os.environ)
        yield f"| {drawings} | {width} x {height} | {strokes} | {done.stdout.strip()} |"


def report(tiny: bool) -> Iterator[str]:
    side, repeats = (64, 3) if tiny else (512, 40)
    yield f"# Speed of the renderer\n\n`python benchmarks/render_speed.py`; {machine()}"
    yield from back_ends(side, 4 if tiny else 100, repeats)
    sizes = (32, 64) if tiny else (256, 512, 1024, 2048)
    yield from table("Page, 100 strokes that grow with it", {f"{n} px": random_drawing(100, n) for n in sizes}, repeats)
    counts = (2, 4) if tiny else (10, 100, 500, 2000)
    strokes = {f"{n} strokes": random_drawing(n, side) for n in counts}
    yield from table(f"Strokes, {side} px", strokes, repeats, {f"{n} strokes": float(n) for n in counts})
    drawing = random_drawing(4 if tiny else 100, side)
    pages = {f"{n} px": on_page(drawing, n) for n in (side, 2 * side)}
    yield from table("The same drawing on a page of four times the area", pages, repeats)
    numbers = (1, 2) if tiny else (1, 10, 100)
    clips = {f"{n} drawings": random_drawing(4 if tiny else 100, side, drawings=n) for n in numbers}
    yield from table(f"Drawings, {side} px", clips, repeats, {f"{n} drawings": float(n) for n in numbers})
    yield from threads(3 if tiny else 24, side, repeats)
    yield from memory(
        [(2, 64, 64, 4)] if tiny else [(100, 512, 512, 100), (20, 1080, 1920, 100), (100, 1080, 1920, 100)]
    )


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--tiny", action="store_true", help="seconds instead of minutes; the figures mean nothing")
    parser.add_argument("--out", type=Path, help="Markdown file to write beside printing")
    parser.add_argument("--memory", help=argparse.SUPPRESS)
    arguments = parser.parse_args()
    configure_threads(1)
    if arguments.memory:
        drawings, height, width, strokes = map(int, arguments.memory.split(","))
        peak_memory(drawings, height, width, strokes)
        return
    write_report(report(arguments.tiny), arguments.out)


if __name__ == "__main__":
    wait_passively()
    main()
