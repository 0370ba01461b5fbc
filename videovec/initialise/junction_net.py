"""Small networks that score every pair of branches at every junction, in the light of what is around it."""

from __future__ import annotations

import hashlib
import json
from dataclasses import dataclass
from functools import cache
from importlib.resources import files

import numpy as np
from numpy.typing import NDArray

from videovec.errors import FitError
from videovec.initialise.arrangement import Arrangement
from videovec.initialise.junction_features import IS_RING, LENGTH, TURN, Features

__all__ = ["CHECKSUM", "WEIGHTS", "JunctionNet", "load_nets", "prior", "read_nets", "score_pairs"]

Array = NDArray[np.float32]
Ints = NDArray[np.intp]

WEIGHTS = "junctions_fp16.safetensors"
CHECKSUM = "2ddb72a827549a9cd4dfb14bd6acf0ce86e99b03129c872c600059089ccb057e"
_STRAIGHT = 1.0  # log-odds of a pair that goes straight on, times the cosine of its turn
_ONWARD = 1.5  # log-odds of any pair: the drawings that the networks learned from end lines more often than others do
_RING = 6.5  # units; a ring that is shorter is a hole in the ink of a rough line
_HOLE = 12.0  # log-odds against its being closed
_CLIPPED = 5.0  # standard deviations of the training set beyond which a number says no more


@dataclass(frozen=True, slots=True, eq=False)
class JunctionNet:
    """A network: states of ends, pairs and regions that tell each other what they know, some rounds long.

    Args:
        weights: Its arrays by name: ``LAYER.w [in, out]`` and ``LAYER.b [out]``.
        rounds: How often neighbours are heard.
    """

    weights: dict[str, Array]
    rounds: int

    def linear(self, layer: str, value: Array) -> Array:
        """One layer. [N, in] to [N, out]"""
        return np.asarray(value @ self.weights[layer + ".w"] + self.weights[layer + ".b"])

    def hidden(self, layer: str, *values: Array) -> Array:
        """Two layers with a rectifier between them. N rows"""
        inner = self.linear(layer + ".in", np.concatenate(values, axis=1))
        return self.linear(layer + ".out", np.maximum(inner, 0.0))

    def scaled(self, kind: str, values: NDArray[np.float64]) -> Array:
        """Numbers as the network is used to see them."""
        scaled = (values.astype(np.float32) - self.weights[kind + ".mean"]) / self.weights[kind + ".spread"]
        return np.asarray(np.clip(scaled, -_CLIPPED, _CLIPPED))


def read_nets(data: bytes) -> tuple[JunctionNet, ...]:
    """Read a safetensors file of ``NUMBER/NAME``: the length of a JSON header, the header, the numbers."""
    begin = 8 + int.from_bytes(data[:8], "little")
    found: dict[str, dict[str, Array]] = {}
    for name, entry in json.loads(data[8:begin]).items():
        if name != "__metadata__":
            low, high = (begin + offset for offset in entry["data_offsets"])
            values = np.frombuffer(data[low:high], np.float16).reshape(entry["shape"]).astype(np.float32)
            number, _, own = name.partition("/")
            found.setdefault(number, {})[own] = values
    return tuple(JunctionNet(own, sum(name.endswith(".end.in.w") for name in own)) for own in found.values())


@cache
def load_nets() -> tuple[JunctionNet, ...]:
    """Read the weights that come with the library.

    Raises:
        FitError: The file is not the one that this code was tested with.
    """
    data = files("videovec").joinpath("weights", WEIGHTS).read_bytes()
    found = hashlib.sha256(data).hexdigest()
    if found != CHECKSUM:
        raise FitError(f"{WEIGHTS} must have sha256 {CHECKSUM}, got {found}: install videovec again")
    return read_nets(data)


