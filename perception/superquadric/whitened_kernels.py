"""Compiled cost of a superquadric over a flat chart of numbers around a guess."""

from __future__ import annotations

import numpy as np
from numba import njit

from .cost_kernels import normal_equations
from .levenberg_marquardt import add_prior, moved, rotation
from .radial_batch_kernels import PARAMETERS


@njit(cache=True, nogil=True, error_model="numpy")
def chart_value(
    y,
    unwhiten,
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
    prior,
    bounds,
):
    """Cost with and without prior, gradient (k,) by y, and the guess at chart point y (k,).

    The chart maps y to the guess moved by the full step ``unwhiten @ y``, with `unwhiten`
    (13, k); arguments from `points` on as in :func:`residual_kernels.normal_equations`.
    """
    step = np.zeros(PARAMETERS)
    for a in range(PARAMETERS):
        for j in range(y.size):
            step[a] += unwhiten[a, j] * y[j]
    new_axes, new_eps, new_R, new_c, new_taper = moved(axes, eps, R, c, taper, step, bounds)
    cost, full, hessian = normal_equations(
        points,
        weights,
        rays,
        plane,
        origin,
        new_axes,
        new_eps,
        new_R,
        new_c,
        new_taper,
        tapered,
        scale,
        ray_weight,
        ray_pull,
        plane_weight,
        plane_scale,
    )
    total = cost + add_prior(prior, new_axes, new_eps, new_taper, full, hessian)
    # A number that a bound holds does not move.
    for j in range(3):
        if new_axes[j] != axes[j] + step[j]:
            full[j] = 0.0
    for j in range(2):
        if new_eps[j] != eps[j] + step[3 + j]:
            full[3 + j] = 0.0
        if new_taper[j] != taper[j] + step[11 + j]:
            full[11 + j] = 0.0
    _to_chart(full, step)
    gradient = np.zeros(y.size)
    for j in range(y.size):
        for a in range(PARAMETERS):
            gradient[j] += unwhiten[a, j] * full[a]
    return total, cost, gradient, new_axes, new_eps, new_R, new_c, new_taper


@njit(cache=True, nogil=True, error_model="numpy")
def _to_chart(full, step):
    """Turn derivatives by increments at the moved guess into those by the chart's step.

    Rotation increments follow the right Jacobian of SO(3); translations were added in the
    start's axes while increments are in the moved ones.
    """
    vector = step[5:8]
    jacobian, turn = right_jacobian(vector), rotation(vector)
    turned, shifted = np.zeros(3), np.zeros(3)
    for i in range(3):
        for j in range(3):
            turned[i] += jacobian[j, i] * full[5 + j]
            shifted[i] += turn[i, j] * full[8 + j]
    for i in range(3):
        full[5 + i] = turned[i]
        full[8 + i] = shifted[i]


@njit(cache=True, nogil=True, error_model="numpy")
def right_jacobian(vector):
    """Right Jacobian (3, 3) of SO(3) at a rotation vector (3,) (Chirikjian 2012, eq 10.86)."""
    angle = np.sqrt(vector[0] ** 2 + vector[1] ** 2 + vector[2] ** 2)
    if angle < 1e-6:
        a, b = 0.5, 0.0
    else:
        a = (1.0 - np.cos(angle)) / angle**2
        b = (angle - np.sin(angle)) / angle**3
    x, y, z = vector[0], vector[1], vector[2]
    out = np.empty((3, 3))
    out[0, 0] = 1.0 - b * (y * y + z * z)
    out[0, 1] = a * z + b * x * y
    out[0, 2] = -a * y + b * x * z
    out[1, 0] = -a * z + b * x * y
    out[1, 1] = 1.0 - b * (x * x + z * z)
    out[1, 2] = a * x + b * y * z
    out[2, 0] = a * y + b * x * z
    out[2, 1] = -a * x + b * y * z
    out[2, 2] = 1.0 - b * (x * x + y * y)
    return out
