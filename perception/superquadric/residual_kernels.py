"""Compiled residuals of a superquadric and their exact derivatives.

The residual of a point is its first-order normal distance r = (G - 1)/‖∇G‖ with the gauge
G = F^(ε1/2) (Sampson 1982 on the function of Solina and Bajcsy 1990). With h = log G, shares
p = ∂h/∂(log x, log y, log z) and n = ‖∇h‖ it reads r = (1 - e^-h)/n: all in logarithms, so that
exponents down to 0.02 neither overflow nor lose digits.

Parameters are ordered log a1, log a2, log a3, ε1, ε2, a rotation vector and a translation, the
last two in the solid's own axes (R ← R exp(δ), c ← c + R τ), and the taper k1, k2.
"""

from __future__ import annotations

import numpy as np
from numba import njit

from .condition_kernels import plane_row, ray_row
from .gauge_kernels import FAST, height_share, log_sum, off_zero, pose_part, to_local

PARAMETERS = 13
"""Length of the full parameter vector."""
STRAIGHT = 11
"""Parameters before the taper's: what solids without one can move."""


@njit(cache=True, error_model="numpy", fastmath=FAST)
def normal_equations(
    points,
    weights,
    rays,
    plane,
    origin,
    axes,
    eps,
    R,
    c,
    taper,
    tapered,
    scale,
    ray_weight,
    ray_pull,
    plane_weight,
    plane_scale,
):
    """Robust cost with gradient (13,) and Gauss-Newton Hessian (13, 13) in one pass.

    Parameters
    ----------
    points
        (N, 3) cloud; `weights` (N,) sum to 1.
    rays
        (K, 3) unit directions from `origin` that the solid must not cross; K may be 0.
    plane
        (4,) support plane normal and offset; used when `plane_weight` > 0.
    axes, eps, R, c, taper
        Logarithms of the semi-axes (3,), exponents (2,), rotation (3, 3), centre (3,), taper (2,).
    tapered
        Whether the taper moves; otherwise its derivatives stay 0, which is faster.
    scale, plane_scale
        Cauchy scales of point and plane residuals, in the cloud's unit.

    Notes
    -----
    The cost is Σ w s²/2 log(1 + r²/s²) over points, plus the mean squared depth by which rays
    enter the solid (times `ray_pull` and with the Cauchy loss where they pass outside), plus the
    Cauchy cost of the gap between solid and support plane.
    """
    cost = 0.0
    gradient = np.zeros(PARAMETERS)
    hessian = np.zeros((PARAMETERS, PARAMETERS))
    row = np.zeros(PARAMETERS)
    local = np.empty(3)
    for i in range(points.shape[0]):
        to_local(points[i, 0], points[i, 1], points[i, 2], R, c, local)
        r = distance_row(local, axes, eps, taper, tapered, row)
        cost += weights[i] * _cauchy(r, scale)
        _accumulate(gradient, hessian, row, r, weights[i] / (1.0 + (r / scale) ** 2), tapered)
    if rays.shape[0] > 0 and ray_weight > 0.0:
        share = ray_weight / rays.shape[0]
        for i in range(rays.shape[0]):
            depth = ray_row(
                rays[i], origin, axes, eps, R, c, taper, tapered, ray_pull > 0.0, row, local
            )
            if depth > 0.0:
                cost += share * 0.5 * depth * depth
                _accumulate(gradient, hessian, row, depth, share, tapered)
            elif depth < 0.0:
                cost += share * ray_pull * _cauchy(depth, scale)
                weight = share * ray_pull / (1.0 + (depth / scale) ** 2)
                _accumulate(gradient, hessian, row, depth, weight, tapered)
    if plane_weight > 0.0:
        gap = plane_row(plane, axes, eps, R, c, taper, tapered, row, local)
        cost += plane_weight * _cauchy(gap, plane_scale)
        weight = plane_weight / (1.0 + (gap / plane_scale) ** 2)
        _accumulate(gradient, hessian, row, gap, weight, tapered)
    for j in range(PARAMETERS):
        for k in range(j):
            hessian[k, j] = hessian[j, k]
    return cost, gradient, hessian


@njit(cache=True, error_model="numpy", fastmath=FAST)
def distances(points, axes, eps, R, c, taper):
    """First-order signed distances (N,) of points (N, 3)."""
    out = np.empty(points.shape[0])
    row = np.empty(PARAMETERS)
    local = np.empty(3)
    for i in range(points.shape[0]):
        to_local(points[i, 0], points[i, 1], points[i, 2], R, c, local)
        out[i] = distance_row(local, axes, eps, taper, True, row)
    return out


