"""Phases that drift along a stroke: the arc length of a noisy curve is too long, and not evenly so.

A rigid phase puts most of a stroke right; where along the texture each part of it lies is then found by dynamic
programming over small offsets, against the template of the other strokes.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from videovec.brush.align import Alignment, Folded, align, spread
from videovec.brush.strips import TEXELS_PER_WIDTH, Strip

__all__ = ["explained_at", "follow", "learn_texture", "lie_along", "texture_of", "textures_without"]

Floats = NDArray[np.float64]

_RIDGE = 1.0
_REACH = 14  # texels to either side of the rigid phase
_HOP = 6  # texels of arc over which the offset changes by at most one
_STIFFNESS = 6.0  # price of a change by one texel, in texels' worth of unexplained grain


def learn_texture(strips: list[Strip], repeat: float, rounds: int = 2) -> Alignment:
    """One texture for all strips at a repeat, with phases that drift along each.

    Args:
        strips: S strips.
        repeat: Length of the texture. Widths
        rounds: How often the drift is found and the texture learned again.
    """
    found = align(strips, repeat)
    for _ in range(rounds):
        found = _with_drift(strips, found)
    return found


def texture_of(strips: list[Strip], found: Alignment) -> Alignment:
    """The alignment with its texture learned again, from these strips."""
    values, weights = (np.sum(parts, axis=0) for parts in zip(*_spread_all(strips, found), strict=True))
    return replace(found, texture=values / (np.maximum(weights, 0) + _RIDGE))


def textures_without(strips: list[Strip], found: Alignment) -> list[Floats]:
    """For each strip, the texture that the others make. S times [U, V]"""
    parts = _spread_all(strips, found)
    values, weights = (np.sum(part, axis=0) for part in zip(*parts, strict=True))
    return [(values - value) / (np.maximum(weights - weight, 0) + _RIDGE) for value, weight in parts]


def lie_along(
    strip: Strip, texture: Floats, repeat: float, ways: tuple[int, ...] = (0, 1)
) -> tuple[float, Floats, float]:
    """Where a stroke lies along a texture that is known.

    Args:
        strip: The stroke unrolled.
        texture: Grain, profile removed. [U, V]
        repeat: Length of the texture. Widths
        ways: Directions that it may have: 0 along it, 1 against it.

    Returns:
        Direction of the stroke, offset of each texel [L] in widths, and the share of its grain explained.
    """
    folded = Folded.of(strip, repeat, len(texture))
    way, phase, _ = folded.best(texture, ways)
    sign = 1.0 if way == 0 else -1.0
    begin = phase * repeat / len(texture) + (0.0 if way == 0 else len(strip.grain) / TEXELS_PER_WIDTH)
    offset, share = follow(strip, sign, np.full(len(strip.grain), begin), texture, repeat)
    return sign, offset, share


def explained_at(strip: Strip, texture: Floats, repeat: float, sign: float, offset: Floats) -> float:
    """Share of a stroke's grain that a texture explains where the stroke lies now."""
    across = slice(None, None, 1 if sign > 0 else -1)
    grain, weight = strip.grain[:, across], strip.weight[:, across]
    seen = _read(texture, _place(len(grain), sign, offset, repeat, len(texture)))
    total = float((weight * grain**2).sum())
    return 1 - float((weight * (grain - seen) ** 2).sum()) / max(total, 1e-12)


def _with_drift(strips: list[Strip], rigid: Alignment) -> Alignment:
    columns = len(rigid.texture)
    parts = _spread_all(strips, rigid)
    values, weights = (np.sum([part[k] for part in parts], axis=0) for k in (0, 1))
    offsets, explained = [], []
    for k, strip in enumerate(strips):
        others = (values - parts[k][0]) / (np.maximum(weights - parts[k][1], 0) + _RIDGE)
        offset, share = follow(strip, rigid.sign[k], rigid.offset[k], others, rigid.repeat)
        offsets.append(offset)
        explained.append(share)
        moved = _spread(strip, rigid.sign[k], offset, rigid.repeat, columns)
        values, weights = values + moved[0] - parts[k][0], weights + moved[1] - parts[k][1]
        parts[k] = moved
    texture = values / (np.maximum(weights, 0) + _RIDGE)
    return replace(rigid, texture=texture, offset=tuple(offsets), explained=np.array(explained))


