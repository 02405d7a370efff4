"""Compiled side conditions of a fit: rays that miss the solid, the plane on which it rests."""

from __future__ import annotations

import numpy as np
from numba import njit

from .gauge_kernels import FAST, height_share, log_gauge, log_sum, off_zero, pose_part, to_local

_RAY_ITERATIONS = 60
_RAY_TOLERANCE = 1e-7
_BALL = 1.8  # every straight superquadric fits into a ball of sqrt(3) times its largest semi-axis
_SECTIONS = 24
_CLOSER = 30


@njit(cache=True, nogil=True, error_model="numpy", fastmath=FAST)
def ray_row(direction, origin, axes, eps, R, c, taper, tapered, outside, row, local):
    """Depth s (1 - min G) by which a ray enters the solid, and its derivatives.

    Of a ray that misses, the depth is negative where `outside` asks for it, else 0.
    By the envelope theorem the derivative at the minimum over the ray needs no derivative of
    the minimiser. s is the smallest semi-axis.
    """
    to_centre = (
        direction[0] * (c[0] - origin[0])
        + direction[1] * (c[1] - origin[1])
        + direction[2] * (c[2] - origin[2])
    )
    reach = np.exp(max(axes[0], axes[1], axes[2])) * _BALL
    if tapered:
        reach *= 1.0 + max(abs(taper[0]), abs(taper[1]))
    # A ray that misses the bounding ball misses the solid.
    miss = 0.0
    for k in range(3):
        gap = origin[k] + to_centre * direction[k] - c[k]
        miss += gap * gap
    if miss > reach * reach and not outside:
        return 0.0
    low, high = to_centre - reach, to_centre + reach
    g_low, s_low = _gauge_on_ray(low, direction, origin, axes, eps, R, c, taper, tapered, local)
    g_high, s_high = _gauge_on_ray(high, direction, origin, axes, eps, R, c, taper, tapered, local)
    gauge = 1.0
    for iteration in range(_RAY_ITERATIONS):
        if s_low >= 0.0 or s_high <= 0.0:
            if not outside:
                return 0.0
            break
        # A convex function lies above its tangents: where they meet is a bound and a good guess.
        # A taper bends the gauge, then they are a guess alone.
        t = (g_high - g_low + s_low * low - s_high * high) / (s_low - s_high)
        if not (outside or tapered) and g_low + s_low * (t - low) >= 1.0:
            return 0.0
        if iteration % 3 == 2 or not (low < t < high):
            t = 0.5 * (low + high)
        gauge, slope = _gauge_on_ray(t, direction, origin, axes, eps, R, c, taper, tapered, local)
        if slope < 0.0:
            low, g_low, s_low = t, gauge, slope
        else:
            high, g_high, s_high = t, gauge, slope
        if high - low < _RAY_TOLERANCE * reach or abs(slope) * reach < _RAY_TOLERANCE:
            break
    if gauge >= 1.0 and not outside:
        return 0.0
    smallest = 0
    for k in range(1, 3):
        if axes[k] < axes[smallest]:
            smallest = k
    s = np.exp(axes[smallest])
    outward = -s * gauge
    x, y, z = off_zero(local[0]), off_zero(local[1]), off_zero(local[2])
    width1, width2, lean1, lean2, height = 1.0, 1.0, 0.0, 0.0, 0.0
    if tapered:
        height, rise = height_share(z, axes[2])
        width1, width2 = 1.0 + taper[0] * height, 1.0 + taper[1] * height
        lean1, lean2 = taper[0] * rise / width1, taper[1] * rise / width2
    _, p1, p2, p3, h1, h2 = log_gauge(x / width1, y / width2, z, axes, eps)
    lean = p1 * lean1 + p2 * lean2
    row[0], row[1], row[2] = -outward * p1, -outward * p2, -outward * (p3 - lean * z)
    row[smallest] += s * (1.0 - gauge)
    row[3], row[4] = outward * h1, outward * h2
    row[11] = -outward * p1 * height / width1
    row[12] = -outward * p2 * height / width2
    pose_part(row, outward * p1 / x, outward * p2 / y, outward * (p3 / z - lean), x, y, z)
    return s * (1.0 - gauge)


