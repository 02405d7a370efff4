"""Compiled height of a solid over its support plane."""

from __future__ import annotations

import numpy as np
from numba import njit

from .work_rows import FAST_MATH, away_from_zero

_GRID_HALF = 24
"""Number of sections above z = 0, and below it, among which the supporting one is searched."""
_REFINEMENTS = 30
"""Number of reductions of the search step, each to 0.6 of it. The last step is 1e-8 a3."""


@njit(cache=True, nogil=True, error_model="numpy", fastmath=FAST_MATH)
def plane_gap(plane, shape, tapered, row, local):
    """Return the height of the lowest point over the plane; write its derivatives to `row` (13,).

    `plane` (4,) is the upward unit normal n and the offset d of the plane n · p + d = 0. `local`
    (3,) is working memory. It receives the downward normal in local axes.
    """
    R, c = shape.R, shape.centre
    for k in range(3):
        local[k] = -(R[0, k] * plane[0] + R[1, k] * plane[1] + R[2, k] * plane[2])
    x, y, z = away_from_zero(local[0]), away_from_zero(local[1]), away_from_zero(local[2])
    centre_height = plane[0] * c[0] + plane[1] * c[1] + plane[2] * c[2] + plane[3]
    row[11], row[12] = 0.0, 0.0
    if tapered:
        support, v1, v2, v3 = _tapered_support(x, y, z, shape, row)
    else:
        # The support function is the dual norm of G: exponents 2 - ε on inverse semi-axes.
        log_h, p1, p2, p3, h1, h2 = log_radial_scale(
            x, y, z, -shape.log_axes, 2.0 - shape.exponents
        )
        support = np.exp(log_h)
        v1, v2, v3 = support * p1 / x, support * p2 / y, support * p3 / z
        row[0], row[1], row[2] = -support * p1, -support * p2, -support * p3
        row[3], row[4] = support * h1, support * h2
    # The direction rotates like a point about the origin. The centre moves along the normal.
    row[5], row[6], row[7] = v3 * y - v2 * z, v1 * z - v3 * x, v2 * x - v1 * y
    row[8], row[9], row[10] = -local[0], -local[1], -local[2]
    return centre_height - support


@njit(cache=True, nogil=True, error_model="numpy", fastmath=FAST_MATH)
def _tapered_support(x, y, z, shape, row):
    """Return the support along (x, y, z) and the point of contact (3 values).

    The derivatives of the negative support by axes, exponents and taper are written to `row`. The
    supporting section is searched on a grid, then by shrinking steps. The derivatives treat its
    height as fixed (envelope theorem).
    """
    best, middle = -np.inf, 0.0
    for k in range(-_GRID_HALF, _GRID_HALF + 1):
        t = k / _GRID_HALF
        value = _section_support(t, x, y, z, shape)[0]
        if value > best:
            best, middle = value, t
    step = 1.0 / _GRID_HALF
    for _ in range(_REFINEMENTS):
        step *= 0.6
        for side in (-1.0, 1.0):
            t = min(max(middle + side * step, -1.0), 1.0)
            value = _section_support(t, x, y, z, shape)[0]
            if value > best:
                best, middle = value, t
    t = middle
    support, across, u1, u2, width1, width2, entropy = _section_support(t, x, y, z, shape)
    e1, a3 = shape.exponents[0], np.exp(shape.log_axes[2])
    row[0], row[1], row[2] = -across * u1, -across * u2, -a3 * t * z
    row[11], row[12] = -across * u1 * t / width1, -across * u2 * t / width2
    depth = max(abs(t), 1e-12) ** (2.0 / e1)
    left = max(1.0 - depth, 1e-12)
    slope = 0.5 * np.log(left) + depth / left * np.log(max(abs(t), 1e-12)) / e1
    row[3] = -across * slope
    row[4] = 0.5 * across * entropy
    return support, across * u1 / x, across * u2 / y, a3 * t


@njit(cache=True, nogil=True, error_model="numpy", fastmath=FAST_MATH)
def _section_support(t, x, y, z, shape):
    """Return the support of the section at height t a3 along (x, y, z).

    The other results are: the part of the support across z, the shares of x and y in this part, the
    two widths of the section, and the entropy of the two shares. The derivative of the logarithm of
    this part by ε2 is minus half the entropy.
    """
    log_axes, e1, e2 = shape.log_axes, shape.exponents[0], shape.exponents[1]
    width1, width2 = 1.0 + shape.taper[0] * t, 1.0 + shape.taper[1] * t
    power = 2.0 / (2.0 - e2)
    l1 = power * (np.log(abs(x) * width1) + log_axes[0])
    l2 = power * (np.log(abs(y) * width2) + log_axes[1])
    log_a, u1, u2 = log_sum(l1, l2)
    size = max(1.0 - abs(t) ** (2.0 / e1), 0.0) ** (0.5 * e1)
    across = size * np.exp(log_a / power)
    entropy = log_a - u1 * l1 - u2 * l2
    return across + t * z * np.exp(log_axes[2]), across, u1, u2, width1, width2, entropy


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
