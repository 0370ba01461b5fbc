"""How many threads work, and that those that wait do not spin.

The environment variable ``VIDEOVEC_THREADS`` is the one setting. Threads are plain ones, a range of drawings to each,
in compiled code that releases the interpreter's lock; where one thread works they cost nothing.
"""

from __future__ import annotations

import os
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from functools import cache
from itertools import pairwise

__all__ = ["configure_threads", "over_ranges", "thread_count", "wait_passively"]

VARIABLE = "VIDEOVEC_THREADS"
RANGES_PER_THREAD = 4
"""Drawings differ in ink: more ranges than threads even out."""


def wait_passively() -> None:
    """Let idle OpenMP threads sleep instead of spin; works only before torch is imported.

    On a busy machine of two cores, spinning made a loop of small operations twenty times slower.
    """
    os.environ.setdefault("OMP_WAIT_POLICY", "passive")
    os.environ.setdefault("KMP_BLOCKTIME", "0")


def configure_threads(count: int | None = None) -> int:
    """Let drawings be rendered by ``count`` threads, or one for each core that the process may use.

    torch itself gets one thread on the CPU: what it does there is small, and drawings are what runs in parallel.

    Returns:
        The count.
    """
    import torch

    if count:
        os.environ[VARIABLE] = str(count)
    torch.set_num_threads(1)
    return thread_count()


def over_ranges(work: Callable[[tuple[int, int]], None], count: int) -> None:
    """Call ``work((first, end))`` for ranges that together make up 0 .. count, in threads where there are several.

    Args:
        work: Must release the interpreter's lock to gain anything, and write to places of its own range alone.
        count: Number of things, such as drawings.
    """
    threads = min(thread_count(), count)
    if threads <= 1:
        work((0, count))
        return
    parts = min(count, threads * RANGES_PER_THREAD)
    bounds = [count * part // parts for part in range(parts + 1)]
    list(_pool(threads).map(work, pairwise(bounds)))


def thread_count() -> int:
    """How many drawings are rendered at once: ``VIDEOVEC_THREADS``, or the cores that the process may use."""
    told = os.environ.get(VARIABLE, "")
    if told.isdigit() and int(told) > 0:
        return int(told)
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


@cache
def _pool(threads: int) -> ThreadPoolExecutor:
    return ThreadPoolExecutor(threads, thread_name_prefix="videovec")