@njit(cache=True, nogil=True, error_model="numpy", fastmath=FAST)
def plane_row(plane, axes, eps, R, c, taper, tapered, row, local):
    """Height of the solid's lowest point over the plane, and its derivatives."""
    for k in range(3):
        local[k] = -(R[0, k] * plane[0] + R[1, k] * plane[1] + R[2, k] * plane[2])
    x, y, z = off_zero(local[0]), off_zero(local[1]), off_zero(local[2])
    height = plane[0] * c[0] + plane[1] * c[1] + plane[2] * c[2] + plane[3]
    row[11], row[12] = 0.0, 0.0
    if tapered:
        support, v1, v2, v3 = _tapered_support(x, y, z, axes, eps, taper, row)
    else:
        # The support function is the dual gauge: exponents 2 - ε on inverse semi-axes.
        log_h, p1, p2, p3, h1, h2 = log_gauge(x, y, z, -axes, 2.0 - eps)
        support = np.exp(log_h)
        v1, v2, v3 = support * p1 / x, support * p2 / y, support * p3 / z
        row[0], row[1], row[2] = -support * p1, -support * p2, -support * p3
        row[3], row[4] = support * h1, support * h2
    # The direction turns like a point about the origin; the centre moves along the normal.
    pose_part(row, -v1, -v2, -v3, x, y, z)
    row[8], row[9], row[10] = -local[0], -local[1], -local[2]
    return height - support


@njit(cache=True, nogil=True, error_model="numpy", fastmath=FAST)
def _tapered_support(x, y, z, axes, eps, taper, row):
    """Support along (x, y, z) and the point that touches; fills shape derivatives of -support.

    The highest section is found on a grid, then by interval halving; by the envelope theorem its
    height counts as fixed.
    """
    best, middle = -np.inf, 0.0
    for k in range(-_SECTIONS, _SECTIONS + 1):
        t = k / _SECTIONS
        value = _section(t, x, y, z, axes, eps, taper)[0]
        if value > best:
            best, middle = value, t
    step = 1.0 / _SECTIONS
    for _ in range(_CLOSER):
        step *= 0.6
        for side in (-1.0, 1.0):
            t = min(max(middle + side * step, -1.0), 1.0)
            value = _section(t, x, y, z, axes, eps, taper)[0]
            if value > best:
                best, middle = value, t
    t = middle
    support, across, u1, u2, width1, width2, spread = _section(t, x, y, z, axes, eps, taper)
    a3 = np.exp(axes[2])
    row[0], row[1], row[2] = -across * u1, -across * u2, -a3 * t * z
    row[11], row[12] = -across * u1 * t / width1, -across * u2 * t / width2
    depth = max(abs(t), 1e-12) ** (2.0 / eps[0])
    left = max(1.0 - depth, 1e-12)
    slope = 0.5 * np.log(left) + depth / left * np.log(max(abs(t), 1e-12)) / eps[0]
    row[3] = -across * slope
    row[4] = 0.5 * across * spread
    return support, across * u1 / x, across * u2 / y, a3 * t


@njit(cache=True, nogil=True, error_model="numpy", fastmath=FAST)
def _section(t, x, y, z, axes, eps, taper):
    """Support of the section at height t a3, its part across z, shares, widths, entropy."""
    width1, width2 = 1.0 + taper[0] * t, 1.0 + taper[1] * t
    power = 2.0 / (2.0 - eps[1])
    l1 = power * (np.log(abs(x) * width1) + axes[0])
    l2 = power * (np.log(abs(y) * width2) + axes[1])
    log_a, u1, u2 = log_sum(l1, l2)
    size = max(1.0 - abs(t) ** (2.0 / eps[0]), 0.0) ** (0.5 * eps[0])
    across = size * np.exp(log_a / power)
    spread = log_a - u1 * l1 - u2 * l2
    return across + t * z * np.exp(axes[2]), across, u1, u2, width1, width2, spread


@njit(cache=True, nogil=True, error_model="numpy", fastmath=FAST)
def _gauge_on_ray(t, direction, origin, axes, eps, R, c, taper, tapered, local):
    """G and dG/dt at `origin + t direction`; leaves the point in `local`."""
    to_local(
        origin[0] + t * direction[0],
        origin[1] + t * direction[1],
        origin[2] + t * direction[2],
        R,
        c,
        local,
    )
    x, y, z = off_zero(local[0]), off_zero(local[1]), off_zero(local[2])
    width1, width2, lean1, lean2 = 1.0, 1.0, 0.0, 0.0
    if tapered:
        height, rise = height_share(z, axes[2])
        width1, width2 = 1.0 + taper[0] * height, 1.0 + taper[1] * height
        lean1, lean2 = taper[0] * rise / width1, taper[1] * rise / width2
    e1, e2 = eps[0], eps[1]
    ax = 2.0 / e2 * (np.log(abs(x / width1)) - axes[0])
    ay = 2.0 / e2 * (np.log(abs(y / width2)) - axes[1])
    log_a, u1, u2 = log_sum(ax, ay)
    log_f, w, w3 = log_sum(e2 / e1 * log_a, 2.0 / e1 * (np.log(abs(z)) - axes[2]))
    gauge = np.exp(0.5 * e1 * log_f)
    g1, g2 = w * u1 / x, w * u2 / y
    g3 = w3 / z - w * u1 * lean1 - w * u2 * lean2
    slope = 0.0
    for k in range(3):
        slope += (R[k, 0] * g1 + R[k, 1] * g2 + R[k, 2] * g3) * direction[k]
    return gauge, gauge * slope
