"""Which repeat, phase and direction make the grain of all strokes one texture.

Every stroke's strip is folded at a candidate repeat; a template is learned from the strokes that are aligned so far,
and each stroke takes the phase and direction at which it fits the template best, found at once for all by Fourier
transforms. What a template from the *other* strokes explains of a stroke's grain is the evidence, against strips of
blocks that are shuffled along the stroke: choosing the best of many phases explains some of anything.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array

from videovec.brush.strips import TEXELS_PER_WIDTH, Strip

__all__ = ["Alignment", "Folded", "align", "shuffled", "spread"]

Floats = NDArray[np.float64]

_RIDGE = 1.0  # texel observations that say "no grain", so that a template of little data promises little
_SHUFFLE_BLOCK = 8  # texels along the stroke that stay together when a strip is shuffled


@dataclass(frozen=True, slots=True, eq=False)
class Alignment:
    """One texture and how every stroke lies in it.

    Texel k of a strip lies at sign * (k + 0.5) / 12 + offset[k] in the texture.

    Args:
        repeat: Length of the texture. Widths
        texture: Grain, profile removed. [U, V]
        sign: Direction in which each stroke runs, 1 or -1. [S]
        offset: Of every texel along each strip. S times [L] widths
        explained: Share of the grain of each stroke that the others' template explains, 1 is all. [S]
        energy: Grain of each stroke, the weights of ``explained``. [S]
    """

    repeat: float
    texture: Floats
    sign: Floats
    offset: tuple[Floats, ...]
    explained: Floats
    energy: Floats

    @property
    def score(self) -> float:
        """Share of all grain that is explained by others' templates."""
        return float((self.explained * self.energy).sum() / max(self.energy.sum(), 1e-12))


def spread(strip: Strip, place: Floats, columns: int) -> tuple[Floats, Floats]:
    """Sums of grain and of weight in a periodic texture.

    Args:
        strip: A stroke unrolled, turned the way it runs.
        place: Where each of its texels along the stroke lies. [L] columns
        columns: Length of the texture, U.

    Returns:
        Sums of grain, and of weight, each texel shared by its two nearest columns. Twice [U, V]
    """
    left = np.floor(place).astype(np.intp)
    share = place - left
    column = np.concatenate([left % columns, (left + 1) % columns])
    texel = np.tile(np.arange(len(place)), 2)
    shares = csr_array((np.concatenate([1 - share, share]), (column, texel)), shape=(columns, len(place)))
    both = shares @ np.concatenate([strip.weight * strip.grain, strip.weight], axis=1)
    across = strip.grain.shape[1]
    return np.asarray(both[:, :across]), np.asarray(both[:, across:])


def _fold(strip: Strip, repeat: float, columns: int) -> tuple[Floats, Floats]:
    place = (np.arange(len(strip.grain)) + 0.5) / TEXELS_PER_WIDTH / repeat * columns - 0.5
    return spread(strip, place, columns)


@dataclass(frozen=True, slots=True, eq=False)
class Folded:
    """A strip folded in both directions, and the transforms that score all phases at once."""

    values: tuple[Floats, Floats]
    weights: tuple[Floats, Floats]
    energy: float
    spectra: tuple[NDArray[np.complex128], NDArray[np.complex128]]
    weight_spectra: tuple[NDArray[np.complex128], NDArray[np.complex128]]

    @staticmethod
    def of(strip: Strip, repeat: float, columns: int) -> Folded:
        """A strip folded at a repeat [widths] into a number of columns."""
        forth, back = _fold(strip, repeat, columns), _fold(strip.turned(), repeat, columns)
        return Folded(
            (forth[0], back[0]),
            (forth[1], back[1]),
            float((strip.weight * strip.grain**2).sum()),
            (np.fft.rfft(forth[0], axis=0).conj(), np.fft.rfft(back[0], axis=0).conj()),
            (np.fft.rfft(forth[1], axis=0).conj(), np.fft.rfft(back[1], axis=0).conj()),
        )

    def best(self, template: Floats, ways: tuple[int, ...] = (0, 1)) -> tuple[int, int, float]:
        """Direction (0 or 1, of those allowed), phase, and the drop in squared error where the template fits best."""
        columns = len(template)
        spectrum, square = np.fft.rfft(template, axis=0), np.fft.rfft(template * template, axis=0)
        found = []
        for way in ways:
            product = 2 * spectrum * self.spectra[way] - square * self.weight_spectra[way]
            drop = np.fft.irfft(product.sum(1), columns)
            phase = int(np.argmax(drop))
            found.append((way, phase, float(drop[phase])))
        return max(found, key=lambda one: one[2])


def align(strips: list[Strip], repeat: float, sweeps: int = 4) -> Alignment:
    """Align the strips to one another at a repeat.

    Args:
        strips: S strips.
        repeat: Length of the texture. Widths
        sweeps: How often every stroke looks for its phase again.

    Returns:
        The texture and every stroke's phase, direction and held-out evidence.
    """
    columns = max(round(repeat * TEXELS_PER_WIDTH), 4)
    folded = [Folded.of(strip, repeat, columns) for strip in strips]
    order = np.argsort([-float(strip.weight.sum()) for strip in strips], kind="stable")
    values, weights = (np.zeros_like(folded[0].values[0]) for _ in range(2))
    way, phase = np.zeros(len(strips), np.intp), np.zeros(len(strips), np.intp)
    explained = np.zeros(len(strips))
    is_in = np.zeros(len(strips), bool)
    for _ in range(sweeps):
        changed = False
        for k in order:
            one = folded[k]
            if is_in[k]:
                values -= np.roll(one.values[way[k]], phase[k], axis=0)
                weights -= np.roll(one.weights[way[k]], phase[k], axis=0)
            if is_in.any():
                before = (way[k], phase[k])
                way[k], phase[k], drop = one.best(values / (np.maximum(weights, 0) + _RIDGE))
                explained[k] = drop / max(one.energy, 1e-12)
                changed |= before != (way[k], phase[k]) or not is_in[k]
            is_in[k] = True
            values += np.roll(one.values[way[k]], phase[k], axis=0)
            weights += np.roll(one.weights[way[k]], phase[k], axis=0)
        if not changed:
            break
    texture = values / (np.maximum(weights, 0) + _RIDGE)
    lengths = np.array([len(strip.grain) for strip in strips])
    sign = np.where(way == 0, 1.0, -1.0)
    begin = phase * repeat / columns + np.where(way == 0, 0.0, lengths / TEXELS_PER_WIDTH)
    offset = tuple(np.full(length, start) for length, start in zip(lengths, begin, strict=True))
    return Alignment(repeat, texture, sign, offset, explained, np.array([one.energy for one in folded]))


def shuffled(strips: list[Strip], rng: np.random.Generator) -> list[Strip]:
    """The strips with blocks of 8 texels in another order along the stroke: no repeat, but each texel's neighbours."""
    found = []
    for strip in strips:
        blocks = np.array_split(np.arange(len(strip.grain)), max(len(strip.grain) // _SHUFFLE_BLOCK, 1))
        order = np.concatenate([blocks[k] for k in rng.permutation(len(blocks))])
        found.append(replace(strip, grain=strip.grain[order], weight=strip.weight[order]))
    return found
