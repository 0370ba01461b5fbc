"""How the benchmarks measure: interleaved repeats, median and quartiles, the machine beside every table.

Times are CPU times of this process unless said: a machine that others use too preempts long calls and spares short
ones, which no ratio of wall times survives.
"""

from __future__ import annotations

import os
import platform
import time
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from datetime import date
from pathlib import Path

import numba
import numpy as np
import torch

from videovec.threads import thread_count

ROW = 0.02
"""About how long the calls in a row take. s"""


@dataclass(frozen=True, slots=True)
class Timing:
    """Quartiles of the time that one call takes. ms"""

    median: float
    low: float
    high: float

    def __str__(self) -> str:
        return f"{self.median:.3g} ({self.low:.3g}-{self.high:.3g})"


def interleaved(
    calls: Mapping[str, Callable[[], object]], repeats: int, clock: Callable[[], float] = time.process_time
) -> dict[str, Timing]:
    """Time several calls in turn, so that what else the machine does falls on all of them.

    Short calls are made several times in a row, as a fit does; slow ones are repeated less.
    """
    seconds: dict[str, list[float]] = {name: [] for name in calls}
    rows = {name: _calls_in_a_row(call) for name, call in calls.items()}
    for turn in range(repeats):
        for name, call in calls.items():
            if turn >= 3 and sum(seconds[name]) * rows[name] > 4:
                continue
            begin = clock()
            for _ in range(rows[name]):
                call()
            seconds[name].append((clock() - begin) / rows[name])
    return {name: Timing(*(1e3 * np.quantile(taken, [0.5, 0.25, 0.75])).tolist()) for name, taken in seconds.items()}


def _calls_in_a_row(call: Callable[[], object]) -> int:
    call()  # compiles, fills caches
    begin = time.perf_counter()
    call()
    return int(np.clip(ROW / max(time.perf_counter() - begin, 1e-9), 1, 20))


def write_report(lines: Iterable[str], out: Path | None) -> None:
    """Print the lines of a report as they come, and write them to a file if one is named."""
    told = []
    for line in lines:
        print(line, flush=True)
        told.append(line)
    if out:
        out.write_text("\n".join(told) + "\n", encoding="utf-8")


def machine() -> str:
    """What the figures were measured on, in one line."""
    device = torch.cuda.get_device_name(0) if torch.cuda.is_available() else "no GPU"
    load = os.getloadavg()[0] if hasattr(os, "getloadavg") else float("nan")
    return (
        f"{date.today()}, {_processor()}, {os.cpu_count()} cores (load {load:.1f} when it began), {device}; "
        f"Python {platform.python_version()}, torch {torch.__version__}, numba {numba.__version__}; "
        f"{thread_count()} threads"
    )


def _processor() -> str:
    info = Path("/proc/cpuinfo")
    if info.exists():
        for line in info.read_text(encoding="utf-8").splitlines():
            if line.startswith("model name"):
                return line.split(":", 1)[1].strip()
    return platform.processor() or platform.machine()