def _place(length: int, sign: float, offset: Floats, repeat: float, columns: int) -> Floats:
    """Place of each texel of a strip in the texture. [L] columns"""
    return np.asarray((sign * (np.arange(length) + 0.5) / TEXELS_PER_WIDTH + offset) / repeat * columns - 0.5)


def _spread_all(strips: list[Strip], found: Alignment) -> list[tuple[Floats, Floats]]:
    """Sums of grain and weight of every strip at its place in the texture. S times twice [U, V]"""
    columns = len(found.texture)
    placed = zip(strips, found.sign, found.offset, strict=True)
    return [_spread(strip, sign, offset, found.repeat, columns) for strip, sign, offset in placed]


def _spread(strip: Strip, sign: float, offset: Floats, repeat: float, columns: int) -> tuple[Floats, Floats]:
    """Sums of grain and weight of a strip at its place in the texture. Twice [U, V]"""
    across = slice(None, None, 1 if sign > 0 else -1)
    seen = replace(strip, grain=strip.grain[:, across], weight=strip.weight[:, across])
    return spread(seen, _place(len(strip.grain), sign, offset, repeat, columns), columns)


def follow(strip: Strip, sign: float, offset: Floats, template: Floats, repeat: float) -> tuple[Floats, float]:
    """How the offset drifts along a strip so that a template fits it best.

    Args:
        strip: The stroke unrolled.
        sign: Its direction.
        offset: Where to look, to either side. [L] widths
        template: Grain, profile removed. [U, V]
        repeat: Length of the template. Widths

    Returns:
        Offset of each texel [L] in widths, and the share of the grain explained there.
    """
    columns, length = len(template), len(strip.grain)
    across = slice(None, None, 1 if sign > 0 else -1)
    grain, weight = strip.grain[:, across], strip.weight[:, across]
    shifts = np.arange(-_REACH, _REACH + 1) / TEXELS_PER_WIDTH
    place = _place(length, sign, offset + shifts[:, None], repeat, columns)
    errors = (weight * (grain - _read(template, place)) ** 2).sum(2)
    starts = np.arange(0, length, _HOP)
    cost = np.add.reduceat(errors, starts, axis=1).T
    total = float((weight * grain * grain).sum())
    price = _STIFFNESS * total / max(float(weight.sum()), 1e-9)
    path = _cheapest_path(cost, price)
    middle = np.minimum(starts + _HOP / 2, length - 1)
    drift = np.interp(np.arange(length), middle, shifts[path])
    remaining = float(sum(cost[k, path[k]] for k in range(len(path))))
    return offset + drift, 1 - remaining / max(total, 1e-12)


def _read(texture: Floats, place: Floats) -> Floats:
    """Rows of a periodic texture [U, V] between columns. [..., V]"""
    columns = len(texture)
    left = np.floor(place).astype(np.intp)
    share = (place - left)[..., None]
    return np.asarray((1 - share) * texture[left % columns] + share * texture[(left + 1) % columns])


def _cheapest_path(cost: Floats, price: float) -> NDArray[np.intp]:
    """States that minimise the sum of costs [K, N], at a price for every step to a neighbouring state. int [K]"""
    best = cost[0]
    came = np.zeros(cost.shape, np.intp)
    for k in range(1, len(cost)):
        padded = np.pad(best, 1, constant_values=np.inf)
        options = np.stack([padded[:-2] + price, padded[1:-1], padded[2:] + price])
        choice = options.argmin(0)
        came[k] = np.arange(len(best)) + choice - 1
        best = options.min(0) + cost[k]
    path = np.zeros(len(cost), np.intp)
    path[-1] = int(np.argmin(best))
    for k in range(len(cost) - 1, 0, -1):
        path[k - 1] = came[k, path[k]]
    return path
