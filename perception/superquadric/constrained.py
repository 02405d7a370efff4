"""Constrained refinement: nlopt moves a solid out of space that the view shows to be empty."""

from __future__ import annotations

import contextlib

import nlopt
import numpy as np
from numba import njit
from numpy.typing import NDArray

from . import work_rows as at
from .cost_kernels import normal_equations
from .free_space import FreeSpace
from .kinds import basis
from .levenberg_marquardt import add_prior, apply_step
from .options import FitOptions
from .parameters import N_PARAMETERS, N_STRAIGHT, ShapeParameters
from .problem import FitProblem, parameter_bounds
from .ray_kernels import TIME, compute_ray_rows, evaluate_on_rays, write_depths
from .shape import Kind
from .whitened_kernels import add_whitened, whitened_cost
from .work_rows import FAST_MATH, LANES, lane_count, new_workspace

POINTS = 600
"""Points of the constrained problem. More change the solid by less than the free space does."""
MAX_ROUNDS = 4
"""Solutions in sequence. Each adds the rays that the previous one violates."""
MAX_NEW_RAYS = 48
"""Rays that a round adds at most, evenly among the violated ones, deepest first."""
MAX_EVALUATIONS = 80
"""Evaluations of the cost in a round."""
MIN_VIOLATION = 1e-4
"""Depth by which a ray must enter the solid to count, in units of the problem."""
RELATIVE_TOLERANCE = 1e-4
"""Relative decrease of the cost below which a round ends."""
SPAN = 200.0
"""Bounds of the whitened variables, in units of the root of the cost: a solid may move far."""
_RIDGE = 1e-6


