"""Ink that no stroke explains, and for how long it has been there."""

from __future__ import annotations

from dataclasses import dataclass, replace

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from videovec.propagate.judge import between_nodes
from videovec.propagate.kernels import nearest
from videovec.propagate.nodes import Nodes
from videovec.propagate.target import Target, distance_to, sample

__all__ = ["Patch", "Residual", "find_residual", "restricted", "successor"]

Bools = NDArray[np.bool_]
Floats = NDArray[np.float64]

_NEAR = 2.5
"""Distance up to which a thin stroke explains ink. px"""
_BRIDGE = 3
"""Gap over which unexplained centre lines are one patch. px"""
_ACROSS = 8.0
"""Gap over which patches are joined where a line crosses them, beyond twice its width. px"""
_STRAIGHT = 0.85
"""Cosine of the largest turn at such a gap."""
_STAYED = 1
"""Distance within which a patch is still where it was. px"""
_DRIFT = 9
"""Distance by which a patch may move between two drawings. px"""


@dataclass(frozen=True, slots=True, eq=False)
class Patch:
    """A connected piece of unexplained ink.

    Args:
        number: Its label in the residual.
        length: Centre-line pixels.
        half_width: Mean half-width. working px
    """

    number: int
    length: int
    half_width: float


@dataclass(frozen=True, slots=True, eq=False)
class Residual:
    """What is left of a drawing.

    Args:
        target: The drawing.
        point: Which centre-line points are unexplained. bool [M]
        label: Patch of each unexplained skeleton pixel, widened by the bridge; 0 is none. int32 [H, W]
        patches: The patches.
    """

    target: Target
    point: Bools
    label: NDArray[np.int32]
    patches: tuple[Patch, ...]

    def gap_to(self, patch: Patch) -> float:
        """Distance of a patch from the nearest centre line that a stroke explains; infinite where there is none."""
        own = self.point & (self.label[self.target.skeleton] == patch.number)
        if not own.any() or self.point.all():
            return np.inf
        return float(cKDTree(self.target.points[~self.point]).query(self.target.points[own])[0].min())

    def ink_mask(self, numbers: list[int], size: tuple[int, int]) -> Bools:
        """Pixels of a drawing of a size [H, W] whose nearest centre line belongs to some patches."""
        skeleton = self.target.skeleton
        belongs = np.isin(self.label[skeleton], numbers) & self.point
        widest = max(patch.half_width for patch in self.patches if patch.number in numbers)
        mask = belongs[self.target.nearest] & (self.target.distance <= widest + 2.0)
        bridge = np.isin(self.label, numbers).astype(np.uint8)
        mask |= cv2.dilate(bridge, _disc(round(widest))) > 0
        return np.asarray(cv2.resize(mask.astype(np.uint8), size[::-1], interpolation=cv2.INTER_NEAREST) > 0)


def find_residual(nodes: Nodes, positions: Floats, seen: Floats, half_width: Floats, target: Target) -> Residual:
    """Find the centre lines that are far from every seen stroke.

    Args:
        nodes: N nodes.
        positions: Where they are. [N, 2] working px
        seen: 1 for nodes that are seen, else 0. [N]
        half_width: Half-width of each stroke. [S] working px
        target: The drawing.

    Returns:
        The residual.
    """
    point = np.ones(len(target), bool)
    dense, owner = between_nodes(nodes, positions) if len(nodes) else (positions, np.zeros(0, np.intp))
    shown = seen[owner] > 0
    if shown.any() and len(target):
        dense, owner = np.ascontiguousarray(dense[shown]), owner[shown]
        found, squared = nearest(target.points, dense, np.zeros(len(target), np.int64))
        reach = np.maximum(_NEAR, half_width[nodes.stroke[owner[found]]] + 1.0)
        point = squared > reach**2
    image = np.zeros(target.skeleton.shape, np.uint8)
    rows, columns = np.nonzero(target.skeleton)
    image[rows[point], columns[point]] = 1
    wide = np.asarray(cv2.dilate(image, np.ones((_BRIDGE, _BRIDGE), np.uint8)), np.uint8)
    wide = _bridged(wide, target, point)
    _, label = cv2.connectedComponents(wide, connectivity=8, ltype=cv2.CV_32S)
    numbers = label[rows[point], columns[point]]
    length = np.bincount(numbers)
    width = np.bincount(numbers, target.half_width[point]) / np.maximum(length, 1)
    patches = tuple(Patch(int(n), int(length[n]), float(width[n])) for n in np.unique(numbers))
    return Residual(target, point, np.asarray(label, np.int32), patches)


def _bridged(patches: NDArray[np.uint8], target: Target, point: Bools) -> NDArray[np.uint8]:
    """Patches joined where another line crosses them: straight on, over its ink."""
    if not point.any():
        return patches
    label = cv2.connectedComponents(patches, connectivity=8, ltype=cv2.CV_32S)[1]
    rows, columns = np.nonzero(target.skeleton)
    places, heading = target.points[point], target.direction[point]
    patch = label[rows[point], columns[point]]
    reach = 4.0 * float(np.median(target.half_width)) + _ACROSS
    pairs = cKDTree(places).query_pairs(reach, output_type="ndarray")
    pairs = pairs[patch[pairs[:, 0]] != patch[pairs[:, 1]]]
    chord = places[pairs[:, 1]] - places[pairs[:, 0]]
    gap = np.linalg.norm(chord, axis=1)
    chord /= np.maximum(gap, 1e-9)[:, None]
    straight = np.min([np.abs((chord * heading[pairs[:, k]]).sum(1)) for k in (0, 1)], axis=0) >= _STRAIGHT
    pairs, gap = pairs[straight], gap[straight]
    between = [places[pairs[:, 0]] * (1 - t) + places[pairs[:, 1]] * t for t in (0.25, 0.5, 0.75)]
    inked = np.min([sample(target.ink, at) for at in between], axis=0) > target.threshold
    joined = patches.copy()
    done: set[tuple[int, int]] = set()
    for k in np.flatnonzero(inked)[np.argsort(gap[inked], kind="stable")]:
        low, high = sorted((int(patch[pairs[k, 0]]), int(patch[pairs[k, 1]])))
        if (low, high) not in done:
            done.add((low, high))
            a, b = np.floor(places[pairs[k]]).astype(int)
            cv2.line(joined, (int(a[0]), int(a[1])), (int(b[0]), int(b[1])), 1, _BRIDGE)
    return joined


def _disc(radius: int) -> NDArray[np.uint8]:
    size = 2 * max(radius, 0) + 1
    return np.asarray(cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (size, size)), np.uint8)


def successor(patch: Patch, residual: Residual, later: Residual) -> list[Patch]:
    """The patches of a later drawing that a patch may have become: those where it is, else those near it."""
    mask = (residual.label == patch.number).astype(np.uint8)
    for reach in (_STAYED, _DRIFT):
        near = cv2.dilate(mask, np.ones((2 * reach + 1, 2 * reach + 1), np.uint8)) > 0
        numbers = set(np.unique(later.label[near]).tolist()) - {0}
        if numbers:
            return [candidate for candidate in later.patches if candidate.number in numbers]
    return []


def restricted(target: Target, point: Bools) -> Target:
    """A target with some of its centre-line points only."""
    skeleton = np.zeros_like(target.skeleton)
    rows, columns = np.nonzero(target.skeleton)
    skeleton[rows[point], columns[point]] = True
    distance, closest = distance_to(skeleton)
    return replace(
        target,
        skeleton=skeleton,
        points=target.points[point],
        direction=target.direction[point],
        half_width=target.half_width[point],
        distance=distance,
        nearest=closest,
    )
