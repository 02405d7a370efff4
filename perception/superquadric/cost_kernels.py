"""Compiled cost of the fit with its gradient and Gauss-Newton Hessian, and point distances."""

from __future__ import annotations

import numpy as np
from numba import njit

from . import work_rows as at
from .parameters import N_PARAMETERS, N_STRAIGHT
from .plane_kernels import plane_gap
from .point_kernels import add_points, add_rays, compute_distance_rows
from .ray_kernels import compute_ray_rows
from .work_rows import FAST_MATH, LANES, new_workspace


@njit(cache=True, nogil=True, error_model="numpy", fastmath=FAST_MATH)
def normal_equations(terms, shape, tapered):
    """Return the robust cost, its gradient (13,) and Gauss-Newton Hessian (13, 13).

    Parameters
    ----------
    terms
        :class:`~.parameters.CostTerms`.
    shape
        :class:`~.parameters.ShapeParameters`.
    tapered
        Whether the taper is free. Otherwise its derivatives stay 0, which is faster.

    Notes
    -----
    The cost is Σ w s²/2 log(1 + r²/s²) over the points, plus the mean squared depth by which rays
    enter the solid (times `ray_pull` and with the Cauchy loss where they pass outside), plus the
    Cauchy cost of the gap between solid and support plane, plus the mean squared length by which
    the solid crosses the planes of the outline (with the Cauchy loss where it ends before them).
    The order of the derivatives is that of :data:`~.parameters.N_PARAMETERS`.
    """
    cost = 0.0
    gradient = np.zeros(N_PARAMETERS)
    hessian = np.zeros((N_PARAMETERS, N_PARAMETERS))
    work = new_workspace()
    count = N_PARAMETERS if tapered else N_STRAIGHT
    points, rays, scale = terms.points, terms.rays, terms.cauchy_scale
    for first in range(0, points.shape[0], LANES):
        n = min(points.shape[0] - first, LANES)
        compute_distance_rows(points, first, n, shape, tapered, work)
        cost += add_points(terms.point_weights, first, n, scale, count, work, gradient, hessian)
    if rays.shape[0] > 0 and terms.ray_weight > 0.0:
        weight, pull = terms.ray_weight / rays.shape[0], terms.ray_pull
        for first in range(0, rays.shape[0], LANES):
            n = min(rays.shape[0] - first, LANES)
            compute_ray_rows(rays, terms.view_origin, first, n, shape, tapered, pull > 0.0, work)
            cost += add_rays(weight, pull, scale, n, count, work, gradient, hessian)
    if terms.plane_weight > 0.0:
        row, local = np.zeros(N_PARAMETERS), np.empty(3)
        gap = plane_gap(terms.plane, shape, tapered, row, local)
        cost += terms.plane_weight * _cauchy_loss(gap, terms.plane_scale)
        weight = terms.plane_weight / (1.0 + (gap / terms.plane_scale) ** 2)
        _add_residual(gradient, hessian, row, gap, weight, count)
    if terms.outline_weight > 0.0:
        row, local = np.zeros(N_PARAMETERS), np.empty(3)
        weight = terms.outline_weight / terms.outline.shape[0]
        for j in range(terms.outline.shape[0]):
            gap = plane_gap(terms.outline[j], shape, tapered, row, local)
            slope = weight
            if gap > 0.0:
                cost += weight * _cauchy_loss(gap, scale)
                slope /= 1.0 + (gap / scale) ** 2
            else:
                cost += 0.5 * weight * gap * gap
            _add_residual(gradient, hessian, row, gap, slope, count)
    for j in range(N_PARAMETERS):
        for k in range(j):
            hessian[k, j] = hessian[j, k]
    return cost, gradient, hessian


@njit(cache=True, nogil=True, error_model="numpy", fastmath=FAST_MATH)
def distances(points, shape):
    """Return the first-order signed distances (N,) of points (N, 3), negative inside."""
    out = np.empty(points.shape[0])
    work = new_workspace()
    tapered = shape.taper[0] != 0.0 or shape.taper[1] != 0.0
    for first in range(0, points.shape[0], LANES):
        n = min(points.shape[0] - first, LANES)
        compute_distance_rows(points, first, n, shape, tapered, work)
        for i in range(n):
            out[first + i] = work.flat[at.RESIDUAL + i]
    return out


@njit(cache=True, nogil=True, error_model="numpy", fastmath=FAST_MATH)
def _add_residual(gradient, hessian, row, r, weight, count):
    """Add one residual r with derivatives `row` to the lower triangle of the Hessian."""
    for j in range(count):
        scaled = weight * row[j]
        gradient[j] += scaled * r
        for k in range(j + 1):
            hessian[j, k] += scaled * row[k]


@njit(cache=True, nogil=True, error_model="numpy", fastmath=FAST_MATH)
def _cauchy_loss(r, scale):
    return 0.5 * scale * scale * np.log1p((r / scale) ** 2)
