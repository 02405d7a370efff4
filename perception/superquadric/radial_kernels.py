"""Compiled pieces of the gauge that every residual of a superquadric shares."""

from __future__ import annotations

import numpy as np
from numba import njit

from .radial_scale import TAPER_REACH

FAST = {"contract", "reassoc", "arcp", "nsz"}
"""Liberties that change rounding alone; infinities and NaN keep their meaning."""

SMALL = 1e-7
"""Coordinates nearer to 0 count as this: their logarithms stay finite."""


@njit(cache=True, nogil=True, error_model="numpy", fastmath=FAST)
def to_local(x, y, z, R, c, local):
    """Write a point in shape coordinates into `local` (3,)."""
    dx, dy, dz = x - c[0], y - c[1], z - c[2]
    for k in range(3):
        local[k] = R[0, k] * dx + R[1, k] * dy + R[2, k] * dz


@njit(cache=True, nogil=True, error_model="numpy", fastmath=FAST)
def off_zero(x):
    """Keep a coordinate's logarithm finite."""
    if abs(x) < SMALL:
        return SMALL if x >= 0.0 else -SMALL
    return x


@njit(cache=True, nogil=True, error_model="numpy", fastmath=FAST)
def log_sum(a, b):
    """log(exp a + exp b) and the two shares of the sum, without overflow."""
    if a > b:
        ratio = np.exp(b - a)
        share = 1.0 / (1.0 + ratio)
        return a + np.log1p(ratio), share, ratio * share
    ratio = np.exp(a - b)
    share = 1.0 / (1.0 + ratio)
    return b + np.log1p(ratio), ratio * share, share


@njit(cache=True, nogil=True, error_model="numpy", fastmath=FAST)
def height_share(z, log_a3):
    """Height over a3 at which the taper is taken, and its slope by z, 0 beyond the reach."""
    a3 = np.exp(log_a3)
    height = z / a3
    if height > TAPER_REACH:
        return TAPER_REACH, 0.0
    if height < -TAPER_REACH:
        return -TAPER_REACH, 0.0
    return height, 1.0 / a3


@njit(cache=True, nogil=True, error_model="numpy", fastmath=FAST)
def log_gauge(x, y, z, axes, eps):
    """Log G at a straight point, its shares p (3 values), its derivatives by ε1 and ε2.

    A share is the derivative by the logarithm of a coordinate; the three sum to one.
    """
    e1, e2 = eps[0], eps[1]
    ax = 2.0 / e2 * (np.log(abs(x)) - axes[0])
    ay = 2.0 / e2 * (np.log(abs(y)) - axes[1])
    log_a, u1, u2 = log_sum(ax, ay)
    t = e2 / e1 * log_a
    s = 2.0 / e1 * (np.log(abs(z)) - axes[2])
    log_f, w, w3 = log_sum(t, s)
    h1 = 0.5 * (log_f - w * t - w3 * s)
    h2 = 0.5 * w * (log_a - u1 * ax - u2 * ay)
    return 0.5 * e1 * log_f, w * u1, w * u2, w3, h1, h2


@njit(cache=True, nogil=True, error_model="numpy", fastmath=FAST)
def pose_part(row, v1, v2, v3, x, y, z):
    """Rotation and translation derivatives of a function with spatial gradient v at (x, y, z)."""
    row[5], row[6], row[7] = v2 * z - v3 * y, v3 * x - v1 * z, v1 * y - v2 * x
    row[8], row[9], row[10] = -v1, -v2, -v3
