"""From scenes to values of pixels, by any back end."""

from __future__ import annotations

from torch import Tensor

from videovec.errors import FitError
from videovec.render.backend import BACKENDS
from videovec.render.listing import list_pairs
from videovec.render.pairs import PairList
from videovec.render.scene import Scene

__all__ = ["composite", "render_image"]


def composite(scene: Scene, pairs: PairList, scale: float, backend: str = "auto") -> tuple[Tensor, Tensor]:
    """Composite the rows on every active pixel, "over", in their order.

    The pixel over a page is ``color + (1 - coverage) * page``. Differentiable by control points, half-widths, visible
    intervals, opacity and colour. Where the coverage is all that counts, give the scene colours [R, 0].

    Args:
        scene: The strokes.
        pairs: Its pair list, whose ``t`` is improved in place.
        scale: Width of the kernel in pixels.
        backend: auto (numba on the CPU, torch elsewhere), numba, torch or reference.

    Returns:
        Premultiplied colour [A, C] and coverage [A] of the active pixels.
    """
    name = _choose(backend, scene)
    if name == "reference":
        from videovec.render.reference import composite_dense

        return composite_dense(scene, pairs.chunks, pairs.active, scale)
    if name == "numba":
        from videovec.render.numba_composite import composite_pairs
    else:
        from videovec.render.torch_backend import composite_pairs
    return composite_pairs(scene, pairs, scale)


def render_image(scene: Scene, page: Tensor, scale: float = 1.0, backend: str = "auto") -> Tensor:
    """Draw every page whole.

    Args:
        scene: The strokes.
        page: Colour of the page. [C]
        scale: Width of the kernel in pixels.
        backend: auto, numba, torch or reference.

    Returns:
        The drawings. [D, H, W, C]
    """
    pairs = list_pairs(scene, scale)
    color, coverage = composite(scene, pairs, scale, backend)
    drawings, height, width = scene.size
    blank = page.to(color).expand(drawings * height * width, -1)
    values = color + (1 - coverage)[:, None] * page.to(color)
    return blank.index_put((pairs.active,), values).reshape(drawings, height, width, -1)


def _choose(backend: str, scene: Scene) -> str:
    on_cpu = scene.control.device.type == "cpu"
    name = ("numba" if on_cpu else "torch") if backend == "auto" else backend
    if name not in BACKENDS or (name == "numba" and not on_cpu):
        raise FitError(
            f"backend must be one of {BACKENDS} and numba on the CPU, got {backend!r} on {scene.control.device}"
        )
    return name
