"""Coverage of (chunk, pixel) pairs and its derivatives, by hand, in numba.

For a pixel with centre p let t be the parameter of the chunk's nearest point B(t), r = p - B, d = |r|, h = h(t) and n
the unit normal there (across the curve, or along r where the chunk ends or has no tangent; there r is stretched, see
`videovec.render.limits`). The pixel's square of side
``scale``, projected on n, is a trapezoid; Q is its integral from 0, and

    coverage = Q(h - d) + Q(h + d),    dc = c_h dh + c_d dd + c_psi dpsi,    psi the angle of n.

Inside the chunk r . B' = 0 stays true when a control point moves, hence with D = B'^2 - r . B''

    dt = sum_i (b_i' r - b_i B') . dP_i / D     and     dpsi = (n . dB') / |B'|,

where dB' counts both the b_i' and B'' dt. Every derivative is thus  dc/dP_i = b_i U + b_i' V  with two vectors U and V
that a pair computes once. Where the nearest point is an end of the chunk, dt = 0 and psi turns with the
stretched r, which depends on the tangent and on h as well.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from videovec.compiling import compiled
from videovec.render.limits import BENT, NARROWEST, NEAREST, SLOWEST, THINNEST

__all__ = ["PARTIALS", "accumulate", "at_parameter", "cover_pairs", "cubic_of", "differentiate"]

Array = NDArray[Any]

PARTIALS = 5
"""Values that a pair leaves for the backward: U, V and dc/dh."""


@compiled(fastmath=True)
def cubic_of(p: Array) -> tuple[Any, ...]:
    """Coefficients of t, t² and t³ of a segment relative to its first control point."""
    three = p.dtype.type(3)  # An integer would turn float32 into float64.
    x1, y1 = three * (p[1, 0] - p[0, 0]), three * (p[1, 1] - p[0, 1])
    x2, y2 = three * (p[2, 0] - p[1, 0]) - x1, three * (p[2, 1] - p[1, 1]) - y1
    return x1, y1, x2, y2, p[3, 0] - p[0, 0] - x1 - x2, p[3, 1] - p[0, 1] - y1 - y2


@compiled(fastmath=True)
def at_parameter(c: tuple[Any, ...], px: Any, py: Any, t: Any) -> tuple[Any, ...]:
    """From the curve to the pixel, and the curve's first and second derivative."""
    x1, y1, x2, y2, x3, y3 = c
    u, v = x3 * t, y3 * t
    u3, v3 = u + u + u, v + v + v
    w, z = x2 + x2, y2 + y2
    rx, ry = px - ((u + x2) * t + x1) * t, py - ((v + y2) * t + y1) * t
    return rx, ry, (u3 + w) * t + x1, (v3 + z) * t + y1, u3 + u3 + w, v3 + v3 + z


@compiled(fastmath=True)
def _band(h: Any, d: Any, a: Any, b: Any, half: Any) -> Any:
    """Coverage of a band of half-width h at distance d by the trapezoid of boxes of widths a >= b."""
    per_two_ab = half / (a * b)
    near = _integral(abs(h - d), a, b, per_two_ab, half)
    far = _integral(h + d, a, b, per_two_ab, half)
    return far + near if h >= d else far - near


@compiled(fastmath=True)
def _integral(m: Any, a: Any, b: Any, per_two_ab: Any, half: Any) -> Any:
    """Integral from 0 to m >= 0 of boxes of widths a >= b convolved; beyond them exactly 1/2."""
    flat = half * (a - b)
    q = min(max(flat + b - m, half - half), b)
    return half - ((b + b) * (flat - min(m, flat)) + q * q) * per_two_ab


@compiled(fastmath=True)
def _slopes(m: Any, a: Any, b: Any, per: tuple[Any, Any], half: Any) -> tuple[Any, Any, Any]:
    """Derivatives of `_integral` by m, a and b."""
    per_a, per_b = per
    flat = half * (a - b)
    q = min(max(flat + b - m, half - half), b)
    by_a = per_a * per_a * (half * q * (q - a) * per_b + flat - min(m, flat))
    return q * per_a * per_b, by_a, half * q * (q - b) * per_a * per_b * per_b


