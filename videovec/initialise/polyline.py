"""Polylines: where they lead, how they turn, and how to resample and smooth them."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import gaussian_filter1d

__all__ = ["angle_between", "arc", "corners", "direction", "end_tangent", "resample", "sharpen", "smooth"]

Floats = NDArray[np.float64]


def arc(line: Floats) -> Floats:
    """Arc length from the first sample to each. [M]"""
    return np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(line, axis=0), axis=1))])


def at_arc(line: Floats, lengths: Floats) -> Floats:
    """Points of a polyline at given arc lengths, which are clipped to its own. [K, 2]"""
    along = arc(line)
    return np.stack([np.interp(lengths, along, line[:, i]) for i in range(2)], axis=1)


def resample(line: Floats, step: float) -> Floats:
    """The same polyline with samples at equal steps, as close to ``step`` as divides its length. [K, 2]"""
    total = arc(line)[-1]
    return at_arc(line, np.linspace(0.0, total, max(2, round(total / step) + 1)))


def direction(line: Floats, start: float, stop: float) -> Floats:
    """Unit vector from one arc length of a polyline to another; zero where it has no length. [2]"""
    total = arc(line)[-1]
    chord = np.diff(at_arc(line, np.array([min(start, 0.5 * total), min(stop, total)])), axis=0)[0]
    length = float(np.linalg.norm(chord))
    return np.asarray(chord / length if length > 1e-9 else np.zeros(2))


def angle_between(one: Floats, two: Floats) -> float:
    """Angle between two directions, in degrees."""
    return float(np.degrees(np.arctan2(abs(one[0] * two[1] - one[1] * two[0]), one @ two)))


def end_tangent(line: Floats, skip: float, reach: float) -> Floats:
    """Direction in which a line leaves its first sample, told from where it is undisturbed.

    A parabola is fitted to the arc lengths ``skip .. skip + reach`` and its direction taken at arc length zero:
    thinning bends the first half-width towards the junction, and a chord would lag behind a curved line.

    Args:
        line: Samples from the junction outwards. [M, 2] px
        skip: Arc length that is disturbed. px
        reach: Arc length that is fitted. px

    Returns:
        Unit vector. [2]
    """
    total = arc(line)[-1]
    start = min(skip, 0.3 * total)
    stop = min(skip + reach, total)
    lengths = np.linspace(start, stop, 12)
    samples = at_arc(line, lengths)
    degree = 2 if stop - start > 0.6 * reach else 1
    tangent = np.polynomial.polynomial.polyfit(lengths, samples, degree)[1]
    length = float(np.linalg.norm(tangent))
    return np.asarray(tangent / length if length > 1e-9 else direction(line, 0.0, total))


def corners(line: Floats, reach: int, limit: float, is_closed: bool) -> NDArray[np.intp]:
    """Samples at which an evenly sampled line turns sharply.

    Args:
        line: Samples at equal steps; a closed line does not repeat its first. [M, 2] px
        reach: Samples to either side between which the turn is measured.
        limit: Least turn. degrees
        is_closed: Whether the last sample is followed by the first.

    Returns:
        Indices, increasing, at least ``reach`` apart. int [K]
    """
    count = len(line)
    if count < 2 * reach + 1:
        return np.zeros(0, np.intp)
    before, after = line - np.roll(line, reach, axis=0), np.roll(line, -reach, axis=0) - line
    turn = np.degrees(
        np.arctan2(np.abs(before[:, 0] * after[:, 1] - before[:, 1] * after[:, 0]), (before * after).sum(axis=1))
    )
    if not is_closed:
        turn[:reach] = turn[count - reach :] = 0.0
    found: list[int] = []
    for i in np.argsort(-turn, kind="stable"):
        if turn[i] < limit:
            break
        gaps = [min(abs(int(i) - j), count - abs(int(i) - j) if is_closed else count) for j in found]
        if all(gap >= reach for gap in gaps):
            found.append(int(i))
    return np.array(sorted(found), np.intp)


def sharpen(line: Floats, corner: int, skip: int, reach: int, width: float) -> Floats:
    """Move a rounded corner to where its two sides would meet.

    Args:
        line: Samples at equal steps. [M, 2] px
        corner: The sample at which it turns.
        skip: Samples on either side that are rounded off; they are laid out straight to the new corner.
        reach: Samples beyond them that tell where a side leads.
        width: Width of the line; the skeleton of a round join that opens by an angle a lies w (1 / sin(a / 2) - 1) / 4
            off its corner, and no corner moves much farther. px

    Returns:
        As many samples; the same ones where the sides are too short or do not meet near by.
    """
    low, high = corner - skip, corner + skip
    if low - reach < 0 or high + reach >= len(line):
        return line
    sides = [line[low - reach : low + 1], line[high + reach : high - 1 : -1]]
    ways = [side[-1] - side[0] for side in sides]
    across = ways[0][0] * ways[1][1] - ways[0][1] * ways[1][0]
    if abs(across) < 0.1 * float(np.linalg.norm(ways[0]) * np.linalg.norm(ways[1])):
        return line
    between = sides[1][0] - sides[0][0]
    meeting = sides[0][0] + (between[0] * ways[1][1] - between[1] * ways[1][0]) / across * ways[0]
    opening = np.radians(max(angle_between(ways[0], ways[1]), 5.0))
    farthest = 0.25 * width * (1.0 / np.sin(0.5 * opening) - 1.0) + max(1.0, 0.2 * width)
    if np.linalg.norm(meeting - line[corner]) > farthest:
        return line
    result = line.copy()
    result[low : corner + 1] = np.linspace(line[low], meeting, skip + 1)
    result[corner : high + 1] = np.linspace(meeting, line[high], skip + 1)
    return result


def smooth(line: Floats, sigma: float, is_closed: bool) -> Floats:
    """Smooth a line with a Gaussian of ``sigma`` samples; the ends of an open one stay where they are."""
    if sigma <= 0.0 or len(line) < 3:
        return line
    if is_closed:
        return np.asarray(gaussian_filter1d(line, sigma, axis=0, mode="wrap"))
    pad = min(len(line) - 1, int(np.ceil(4.0 * sigma)))
    before, after = 2.0 * line[0] - line[pad:0:-1], 2.0 * line[-1] - line[-2 : -pad - 2 : -1]
    padded = gaussian_filter1d(np.concatenate([before, line, after]), sigma, axis=0, mode="nearest")
    return np.asarray(padded[pad : pad + len(line)])
