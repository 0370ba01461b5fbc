"""The step of a fit on a GPU, in three Triton kernels: coverage of pairs, pixels, gradients of segments.

The formulas are those of `videovec.render.numba_kernels`, which derives them. Nothing is added atomically, so that
equal inputs give equal bits: a chunk writes its own pairs, a pixel its own value and the weights of its own pairs, a
segment its own gradients.
"""

from __future__ import annotations

import triton
import triton.language as tl

from videovec.render import limits

__all__ = ["cover_chunks", "gather_segments", "match_pixels"]

SLOWEST = tl.constexpr(limits.SLOWEST)
SLOWEST2 = tl.constexpr(limits.SLOWEST**2)
NEAREST = tl.constexpr(limits.NEAREST)
NARROWEST = tl.constexpr(limits.NARROWEST)
THINNEST = tl.constexpr(limits.THINNEST)
BENT = tl.constexpr(limits.BENT)
"""The limits in a form that kernels can read."""


@triton.jit
def _cubic(control, g):
    """First control point, and the coefficients of t, t² and t³ relative to it, as (x0, y0, x1, ..., y3)."""
    p = control + g * 8
    x0, y0, ax, ay = tl.load(p), tl.load(p + 1), tl.load(p + 2), tl.load(p + 3)
    bx, by, cx, cy = tl.load(p + 4), tl.load(p + 5), tl.load(p + 6), tl.load(p + 7)
    x1, y1 = 3 * (ax - x0), 3 * (ay - y0)
    x2, y2 = 3 * (bx - ax) - x1, 3 * (by - ay) - y1
    wide = tl.maximum(tl.maximum(tl.abs(ax - x0), tl.abs(bx - x0)), tl.abs(cx - x0))
    high = tl.maximum(tl.maximum(tl.abs(ay - y0), tl.abs(by - y0)), tl.abs(cy - y0))
    is_dot = tl.maximum(wide, high) < SLOWEST
    return x0, y0, x1, y1, x2, y2, cx - x0 - x1 - x2, cy - y0 - y1 - y2, is_dot


@triton.jit
def _at(c, t):
    """Place on the curve relative to its first point, and its first and second derivative."""
    _, _, x1, y1, x2, y2, x3, y3, _ = c
    x, y = ((x3 * t + x2) * t + x1) * t, ((y3 * t + y2) * t + y1) * t
    bx, by = (3 * x3 * t + 2 * x2) * t + x1, (3 * y3 * t + 2 * y2) * t + y1
    return x, y, bx, by, 6 * x3 * t + 2 * x2, 6 * y3 * t + 2 * y2


@triton.jit
def _visible(bounds, interval, chunk, g):
    """First and last visible t of a chunk, and whether those are ends of the visible interval."""
    b0, b1 = tl.load(bounds + 2 * chunk), tl.load(bounds + 2 * chunk + 1)
    i0, i1 = tl.load(interval + 2 * g), tl.load(interval + 2 * g + 1)
    return tl.maximum(b0, i0), tl.minimum(b1, i1), i0 >= b0, i1 <= b1


@triton.jit
def _stretch(h, k, is_dot):
    """Factors of distances from an end, everywhere and what is added along the tangent; their slopes by h."""
    q = tl.maximum(h / k, THINNEST)
    m = tl.where(q < 0.5, q * (2 / 3) + 0.5 / q, 1 + (1 / 12) / (q * q))
    slope = tl.where(q < 0.5, ((2 / 3) - 0.5 / (q * q)) / k, -(1 / 6) / (q * q * q * k))
    slope = tl.where(q == THINNEST, 0.0, slope)
    root = tl.sqrt(m)
    far, more = tl.where(is_dot, root, 1.0), tl.where(is_dot, 0.0, m - 1)
    return far, more, tl.where(is_dot, 0.5 * slope / root, 0.0), tl.where(is_dot, 0.0, slope)


