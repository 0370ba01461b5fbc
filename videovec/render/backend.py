"""Which renderer draws, on which device, and why."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import torch

from videovec.errors import ConfigError
from videovec.progress import Progress
from videovec.render.scene import Scene
from videovec.settings import RenderSettings
from videovec.threads import configure_threads, thread_count

__all__ = ["BACKENDS", "Backend", "BackendReport", "describe_backend", "prepare_backend", "resolve_backend"]

BACKENDS = ("numba", "torch", "reference")


@dataclass(frozen=True, slots=True)
class Backend:
    """A renderer and where its tensors live.

    Args:
        name: numba, torch or reference.
        device: Where scenes must lie.
    """

    name: str
    device: torch.device


@dataclass(frozen=True, slots=True)
class BackendReport:
    """What draws here, and why.

    Args:
        backend: What was chosen.
        threads: Drawings that are rendered at once.
        cuda: The GPU, or why there is none.
        cache: Where machine code is kept; None where it cannot be kept, so that every run compiles.
        is_compiled: Whether an earlier run left machine code.
        versions: Of torch and numba.
    """

    backend: Backend
    threads: int
    cuda: str
    cache: Path | None
    is_compiled: bool
    versions: tuple[str, str]


def resolve_backend(settings: RenderSettings) -> Backend:
    """Choose what is not told: the GPU where there is one, numba on the CPU, torch elsewhere.

    Raises:
        ConfigError: There is no such back end or device, or one cannot run on the other.
    """
    if settings.backend not in ("auto", *BACKENDS):
        raise ConfigError(f"render.backend must be auto, {', '.join(BACKENDS)}, got {settings.backend!r}")
    device = _resolve_device(settings)
    name = settings.backend
    if name == "auto":
        name = "numba" if device.type == "cpu" else "torch"
    if name == "numba" and device.type != "cpu":
        raise ConfigError(f"render.backend numba runs on the cpu, got render.device {settings.device!r}")
    return Backend(name, device)


def describe_backend(settings: RenderSettings) -> BackendReport:
    """Say what `resolve_backend` chooses and what it rests on; loads numba."""
    import numba

    from videovec.compiling import cache_folder, is_compiled

    package = Path(__file__).parent
    return BackendReport(
        backend=resolve_backend(settings),
        threads=thread_count(),
        cuda=_cuda_state(),
        cache=cache_folder(package),
        is_compiled=is_compiled(package),
        versions=(torch.__version__, numba.__version__),
    )


def prepare_backend(backend: Backend, progress: Progress) -> None:
    """Make ready for a fit: on the CPU compile what it calls, and say so, unless an earlier run has done it.

    There torch gets one thread: drawings are what runs in parallel, and torch's threads would wait for each other.
    """
    if backend.name != "numba":
        return
    configure_threads()
    from videovec.compiling import is_compiled
    from videovec.render.fused import coverage_loss_and_gradients
    from videovec.render.listing import list_pairs

    if is_compiled(Path(__file__).parent):
        return
    progress.note("compiling for this machine, once; up to a minute")
    line = torch.tensor([[[4.0, 8.0], [6.0, 8.0], [10.0, 8.0], [12.0, 8.0]]])
    one, two = torch.ones(1), torch.ones(1, 2)
    origin = torch.zeros(1, dtype=torch.long)
    interval = torch.tensor([[0.0, 1.0]])
    scene = Scene(line, two, interval, origin, one, torch.zeros(1, 0), origin, (1, 16, 16))
    coverage_loss_and_gradients(scene, list_pairs(scene, 1.0), 1.0, torch.zeros(1, 16, 16, dtype=torch.uint8))


def _cuda_state() -> str:
    if torch.cuda.is_available():
        from videovec.render.fused import has_triton

        kernels = "kernels by Triton" if has_triton() else "no Triton: its steps take 20 times as long"
        return f"{torch.cuda.get_device_name(0)}, {kernels}"
    if torch.version.cuda is None:
        return "none: this torch is built for the CPU"
    return "none: torch finds no CUDA device, or no driver for it"


def _resolve_device(settings: RenderSettings) -> torch.device:
    if settings.device == "auto":
        wants_cpu = settings.backend == "numba" or not torch.cuda.is_available()
        return torch.device("cpu" if wants_cpu else "cuda")
    try:
        device = torch.device(settings.device)
    except RuntimeError as error:
        raise ConfigError(f"render.device must be auto or a torch device, got {settings.device!r}") from error
    if device.type == "cuda" and not torch.cuda.is_available():
        raise ConfigError(f"render.device must be available, got {settings.device!r}: torch finds no CUDA device")
    return device
