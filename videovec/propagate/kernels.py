"""The loops of registration: nearest features on a grid, and the as-rigid-as-possible solve."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from videovec.compiling import compiled

__all__ = ["assemble", "nearest", "relax", "rotations"]

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

_CELL = 8.0
"""Side of a cell of the search grid. px"""
_MARGIN = 64
"""How many cells off the grid a query is still told apart."""


@compiled()
def _fill_grid(data: Floats) -> tuple[Ints, Ints, float, float, int, int]:
    """Sort data by cell: begin of each cell, items, origin and number of cells in x and y."""
    x0, y0 = data[0, 0], data[0, 1]
    x1, y1 = x0, y0
    for i in range(len(data)):
        x0, x1 = min(x0, data[i, 0]), max(x1, data[i, 0])
        y0, y1 = min(y0, data[i, 1]), max(y1, data[i, 1])
    nx, ny = int((x1 - x0) / _CELL) + 1, int((y1 - y0) / _CELL) + 1
    start = np.zeros(nx * ny + 1, np.int64)
    cell = np.empty(len(data), np.int64)
    for i in range(len(data)):
        cell[i] = int((data[i, 1] - y0) / _CELL) * nx + int((data[i, 0] - x0) / _CELL)
        start[cell[i] + 1] += 1
    for c in range(nx * ny):
        start[c + 1] += start[c]
    items = np.empty(len(data), np.int64)
    cursor = start[:-1].copy()
    for i in range(len(data)):
        items[cursor[cell[i]]] = i
        cursor[cell[i]] += 1
    return start, items, x0, y0, nx, ny


@compiled()
def nearest(query: Floats, data: Floats, guess: Ints) -> tuple[Ints, Floats]:
    """The nearest of some features, whose first two entries are a place on the page.

    Args:
        query: What to look for. [Q, F]
        data: Where to look, at least one. [M, F]
        guess: An entry of ``data`` that may be near; only speed depends on it. int [Q]

    Returns:
        Nearest entry of each query and its squared distance. int [Q], [Q]
    """
    start, items, x0, y0, nx, ny = _fill_grid(data)
    features = data.shape[1]
    found = np.empty(len(query), np.int64)
    squared = np.empty(len(query))
    for q in range(len(query)):
        best_at, best = guess[q], 0.0
        for f in range(features):
            best += (query[q, f] - data[best_at, f]) ** 2
        cx = min(max(math.floor((query[q, 0] - x0) / _CELL), -_MARGIN), nx + _MARGIN)
        cy = min(max(math.floor((query[q, 1] - y0) / _CELL), -_MARGIN), ny + _MARGIN)
        for ring in range(max(nx, ny) + 2 * _MARGIN):
            if ring > 1 and ((ring - 1) * _CELL) ** 2 > best:
                break
            for gy in range(max(cy - ring, 0), min(cy + ring, ny - 1) + 1):
                step = 1 if abs(gy - cy) == ring else max(2 * ring, 1)
                for gx in range(cx - ring, cx + ring + 1, step):
                    if gx < 0 or gx >= nx:
                        continue
                    for k in range(start[gy * nx + gx], start[gy * nx + gx + 1]):
                        i = items[k]
                        d = (query[q, 0] - data[i, 0]) ** 2 + (query[q, 1] - data[i, 1]) ** 2
                        f = 2
                        while f < features and d < best:
                            d += (query[q, f] - data[i, f]) ** 2
                            f += 1
                        if d < best:
                            best, best_at = d, i
        found[q], squared[q] = best_at, best
    return found, squared


@compiled()
def assemble(
    pull: Floats, rhs: Floats, node: Ints, goal: Floats, direction: Floats, weight: Floats, along: Floats
) -> None:
    """Add springs from nodes to lines.

    Args:
        pull: Stiffness of each node as xx, xy, yy; added to. [N, 3]
        rhs: Stiffness times goal; added to. [N, 2]
        node: Node of each spring. int [K]
        goal: A point on each line. [K, 2]
        direction: Unit direction of each line. [K, 2]
        weight: Stiffness across the line. [K]
        along: Stiffness along the line as a share of that across. [K]
    """
    for k in range(len(node)):
        tx, ty = direction[k, 0], direction[k, 1]
        w, s = weight[k], along[k] * weight[k]
        xx = w * ty * ty + s * tx * tx
        xy = (s - w) * tx * ty
        yy = w * tx * tx + s * ty * ty
        i = node[k]
        pull[i, 0] += xx
        pull[i, 1] += xy
        pull[i, 2] += yy
        rhs[i, 0] += xx * goal[k, 0] + xy * goal[k, 1]
        rhs[i, 1] += xy * goal[k, 0] + yy * goal[k, 1]


@compiled()
def rotations(x: Floats, rest: Floats, indptr: Ints, index: Ints, weight: Floats, low: float, high: float) -> Floats:
    """The rotation, times a scale in low .. high, that best takes each node's rest edges to its present ones.

    Returns:
        As complex numbers, real and imaginary part. [N, 2]
    """
    out = np.zeros((len(x), 2))
    for i in range(len(x)):
        re, im, norm = 0.0, 0.0, 0.0
        for k in range(indptr[i], indptr[i + 1]):
            j = index[k]
            rx, ry = rest[j, 0] - rest[i, 0], rest[j, 1] - rest[i, 1]
            ex, ey = x[j, 0] - x[i, 0], x[j, 1] - x[i, 1]
            re += weight[k] * (rx * ex + ry * ey)
            im += weight[k] * (rx * ey - ry * ex)
            norm += weight[k] * (rx * rx + ry * ry)
        size = math.sqrt(re * re + im * im)
        if size < 1e-12:
            out[i, 0] = 1.0
            continue
        scale = min(max(size / norm, low), high)
        out[i, 0], out[i, 1] = scale * re / size, scale * im / size
    return out


@compiled()
def _apply(x: Floats, pull: Floats, indptr: Ints, index: Ints, weight: Floats, out: Floats) -> None:
    for i in range(len(x)):
        sx = pull[i, 0] * x[i, 0] + pull[i, 1] * x[i, 1]
        sy = pull[i, 1] * x[i, 0] + pull[i, 2] * x[i, 1]
        for k in range(indptr[i], indptr[i + 1]):
            j = index[k]
            sx += weight[k] * (x[i, 0] - x[j, 0])
            sy += weight[k] * (x[i, 1] - x[j, 1])
        out[i, 0], out[i, 1] = sx, sy


@compiled()
def relax(
    x: Floats,
    rest: Floats,
    edges: tuple[Ints, Ints, Floats],
    springs: tuple[Floats, Floats],
    scale: tuple[float, float],
    iterations: int,
) -> Floats:
    """Move nodes to where springs and rest shape agree: local rotations, then one linear solve for all nodes.

    Args:
        x: Present positions. [N, 2]
        rest: Positions at rest. [N, 2]
        edges: Neighbours of each node as compressed rows, and their stiffness: indptr, index, weight.
        springs: Stiffness [N, 3] and right-hand side [N, 2] of the springs; see `assemble`.
        scale: Least and largest local scale; 1 and 1 is as rigid as possible.
        iterations: Most conjugate-gradient iterations.

    Returns:
        New positions. [N, 2]

    Source:
        Sorkine and Alexa 2007, "As-Rigid-As-Possible Surface Modeling".
    """
    indptr, index, weight = edges
    pull, rhs = springs
    turn = rotations(x, rest, indptr, index, weight, scale[0], scale[1])
    n = len(x)
    out = x.copy()
    inverse = np.empty((n, 3))
    r = np.empty((n, 2))
    _apply(out, pull, indptr, index, weight, r)
    for i in range(n):
        total, bx, by = 1e-9, rhs[i, 0], rhs[i, 1]
        for k in range(indptr[i], indptr[i + 1]):
            j = index[k]
            re, im = 0.5 * (turn[i, 0] + turn[j, 0]), 0.5 * (turn[i, 1] + turn[j, 1])
            rx, ry = rest[i, 0] - rest[j, 0], rest[i, 1] - rest[j, 1]
            bx += weight[k] * (re * rx - im * ry)
            by += weight[k] * (im * rx + re * ry)
            total += weight[k]
        r[i, 0], r[i, 1] = bx - r[i, 0], by - r[i, 1]
        xx, xy, yy = pull[i, 0] + total, pull[i, 1], pull[i, 2] + total
        determinant = xx * yy - xy * xy
        inverse[i, 0], inverse[i, 1], inverse[i, 2] = yy / determinant, -xy / determinant, xx / determinant
    _conjugate_gradients(out, r, inverse, pull, edges, iterations)
    return out


@compiled()
def _conjugate_gradients(
    x: Floats, r: Floats, inverse: Floats, pull: Floats, edges: tuple[Ints, Ints, Floats], iterations: int
) -> None:
    """Solve in place from a residual, preconditioned by each node's own 2 x 2 block."""
    indptr, index, weight = edges
    n = len(x)
    z = np.empty((n, 2))
    p = np.zeros((n, 2))
    ap = np.empty((n, 2))
    rz_old, rz_first = 1.0, -1.0
    for step in range(iterations):
        rz = 0.0
        for i in range(n):
            z[i, 0] = inverse[i, 0] * r[i, 0] + inverse[i, 1] * r[i, 1]
            z[i, 1] = inverse[i, 1] * r[i, 0] + inverse[i, 2] * r[i, 1]
            rz += r[i, 0] * z[i, 0] + r[i, 1] * z[i, 1]
        if step == 0:
            rz_first = rz
        if rz <= 1e-6 * rz_first or rz < 1e-8 * n:
            return
        for i in range(n):
            for c in range(2):
                p[i, c] = z[i, c] + (rz / rz_old if step else 0.0) * p[i, c]
        _apply(p, pull, indptr, index, weight, ap)
        curvature = 0.0
        for i in range(n):
            curvature += p[i, 0] * ap[i, 0] + p[i, 1] * ap[i, 1]
        if curvature <= 0.0:
            return
        length = rz / curvature
        for i in range(n):
            for c in range(2):
                x[i, c] += length * p[i, c]
                r[i, c] -= length * ap[i, c]
        rz_old = rz
