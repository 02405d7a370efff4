"""Compiled radial scale of one point: the scalar formulas that the support plane needs."""

from __future__ import annotations

import numpy as np
from numba import njit

from .work_rows import FAST_MATH


@njit(cache=True, nogil=True, error_model="numpy", fastmath=FAST_MATH)
def log_sum(a, b):
    """Return log(exp a + exp b) and the two shares of the sum, without overflow."""
    if a > b:
        ratio = np.exp(b - a)
        share = 1.0 / (1.0 + ratio)
        return a + np.log1p(ratio), share, ratio * share
    ratio = np.exp(a - b)
    share = 1.0 / (1.0 + ratio)
    return b + np.log1p(ratio), ratio * share, share


@njit(cache=True, nogil=True, error_model="numpy", fastmath=FAST_MATH)
def log_radial_scale(x, y, z, log_axes, exponents):
    """Return log G at a straight point, its shares p (3 values), its derivatives by ε1 and ε2.

    A share is the derivative by the logarithm of a coordinate. The three sum to 1.
    """
    e1, e2 = exponents[0], exponents[1]
    ax = 2.0 / e2 * (np.log(abs(x)) - log_axes[0])
    ay = 2.0 / e2 * (np.log(abs(y)) - log_axes[1])
    log_a, u1, u2 = log_sum(ax, ay)
    t = e2 / e1 * log_a
    s = 2.0 / e1 * (np.log(abs(z)) - log_axes[2])
    log_f, w, w3 = log_sum(t, s)
    h1 = 0.5 * (log_f - w * t - w3 * s)
    h2 = 0.5 * w * (log_a - u1 * ax - u2 * ay)
    return 0.5 * e1 * log_f, w * u1, w * u2, w3, h1, h2