def refine_in_free_space(
    problem: FitProblem,
    start: ShapeParameters,
    kind: Kind,
    free_space: FreeSpace,
    tolerance: float,
    options: FitOptions,
) -> ShapeParameters:
    """Minimise the cost under the constraint that no ray enters the solid in empty space.

    SLSQP of nlopt solves it from the solution of the Levenberg-Marquardt. The constraints are the
    rays that the solid violates. MMA and CCSAQ do not leave an infeasible start.

    Parameters
    ----------
    problem, start, kind
        The problem, the shape to start from, and its kind.
    free_space
        In the frame of the cloud, m.
    tolerance
        Length by which a ray may enter the solid too early, m.
    options
        The options of the fit.

    Returns
    -------
    ShapeParameters
        The last solution. It may still violate rays if no solid of this kind avoids them.
    """
    problem = problem.thinned(POINTS, 1)
    known = free_space.depth > 0
    rays = free_space.rays[known]
    depth = (free_space.depth[known] - tolerance) / problem.unit
    origin = (free_space.origin - problem.centre) / problem.unit
    bounds = parameter_bounds(kind, problem, options)
    columns = basis(kind)
    tapered = bool(columns[N_STRAIGHT:].any())
    active = np.zeros(len(rays), dtype=bool)
    shape = start._replace(R=np.ascontiguousarray(start.R))
    values, rows = np.empty(len(rays)), np.empty((len(rays), N_PARAMETERS))
    for _ in range(MAX_ROUNDS):
        ray_depths(rays, depth, origin, shape, tapered, values, rows)
        violated = np.flatnonzero((values > MIN_VIOLATION) & ~active)
        if not violated.size:
            break
        deepest = violated[np.argsort(-values[violated])]
        active[deepest[:: max(len(deepest) // MAX_NEW_RAYS, 1)][:MAX_NEW_RAYS]] = True
        limits = (np.ascontiguousarray(rays[active]), depth[active], origin)
        shape = _solve(problem, shape, columns, bounds, limits)
    return shape


def _solve(
    problem: FitProblem,
    start: ShapeParameters,
    columns: NDArray[np.float64],
    bounds: NDArray[np.float64],
    limits: tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]],
) -> ShapeParameters:
    """Minimise the cost with one inequality for each ray of `limits`: rays, depths and origin.

    The free numbers are whitened by the Gauss-Newton Hessian at the start, so that one unit of
    any variable changes the cost equally. Without this SLSQP needs several times the evaluations.
    """
    tapered = bool(columns[N_STRAIGHT:].any())
    cost, gradient, hessian = normal_equations(problem.terms, start, tapered)
    total = float(cost) + add_prior(problem.prior, start, gradient, hessian)
    if not np.isfinite(total) or total <= 0.0:
        return start
    unwhiten = _unwhitening(hessian, columns)

    def shape_at(y: NDArray[np.float64]) -> tuple[float, NDArray[np.float64], ShapeParameters]:
        value, _, slope, shape = whitened_cost(
            y, unwhiten, problem.terms, problem.prior, start, tapered, bounds
        )
        return float(value), slope, shape

    def objective(y: NDArray[np.float64], slope: NDArray[np.float64]) -> float:
        value, gradient, _ = shape_at(y)
        if slope.size:
            slope[:] = gradient / total
        return value / total

    def constraints(
        out: NDArray[np.float64], y: NDArray[np.float64], slopes: NDArray[np.float64]
    ) -> None:
        out[:], gradients = whitened_ray_depths(y, unwhiten, *limits, start, tapered, bounds)
        if slopes.size:
            slopes[:] = gradients

    size = columns.shape[1]
    solver = nlopt.opt(nlopt.LD_SLSQP, size)
    solver.set_min_objective(objective)
    solver.add_inequality_mconstraint(constraints, np.full(len(limits[1]), MIN_VIOLATION))
    span = SPAN * np.sqrt(total)
    solver.set_lower_bounds(np.full(size, -span))
    solver.set_upper_bounds(np.full(size, span))
    solver.set_ftol_rel(RELATIVE_TOLERANCE)
    solver.set_maxeval(MAX_EVALUATIONS)
    # nlopt raises these at the optimum, where round-off prevents any progress.
    with contextlib.suppress(nlopt.RoundoffLimited, nlopt.exception, ValueError, RuntimeError):
        return shape_at(solver.optimize(np.zeros(size)))[2]
    return start


def _unwhitening(hessian: NDArray[np.float64], columns: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the matrix (13, k) from whitened free numbers to a full step."""
    reduced = columns.T @ hessian @ columns
    size = columns.shape[1]
    reduced += (_RIDGE * np.trace(reduced) / size + np.finfo(float).tiny) * np.eye(size)
    return np.ascontiguousarray(columns @ np.linalg.inv(np.linalg.cholesky(reduced)).T)


@njit(cache=True, nogil=True, error_model="numpy", fastmath=FAST_MATH)
def ray_depths(rays, depth, view_origin, shape, tapered, values, rows):
    """Compute how deep rays enter a solid before they end, and the derivatives.

    A ray ends at `depth` (K,). Its depth in the solid is r (1 - min G), and negative if it misses
    the solid.

    Parameters
    ----------
    rays, view_origin
        (K, 3) unit directions from the camera, (3,).
    shape, tapered
        As in :func:`~.cost_kernels.normal_equations`.
    values, rows
        Receive the depths (K,) and their derivatives (K, 13) by a full step.
    """
    work = new_workspace()
    for first in range(0, rays.shape[0], LANES):
        n = min(rays.shape[0] - first, LANES)
        lanes = lane_count(n)
        local = compute_ray_rows(rays, view_origin, first, n, shape, tapered, True, work)
        for i in range(lanes):
            limit = depth[first + min(i, n - 1)]
            work.flat[TIME + i] = min(work.flat[TIME + i], limit)
        evaluate_on_rays(local, shape, tapered, work, lanes)
        write_depths(shape.log_axes, shape.taper, True, work.flat, work.grid, lanes)
        for i in range(n):
            values[first + i] = work.flat[at.RESIDUAL + i]
            for j in range(N_PARAMETERS):
                rows[first + i, j] = work.flat[j * LANES + i]


@njit(cache=True, nogil=True, error_model="numpy")
def whitened_ray_depths(y, unwhiten, rays, depth, view_origin, start, tapered, bounds):
    """Return the depths (K,) of :func:`ray_depths` and their derivatives (K, k) by y.

    See :func:`~.whitened_kernels.whitened_cost` for y (k,), `unwhiten`, `start` and `bounds`.
    """
    step = np.zeros(N_PARAMETERS)
    for a in range(N_PARAMETERS):
        for j in range(y.size):
            step[a] += unwhiten[a, j] * y[j]
    shape = apply_step(start, step, bounds)
    count = rays.shape[0]
    values, rows = np.empty(count), np.zeros((count, N_PARAMETERS))
    ray_depths(rays, depth, view_origin, shape, tapered, values, rows)
    gradients = np.zeros((count, y.size))
    for i in range(count):
        add_whitened(rows[i], shape, start, step, unwhiten, gradients[i])
    return values, gradients
