"""Which renderer draws, on which device, and why."""

from __future__ import annotations

from dataclasses import dataclass

import torch

from videovec.errors import ConfigError
from videovec.settings import RenderSettings

__all__ = ["BACKENDS", "Backend", "resolve_backend"]

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
