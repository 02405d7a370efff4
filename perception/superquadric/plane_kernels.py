"""Compiled side condition of a fit: the plane on which the solid rests."""

from __future__ import annotations

import numpy as np
from numba import njit

from .radial_kernels import FAST, log_gauge, log_sum, off_zero, pose_part

_SECTIONS = 24
_CLOSER = 30


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
