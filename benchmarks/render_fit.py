"""What each renderer can reach: its ceiling at true geometry, a fit from near the truth, and one from random strokes.

    python benchmarks/render_fit.py [--tiny] [--drawing DIR/w3_256.png] [--out benchmarks/render_fit.md]

Truth is the exact area that strokes cover (8 x 8 samples a pixel). All renderers are driven by the same small Adam loop
here, without the initialisation and the edits of the real fit. The random start is the experiment of the supplement's
Figures 6 and 7: strokes everywhere, none of them near a line. Its pictures are written beside the table.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from pathlib import Path

import imageio.v3 as iio
import numpy as np
import torch
from drawings import exact_raster, random_drawing
from numpy.typing import NDArray
from timing import machine, write_report
from torch import Tensor

from videovec.render import Scene, coverage_loss_and_gradients, list_pairs, render_image
from videovec.render.fused import match_with_torch
from videovec.render.pairs import PairList
from videovec.render.splats import draw_splats, place_splats
from videovec.threads import configure_threads, wait_passively

REBUILD = 10
"""Steps of a fit that share a list of pairs."""
SPACING = 1.0
"""Distance between the splats of a fit. px"""

Gradients = tuple[Tensor, Tensor, Tensor]
"""By control points, half-widths and opacities."""


@dataclass(slots=True)
class PairRenderer:
    """The closed form over a list of pairs that is rebuilt as the strokes move."""

    match: Callable[..., object]
    pairs: PairList | None = None

    def gradients(self, scene: Scene, target: Tensor, step: int, scale: float) -> Gradients:
        """Of the squared residual of one step."""
        if step % REBUILD == 0 or self.pairs is None:
            self.pairs = list_pairs(scene, scale)
        found = self.match(scene, self.pairs, scale, target)
        return found.control, found.half_width, found.opacity  # type: ignore[attr-defined]


@dataclass(slots=True)
class SplatRenderer:
    """Sampled Gaussians, dense."""

    def gradients(self, scene: Scene, target: Tensor, step: int, scale: float) -> Gradients:
        """Of the squared residual of one step; splats have no scale."""
        leaves = [v.clone().requires_grad_() for v in (scene.control, scene.half_width, scene.opacity)]
        free = replace(scene, control=leaves[0], half_width=leaves[1], opacity=leaves[2])
        image = draw_splats(place_splats(free, SPACING), scene.size[1:], torch.zeros(1))[..., 0]
        by = torch.autograd.grad((image - target[0] / 255).square().sum(), leaves)
        return by[0], by[1], by[2]


@dataclass(frozen=True, slots=True)
class Course:
    """A fit: seconds and PSNR at some steps, and where it ended."""

    steps: list[int]
    seconds: list[float]
    psnr: list[float]
    scene: Scene


def picture(scene: Scene, is_splats: bool) -> NDArray[np.float32]:
    """The coverage that a renderer draws. [H, W]"""
    if is_splats:
        return np.asarray(draw_splats(place_splats(scene, SPACING), scene.size[1:], torch.zeros(1))[..., 0])
    return np.asarray(render_image(scene, torch.zeros(1))[0, ..., 0])


def decibels(image: NDArray[np.float32], truth: NDArray[np.float32]) -> float:
    return float(-10 * np.log10(np.square(image.astype(float) - truth).mean()))


def fit(
    scene: Scene, truth: NDArray[np.float32], renderer: PairRenderer | SplatRenderer, steps: int, coarsest: float
) -> Course:
    """Adam on control points, half-widths and opacities; the kernel's scale falls to 1 over the first third."""
    target = torch.from_numpy(np.rint(truth * 255).astype(np.uint8))[None]
    points, logs = scene.control.clone(), scene.half_width.log()
    logits = torch.logit(scene.opacity.clamp(0.02, 0.98))
    adam = torch.optim.Adam(
        [{"params": [points], "lr": 0.3}, {"params": [logs], "lr": 0.03}, {"params": [logits], "lr": 0.05}]
    )
    course = Course([], [], [], scene)
    spent = 0.0
    for step in range(steps + 1):
        present = replace(scene, control=points.detach(), half_width=logs.exp(), opacity=logits.sigmoid())
        if step in (0, steps) or (step & (step - 1)) == 0:
            course.steps.append(step)
            course.seconds.append(spent)
            course.psnr.append(decibels(picture(present, isinstance(renderer, SplatRenderer)), truth))
        begin = time.process_time()
        scale = coarsest ** max(0.0, 1 - 3 * (step - step % REBUILD) / steps)
        by_points, by_width, by_opacity = renderer.gradients(present, target, step, scale)
        points.grad, logs.grad = by_points, by_width * present.half_width
        logits.grad = by_opacity * present.opacity * (1 - present.opacity)
        adam.step()
        spent += time.process_time() - begin
    return replace(course, scene=present)