@njit(cache=True, error_model="numpy", fastmath=FAST)
def distance_row(local, axes, eps, taper, tapered, row):
    """Residual r of a point in shape coordinates; fills `row` (13,) with its derivatives."""
    x, y, z = off_zero(local[0]), off_zero(local[1]), off_zero(local[2])
    width1, width2, lean1, lean2, height, rise = 1.0, 1.0, 0.0, 0.0, 0.0, 0.0
    if tapered:
        height, rise = height_share(z, axes[2])
        width1, width2 = 1.0 + taper[0] * height, 1.0 + taper[1] * height
        lean1, lean2 = taper[0] * rise / width1, taper[1] * rise / width2
    e1, e2 = eps[0], eps[1]
    k1, k2 = 2.0 / e1, 2.0 / e2
    # One division each: they cost as much as a logarithm.
    over_x, over_y, over_z = 1.0 / x, 1.0 / y, 1.0 / z
    ax = k2 * (np.log(abs(x / width1)) - axes[0])
    ay = k2 * (np.log(abs(y / width2)) - axes[1])
    log_a, u1, u2 = log_sum(ax, ay)
    t = e2 * 0.5 * k1 * log_a
    s = k1 * (np.log(abs(z)) - axes[2])
    log_f, w, w3 = log_sum(t, s)
    h = 0.5 * e1 * log_f
    p1, p2, p3 = w * u1, w * u2, w3
    # ∇h: a step along z also moves between sections.
    g1, g2 = p1 * over_x, p2 * over_y
    g3 = p3 * over_z - p1 * lean1 - p2 * lean2
    over_n = 1.0 / np.sqrt(g1 * g1 + g2 * g2 + g3 * g3)
    falling = np.exp(-h)
    r = (1.0 - falling) * over_n
    along, across = falling * over_n, r * over_n

    # Derivatives of the shares by the logarithms of the straight coordinates (symmetric), and
    # m = ∂n/∂p: r moves with a share by -across m.
    q, o = w * w3 * k1, w * k2 * u1 * u2
    d11, d12, d13 = q * u1 * u1 + o, q * u1 * u2 - o, -q * u1
    d22, d23, d33 = q * u2 * u2 + o, -q * u2, q
    n1, n2, n3 = g1 * over_n, g2 * over_n, g3 * over_n
    m1, m2, m3 = n1 * over_x - n3 * lean1, n2 * over_y - n3 * lean2, n3 * over_z
    r1 = along * p1 - across * (m1 * d11 + m2 * d12 + m3 * d13)
    r2 = along * p2 - across * (m1 * d12 + m2 * d22 + m3 * d23)
    r3 = along * p3 - across * (m1 * d13 + m2 * d23 + m3 * d33)
    row[0], row[1], row[2] = -r1, -r2, -r3

    spread = log_a - u1 * ax - u2 * ay
    dw = w * w3 * (s - t) * (0.5 * k1)
    row[3] = along * 0.5 * (log_f - w * t - w3 * s) - across * dw * (m1 * u1 + m2 * u2 - m3)
    dw = w * w3 * spread * (0.5 * k1)
    du = -u1 * u2 * (ax - ay) * (0.5 * k2)
    row[4] = along * 0.5 * w * spread - across * (
        m1 * (dw * u1 + w * du) + m2 * (dw * u2 - w * du) - m3 * dw
    )
    v1 = (r1 + across * n1 * p1 * over_x) * over_x
    v2 = (r2 + across * n2 * p2 * over_y) * over_y
    v3 = (r3 + across * n3 * p3 * over_z) * over_z
    if tapered:
        bend = n3 * (p1 * lean1 * lean1 + p2 * lean2 * lean2)
        v3 -= r1 * lean1 + r2 * lean2 + across * bend
        if rise > 0.0:
            lean = n3 * (p1 * lean1 + p2 * lean2)
            row[2] += (r1 * lean1 + r2 * lean2 + across * bend) * z - across * lean
        row[11] = -r1 * height / width1 + across * n3 * rise * p1 / (width1 * width1)
        row[12] = -r2 * height / width2 + across * n3 * rise * p2 / (width2 * width2)
    pose_part(row, v1, v2, v3, x, y, z)
    return r


@njit(cache=True, error_model="numpy", fastmath=FAST)
def _accumulate(gradient, hessian, row, r, weight, tapered):
    for j in range(STRAIGHT):
        scaled = weight * row[j]
        gradient[j] += scaled * r
        for k in range(j + 1):
            hessian[j, k] += scaled * row[k]
    if tapered:
        for j in range(STRAIGHT, PARAMETERS):
            scaled = weight * row[j]
            gradient[j] += scaled * r
            for k in range(j + 1):
                hessian[j, k] += scaled * row[k]


@njit(cache=True, error_model="numpy", fastmath=FAST)
def _cauchy(r, scale):
    return 0.5 * scale * scale * np.log1p((r / scale) ** 2)
