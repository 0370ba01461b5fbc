"""Grain that is known by its statistics alone: measured from strips, and drawn again, always another.

Along the stroke grain is stationary; across it is not. So its second-order statistics are one covariance of all places
across with all places across per lag along, in other words one matrix [V, V] per frequency along the stroke. A Gaussian
field with that spectrum, whose values are then mapped row by row to the distribution of ink that was seen there, looks
like the brush without repeating any mark of it (spectrum synthesis, Galerne, Gousseau, Morel 2011, "Random phase
textures", extended to non-stationary rows; the row-wise map is Heeger, Bergen 1995, "Pyramid-based texture analysis").
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from videovec.brush.strips import TEXELS_PER_WIDTH, Strip

__all__ = ["GrainStatistics", "measure_grain", "synthesise_grain"]

Floats = NDArray[np.float64]

_LAGS = 3 * TEXELS_PER_WIDTH  # texels along the stroke beyond which grain is independent
_QUANTILES = 65


@dataclass(frozen=True, slots=True, eq=False)
class GrainStatistics:
    """What is known of random grain.

    Args:
        covariance: Of the places across with those a lag further along, lags 0 .. L. [L+1, V, V]
        quantiles: Of ink against density at each place across, profile included, in equal steps from 0 to 1. [Q, V]
    """

    covariance: Floats
    quantiles: Floats


def measure_grain(strips: list[Strip], profile: Floats) -> GrainStatistics:
    """Measure the grain of strips about a profile [V]."""
    across = len(profile)
    total, count = np.zeros((_LAGS + 1, across, across)), np.zeros((_LAGS + 1, across, across))
    for strip in strips:
        seen = (strip.weight > 0).astype(np.float64)
        grain = strip.grain * seen
        for lag in range(min(_LAGS, len(grain) - 1) + 1):
            ahead = slice(lag, None)
            total[lag] += grain[: len(grain) - lag].T @ grain[ahead]
            count[lag] += seen[: len(seen) - lag].T @ seen[ahead]
    covariance = total / np.maximum(count, 1.0)
    steps = np.linspace(0, 1, _QUANTILES)
    quantiles = np.zeros((_QUANTILES, across))
    for v in range(across):
        values = np.concatenate([strip.grain[strip.weight[:, v] > 0, v] for strip in strips])
        quantiles[:, v] = np.quantile(values, steps) + profile[v] if len(values) else profile[v]
    return GrainStatistics(covariance, np.maximum(quantiles, 0.0))


def synthesise_grain(statistics: GrainStatistics, columns: int, rng: np.random.Generator) -> Floats:
    """A periodic strip of grain that was never drawn.

    Args:
        statistics: Of the grain.
        columns: Length of the strip. Texels, at least twice the lags of the statistics
        rng: Where chance comes from.

    Returns:
        Ink against density, profile included. [columns, V] in [0, 1]
    """
    field = _gaussian_field(statistics.covariance, columns, rng)
    rank = (np.argsort(np.argsort(field, axis=0), axis=0) + 0.5) / columns
    steps = np.linspace(0, 1, len(statistics.quantiles))
    found = [np.interp(rank[:, v], steps, statistics.quantiles[:, v]) for v in range(field.shape[1])]
    return np.stack(found, axis=1)


def _gaussian_field(covariance: Floats, columns: int, rng: np.random.Generator) -> Floats:
    """A periodic Gaussian field [columns, V] with the given covariances."""
    lags = len(covariance) - 1
    taper = 0.5 * (1 + np.cos(np.pi * np.arange(lags + 1) / (lags + 1)))
    tapered = covariance * taper[:, None, None]
    around = np.zeros((columns, *covariance.shape[1:]))
    around[: lags + 1] += tapered
    around[columns - lags :] += tapered[1:][::-1].transpose(0, 2, 1)
    spectrum = np.fft.fft(around, axis=0)
    spectrum = 0.5 * (spectrum + spectrum.conj().transpose(0, 2, 1))
    power, basis = np.linalg.eigh(spectrum)
    noise = np.fft.fft(rng.normal(size=(columns, covariance.shape[1])), axis=0)
    shaped = (basis * np.sqrt(np.maximum(power, 0))[:, None, :]) @ noise[:, :, None]
    return np.asarray(np.fft.ifft(shaped[:, :, 0], axis=0).real)
