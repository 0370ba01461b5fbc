"""Splines through traced lines: as few cubics as a tolerance allows, by least squares."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from videovec.compiling import compiled

__all__ = ["fit_spline"]

Floats = NDArray[np.float64]
Ints = NDArray[np.intp]

_ROUNDS = 12  # reparametrisations of each least-squares fit, at most
_STILL = 1e-3  # change of every parameter below which they end
_TANGENT_SAMPLES = 4  # samples to either side of a smooth joint from which its tangent is told


@compiled()
def _fit_cubic(line: Floats, first: Floats, last: Floats, rounds: int, still: float) -> tuple[Floats, Floats]:
    """One cubic from the first sample to the last; a zero tangent leaves its handle free. Cubic [4, 2], errors [M]."""
    count = len(line)
    t = np.zeros(count)
    for i in range(1, count):
        t[i] = t[i - 1] + np.hypot(line[i, 0] - line[i - 1, 0], line[i, 1] - line[i - 1, 1])
    total = max(t[-1], 1e-12)
    t /= total
    basis = np.zeros((4, 4))  # direction of each unknown: (x, y) of the first handle, then of the second
    is_first_free = first[0] == 0.0 and first[1] == 0.0
    is_last_free = last[0] == 0.0 and last[1] == 0.0
    unknowns = 0
    for free, tangent, handle in ((is_first_free, first, 0), (is_last_free, last, 1)):
        if free:
            basis[unknowns, 2 * handle] = 1.0
            basis[unknowns + 1, 2 * handle + 1] = 1.0
            unknowns += 2
        else:
            basis[unknowns, 2 * handle], basis[unknowns, 2 * handle + 1] = tangent[0], tangent[1]
            unknowns += 1
    cubic = np.empty((4, 2))
    error = np.zeros(count)
    for step in range(rounds):
        normal, right = np.zeros((unknowns, unknowns)), np.zeros(unknowns)
        for i in range(count):
            s, r = t[i], 1.0 - t[i]
            b1, b2 = 3.0 * r * r * s, 3.0 * r * s * s
            b0, b3 = r * r * r + b1, s * s * s + b2
            dx = line[i, 0] - b0 * line[0, 0] - b3 * line[-1, 0]
            dy = line[i, 1] - b0 * line[0, 1] - b3 * line[-1, 1]
            for k in range(unknowns):
                kx, ky = b1 * basis[k, 0] + b2 * basis[k, 2], b1 * basis[k, 1] + b2 * basis[k, 3]
                right[k] += kx * dx + ky * dy
                for m in range(unknowns):
                    normal[k, m] += kx * (b1 * basis[m, 0] + b2 * basis[m, 2]) + ky * (
                        b1 * basis[m, 1] + b2 * basis[m, 3]
                    )
        for k in range(unknowns):  # a little pull towards handles on the chord, for runs of few samples
            weight = 1e-4 * count * 0.05
            normal[k, k] += weight
            handle = 0 if basis[k, 0] != 0.0 or basis[k, 1] != 0.0 else 1
            sign = 1.0 if handle == 0 else -1.0
            chord_x, chord_y = line[-1, 0] - line[0, 0], line[-1, 1] - line[0, 1]
            along = chord_x * basis[k, 2 * handle] + chord_y * basis[k, 2 * handle + 1]
            rest = sign * along / 3.0 if basis[k, 2 * handle] * basis[k, 2 * handle + 1] == 0.0 else total / 3.0
            right[k] += weight * rest
        solution = np.linalg.solve(normal, right)
        h = np.zeros(4)
        for k in range(unknowns):
            value = solution[k]
            if (not is_first_free and k == 0) or (not is_last_free and k == unknowns - 1):
                value = min(max(value, 0.02 * total), 1.2 * total)
            for m in range(4):
                h[m] += value * basis[k, m]
        for d in range(2):
            cubic[0, d], cubic[3, d] = line[0, d], line[-1, d]
            cubic[1, d], cubic[2, d] = line[0, d] + h[d], line[-1, d] + h[2 + d]
        moved = 0.0
        for i in range(count):
            s, r = t[i], 1.0 - t[i]
            p, v, a = np.zeros(2), np.zeros(2), np.zeros(2)
            for d in range(2):
                c0, c1, c2, c3 = cubic[0, d], cubic[1, d], cubic[2, d], cubic[3, d]
                p[d] = r * r * (r * c0 + 3.0 * s * c1) + s * s * (3.0 * r * c2 + s * c3) - line[i, d]
                v[d] = 3.0 * (r * r * (c1 - c0) + 2.0 * r * s * (c2 - c1) + s * s * (c3 - c2))
                a[d] = 6.0 * (r * (c2 - 2.0 * c1 + c0) + s * (c3 - 2.0 * c2 + c1))
            error[i] = np.hypot(p[0], p[1])
            if step < rounds - 1 and 0 < i < count - 1:
                slope = v[0] * v[0] + v[1] * v[1] + p[0] * a[0] + p[1] * a[1]
                if slope > 1e-9:
                    t[i] = min(1.0, max(0.0, s - (p[0] * v[0] + p[1] * v[1]) / slope))
                    moved = max(moved, abs(t[i] - s))
        if moved < still:
            break
    return cubic, error


@compiled()
def _tangent(line: Floats, at: int, low: int, high: int, reach: int) -> Floats:
    """Direction of a smooth line at a sample, from samples within its stretch. Unit vector [2]"""
    before, after = max(low, at - reach), min(high, at + reach)
    chord = line[after] - line[before]
    length = np.hypot(chord[0], chord[1])
    return chord / length if length > 1e-12 else np.zeros(2)


@compiled()
def _fit_stretch(line: Floats, tolerance: float, ends: Floats, rounds: int, still: float, reach: int) -> Floats:
    """Cubics along a line without corners, split where they are worst, then rejoined where one does as well.

    ``ends`` are the tangents at both ends, zero for free. [n, 4, 2]
    """
    last = len(line) - 1
    joints = [0, last]
    whole, whole_error = _fit_cubic(line, ends[0], ends[1], rounds, still)
    cubics, worst = [whole], [whole_error.max()]
    k = 0
    while k < len(cubics):
        low, high = joints[k], joints[k + 1]
        if worst[k] <= tolerance or high - low < 4:
            k += 1
            continue
        first = ends[0] if low == 0 else _tangent(line, low, 0, last, reach)
        final = ends[1] if high == last else -_tangent(line, high, 0, last, reach)
        error = _fit_cubic(line[low : high + 1], first, final, rounds, still)[1]
        at = min(max(low + int(np.argmax(error)), low + 2), high - 2)
        middle = _tangent(line, at, 0, last, reach)
        one, error_one = _fit_cubic(line[low : at + 1], first, -middle, rounds, still)
        two, error_two = _fit_cubic(line[at : high + 1], middle, final, rounds, still)
        joints.insert(k + 1, at)
        cubics[k], worst[k] = one, error_one.max()
        cubics.insert(k + 1, two)
        worst.insert(k + 1, error_two.max())
    k = 1
    while k < len(cubics):
        low, high = joints[k - 1], joints[k + 1]
        first = ends[0] if low == 0 else _tangent(line, low, 0, last, reach)
        final = ends[1] if high == last else -_tangent(line, high, 0, last, reach)
        cubic, error = _fit_cubic(line[low : high + 1], first, final, rounds, still)
        if error.max() <= tolerance:
            joints.pop(k)
            cubics.pop(k)
            cubics[k - 1] = cubic
            k = max(1, k - 1)
        else:
            k += 1
    result = np.empty((len(cubics), 4, 2))
    for i in range(len(cubics)):
        result[i] = cubics[i]
    return result


def fit_spline(line: Floats, corners: Ints, tolerance: float, is_closed: bool) -> Floats:
    """Fit a spline to a line.

    Args:
        line: Samples at about equal steps; a closed line repeats its first sample as its last. [M, 2] px
        corners: Samples at which the spline may turn sharply. int [K]
        tolerance: Largest distance of a sample from its cubic. px
        is_closed: Whether the line is closed; it is smooth at its seam unless that is a corner.

    Returns:
        Control points. [3n+1, 2] px

    Source:
        The scheme of Schneider 1990, "An algorithm for automatically fitting digitized curves" (Graphics Gems),
        with free handles at ends and corners, and a pass that rejoins.
    """
    line = np.ascontiguousarray(line)
    last = len(line) - 1
    cuts = np.unique(np.concatenate([[0], corners, [last]]))
    seam = np.zeros(2)
    if is_closed and 0 not in corners and last not in corners and last >= 4:
        chord = line[min(_TANGENT_SAMPLES, last)] - line[last - min(_TANGENT_SAMPLES, last)]
        seam = chord / max(float(np.linalg.norm(chord)), 1e-12)
    parts = []
    for low, high in pairwise(cuts):
        ends = np.stack([seam if low == 0 else np.zeros(2), -seam if high == last else np.zeros(2)])
        parts.append(_fit_stretch(line[low : high + 1], tolerance, ends, _ROUNDS, _STILL, _TANGENT_SAMPLES))
    control = np.concatenate(parts)
    return np.concatenate([control[:1, 0], control[:, 1:].reshape(-1, 2)])
