"""Coverage of (chunk, pixel) pairs and its derivatives, by hand, in numba.

For a pixel with centre p let t be the parameter of the chunk's nearest point B(t), r = p - B, d = |r|, h = h(t) and n
the unit normal there (across the curve, or along r where the chunk ends or has no tangent). The pixel's square of side
``scale``, projected on n, is a trapezoid; Q is its integral from 0, and

    coverage = Q(h - d) + Q(h + d),    dc = c_h dh + c_d dd + c_psi dpsi,    psi the angle of n.

Inside the chunk r . B' = 0 stays true when a control point moves, hence with D = B'^2 - r . B''

    dt = sum_i (b_i' r - b_i B') . dP_i / D     and     dpsi = (n . dB') / |B'|,

where dB' counts both the b_i' and B'' dt. Every derivative is thus  dc/dP_i = b_i U + b_i' V  with two vectors U and V
that a pair computes once. Where the nearest point is an end of the chunk, dt = 0 and psi turns with r.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numba import njit
from numpy.typing import NDArray

from videovec.render.limits import BENT, NARROWEST, NEAREST, SLOWEST

__all__ = ["PARTIALS", "accumulate", "evaluate"]

Array = NDArray[Any]

PARTIALS = 5
"""Values that a pair leaves for the backward: U, V and dc/dh."""


@njit(cache=True, fastmath=True, error_model="numpy", inline="always")
def _cubic(p: Array) -> tuple[float, float, float, float, float, float]:
    """Coefficients of t, t², t³ of a segment relative to its first control point."""
    x1, y1 = 3 * (p[1, 0] - p[0, 0]), 3 * (p[1, 1] - p[0, 1])
    x2, y2 = 3 * (p[2, 0] - p[1, 0]) - x1, 3 * (p[2, 1] - p[1, 1]) - y1
    x3, y3 = p[3, 0] - p[0, 0] - x1 - x2, p[3, 1] - p[0, 1] - y1 - y2
    return x1, y1, x2, y2, x3, y3


@njit(cache=True, fastmath=True, error_model="numpy")
def evaluate(
    control: Array, half_width: Array, ends: Array, scale: float, pixels: tuple[Array, Array], out: tuple[Array, ...]
) -> None:
    """Improve t by one Newton step, and write the coverage and the partials of the pairs of one chunk.

    All arithmetic is in the precision of ``control``; the loop has no branches, so that it runs in vector registers.

    Args:
        control: The chunk's segment. [4, 2] px
        half_width: At both ends of the segment. [2] px
        ends: First and last visible t of the chunk. [2]
        scale: Side of the kernel. px
        pixels: Column and row of each pair. int16 [n], int16 [n]
        out: t, coverage, U (2), V (2) and dc/dh of each pair, written in place. 7 x [n]
    """
    real = control.dtype.type
    zero, half, one, two, three = real(0), real(0.5), real(1), real(2), real(3)
    slowest2, nearest, narrowest, bent, quarter = (
        real(SLOWEST * SLOWEST),
        real(NEAREST),
        real(NARROWEST),
        real(BENT),
        real(0.25),
    )
    k = real(scale)
    lo, hi = ends[0], ends[1]
    h0, dh = half_width[0], half_width[1] - half_width[0]
    x0, y0 = control[0, 0] - half, control[0, 1] - half
    x1, y1, x2, y2, x3, y3 = _cubic(control)
    columns, rows = pixels
    ts, cs, uxs, uys, vxs, vys, hs = out
    for i in range(len(ts)):
        px, py = real(columns[i]) - x0, real(rows[i]) - y0

        t = min(max(ts[i], lo), hi)
        rx, ry = px - ((x3 * t + x2) * t + x1) * t, py - ((y3 * t + y2) * t + y1) * t
        bx, by = (three * x3 * t + two * x2) * t + x1, (three * y3 * t + two * y2) * t + y1
        ax, ay = three * two * x3 * t + two * x2, three * two * y3 * t + two * y2
        speed2 = bx * bx + by * by
        curvature = speed2 - rx * ax - ry * ay
        t += (rx * bx + ry * by) / max(curvature, quarter * speed2 + real(1e-12))
        t = min(max(t, lo), hi)
        ts[i] = t

        rx, ry = px - ((x3 * t + x2) * t + x1) * t, py - ((y3 * t + y2) * t + y1) * t
        bx, by = (three * x3 * t + two * x2) * t + x1, (three * y3 * t + two * y2) * t + y1
        ax, ay = three * two * x3 * t + two * x2, three * two * y3 * t + two * y2
        speed2 = bx * bx + by * by
        bend = max(speed2 - rx * ax - ry * ay, bent * speed2)
        d = np.sqrt(rx * rx + ry * ry)
        h = h0 + dh * t

        per_d = one / max(d, nearest)
        is_inside = (t > lo) & (t < hi) & (speed2 > slowest2)
        per_speed2 = one / max(speed2, slowest2)
        per_speed = np.sqrt(per_speed2)
        has_tangent = is_inside | ((d < nearest) & (speed2 > slowest2))
        nx = -by * per_speed if has_tangent else (rx * per_d if d >= nearest else one)
        ny = bx * per_speed if has_tangent else ry * per_d
        wide, thin = max(abs(nx), abs(ny)), min(abs(nx), abs(ny))
        thin_clamped = max(thin, narrowest)
        a, b = k * wide, k * thin_clamped
        per_a, per_b = one / a, one / b
        flat, outer = half * (a - b), half * (a + b)

        near, far = h - d, h + d
        m = abs(near)
        sign = one if near >= zero else -one
        q = min(max(outer - m, zero), b)
        on_flat = min(m, flat)
        near_q = sign * (on_flat * per_a + half * (b * b - q * q) * per_a * per_b)
        near_f = q * per_a * per_b
        near_a = sign * per_a * per_a * (half * q * (q - a) * per_b + flat - on_flat)
        near_b = sign * half * q * (q - b) * per_a * per_b * per_b

        q = min(max(outer - far, zero), b)
        on_flat = min(far, flat)
        far_q = on_flat * per_a + half * (b * b - q * q) * per_a * per_b
        far_f = q * per_a * per_b
        far_a = per_a * per_a * (half * q * (q - a) * per_b + flat - on_flat)
        far_b = half * q * (q - b) * per_a * per_b * per_b

        cs[i] = near_q + far_q
        c_h, c_d = near_f + far_f, far_f - near_f
        spin = k if (abs(nx) >= abs(ny)) == (nx * ny >= zero) else -k
        c_psi = spin * ((near_b + far_b) * wide * (one if thin > narrowest else zero) - (near_a + far_a) * thin)

        # Inside: psi turns with the tangent. At an end: with r.
        turn = c_psi * per_speed if has_tangent else zero
        slide = (c_h * dh + turn * (nx * ax + ny * ay)) / max(bend, bent * slowest2)
        slide = slide if is_inside else zero
        along = -c_d * per_d
        around = zero if (has_tangent | (d < nearest)) else c_psi * per_d * per_d
        uxs[i] = along * rx + around * ry - slide * bx
        uys[i] = along * ry - around * rx - slide * by
        vxs[i] = turn * nx + slide * rx
        vys[i] = turn * ny + slide * ry
        hs[i] = c_h


@njit(cache=True, fastmath=True, error_model="numpy")
def accumulate(
    weight: Array, ends: Array, partials: tuple[Array, ...], grad_control: Array, grad_half_width: Array
) -> None:
    """Add up the derivatives of one chunk's pairs, each times its ``weight``.

    Args:
        weight: Derivative of the loss by each pair's coverage. [n]
        ends: First and last visible t of the chunk. [2]
        partials: What `evaluate` wrote. 7 x [n]
        grad_control: Gradient of the chunk's segment, added to. [4, 2]
        grad_half_width: Gradient of its half-widths, added to. [2]
    """
    real = weight.dtype.type
    one, two, three = real(1), real(2), real(3)
    ts, _, uxs, uys, vxs, vys, hs = partials
    h0 = h1 = gx0 = gx1 = gx2 = gx3 = gy0 = gy1 = gy2 = gy3 = real(0)
    for i in range(len(ts)):
        t, w = ts[i], weight[i]
        s = one - t
        b0, b1, b2, b3 = s * s * s, three * s * s * t, three * s * t * t, t * t * t
        d0, d1, d2, d3 = -three * s * s, three * s * (s - two * t), three * t * (two * s - t), three * t * t
        ux, uy, vx, vy = w * uxs[i], w * uys[i], w * vxs[i], w * vys[i]
        gx0 += b0 * ux + d0 * vx
        gx1 += b1 * ux + d1 * vx
        gx2 += b2 * ux + d2 * vx
        gx3 += b3 * ux + d3 * vx
        gy0 += b0 * uy + d0 * vy
        gy1 += b1 * uy + d1 * vy
        gy2 += b2 * uy + d2 * vy
        gy3 += b3 * uy + d3 * vy
        h = w * hs[i]
        h0 += s * h
        h1 += t * h
    grad_control[0, 0] += gx0
    grad_control[1, 0] += gx1
    grad_control[2, 0] += gx2
    grad_control[3, 0] += gx3
    grad_control[0, 1] += gy0
    grad_control[1, 1] += gy1
    grad_control[2, 1] += gy2
    grad_control[3, 1] += gy3
    grad_half_width[0] += h0
    grad_half_width[1] += h1