def ceilings(side: int, strokes: int) -> Iterator[str]:
    yield f"\n## Ceiling: true geometry against exact coverage, {strokes} strokes, {side} px. dB\n"
    yield "| width px | closed form | splats 1 px | splats 0.5 px | splats 0.25 px |\n|---|---|---|---|---|"
    for width in (0.512, 1.5, 3.0, 6.0):
        scene = random_drawing(strokes, side, width)
        truth = exact_raster(scene)
        cells = [decibels(picture(scene, False), truth)]
        for spacing in (1.0, 0.5, 0.25):
            image = draw_splats(place_splats(scene, spacing), scene.size[1:], torch.zeros(1))[..., 0]
            cells.append(decibels(np.asarray(image), truth))
        yield f"| {width} | " + " | ".join(f"{cell:.1f}" for cell in cells) + " |"


def courses(start: Scene, truth: NDArray[np.float32], steps: dict[str, int], coarsest: float) -> dict[str, Course]:
    renderers: dict[str, PairRenderer | SplatRenderer] = {
        "numba": PairRenderer(coverage_loss_and_gradients),
        "torch": PairRenderer(match_with_torch),
        "splats in torch, 1 px": SplatRenderer(),
    }
    return {name: fit(start, truth, renderers[name], count, coarsest) for name, count in steps.items()}


def tell(title: str, found: dict[str, Course], truth: NDArray[np.float32]) -> Iterator[str]:
    yield f"\n## {title}\n"
    yield "| renderer | steps | CPU s | PSNR dB, as drawn by itself | its strokes drawn by the closed form |"
    yield "|---|---|---|---|---|"
    for name, course in found.items():
        for row in sorted({len(course.steps) // 2, len(course.steps) - 2, len(course.steps) - 1}):
            last = f"{decibels(picture(course.scene, False), truth):.1f}" if row == len(course.steps) - 1 else ""
            yield f"| {name} | {course.steps[row]} | {course.seconds[row]:.2f} | {course.psnr[row]:.1f} | {last} |"


def nearby(side: int, strokes: int, steps: int) -> Iterator[str]:
    truth_scene = random_drawing(strokes, side)
    truth = exact_raster(truth_scene)
    noise = torch.randn(truth_scene.control.shape, generator=torch.Generator().manual_seed(0))
    start = replace(truth_scene, control=truth_scene.control + noise)
    counts = {"numba": steps, "torch": steps, "splats in torch, 1 px": steps}
    title = f"{steps} steps from the truth + N(0, 1 px), {strokes} strokes of 3 px, {side} px"
    yield from tell(title, courses(start, truth, counts, 4.0), truth)


def from_random(truth: NDArray[np.float32], strokes: int, steps: int, folder: Path | None) -> Iterator[str]:
    side = truth.shape[0]
    rng = torch.Generator().manual_seed(0)
    begin = torch.rand(strokes, 1, 2, generator=rng) * side
    control = begin + (torch.rand(strokes, 4, 2, generator=rng) - 0.5) * side / 12
    start = Scene(
        control=control,
        half_width=torch.full((strokes, 2), 1.0),
        interval=torch.tensor([[0.0, 1.0]]).repeat(strokes, 1),
        row=torch.arange(strokes),
        opacity=torch.full((strokes,), 0.5),
        color=torch.ones(strokes, 1),
        drawing=torch.zeros(strokes, dtype=torch.long),
        size=(1, side, side),
    )
    found = courses(start, truth, {"numba": steps, "splats in torch, 1 px": steps}, 4.0)
    yield from tell(f"{steps} steps from {strokes} random strokes, {side} px", found, truth)
    if folder:
        images = [truth, *(picture(course.scene, name.startswith("splats")) for name, course in found.items())]
        page = np.rint(255 * (1 - np.clip(np.concatenate(images, axis=1), 0, 1))).astype(np.uint8)
        iio.imwrite(folder / "render_fit_random.png", page)
        yield "\n![drawing, closed form, splats](render_fit_random.png)\n\nThe drawing, the closed form, the splats."


def report(tiny: bool, drawing: Path | None, folder: Path | None) -> Iterator[str]:
    yield f"# What the renderers reach\n\n`python benchmarks/render_fit.py`; {machine()}"
    side, strokes, steps = (48, 3, 8) if tiny else (256, 60, 200)
    yield from ceilings(side if tiny else 512, strokes if tiny else 100)
    yield from nearby(side, strokes, steps)
    truth = exact_raster(random_drawing(strokes, side))
    if drawing:
        truth = 1 - iio.imread(drawing, mode="L").astype(np.float32) / np.float32(255)
    yield from from_random(truth, 16 if tiny else 1024, steps, folder)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--tiny", action="store_true", help="seconds instead of minutes; the figures mean nothing")
    parser.add_argument("--drawing", type=Path, help="square drawing, black on white, for the random start")
    parser.add_argument("--out", type=Path, help="Markdown file to write beside printing")
    arguments = parser.parse_args()
    configure_threads(1)
    folder = arguments.out.parent if arguments.out else None
    write_report(report(arguments.tiny, arguments.drawing, folder), arguments.out)


if __name__ == "__main__":
    wait_passively()
    main()
