"""Final refinement of the selected solid by one of several optimisers."""

from __future__ import annotations

import contextlib
from typing import TYPE_CHECKING, NamedTuple, Protocol

import nlopt
import numpy as np

from .cost_kernels import normal_equations
from .kinds import basis
from .levenberg_marquardt import add_prior, levenberg_marquardt
from .parameters import N_STRAIGHT
from .whitened_kernels import whitened_cost

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from .options import OptimiserName
    from .parameters import ShapeParameters
    from .problem import FitProblem
    from .shape import Kind

MAX_EVALUATIONS = 60
"""Evaluations of the cost in the final refinement. More do not improve the fit measurably."""
_RELATIVE_TOLERANCE = 1e-6
"""Relative decrease of the cost below which nlopt ends."""
_SPAN = 20.0
"""Bounds of the whitened variables, in units of the root of the cost."""
_RIDGE = 1e-6


class Refinement(NamedTuple):
    """The result of an optimiser."""

    shape: ShapeParameters
    """The best point evaluated; the start if no point is better."""
    cost: float
    """Its robust cost without the prior."""
    evaluations: int
    """Number of evaluations of the cost."""


class Optimiser(Protocol):
    """Minimises the cost from a start within a number of evaluations; never raises."""

    def __call__(
        self,
        problem: FitProblem,
        start: ShapeParameters,
        kind: Kind,
        bounds: NDArray[np.float64],
        evaluations: int,
    ) -> Refinement:
        """Refine a shape of a kind within (3, 2) bounds of log axes, exponents and taper."""
        ...


def refine_by_levenberg_marquardt(
    problem: FitProblem,
    start: ShapeParameters,
    kind: Kind,
    bounds: NDArray[np.float64],
    evaluations: int,
) -> Refinement:
    """Continue with the compiled Levenberg-Marquardt; see :class:`Optimiser`."""
    return Refinement(*levenberg_marquardt(problem, start, basis(kind), bounds, evaluations))


class NloptOptimiser:
    """A local algorithm of nlopt on whitened variables.

    The free numbers are whitened by the Gauss-Newton Hessian at the start, so that one unit of
    any variable changes the cost equally. Without this the algorithms need several times the
    evaluations.
    """

    def __init__(self, algorithm: int) -> None:
        self.algorithm = algorithm

    def __call__(
        self,
        problem: FitProblem,
        start: ShapeParameters,
        kind: Kind,
        bounds: NDArray[np.float64],
        evaluations: int,
    ) -> Refinement:
        """Refine a solid; see :class:`Optimiser`."""
        columns = basis(kind)
        tapered = bool(columns[N_STRAIGHT:].any())
        cost, gradient, hessian = normal_equations(problem.terms, start, tapered)
        total = float(cost) + add_prior(problem.prior, start, gradient, hessian)
        if not np.isfinite(total):
            # bobyqa corrupts memory if the cost is NaN.
            return Refinement(start, float(cost), 1)
        unwhiten = _unwhitening(hessian, columns)
        best, used = Refinement(start, float(cost), 0), 0
        lowest = total

        def objective(y: NDArray[np.float64], slope: NDArray[np.float64]) -> float:
            nonlocal best, used, lowest
            value, plain, gradient, shape = whitened_cost(
                y, unwhiten, problem.terms, problem.prior, start, tapered, bounds
            )
            used += 1
            if value < lowest:
                best, lowest = Refinement(shape, float(plain), used), float(value)
            if slope.size:
                slope[:] = gradient
            return float(value)

        size = columns.shape[1]
        solver = nlopt.opt(self.algorithm, size)
        solver.set_min_objective(objective)
        span = _SPAN * np.sqrt(max(total, np.finfo(float).tiny))
        solver.set_lower_bounds(np.full(size, -span))
        solver.set_upper_bounds(np.full(size, span))
        solver.set_initial_step(0.1 * span)
        solver.set_ftol_rel(_RELATIVE_TOLERANCE)
        solver.set_maxeval(evaluations)
        # nlopt raises these at the optimum, where round-off prevents any progress.
        with contextlib.suppress(nlopt.RoundoffLimited, nlopt.exception):
            solver.optimize(np.zeros(size))
        return best._replace(evaluations=used)


OPTIMISERS: dict[OptimiserName, Optimiser] = {
    "lm": refine_by_levenberg_marquardt,
    "slsqp": NloptOptimiser(nlopt.LD_SLSQP),
    "lbfgs": NloptOptimiser(nlopt.LD_LBFGS),
    "mma": NloptOptimiser(nlopt.LD_MMA),
    "bobyqa": NloptOptimiser(nlopt.LN_BOBYQA),
    "cobyla": NloptOptimiser(nlopt.LN_COBYLA),
}
"""Optimisers by their name in the options."""


def _unwhitening(hessian: NDArray[np.float64], columns: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the matrix (13, k) from whitened free numbers to a full step."""
    reduced = columns.T @ hessian @ columns
    size = columns.shape[1]
    reduced += (_RIDGE * np.trace(reduced) / size + np.finfo(float).tiny) * np.eye(size)
    return np.ascontiguousarray(columns @ np.linalg.inv(np.linalg.cholesky(reduced)).T)