@triton.jit
def _integral(m, a, b):
    """Integral from 0 to m >= 0 of boxes of widths a >= b convolved."""
    flat = 0.5 * (a - b)
    q = tl.minimum(tl.maximum(flat + b - m, 0.0), b)
    return 0.5 - (2 * b * (flat - tl.minimum(m, flat)) + q * q) * 0.5 / (a * b)


@triton.jit
def _slopes(m, a, b):
    """Derivatives of `_integral` by m, a and b."""
    flat = 0.5 * (a - b)
    q = tl.minimum(tl.maximum(flat + b - m, 0.0), b)
    by_a = (0.5 * q * (q - a) / b + flat - tl.minimum(m, flat)) / (a * a)
    return q / (a * b), by_a, 0.5 * q * (q - b) / (a * b * b)


@triton.jit
def cover_chunks(
    control, half_width, interval, segment, bounds, chunk_pairs, xs, ys, ts, coverage, k, BLOCK: tl.constexpr
):  # fmt: skip
    """Improve t by one Newton step, and write the coverage of the pairs of one chunk."""
    chunk = tl.program_id(0)
    g = tl.load(segment + chunk)
    c = _cubic(control, g)
    x0, y0, is_dot = c[0], c[1], c[8]
    lo, hi, _, _ = _visible(bounds, interval, chunk, g)
    is_visible = hi > lo
    middle = 0.5 * (lo + hi)
    lo, hi = tl.where(is_dot, middle, lo), tl.where(is_dot, middle, hi)
    h0 = tl.load(half_width + 2 * g)
    dh = tl.load(half_width + 2 * g + 1) - h0
    far_lo, more_lo, _, _ = _stretch(h0 + dh * lo, k, is_dot)
    far_hi, more_hi, _, _ = _stretch(h0 + dh * hi, k, is_dot)
    last = tl.load(chunk_pairs + chunk + 1)
    begin = tl.load(chunk_pairs + chunk)
    while begin < last:
        at = begin + tl.arange(0, BLOCK)
        here = at < last
        px = tl.load(xs + at, mask=here, other=0).to(tl.float32) + 0.5 - x0
        py = tl.load(ys + at, mask=here, other=0).to(tl.float32) + 0.5 - y0
        t = tl.minimum(tl.maximum(tl.load(ts + at, mask=here, other=0.0), lo), hi)
        x, y, bx, by, ax, ay = _at(c, t)
        rx, ry, speed2 = px - x, py - y, bx * bx + by * by
        bend = tl.maximum(speed2 - rx * ax - ry * ay, 0.25 * speed2 + 1e-12)
        t = tl.minimum(tl.maximum(t + (rx * bx + ry * by) / bend, lo), hi)
        tl.store(ts + at, t, mask=here)

        x, y, bx, by, ax, ay = _at(c, t)
        rx, ry, speed2 = px - x, py - y, bx * bx + by * by
        has_speed = speed2 > SLOWEST2
        is_inside = (t > lo) & (t < hi) & has_speed
        far = tl.where(is_inside, 1.0, tl.where(t < middle, far_lo, far_hi))
        more = tl.where(is_inside, 0.0, tl.where(t < middle, more_lo, more_hi))
        along = tl.where(has_speed, more * (rx * bx + ry * by) / tl.maximum(speed2, SLOWEST2), 0.0)
        ex, ey = far * rx + along * bx, far * ry + along * by
        d2 = ex * ex + ey * ey
        is_near = d2 < NEAREST * NEAREST
        has_tangent = is_inside | (is_near & has_speed)
        length2 = tl.where(has_tangent, speed2, tl.where(is_near, 1.0, d2))
        nx = tl.where(has_tangent, by, tl.where(is_near, 1.0, ex))
        ny = tl.where(has_tangent, bx, tl.where(is_near, 0.0, ey))
        per_length = 1 / tl.sqrt(length2)
        wide = k * tl.maximum(tl.abs(nx), tl.abs(ny)) * per_length
        thin = k * tl.maximum(tl.minimum(tl.abs(nx), tl.abs(ny)) * per_length, NARROWEST)
        h, d = h0 + dh * t, tl.sqrt(d2)
        near, beyond = _integral(tl.abs(h - d), wide, thin), _integral(h + d, wide, thin)
        covered = tl.where(h >= d, beyond + near, beyond - near)
        tl.store(coverage + at, tl.where(is_visible, covered, 0.0), mask=here)
        begin += BLOCK


