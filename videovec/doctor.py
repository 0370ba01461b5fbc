"""Whether this machine can do what videovec needs: one check for each thing, with what to do about it."""

from __future__ import annotations

import platform
import sys
import tempfile
from collections.abc import Callable
from dataclasses import dataclass
from importlib.metadata import PackageNotFoundError, version
from importlib.metadata import requires as requirements_of
from pathlib import Path

from videovec.config import preset_names
from videovec.settings import RenderSettings

__all__ = ["Finding", "examine", "library_versions"]

WANTED_DECODERS = ("h264", "hevc", "vp9", "av1", "gif", "apng", "libvpx-vp9")
"""What common clips are coded with; libvpx-vp9 alone keeps the transparency of webm."""


@dataclass(frozen=True, slots=True)
class Finding:
    """What one check found.

    Args:
        name: The thing looked at.
        state: What it is.
        advice: What to do; empty where all is well.
        is_fatal: Whether videovec cannot work like this.
    """

    name: str
    state: str
    advice: str = ""
    is_fatal: bool = False


def examine() -> tuple[Finding, ...]:
    """Look at everything; a check that fails unexpectedly is itself a finding."""
    return tuple(_guarded(check) for check in (_python, _libraries, _renderer, _decoders, _compiler, _presets, _disk))


def library_versions() -> dict[str, str]:
    """Version of videovec, of Python and of each library that it depends on; of those that are installed."""
    found = {"python": platform.python_version()}
    for name in ("videovec", *_required()):
        try:
            found[name] = version(name)
        except PackageNotFoundError:
            continue
    return found


def _required() -> tuple[str, ...]:
    """Names of the libraries that videovec cannot do without."""
    texts = [text for text in requirements_of("videovec") or () if "extra ==" not in text]
    return tuple(_name(text) for text in texts)


def _name(requirement: str) -> str:
    end = next((at for at, letter in enumerate(requirement) if letter in "<>=!~;[ ("), len(requirement))
    return requirement[:end]


def _guarded(check: Callable[[], Finding]) -> Finding:
    try:
        return check()
    except Exception as error:
        return Finding(check.__name__.strip("_"), f"{type(error).__name__}: {error}", "this check must not fail", True)


def _python() -> Finding:
    is_old = sys.version_info < (3, 11)
    return Finding("python", platform.python_version(), "videovec needs 3.11 or later" if is_old else "", is_old)


def _libraries() -> Finding:
    found = library_versions()
    missing = [name for name in _required() if name not in found]
    state = ", ".join(f"{name} {number}" for name, number in found.items() if name != "python")
    if missing:
        return Finding("libraries", state, f"pip install {' '.join(missing)}", True)
    return Finding("libraries", state)


def _renderer() -> Finding:
    from videovec.render import describe_backend

    report = describe_backend(RenderSettings())
    state = f"{report.backend.name} on {report.backend.device}, {report.threads} threads; cuda: {report.cuda}"
    return Finding("renderer", state)


def _decoders() -> Finding:
    from av.codec import codecs_available

    missing = [name for name in WANTED_DECODERS if name not in codecs_available]
    advice = f"clips coded with {', '.join(missing)} cannot be read in full" if missing else ""
    return Finding("decoders", ", ".join(name for name in WANTED_DECODERS if name not in missing), advice)


def _compiler() -> Finding:
    from videovec.render import describe_backend

    report = describe_backend(RenderSettings())
    if report.cache is None:
        advice = "every run compiles for about 20 s; set NUMBA_CACHE_DIR to a folder that can be written to"
        return Finding("compiler", "machine code cannot be kept", advice)
    when = "is ready" if report.is_compiled else "will be made by the first run, in up to a minute"
    return Finding("compiler", f"machine code {when}, in {report.cache}")


def _presets() -> Finding:
    names = preset_names()
    return Finding("presets", ", ".join(names), "" if names else "the installation lacks its presets", not names)


def _disk() -> Finding:
    folder = Path(tempfile.gettempdir())
    with tempfile.TemporaryFile(dir=folder):
        return Finding("temporary", f"{folder} is writable")
