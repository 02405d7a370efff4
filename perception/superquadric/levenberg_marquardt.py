"""Compiled Levenberg-Marquardt on the manifold of superquadrics: picks the basin, fast."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numba import njit

from .cost_kernels import normal_equations
from .problem import FitProblem, Guess
from .radial_batch_kernels import STRAIGHT

if TYPE_CHECKING:
    from numpy.typing import NDArray

_STEP_TOLERANCE = 1e-5
_MIN_DAMPING = 1e-5
_MAX_DAMPING = 1e3
_RIDGE = 1e-9


def levenberg_marquardt(
    problem: FitProblem,
    start: Guess,
    basis: NDArray[np.float64],
    bounds: NDArray[np.float64],
    iterations: int,
    tolerance: float = 1e-6,
) -> tuple[Guess, float, int]:
    """Descend from a guess along the columns of a basis (13, k).

    Parameters
    ----------
    problem, start
        What is fitted, and from where.
    basis
        Full parameter step per free number, see :func:`kinds.basis`.
    bounds
        (3, 2) rows of [low, high] for log semi-axes, exponents and taper.
    iterations
        Most steps to take.
    tolerance
        Relative gain of a step below which the descent ends.

    Returns
    -------
    guess, cost, steps
        The end point, its robust cost without the prior, and the steps taken.
    """
    axes, eps, R, c, taper, cost, steps = descend(
        *problem.data(),
        start.axes.copy(),
        start.eps.copy(),
        np.ascontiguousarray(start.R),
        start.c.copy(),
        start.taper.copy(),
        bool(basis[STRAIGHT:].any()),
        *problem.weighting(),
        np.ascontiguousarray(basis),
        bounds,
        problem.prior,
        iterations,
        tolerance,
    )
    return Guess(axes, eps, R, c, taper), float(cost), int(steps)


@njit(cache=True, nogil=True, error_model="numpy")
def descend(
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
    basis,
    bounds,
    prior,
    iterations,
    tolerance,
):
    """Descend; see :func:`levenberg_marquardt`."""
    damping = 1e-2
    cost, gradient, hessian = normal_equations(
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
    )
    total = cost + add_prior(prior, axes, eps, taper, gradient, hessian)
    steps = 0
    while steps < iterations:
        steps += 1
        reduced, slope = _reduced(hessian, gradient, basis)
        _hold(reduced, slope, basis, axes, eps, taper, bounds)
        improved = False
        size = gain = 0.0
        while damping < _MAX_DAMPING:
            step = _damped_step(reduced, slope, basis, damping)
            new_axes, new_eps, new_R, new_c, new_taper = moved(axes, eps, R, c, taper, step, bounds)
            new_cost, new_gradient, new_hessian = normal_equations(
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
            new_total = new_cost + add_prior(
                prior, new_axes, new_eps, new_taper, new_gradient, new_hessian
            )
            if new_total < total:
                size = np.sqrt(np.sum(step * step))
                gain = total - new_total
                axes, eps, R, c, taper = new_axes, new_eps, new_R, new_c, new_taper
                cost, total = new_cost, new_total
                gradient, hessian = new_gradient, new_hessian
                improved = True
                damping = max(damping * 0.2, _MIN_DAMPING)
                break
            damping *= 10.0
        if not improved:
            break
        if size < _STEP_TOLERANCE or gain < tolerance * total:
            break
    return axes, eps, R, c, taper, cost, steps


@njit(cache=True, nogil=True, error_model="numpy")
def add_prior(prior, axes, eps, taper, gradient, hessian):
    """Cost of the distance from the prior; adds its derivatives to gradient and Hessian.

    `prior` is (4, 7): homes and weights of log semi-axes, exponents and taper, then ceilings and
    the weights above them.
    """
    cost = 0.0
    for j in range(7):
        if j < 3:
            k, gap = j, axes[j] - prior[0, j]
        elif j < 5:
            k, gap = j, eps[j - 3] - prior[0, j]
        else:
            k, gap = j + 6, taper[j - 5] - prior[0, j]
        cost += 0.5 * prior[1, j] * gap * gap
        gradient[k] += prior[1, j] * gap
        hessian[k, k] += prior[1, j]
        over = gap + prior[0, j] - prior[2, j]
        if over > 0.0:
            cost += 0.5 * prior[3, j] * over * over
            gradient[k] += prior[3, j] * over
            hessian[k, k] += prior[3, j]
    return cost


# Products of matrices this small cost more in calls to BLAS than in arithmetic: plain loops.
@njit(cache=True, nogil=True, error_model="numpy")
def _reduced(hessian, gradient, basis):
    """Hessian (k, k) and gradient (k,) along the columns of the basis."""
    n, k = basis.shape
    half = np.zeros((n, k))
    slope = np.zeros(k)
    for a in range(n):
        for j in range(k):
            b = basis[a, j]
            if b != 0.0:
                slope[j] += b * gradient[a]
                for i in range(n):
                    half[i, j] += hessian[i, a] * b
    reduced = np.zeros((k, k))
    for a in range(n):
        for i in range(k):
            b = basis[a, i]
            if b != 0.0:
                for j in range(k):
                    reduced[i, j] += b * half[a, j]
    return reduced, slope


@njit(cache=True, nogil=True, error_model="numpy")
def _damped_step(reduced, slope, basis, damping):
    """Full step (13,) of the damped normal equations, by Cholesky decomposition."""
    k = slope.size
    factor = np.zeros((k, k))
    for i in range(k):
        for j in range(i + 1):
            value = reduced[i, j]
            if i == j:
                value += damping * (reduced[i, i] + _RIDGE)
            for m in range(j):
                value -= factor[i, m] * factor[j, m]
            if i == j:
                factor[i, i] = np.sqrt(max(value, _RIDGE * _RIDGE))
            else:
                factor[i, j] = value / factor[j, j]
    y = np.empty(k)
    for i in range(k):
        value = -slope[i]
        for m in range(i):
            value -= factor[i, m] * y[m]
        y[i] = value / factor[i, i]
    for i in range(k - 1, -1, -1):
        value = y[i]
        for m in range(i + 1, k):
            value -= factor[m, i] * y[m]
        y[i] = value / factor[i, i]
    step = np.zeros(basis.shape[0])
    for a in range(basis.shape[0]):
        for j in range(k):
            step[a] += basis[a, j] * y[j]
    return step


@njit(cache=True, nogil=True, error_model="numpy")
def moved(axes, eps, R, c, taper, step, bounds):
    """State after a full step (13,), held inside the bounds."""
    new_axes, new_eps, new_taper = np.empty(3), np.empty(2), np.empty(2)
    for j in range(3):
        new_axes[j] = min(max(axes[j] + step[j], bounds[0, 0]), bounds[0, 1])
    for j in range(2):
        new_eps[j] = min(max(eps[j] + step[3 + j], bounds[1, 0]), bounds[1, 1])
        new_taper[j] = min(max(taper[j] + step[11 + j], bounds[2, 0]), bounds[2, 1])
    turn = rotation(step[5:8])
    new_R, new_c = np.zeros((3, 3)), c.copy()
    for i in range(3):
        for m in range(3):
            new_c[i] += R[i, m] * step[8 + m]
            for j in range(3):
                new_R[i, j] += R[i, m] * turn[m, j]
    return new_axes, new_eps, new_R, new_c, new_taper


@njit(cache=True, nogil=True, error_model="numpy")
def rotation(vector):
    """Rotation matrix (3, 3) of a rotation vector (3,), Rodrigues' formula."""
    angle = np.sqrt(vector[0] ** 2 + vector[1] ** 2 + vector[2] ** 2)
    if angle < 1e-12:
        a, b = 1.0, 0.5
    else:
        a, b = np.sin(angle) / angle, (1.0 - np.cos(angle)) / angle**2
    x, y, z = vector[0], vector[1], vector[2]
    out = np.empty((3, 3))
    out[0, 0] = 1.0 - b * (y * y + z * z)
    out[0, 1] = b * x * y - a * z
    out[0, 2] = b * x * z + a * y
    out[1, 0] = b * x * y + a * z
    out[1, 1] = 1.0 - b * (x * x + z * z)
    out[1, 2] = b * y * z - a * x
    out[2, 0] = b * x * z - a * y
    out[2, 1] = b * y * z + a * x
    out[2, 2] = 1.0 - b * (x * x + y * y)
    return out


@njit(cache=True, nogil=True, error_model="numpy")
def _hold(reduced, slope, basis, axes, eps, taper, bounds):
    """Leave out numbers at a bound that downhill would lead across it."""
    k = slope.size
    for j in range(k):
        held = False
        for a in range(7):
            if a < 3:
                row, value, low, high = a, axes[a], bounds[0, 0], bounds[0, 1]
            elif a < 5:
                row, value, low, high = a, eps[a - 3], bounds[1, 0], bounds[1, 1]
            else:
                row, value, low, high = a + 6, taper[a - 5], bounds[2, 0], bounds[2, 1]
            falls = (value <= low and slope[j] > 0.0) or (value >= high and slope[j] < 0.0)
            held = held or (basis[row, j] != 0.0 and falls)
        if held:
            slope[j] = 0.0
            for i in range(k):
                reduced[i, j] = 0.0
                reduced[j, i] = 0.0
            reduced[j, j] = 1.0
