"""When frames are shown, in the ticks of a steady clock, as formats without time stamps need it."""

from __future__ import annotations

import math
from dataclasses import dataclass
from fractions import Fraction

import numpy as np
from numpy.typing import NDArray

from videovec.clip import Timeline

__all__ = ["TimeBase", "time_base"]

_FASTEST = 1000  # ticks per second; times that need a faster clock are rounded to it


@dataclass(frozen=True, slots=True, eq=False)
class TimeBase:
    """A steady clock and what it shows.

    Args:
        rate: Ticks per second.
        frame_ticks: When each of T frames begins, and when the last one ends. int [T+1]
        drawing_ticks: When each of D drawings begins, and when the last one ends. int [D+1]
        exposure: For how many frames each drawing stays. int [D]
    """

    rate: Fraction
    frame_ticks: NDArray[np.intp]
    drawing_ticks: NDArray[np.intp]
    exposure: NDArray[np.intp]


def time_base(timeline: Timeline) -> TimeBase:
    """The slowest clock that ticks at every frame: the frame rate itself where that is constant."""
    last = timeline.duration - timeline.times[-1]
    end = timeline.duration if last > 0 else timeline.times[-1] + 1 / timeline.frame_rate
    times = [*timeline.times, end]
    denominator = math.lcm(*(time.denominator for time in times))
    rate = Fraction(denominator, math.gcd(*(int(time * denominator) for time in times)))
    if rate > _FASTEST:
        rate = Fraction(_FASTEST)
    ticks = np.array([round(time * rate) for time in times], dtype=np.intp)
    first = timeline.first_frames()
    return TimeBase(
        rate=rate,
        frame_ticks=ticks,
        drawing_ticks=ticks[np.append(first, timeline.frame_count)],
        exposure=np.diff(np.append(first, timeline.frame_count)),
    )
