"""Final refinement by the optimiser of choice, all behind one call."""

from __future__ import annotations

import contextlib
from typing import TYPE_CHECKING, NamedTuple, Protocol

import nlopt
import numpy as np

from .cost_kernels import normal_equations
from .kinds import basis
from .levenberg_marquardt import add_prior, levenberg_marquardt
from .problem import FitProblem, Guess
from .radial_batch_kernels import STRAIGHT
from .whitened_kernels import chart_value

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from .options import OptimiserName
    from .shape import Kind


class Refined(NamedTuple):
    """Where an optimiser ended."""

    guess: Guess
    """Best point seen: the start, should nothing be better."""
    cost: float
    """Its robust cost without the prior."""
    evaluations: int
    """Evaluations of the cost used."""


class Optimiser(Protocol):
    """Takes a guess downhill within a budget of evaluations; never raises on any problem."""

    def __call__(
        self,
        problem: FitProblem,
        start: Guess,
        kind: Kind,
        bounds: NDArray[np.float64],
        evaluations: int,
    ) -> Refined:
        """Refine a guess of a kind within (3, 2) bounds of log axes, exponents and taper."""
        ...


_RELATIVE_TOLERANCE = 1e-6
_SPAN = 20.0
_RIDGE = 1e-6


def by_levenberg_marquardt(
    problem: FitProblem,
    start: Guess,
    kind: Kind,
    bounds: NDArray[np.float64],
    evaluations: int,
) -> Refined:
    """Go on with the compiled Levenberg-Marquardt."""
    return Refined(*levenberg_marquardt(problem, start, basis(kind), bounds, evaluations))


class ByNlopt:
    """One of nlopt's local algorithms on whitened variables.

    The free numbers are whitened by the Gauss-Newton Hessian at the start, so that one unit of
    any variable costs the same: without it the algorithms need several times the evaluations.
    """

    def __init__(self, algorithm: int) -> None:
        self.algorithm = algorithm

    def __call__(
        self,
        problem: FitProblem,
        start: Guess,
        kind: Kind,
        bounds: NDArray[np.float64],
        evaluations: int,
    ) -> Refined:
        """Refine; see :class:`Optimiser`."""
        columns = basis(kind)
        tapered = bool(columns[STRAIGHT:].any())
        cost, gradient, hessian = normal_equations(
            *problem.data(), *start, tapered, *problem.weighting()
        )
        total = float(cost) + add_prior(
            problem.prior, start.axes, start.eps, start.taper, gradient, hessian
        )
        if not np.isfinite(total):
            # On numbers that are none bobyqa corrupts memory.
            return Refined(start, float(cost), 1)
        unwhiten = _unwhitening(hessian, columns)
        best, used = Refined(start, float(cost), 0), 0
        lowest = total

        def objective(y: NDArray[np.float64], slope: NDArray[np.float64]) -> float:
            nonlocal best, used, lowest
            value, plain, downhill, *parts = chart_value(
                y,
                unwhiten,
                *problem.data(),
                *start,
                tapered,
                *problem.weighting(),
                problem.prior,
                bounds,
            )
            used += 1
            if value < lowest:
                best, lowest = Refined(Guess(*parts), float(plain), used), float(value)
            if slope.size:
                slope[:] = downhill
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
        # Round-off at the optimum is nlopt's way to say that no step helps: the best point stands.
        with contextlib.suppress(nlopt.RoundoffLimited, nlopt.exception):
            solver.optimize(np.zeros(size))
        return best._replace(evaluations=used)


OPTIMISERS: dict[OptimiserName, Optimiser] = {
    "lm": by_levenberg_marquardt,
    "slsqp": ByNlopt(nlopt.LD_SLSQP),
    "lbfgs": ByNlopt(nlopt.LD_LBFGS),
    "mma": ByNlopt(nlopt.LD_MMA),
    "bobyqa": ByNlopt(nlopt.LN_BOBYQA),
    "cobyla": ByNlopt(nlopt.LN_COBYLA),
}
"""Optimisers by the name in the options; the last two use no derivative."""


def _unwhitening(hessian: NDArray[np.float64], columns: NDArray[np.float64]) -> NDArray[np.float64]:
    """Matrix (13, k) from whitened free numbers to a full step."""
    reduced = columns.T @ hessian @ columns
    size = columns.shape[1]
    reduced += (_RIDGE * np.trace(reduced) / size + np.finfo(float).tiny) * np.eye(size)
    return np.ascontiguousarray(columns @ np.linalg.inv(np.linalg.cholesky(reduced)).T)
