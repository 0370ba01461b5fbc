"""Which repeat makes the textures of all strokes one.

Arc lengths of traced strokes drift, and a long repeat explains more of anything than a short one: rigid alignments find
the best repeat near a candidate, but candidates are told apart by alignments that may drift.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from videovec.brush.align import align
from videovec.brush.drift import learn_texture
from videovec.brush.repeat import recurrence
from videovec.brush.strips import Strip

__all__ = ["find_repeat"]

Floats = NDArray[np.float64]

_SCAN_STEP = 0.005  # of the repeat; the evidence's peak is under 2 % wide
_SCAN_REACH = 6  # steps to either side of a candidate
_CANDIDATES = 4
_NEARLY = 0.95  # of the best evidence that a shorter repeat needs


def find_repeat(strips: list[Strip], shortest: float, longest: float, most: int = 14) -> float:
    """The repeat at which the strokes' textures are one.

    Candidates are the distances at which grain comes back along a stroke, and repeats within a few percent of them:
    arc lengths of traced strokes are wrong by as much. Where no stroke shows a repeat twice, all are candidates.

    Args:
        strips: S strips.
        shortest: Shortest repeat. Widths
        longest: Longest repeat. Widths
        most: How many of the strips, the longest ones, are looked at.

    Returns:
        The shortest repeat whose peak of evidence is within 5 % of the best. Widths
    """
    longest_first = sorted(strips, key=lambda strip: -float(strip.weight.sum()))[:most]
    longest_first = [_coarser(strip) for strip in longest_first]
    peaks = np.sort(recurrence(longest_first, shortest, longest).peaks(_CANDIDATES))
    if not len(peaks):
        return _best_rigid(longest_first, _all_repeats(shortest, longest))
    around = 1 + _SCAN_STEP * np.arange(-_SCAN_REACH, _SCAN_REACH + 1)
    found = [(float(peak), _best_rigid(longest_first, peak * around)) for peak in peaks]
    scores = np.array([[learn_texture(longest_first, one, rounds=1).score for one in both] for both in found])
    chosen = _first_good(scores.max(axis=1))
    return found[chosen][int(np.argmax(scores[chosen]))]


def _best_rigid(strips: list[Strip], repeats: Floats) -> float:
    """The first of ascending repeats at a peak of rigid evidence that is nearly the best. Widths"""
    scores = np.array([align(strips, float(one), sweeps=3).score for one in repeats])
    good = _first_good(scores)
    while good + 1 < len(scores) and scores[good + 1] > scores[good]:
        good += 1
    return float(repeats[good])


def _first_good(scores: Floats) -> int:
    """The first of some scores that is nearly the best, which may be less than nothing."""
    best = float(scores.max())
    return int(np.flatnonzero(scores >= min(_NEARLY * best, best))[0])


def _all_repeats(shortest: float, longest: float) -> Floats:
    """Repeats in steps of half a percent. Widths"""
    count = max(int(np.log(longest / shortest) / np.log1p(_SCAN_STEP)), 1)
    return np.asarray(shortest * (1 + _SCAN_STEP) ** np.arange(count, dtype=np.float64))


def _coarser(strip: Strip) -> Strip:
    """The strip with half as many texels across."""
    halves = (len(strip.grain), strip.grain.shape[1] // 2, 2)
    weight = strip.weight[:, : 2 * halves[1]].reshape(halves)
    grain = (strip.grain[:, : 2 * halves[1]].reshape(halves) * weight).sum(2)
    return replace(strip, grain=grain / np.maximum(weight.sum(2), 1e-9), weight=weight.sum(2))
