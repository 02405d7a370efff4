"""Final refinement by nlopt on whitened variables."""

from __future__ import annotations

import contextlib
from typing import TYPE_CHECKING

import nlopt
import numpy as np
from scipy.spatial.transform import Rotation

from .problem import FitProblem, Guess
from .residual_kernels import normal_equations

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from .options import Optimiser

ALGORITHMS: dict[Optimiser, int] = {
    "slsqp": nlopt.LD_SLSQP,
    "lbfgs": nlopt.LD_LBFGS,
    "mma": nlopt.LD_MMA,
}
"""nlopt's gradient algorithms by the name in the options."""

_RELATIVE_TOLERANCE = 1e-6
_SPAN = 20.0
_RIDGE = 1e-6


def refine(
    problem: FitProblem,
    start: Guess,
    basis: NDArray[np.float64],
    bounds: NDArray[np.float64],
    optimiser: Optimiser,
    evaluations: int,
) -> tuple[Guess, float, int]:
    """Polish a guess with one of nlopt's gradient algorithms.

    The free numbers are whitened by the Gauss-Newton Hessian at the start, so that one unit of
    any variable costs the same: without it the algorithms need several times the evaluations.

    Returns
    -------
    guess, cost, evaluations
        The best point seen (the start, should nothing be better), its cost, evaluations used.
    """
    cost, _, hessian = normal_equations(*problem.data(), *start, *problem.weighting())
    reduced = basis.T @ hessian @ basis
    size = basis.shape[1]
    reduced += _RIDGE * np.trace(reduced) / size * np.eye(size)
    unwhiten = basis @ np.linalg.inv(np.linalg.cholesky(reduced)).T
    best = [start, float(cost), 0]

    def objective(y: NDArray[np.float64], gradient: NDArray[np.float64]) -> float:
        step = unwhiten @ y
        guess, free = _moved(start, step, bounds)
        value, full, _ = normal_equations(*problem.data(), *guess, *problem.weighting())
        best[2] += 1
        if value < best[1]:
            best[0], best[1] = guess, float(value)
        if gradient.size:
            gradient[:] = unwhiten.T @ _chart_gradient(full, step, free)
        return float(value)

    solver = nlopt.opt(ALGORITHMS[optimiser], size)
    solver.set_min_objective(objective)
    span = _SPAN * np.sqrt(max(float(cost), np.finfo(float).tiny))
    solver.set_lower_bounds(np.full(size, -span))
    solver.set_upper_bounds(np.full(size, span))
    solver.set_ftol_rel(_RELATIVE_TOLERANCE)
    solver.set_maxeval(evaluations)
    # Round-off at the optimum is nlopt's way to say that no step helps: the best point stands.
    with contextlib.suppress(nlopt.RoundoffLimited, nlopt.exception):
        solver.optimize(np.zeros(size))
    return best[0], best[1], best[2]


def _moved(
    start: Guess, step: NDArray[np.float64], bounds: NDArray[np.float64]
) -> tuple[Guess, NDArray[np.float64]]:
    """Guess after a full step, and which of its 11 numbers are not held by a bound."""
    free = np.ones(11)
    axes = np.clip(start.axes + step[:3], *bounds[0])
    eps = np.clip(start.eps + step[3:5], *bounds[1])
    free[:3] = axes == start.axes + step[:3]
    free[3:5] = eps == start.eps + step[3:5]
    turn = Rotation.from_rotvec(step[5:8]).as_matrix()
    return Guess(axes, eps, start.R @ turn, start.c + start.R @ step[8:11]), free


def _chart_gradient(
    full: NDArray[np.float64], step: NDArray[np.float64], free: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Gradient by the chart's numbers from the gradient by increments at the moved guess.

    Rotation increments follow the right Jacobian of SO(3); translations were added in the
    start's axes while increments are in the moved ones.
    """
    out = full * free
    vector = step[5:8]
    out[5:8] = _right_jacobian(vector).T @ full[5:8]
    out[8:11] = Rotation.from_rotvec(vector).as_matrix() @ full[8:11]
    return out


def _right_jacobian(vector: NDArray[np.float64]) -> NDArray[np.float64]:
    angle = float(np.linalg.norm(vector))
    x, y, z = vector
    cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    if angle < 1e-6:
        return np.eye(3) - 0.5 * cross
    a = (1.0 - np.cos(angle)) / angle**2
    b = (angle - np.sin(angle)) / angle**3
    return np.eye(3) - a * cross + b * cross @ cross