@triton.jit
def match_pixels(
    opacity, start, order, order_row, active, target, extra, coverage, weight, value, squared, slope_opacity, pixels,
    HAS_EXTRA: tl.constexpr, BLOCK: tl.constexpr,
):  # fmt: skip
    """Union of the rows on each active pixel, its squared residual, and the derivatives of the loss by its pairs.

    ``weight`` and ``slope_opacity`` come as zeros: only the pair of each row that covers most gets a weight.
    """
    pixel = tl.program_id(0) * BLOCK + tl.arange(0, BLOCK)
    here = pixel < pixels
    begin = tl.load(start + pixel, mask=here, other=0)
    count = tl.load(start + pixel + 1, mask=here, other=0) - begin
    most = tl.max(count, axis=0)

    # Upwards: what shows through the rows below is left at each row's pair.
    clear, row = tl.full([BLOCK], 1.0, tl.float32), tl.full([BLOCK], -1, tl.int32)
    best, winner = tl.full([BLOCK], 0.0, tl.float32), tl.full([BLOCK], 0, tl.int32)
    n = 0
    while n <= most:
        is_pair = here & (n < count)
        this_row = tl.load(order_row + begin + n, mask=is_pair, other=-1)
        this = tl.load(order + begin + n, mask=is_pair, other=0)
        covered = tl.load(coverage + this, mask=is_pair, other=0.0)
        is_new = this_row != row
        ends = is_new & (row >= 0)
        tl.store(weight + winner, clear, mask=ends)
        below = tl.load(opacity + row, mask=ends, other=0.0)
        clear = tl.where(ends, clear * (1 - below * best), clear)
        takes = is_new | (covered > best)
        best, winner = tl.where(takes, covered, best), tl.where(takes, this, winner)
        row = this_row
        n += 1

    drawn = 1 - clear
    wanted = tl.load(target + tl.load(active + pixel, mask=here, other=0), mask=here, other=0).to(tl.float32)
    residual = drawn - wanted * (1 / 255)
    slope = 2 * residual
    if HAS_EXTRA:
        slope += tl.load(extra + pixel, mask=here, other=0.0)
    tl.store(value + pixel, drawn, mask=here)
    tl.store(squared + pixel, residual * residual, mask=here)

    # Downwards: the rows above dim the slope.
    row = tl.full([BLOCK], -1, tl.int32)
    best, winner = tl.full([BLOCK], 0.0, tl.float32), tl.full([BLOCK], 0, tl.int32)
    n = count - 1
    while most >= 0:
        is_pair = here & (n >= 0)
        this_row = tl.load(order_row + begin + n, mask=is_pair, other=-1)
        this = tl.load(order + begin + n, mask=is_pair, other=0)
        covered = tl.load(coverage + this, mask=is_pair, other=0.0)
        is_new = this_row != row
        ends = is_new & (row >= 0)
        own = tl.load(opacity + row, mask=ends, other=0.0)
        through = slope * tl.load(weight + winner, mask=ends, other=0.0)
        is_steep = (best > 0) & (best < 1)
        tl.store(weight + winner, tl.where(is_steep, through * own, 0.0), mask=ends)
        tl.store(slope_opacity + winner, through * best, mask=ends)
        slope = tl.where(ends, slope * (1 - own * best), slope)
        takes = is_new | (covered >= best)
        best, winner = tl.where(takes, covered, best), tl.where(takes, this, winner)
        row = this_row
        n -= 1
        most -= 1