@compiled(fastmath=True)
def _profile(h: Any, d: Any, nx: Any, ny: Any, k: Any, limit: Any, half: Any) -> tuple[Any, ...]:
    """Derivatives of the coverage of a band of half-width h at distance d by h, d and the angle of n."""
    one = half + half
    wide, thin = max(abs(nx), abs(ny)), min(abs(nx), abs(ny))
    a, b = k * wide, k * max(thin, limit)
    per = one / a, one / b
    near_f, near_a, near_b = _slopes(abs(h - d), a, b, per, half)
    far_f, far_a, far_b = _slopes(h + d, a, b, per, half)
    sign = one if h >= d else -one
    spin = k if (abs(nx) >= abs(ny)) == (nx * ny >= one - one) else -k
    by_b = (far_b + sign * near_b) * wide if thin > limit else one - one
    by_psi = spin * (by_b - (far_a + sign * near_a) * thin)
    return far_f + near_f, far_f - near_f, by_psi


@compiled()
def _stretch(p: Array, h: Any, k: Any, is_dot: bool) -> tuple[Any, Any, Any, Any]:
    """Factors of distances from an end, in all directions and what is added along the tangent; their slopes by h."""
    real = p.dtype.type
    q = max(h / k, real(THINNEST))
    if q < real(0.5):
        m, slope = real(2 / 3) * q + real(0.5) / q, (real(2 / 3) - real(0.5) / (q * q)) / k
    else:
        m, slope = real(1) + real(1 / 12) / (q * q), -real(1 / 6) / (q * q * q * k)
    if q == real(THINNEST):
        slope = real(0)
    if is_dot:
        return np.sqrt(m), real(0), real(0.5) * slope / np.sqrt(m), real(0)
    return real(1), m - real(1), real(0), slope


@compiled()
def _ends(control: Array, half_width: Array, visible: tuple[Any, Any], k: Any) -> tuple[Any, ...]:
    """First and last t of a chunk, their middle if it is a dot; how distances from either are stretched, 2 x 4."""
    is_dot = True
    for n in range(1, 4):
        farther = max(abs(control[n, 0] - control[0, 0]), abs(control[n, 1] - control[0, 1]))
        is_dot = is_dot and farther < control.dtype.type(SLOWEST)
    middle = control.dtype.type(0.5) * (visible[0] + visible[1])
    lo, hi = (middle, middle) if is_dot else visible
    h0, dh = half_width[0], half_width[1] - half_width[0]
    return lo, hi, _stretch(control, h0 + dh * lo, k, is_dot), _stretch(control, h0 + dh * hi, k, is_dot)


