"""Compiled cost of a superquadric as a function of a whitened step from a start."""

from __future__ import annotations

import numpy as np
from numba import njit

from .cost_kernels import normal_equations
from .levenberg_marquardt import add_prior, apply_step, rotation_matrix
from .parameters import N_PARAMETERS


@njit(cache=True, nogil=True, error_model="numpy")
def whitened_cost(y, unwhiten, terms, prior, start, tapered, bounds):
    """Return the cost with and without the prior, the gradient of the former, and the shape.

    The shape is `start` after the full step ``unwhiten @ y``, clipped to the bounds. `unwhiten` is
    (13, k), y is (k,). The gradient (k,) is the derivative with respect to y. See
    :func:`~.cost_kernels.normal_equations` for `terms` and `tapered`, and
    :func:`~.levenberg_marquardt.levenberg_marquardt` for `bounds`.
    """
    step = np.zeros(N_PARAMETERS)
    for a in range(N_PARAMETERS):
        for j in range(y.size):
            step[a] += unwhiten[a, j] * y[j]
    shape = apply_step(start, step, bounds)
    cost, full, hessian = normal_equations(terms, shape, tapered)
    total = cost + add_prior(prior, shape, full, hessian)
    gradient = np.zeros(y.size)
    add_whitened(full, shape, start, step, unwhiten, gradient)
    return total, cost, gradient, shape


@njit(cache=True, nogil=True, error_model="numpy")
def add_whitened(full, shape, start, step, unwhiten, gradient):
    """Add the derivatives by y (k,) of a value with derivatives `full` (13,) at the moved shape.

    The derivative by a parameter that was clipped to its bound is 0. `full` is changed in place.
    """
    for j in range(3):
        if shape.log_axes[j] != start.log_axes[j] + step[j]:
            full[j] = 0.0
    for j in range(2):
        if shape.exponents[j] != start.exponents[j] + step[3 + j]:
            full[3 + j] = 0.0
        if shape.taper[j] != start.taper[j] + step[11 + j]:
            full[11 + j] = 0.0
    to_start_axes(full, step)
    for j in range(gradient.size):
        for a in range(N_PARAMETERS):
            gradient[j] += unwhiten[a, j] * full[a]


@njit(cache=True, nogil=True, error_model="numpy")
def to_start_axes(full, step):
    """Convert the gradient at the moved shape to the gradient with respect to the step, in place.

    `full` (13,) holds derivatives with respect to increments in the axes of the moved shape. The
    translation of the step is in the axes of the start, so its derivatives are rotated. The
    derivatives of the rotation are multiplied by the transposed right Jacobian of SO(3).
    """
    vector = step[5:8]
    jacobian, R = right_jacobian(vector), rotation_matrix(vector)
    rotated, shifted = np.zeros(3), np.zeros(3)
    for i in range(3):
        for j in range(3):
            rotated[i] += jacobian[j, i] * full[5 + j]
            shifted[i] += R[i, j] * full[8 + j]
    for i in range(3):
        full[5 + i] = rotated[i]
        full[8 + i] = shifted[i]


@njit(cache=True, nogil=True, error_model="numpy")
def right_jacobian(vector):
    """Return the right Jacobian (3, 3) of SO(3) at a rotation vector.

    See eq. 10.86 of Chirikjian (2012).
    """
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
