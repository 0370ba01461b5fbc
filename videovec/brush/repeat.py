"""At which distances the grain of strokes comes back: what the repeat of a brush is looked for by.

A short window of one stroke is found again wherever the brush was laid with the same part of its texture: once in
every repeat of every other stroke. Within a few widths the arc length of a traced curve is right to a texel, however
wrong it is along the whole stroke, so windows are matched one by one, against all strokes in both directions; how far
apart the places are that one window matches on one stroke tells the repeat.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import gaussian_filter1d, maximum_filter1d

from videovec.brush.strips import TEXELS_PER_WIDTH, Strip

__all__ = ["Recurrence", "recurrence"]

Floats = NDArray[np.float64]
Spectra = NDArray[np.complex128]

_WINDOW = 4.0  # widths that are matched at once
_MOST_WINDOWS = 120
_MOST_STROKES = 16
_SEEN = 0.5  # share of a window that must hold ink of this stroke alone
_STANDS_OUT = 2.0  # standard deviations of all correlations above which one is a match
_TOLERANCE = 2.0  # texels that a match may be off
_APART = 1.0  # widths between two peaks
_STEADY = 0.3  # of the matches that chance makes where there are most pairs, counted as seen everywhere


@dataclass(frozen=True, slots=True, eq=False)
class Recurrence:
    """How often what was matched once is matched again further along the same stroke.

    Args:
        distance: How much further. [K] widths
        score: Against chance, which is 1. [K]
    """

    distance: Floats
    score: Floats

    def peaks(self, count: int) -> Floats:
        """Distances at which the score is highest, the highest first. Widths"""
        reach = 2 * round(_APART * TEXELS_PER_WIDTH) + 1
        is_peak = (self.score > 1) & (self.score == maximum_filter1d(self.score, reach, mode="constant"))
        found = np.flatnonzero(is_peak)
        return self.distance[found[np.argsort(-self.score[found], kind="stable")][:count]]


@dataclass(frozen=True, slots=True, eq=False)
class _Spectra:
    """Transforms along the stroke of grain, of its square, and of the weight. [N, V] each"""

    grain: Spectra
    square: Spectra
    weight: Spectra

    @staticmethod
    def of(strip: Strip, size: int) -> _Spectra:
        grain = strip.grain * strip.weight
        parts = (grain, grain * strip.grain, strip.weight)
        return _Spectra(*(np.fft.rfft(part, size, axis=0) for part in parts))


def recurrence(strips: list[Strip], shortest: float, longest: float) -> Recurrence:
    """Match windows of the longest strokes, and see at which distances matches come again.

    Args:
        strips: S strips.
        shortest: Least distance of interest. Widths
        longest: Greatest distance of interest. Widths

    Returns:
        Scores of all distances between, a texel apart; none where no stroke is long enough.
    """
    window = round(_WINDOW * TEXELS_PER_WIDTH)
    lags = np.arange(round(shortest * TEXELS_PER_WIDTH), round(longest * TEXELS_PER_WIDTH) + 1)
    kept = sorted(strips, key=lambda strip: -float(strip.weight.sum()))[:_MOST_STROKES]
    kept = [strip for strip in kept if len(strip.grain) >= window + lags[0]]
    found, chance = np.zeros(lags[-1] + 1), np.zeros(lags[-1] + 1)
    windows = list(_windows(kept, window))
    for strip in kept:
        matches = _matches(strip, windows)
        places = matches.shape[1]
        size = _fast(2 * places)
        spectrum = np.fft.rfft(matches, size, axis=1)
        again = np.fft.irfft((spectrum * spectrum.conj()).sum(0), size)
        reach = min(len(found), places)
        found[:reach] += again[:reach]
        chance[:reach] += len(matches) * (places - np.arange(reach)) * matches.mean() ** 2
    steady = max(_STEADY * float(chance.max()), 1e-9)  # far apart there are few pairs, and much may be chance
    return Recurrence(lags / TEXELS_PER_WIDTH, ((found + steady) / (chance + steady))[lags])


def _windows(strips: list[Strip], length: int) -> Iterator[Strip]:
    """Windows [length, V] that are evenly spread over the strips."""
    total = sum(len(strip.grain) for strip in strips)
    hop = max(length // 2, total // _MOST_WINDOWS)
    for strip in strips:
        for begin in range(0, len(strip.grain) - length + 1, hop):
            part = slice(begin, begin + length)
            if (strip.weight[part] > 0).mean() > _SEEN * (strip.weight > 0).any(0).mean():
                yield Strip(strip.grain[part], strip.weight[part], strip.density[part], strip.agreement)


def _matches(strip: Strip, windows: list[Strip]) -> Floats:
    """By how much each window, either way round, fits a strip at each place better than it might by chance. [M, K]"""
    length = len(windows[0].grain)
    places = len(strip.grain) - length + 1
    size = _fast(len(strip.grain) + length)
    here = _Spectra.of(strip, size)
    rows = []
    for window in windows:
        for turned in (window, window.turned()):
            there = _Spectra.of(turned, size)
            both, ours, theirs = (
                np.fft.irfft((one * other.conj()).sum(1), size)[:places]
                for one, other in (
                    (here.grain, there.grain),
                    (here.square, there.weight),
                    (here.weight, there.square),
                )
            )
            rows.append(both / np.sqrt(np.maximum(ours * theirs, 1e-9)))
    fits = np.array(rows)
    stands_out = np.maximum(fits / max(float(fits.std()), 1e-9) - _STANDS_OUT, 0.0)
    return np.asarray(gaussian_filter1d(stands_out, _TOLERANCE, axis=1))


def _fast(length: int) -> int:
    """The power of two from this length on."""
    return 1 << int(np.ceil(np.log2(max(length, 2))))