@dataclass(frozen=True, slots=True, eq=False)
class _Gather:
    """Sums, means and maxima of rows that belong together.

    Args:
        order: Rows, those of a group side by side.
        starts: Where each group begins; groups without rows are left out.
        groups: Which groups have rows.
        counts: How many rows each of all groups has, at least 1. [G, 1]
    """

    order: Ints
    starts: Ints
    groups: Ints
    counts: Array

    @staticmethod
    def of(owner: Ints, count: int) -> _Gather:
        order = np.argsort(owner, kind="stable")
        groups, starts = np.unique(owner[order], return_index=True)
        counts = np.maximum(np.bincount(owner, minlength=count), 1).astype(np.float32)[:, None]
        return _Gather(order, starts, groups, counts)

    def _reduced(self, reduce: np.ufunc, rows: Array) -> Array:
        result = np.zeros((len(self.counts), rows.shape[1]), np.float32)
        if len(self.order):
            result[self.groups] = reduce.reduceat(rows[self.order], self.starts, axis=0)
        return result

    def mean(self, rows: Array, counts: Array | None = None) -> Array:
        """Sums over the number of rows, or over other counts. [G, 1]"""
        return np.asarray(self._reduced(np.add, rows) / (self.counts if counts is None else counts), np.float32)

    def most(self, rows: Array) -> Array:
        return self._reduced(np.maximum, rows)


def _both(one: Array, two: Array) -> tuple[Array, Array]:
    """What two states say in whatever order they are given."""
    return np.asarray(one + two), np.asarray(np.abs(one - two))


def _rectified(value: Array) -> Array:
    return np.asarray(np.maximum(value, 0.0))


def prior(pairs: NDArray[np.float64]) -> NDArray[np.float64]:
    """What speaks for each pair before any network is asked. [P, 36] to [P]"""
    is_hole = (pairs[:, IS_RING] > 0.5) & (np.expm1(pairs[:, LENGTH]) < _RING)
    return np.asarray(_ONWARD + _STRAIGHT * np.cos(np.pi * pairs[:, TURN]) - _HOLE * is_hole)


def score_pairs(nets: tuple[JunctionNet, ...], drawn: Arrangement, features: Features) -> NDArray[np.float64]:
    """How much speaks for each pair being one stroke: log-odds of a decision are the sums of these.

    Args:
        nets: Networks whose mean counts.
        drawn: A drawing's branches as arrays.
        features: What they look like.

    Returns:
        Score of each pair; ending at the junction scores 0. [P]
    """
    told = [_told(net, drawn, features) for net in nets]
    return np.asarray(np.mean(told, axis=0) + prior(features.pairs))


def _told(net: JunctionNet, drawn: Arrangement, features: Features) -> NDArray[np.float64]:
    """What one network says of each pair. [P]"""
    count, (one, two) = len(drawn.ends), drawn.pairs.T
    turned = np.flatnonzero(drawn.wedge >= 0)
    wedge, region = drawn.wedge[turned], drawn.region[turned]
    by_end = _Gather.of(np.concatenate([one, two]), count)
    regions_of_wedges = _Gather.of(region, len(drawn.area))
    regions_of_ends = _Gather.of(drawn.sides.reshape(-1), len(drawn.area))
    wedges_of_pairs = _Gather.of(wedge, len(drawn.pairs))
    ends = _rectified(net.linear("end", net.scaled("end", features.ends)))
    areas = _rectified(net.linear("region", net.scaled("region", features.regions)))
    seen, degree = net.scaled("pair", features.pairs), drawn.degree[:, None].astype(np.float32)
    pairs = _rectified(net.hidden("pair", seen, *_both(ends[one], ends[two])))
    for k in range(net.rounds):
        heard = np.concatenate([pairs, pairs])
        told = by_end.most(heard), by_end.mean(heard, degree)
        sides = _both(areas[drawn.sides[:, 0]], areas[drawn.sides[:, 1]])
        corner = pairs[wedge]
        along = regions_of_ends.mean(np.repeat(ends, 2, axis=0))
        bounds = regions_of_wedges.mean(corner), regions_of_wedges.most(corner), along
        heard_by_regions = net.hidden(f"{k}.region", areas, *bounds)
        ends = _rectified(ends + net.hidden(f"{k}.end", ends, ends[drawn.opposite], *told, *sides))
        areas = _rectified(areas + heard_by_regions)
        around = wedges_of_pairs.mean(areas[region])
        pairs = _rectified(pairs + net.hidden(f"{k}.pair", pairs, *_both(ends[one], ends[two]), around))
    return net.linear("score", pairs)[:, 0].astype(np.float64)