@compiled(fastmath=True)
def cover_pairs(
    curve: tuple[Array, Array], visible: tuple[Any, Any], scale: float, pixels: tuple[Array, Array], out: Any
) -> None:
    """Improve t by one Newton step, and write the coverage of the pairs of one chunk.

    All arithmetic is in the precision of the curve; the loop has no branches, so that it runs in vector registers.

    Args:
        curve: Control points of the chunk's segment [4, 2] and half-width at its ends [2]. px
        visible: First and last visible t of the chunk.
        scale: Side of the kernel. px
        pixels: Column and row of each pair. int16 [n], int16 [n]
        out: t and coverage of each pair, written in place. 2 x [n]
    """
    control, half_width = curve
    real = control.dtype.type
    zero, half, one, quarter, tiny = real(0), real(0.5), real(1), real(0.25), real(1e-12)
    slowest2, nearest, limit, k = real(SLOWEST**2), real(NEAREST), real(NARROWEST), real(scale)
    lo, hi, (far_lo, more_lo, _, _), (far_hi, more_hi, _, _) = _ends(control, half_width, visible, k)
    middle, h0, dh = half * (lo + hi), half_width[0], half_width[1] - half_width[0]
    x0, y0 = control[0, 0] - half, control[0, 1] - half
    cubic = cubic_of(control)
    columns, rows = pixels
    ts, cs = out
    for i in range(len(ts)):
        px, py = real(columns[i]) - x0, real(rows[i]) - y0
        t = min(max(ts[i], lo), hi)
        rx, ry, bx, by, ax, ay = at_parameter(cubic, px, py, t)
        speed2 = bx * bx + by * by
        bend = max(speed2 - rx * ax - ry * ay, quarter * speed2 + tiny)
        t = min(max(t + (rx * bx + ry * by) / bend, lo), hi)
        ts[i] = t

        rx, ry, bx, by, ax, ay = at_parameter(cubic, px, py, t)
        speed2 = bx * bx + by * by
        has_speed = speed2 > slowest2
        is_inside = (t > lo) & (t < hi) & has_speed
        is_low = t < middle
        far = one if is_inside else (far_lo if is_low else far_hi)
        more = zero if is_inside else (more_lo if is_low else more_hi)
        along = more * (rx * bx + ry * by) / max(speed2, slowest2) if has_speed else zero
        ex, ey = far * rx + along * bx, far * ry + along * by
        d2 = ex * ex + ey * ey
        is_near = d2 < nearest * nearest
        has_tangent = is_inside | (is_near & has_speed)
        length2 = speed2 if has_tangent else (one if is_near else d2)
        nx = by if has_tangent else (one if is_near else ex)
        ny = bx if has_tangent else (zero if is_near else ey)
        per_length = one / np.sqrt(length2)
        wide, thin = max(abs(nx), abs(ny)) * per_length, min(abs(nx), abs(ny)) * per_length
        cs[i] = _band(h0 + dh * t, np.sqrt(d2), k * wide, k * max(thin, limit), half)


@compiled(fastmath=True)
def differentiate(
    curve: tuple[Array, Array], visible: tuple[Any, Any], scale: float, pixels: tuple[Array, Array, Array], out: Any
) -> None:
    """Write the partials of some pairs of one chunk: U (2), V (2) and dc/dh.

    Args:
        curve: Control points of the chunk's segment [4, 2] and half-width at its ends [2]. px
        visible: First and last visible t of the chunk.
        scale: Side of the kernel. px
        pixels: Column, row and t of each pair. 3 x [n]
        out: The partials. 5 x [n]
    """
    control, half_width = curve
    real = control.dtype.type
    zero, half, one, tiny = real(0), real(0.5), real(1), real(1e-12)
    slowest2, nearest, limit, bent, k = real(SLOWEST**2), real(NEAREST), real(NARROWEST), real(BENT), real(scale)
    lo, hi, low_end, high_end = _ends(control, half_width, visible, k)
    far_lo, more_lo, far_slope_lo, more_slope_lo = low_end
    far_hi, more_hi, far_slope_hi, more_slope_hi = high_end
    middle, h0, dh = half * (lo + hi), half_width[0], half_width[1] - half_width[0]
    x0, y0 = control[0, 0] - half, control[0, 1] - half
    cubic = cubic_of(control)
    columns, rows, ts = pixels
    uxs, uys, vxs, vys, hs = out
    for i in range(len(ts)):
        t = ts[i]
        rx, ry, bx, by, ax, ay = at_parameter(cubic, real(columns[i]) - x0, real(rows[i]) - y0, t)
        speed2 = bx * bx + by * by
        bend = max(max(speed2 - rx * ax - ry * ay, bent * speed2), bent * slowest2)
        has_speed = speed2 > slowest2
        is_inside = (t > lo) & (t < hi) & has_speed
        per_speed = one / np.sqrt(max(speed2, slowest2))
        tx, ty = bx * per_speed, by * per_speed
        u = rx * tx + ry * ty if has_speed else zero
        v = ry * tx - rx * ty

        # Around an end, r is stretched.
        is_low = t < middle
        far = one if is_inside else (far_lo if is_low else far_hi)
        more = zero if is_inside else (more_lo if is_low else more_hi)
        ex, ey = far * rx + more * u * tx, far * ry + more * u * ty
        d = np.sqrt(ex * ex + ey * ey)
        per_d = one / max(d, tiny)
        has_tangent = is_inside | ((d < nearest) & has_speed)
        nx = -ty if has_tangent else (ex * per_d if d >= nearest else one)
        ny = tx if has_tangent else (ey * per_d if d >= nearest else zero)
        by_h, by_d, by_psi = _profile(h0 + dh * t, d, nx, ny, k, limit, half)

        # psi turns with the tangent inside, with the stretched r at an end.
        along = -by_d * per_d
        around = zero if (has_tangent | (d < nearest)) else by_psi * per_d * per_d
        gx, gy = along * ex + around * ey, along * ey - around * ex
        g_u, g_v = gx * tx + gy * ty, gy * tx - gx * ty
        far_slope = zero if is_inside else (far_slope_lo if is_low else far_slope_hi)
        more_slope = zero if is_inside else (more_slope_lo if is_low else more_slope_hi)
        turn = (by_psi if has_tangent else zero) - more * (g_u * v + g_v * u)
        turn = turn * per_speed if has_speed else zero
        slide = (by_h * dh - turn * (ty * ax - tx * ay)) / bend if is_inside else zero
        hs[i] = by_h - far_slope * (gx * rx + gy * ry) - more_slope * u * g_u
        more_g = more * g_u if has_speed else zero
        uxs[i], uys[i] = far * gx + more_g * tx - slide * bx, far * gy + more_g * ty - slide * by
        vxs[i], vys[i] = -turn * ty + slide * rx, turn * tx + slide * ry