@triton.jit
def gather_segments(
    control, half_width, interval, bounds, chunk_pairs, first_chunk, chunk_count, xs, ys, ts, weight, slope_opacity,
    by_control, by_half_width, by_interval, by_opacity, k, BLOCK: tl.constexpr,
):  # fmt: skip
    """Gradients of one segment: its control points, half-widths, visible interval, and its share of the opacity."""
    g = tl.program_id(0)
    c = _cubic(control, g)
    x0, y0, is_dot = c[0], c[1], c[8]
    h0 = tl.load(half_width + 2 * g)
    dh = tl.load(half_width + 2 * g + 1) - h0
    zero = tl.full([BLOCK], 0.0, tl.float32)
    gx0, gx1, gx2, gx3, gy0, gy1, gy2, gy3 = zero, zero, zero, zero, zero, zero, zero, zero
    gh0, gh1, gi0, gi1, go = zero, zero, zero, zero, zero
    chunk = tl.load(first_chunk + g)
    stop = chunk + tl.load(chunk_count + g)
    while chunk < stop:
        lo, hi, is_first, is_last = _visible(bounds, interval, chunk, g)
        begin, last = tl.load(chunk_pairs + chunk), tl.load(chunk_pairs + chunk + 1)
        last = tl.where(hi > lo, last, begin)
        end0, end1 = tl.where(is_first, lo, -1.0), tl.where(is_last, hi, -1.0)
        middle = 0.5 * (lo + hi)
        lo, hi = tl.where(is_dot, middle, lo), tl.where(is_dot, middle, hi)
        far_lo, more_lo, far_slope_lo, more_slope_lo = _stretch(h0 + dh * lo, k, is_dot)
        far_hi, more_hi, far_slope_hi, more_slope_hi = _stretch(h0 + dh * hi, k, is_dot)
        while begin < last:
            at = begin + tl.arange(0, BLOCK)
            here = at < last
            w = tl.load(weight + at, mask=here, other=0.0)
            go += tl.load(slope_opacity + at, mask=here, other=0.0)
            t = tl.load(ts + at, mask=here, other=0.0)
            x, y, bx, by, ax, ay = _at(c, t)
            rx = tl.load(xs + at, mask=here, other=0).to(tl.float32) + 0.5 - x0 - x
            ry = tl.load(ys + at, mask=here, other=0).to(tl.float32) + 0.5 - y0 - y
            speed2 = bx * bx + by * by
            bend = tl.maximum(tl.maximum(speed2 - rx * ax - ry * ay, BENT * speed2), BENT * SLOWEST2)
            has_speed = speed2 > SLOWEST2
            is_inside = (t > lo) & (t < hi) & has_speed
            per_speed = 1 / tl.sqrt(tl.maximum(speed2, SLOWEST2))
            tx, ty = bx * per_speed, by * per_speed
            u = tl.where(has_speed, rx * tx + ry * ty, 0.0)
            v = ry * tx - rx * ty

            # Around an end, r is stretched.
            is_low = t < middle
            far = tl.where(is_inside, 1.0, tl.where(is_low, far_lo, far_hi))
            more = tl.where(is_inside, 0.0, tl.where(is_low, more_lo, more_hi))
            ex, ey = far * rx + more * u * tx, far * ry + more * u * ty
            d = tl.sqrt(ex * ex + ey * ey)
            per_d = 1 / tl.maximum(d, 1e-12)
            is_near = d < NEAREST
            has_tangent = is_inside | (is_near & has_speed)
            nx = tl.where(has_tangent, -ty, tl.where(is_near, 1.0, ex * per_d))
            ny = tl.where(has_tangent, tx, tl.where(is_near, 0.0, ey * per_d))

            # Slopes of the profile by half-width, distance and the normal's angle.
            h = h0 + dh * t
            wide, thin = tl.maximum(tl.abs(nx), tl.abs(ny)), tl.minimum(tl.abs(nx), tl.abs(ny))
            a, b = k * wide, k * tl.maximum(thin, NARROWEST)
            near_f, near_a, near_b = _slopes(tl.abs(h - d), a, b)
            far_f, far_a, far_b = _slopes(h + d, a, b)
            sign = tl.where(h >= d, 1.0, -1.0)
            spin = tl.where((tl.abs(nx) >= tl.abs(ny)) == (nx * ny >= 0), k, -k)
            by_b = tl.where(thin > NARROWEST, (far_b + sign * near_b) * wide, 0.0)
            by_psi = spin * (by_b - (far_a + sign * near_a) * thin)
            by_h, by_d = far_f + near_f, far_f - near_f

            along = -by_d * per_d
            around = tl.where(has_tangent | is_near, 0.0, by_psi * per_d * per_d)
            gx, gy = along * ex + around * ey, along * ey - around * ex
            g_u, g_v = gx * tx + gy * ty, gy * tx - gx * ty
            far_slope = tl.where(is_inside, 0.0, tl.where(is_low, far_slope_lo, far_slope_hi))
            more_slope = tl.where(is_inside, 0.0, tl.where(is_low, more_slope_lo, more_slope_hi))
            turn = tl.where(has_tangent, by_psi, 0.0) - more * (g_u * v + g_v * u)
            turn = tl.where(has_speed, turn * per_speed, 0.0)
            slide = tl.where(is_inside, (by_h * dh - turn * (ty * ax - tx * ay)) / bend, 0.0)
            by_h = w * (by_h - far_slope * (gx * rx + gy * ry) - more_slope * u * g_u)
            more_g = tl.where(has_speed, more * g_u, 0.0)
            ux, uy = w * (far * gx + more_g * tx - slide * bx), w * (far * gy + more_g * ty - slide * by)
            vx, vy = w * (slide * rx - turn * ty), w * (slide * ry + turn * tx)

            s = 1 - t
            gx0, gy0 = gx0 + s * s * (s * ux - 3 * vx), gy0 + s * s * (s * uy - 3 * vy)
            b1, d1 = 3 * s * s * t, 3 * s * (s - t - t)
            gx1, gy1 = gx1 + b1 * ux + d1 * vx, gy1 + b1 * uy + d1 * vy
            b2, d2 = 3 * s * t * t, 3 * t * (s + s - t)
            gx2, gy2 = gx2 + b2 * ux + d2 * vx, gy2 + b2 * uy + d2 * vy
            gx3, gy3 = gx3 + t * t * (t * ux + 3 * vx), gy3 + t * t * (t * uy + 3 * vy)
            gh0, gh1 = gh0 + s * by_h, gh1 + t * by_h
            # Pairs whose nearest point is a visible end move and widen with it.
            pull = ux * bx + uy * by + vx * ax + vy * ay + by_h * dh
            gi0 += tl.where(here & (t == end0), pull, 0.0)
            gi1 += tl.where(here & (t == end1), pull, 0.0)
            begin += BLOCK
        chunk += 1
    out = by_control + g * 8
    tl.store(out, tl.sum(gx0, axis=0))
    tl.store(out + 1, tl.sum(gy0, axis=0))
    tl.store(out + 2, tl.sum(gx1, axis=0))
    tl.store(out + 3, tl.sum(gy1, axis=0))
    tl.store(out + 4, tl.sum(gx2, axis=0))
    tl.store(out + 5, tl.sum(gy2, axis=0))
    tl.store(out + 6, tl.sum(gx3, axis=0))
    tl.store(out + 7, tl.sum(gy3, axis=0))
    tl.store(by_half_width + 2 * g, tl.sum(gh0, axis=0))
    tl.store(by_half_width + 2 * g + 1, tl.sum(gh1, axis=0))
    tl.store(by_interval + 2 * g, tl.sum(gi0, axis=0))
    tl.store(by_interval + 2 * g + 1, tl.sum(gi1, axis=0))
    tl.store(by_opacity + g, tl.sum(go, axis=0))
