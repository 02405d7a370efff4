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

from .plane_kernels import plane_row
from .point_kernels import add_block, add_ray_block, distance_rows
from .radial_batch_kernels import LANES, PARAMETERS, R_ROW, ROWS, STRAIGHT
from .radial_kernels import FAST
from .ray_kernels import ray_rows


@njit(cache=True, nogil=True, error_model="numpy", fastmath=FAST)
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
    m = np.empty(ROWS * LANES)
    grid = m.reshape(ROWS, LANES)
    bits = grid.view(np.int64)
    count = PARAMETERS if tapered else STRAIGHT
    for first in range(0, points.shape[0], LANES):
        n = min(points.shape[0] - first, LANES)
        distance_rows(points, first, n, R, c, axes, eps, taper, tapered, m)
        cost += add_block(weights, first, n, scale, count, m, gradient, hessian)
    if rays.shape[0] > 0 and ray_weight > 0.0:
        share = ray_weight / rays.shape[0]
        for first in range(0, rays.shape[0], LANES):
            n = min(rays.shape[0] - first, LANES)
            outside = ray_pull > 0.0
            ray_rows(
                rays, first, n, origin, axes, eps, R, c, taper, tapered, outside, m, grid, bits
            )
            cost += add_ray_block(
                share, ray_pull, scale, n, count, m, grid, bits, gradient, hessian
            )
    if plane_weight > 0.0:
        gap = plane_row(plane, axes, eps, R, c, taper, tapered, row, local)
        cost += plane_weight * _cauchy(gap, plane_scale)
        weight = plane_weight / (1.0 + (gap / plane_scale) ** 2)
        _accumulate(gradient, hessian, row, gap, weight, tapered)
    for j in range(PARAMETERS):
        for k in range(j):
            hessian[k, j] = hessian[j, k]
    return cost, gradient, hessian


@njit(cache=True, nogil=True, error_model="numpy", fastmath=FAST)
def distances(points, axes, eps, R, c, taper):
    """First-order signed distances (N,) of points (N, 3)."""
    out = np.empty(points.shape[0])
    m = np.empty(ROWS * LANES)
    tapered = taper[0] != 0.0 or taper[1] != 0.0
    for first in range(0, points.shape[0], LANES):
        n = min(points.shape[0] - first, LANES)
        distance_rows(points, first, n, R, c, axes, eps, taper, tapered, m)
        for i in range(n):
            out[first + i] = m[R_ROW * LANES + i]
    return out


@njit(cache=True, nogil=True, error_model="numpy", fastmath=FAST)
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


@njit(cache=True, nogil=True, error_model="numpy", fastmath=FAST)
def _cauchy(r, scale):
    return 0.5 * scale * scale * np.log1p((r / scale) ** 2)