@compiled(fastmath=True)
def accumulate(
    ts: Array, weight: Array, partials: tuple[Array, ...], grad_control: Array, grad_half_width: Array
) -> None:
    """Add up the derivatives of one chunk's pairs, each times its ``weight``.

    Args:
        ts: t of each pair. [n]
        weight: Derivative of the loss by each pair's coverage. [n]
        partials: What `differentiate` wrote. 5 x [n]
        grad_control: Gradient of the chunk's segment, added to. [4, 2]
        grad_half_width: Gradient of its half-widths, added to. [2]
    """
    real = weight.dtype.type
    one, three = real(1), real(3)
    uxs, uys, vxs, vys, hs = partials
    h0 = h1 = x0 = x1 = x2 = x3 = y0 = y1 = y2 = y3 = real(0)
    for i in range(len(ts)):
        t, w = ts[i], weight[i]
        s = one - t
        b0, b1, b2, b3 = s * s * s, three * s * s * t, three * s * t * t, t * t * t
        d0, d1, d2, d3 = -three * s * s, three * s * (s - t - t), three * t * (s + s - t), three * t * t
        ux, uy, vx, vy, h = w * uxs[i], w * uys[i], w * vxs[i], w * vys[i], w * hs[i]
        x0, y0 = x0 + b0 * ux + d0 * vx, y0 + b0 * uy + d0 * vy
        x1, y1 = x1 + b1 * ux + d1 * vx, y1 + b1 * uy + d1 * vy
        x2, y2 = x2 + b2 * ux + d2 * vx, y2 + b2 * uy + d2 * vy
        x3, y3 = x3 + b3 * ux + d3 * vx, y3 + b3 * uy + d3 * vy
        h0, h1 = h0 + s * h, h1 + t * h
    for n, gradient in enumerate(((x0, y0), (x1, y1), (x2, y2), (x3, y3))):
        grad_control[n, 0] += gradient[0]
        grad_control[n, 1] += gradient[1]
    grad_half_width[0] += h0
    grad_half_width[1] += h1
