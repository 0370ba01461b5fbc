"""Compiled functions and where their machine code is kept between runs.

Numba recompiles a function when its own file changes, but not when a file changes that it calls into. The cache's name
therefore carries a digest of all sources of the function's package: code that changed never meets machine code that did
not.

Functions are put into those that call them. Else the machine code of every caller holds a copy, a little different in
each, and whichever is met first stands in for all: sums would come out otherwise, in their last bits, in the run that
compiles than in those that find the code in the cache.
"""

from __future__ import annotations

import hashlib
import os
import sys
import tempfile
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import cache
from pathlib import Path
from typing import Any, ParamSpec, TypeVar

import numba

__all__ = ["cache_folder", "compiled", "is_compiled"]

P = ParamSpec("P")
R = TypeVar("R")


def compiled(*, fastmath: bool = False, inline: bool = False) -> Callable[[Callable[P, R]], Callable[P, R]]:
    """Compile a function at its first call, or load it from the cache; no cache where none can be written.

    Args:
        fastmath: Reorder sums and divide by multiplying; such loops fit vector registers.
        inline: Put the function's body where it is called.
    """

    def compile_lazily(function: Callable[P, R]) -> Callable[P, R]:
        folder = cache_folder(Path(function.__code__.co_filename).parent)
        with _caching_in(folder):
            return numba.njit(
                cache=folder is not None,
                nogil=True,
                error_model="numpy",
                fastmath=fastmath,
                forceinline=True,
                inline="always" if inline else "never",
            )(function)

    return compile_lazily


@cache
def cache_folder(package: Path) -> Path | None:
    """Where the machine code of a package is kept, or None where nothing can be written.

    Below ``NUMBA_CACHE_DIR`` if it is set, else the user's cache folder, else the folder for temporary files.

    Args:
        package: Folder of the package's sources.
    """
    sources = sorted(package.glob("*.py"))
    digest = hashlib.sha256(b"".join(source.read_bytes() for source in sources)).hexdigest()[:12]
    roots = [Path(os.environ["NUMBA_CACHE_DIR"])] if os.environ.get("NUMBA_CACHE_DIR") else [_user_cache()]
    for root in [*roots, Path(tempfile.gettempdir())]:
        folder = root / "videovec" / f"{package.name}-{digest}"
        try:
            folder.mkdir(parents=True, exist_ok=True)
            with tempfile.TemporaryFile(dir=folder):
                return folder
        except OSError:
            continue
    return None


def is_compiled(package: Path) -> bool:
    """Whether an earlier run left machine code of a package, so that nothing has to be compiled."""
    folder = cache_folder(package)
    return folder is not None and any(folder.rglob("*.nbc"))


def _user_cache() -> Path:
    if sys.platform == "win32":
        return Path(os.environ.get("LOCALAPPDATA", Path.home() / "AppData" / "Local"))
    if sys.platform == "darwin":
        return Path.home() / "Library" / "Caches"
    return Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache")


@contextmanager
def _caching_in(folder: Path | None) -> Iterator[None]:
    config: Any = numba.config
    before, config.CACHE_DIR = config.CACHE_DIR, str(folder or "")
    try:
        yield
    finally:
        config.CACHE_DIR = before
