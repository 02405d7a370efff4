"""Finish a selected model: its last descent, and the result that describes it."""

from __future__ import annotations

from typing import Protocol

import numpy as np
from scipy.spatial.transform import RigidTransform

from .canonical import canonical_axes
from .cost_kernels import distances
from .kinds import BOX_EXPONENT, basis
from .levenberg_marquardt import levenberg_marquardt
from .model_selection import CandidateModel, criterion
from .options import FitOptions
from .parameters import ShapeParameters
from .problem import DIRECTIONS, FitProblem, parameter_bounds
from .result import AMBIGUOUS_MARGIN, SHAPE_TOLERANCE, CandidateSolid, SuperquadricFit
from .robust import robust_spread
from .shape import Superquadric
from .uncertainty import estimate_uncertainty
from .validity import check_residuals, check_size

SPREAD_POINTS = 300
"""Points from which the spread of the candidates is computed."""
MAX_ITERATIONS = 60
"""Steps of the last descent of the selected solid."""
MAX_EDGE_CHANGE = 0.08
"""Maximum change of a semi-axis by sharper edges, as a share of the cloud's radius (root mean
square), about 4 mm for a box of 100 mm. Exact boxes change by at most 1.6 mm. Boxes that change
more grow along a side that the view does not show: their edges stay."""


class FinishFit(Protocol):
    """Refines the best model of a problem and returns its fit; see :func:`finish_fit`."""

    def __call__(
        self, models: list[CandidateModel], problem: FitProblem, options: FitOptions, /
    ) -> SuperquadricFit:
        """Return the fit of models, best first."""
        ...


def finish_fit(
    models: list[CandidateModel], problem: FitProblem, options: FitOptions
) -> SuperquadricFit:
    """Refine the first of the models of a part, and return it with the others as candidates."""
    models = [model for model in models if is_finite(model.shape)]
    if not models:
        return SuperquadricFit.rejected("the parameters of a part are not finite")
    return describe_fit([refine_model(models[0], problem, options), *models[1:]], problem, options)


def refine_model(model: CandidateModel, problem: FitProblem, options: FitOptions) -> CandidateModel:
    """Return the model after the last steps of the Levenberg-Marquardt.

    Only here do boxes get their sharper edges: a comparison of kinds with them takes more boxes
    with worn edges for general superquadrics.
    """
    bounds = parameter_bounds(model.kind, problem, options)
    columns, start = basis(model.kind), model.shape
    if model.kind == "box":
        start = start._replace(exponents=np.array([BOX_EXPONENT, BOX_EXPONENT]))
    shape, cost, _ = levenberg_marquardt(problem, start, columns, bounds, MAX_ITERATIONS)
    change = np.abs(np.exp(shape.log_axes) - np.exp(start.log_axes)).max()
    if model.kind == "box" and change > MAX_EDGE_CHANGE:
        shape, cost, _ = levenberg_marquardt(problem, model.shape, columns, bounds, MAX_ITERATIONS)
    return model._replace(
        shape=shape, cost=cost, criterion=criterion(cost, model.kind, problem, options)
    )


def describe_fit(
    models: list[CandidateModel], problem: FitProblem, options: FitOptions
) -> SuperquadricFit:
    """Return the result with the first of the models as its solid."""
    selected = models[0]
    residuals = distances(problem.points, selected.shape) * problem.unit
    reason = check_size(selected.shape, problem, options) or check_residuals(
        residuals, problem.unit, options
    )
    few = problem.thinned(SPREAD_POINTS, 1)
    candidates = tuple(candidate_solid(model, few) for model in models)
    solid = candidates[0].superquadric
    return SuperquadricFit(
        superquadric=solid,
        converged=not reason,
        reason=reason,
        residuals=residuals,
        candidates=candidates,
        seconds=0.0,
        uncertainty=estimate_uncertainty(selected.shape, selected.kind, solid, problem, options),
        alternatives=_alternatives(selected, candidates, problem, options),
        parts=(solid,),
    )


def candidate_solid(model: CandidateModel, problem: FitProblem) -> CandidateSolid:
    """Return the solid of a model with the spread of the points of a problem about it."""
    residuals = distances(problem.points, model.shape) * problem.unit
    return CandidateSolid(model_solid(model, problem), robust_spread(residuals), model.criterion)


def model_solid(model: CandidateModel, problem: FitProblem) -> Superquadric:
    """Return the solid in m and in the frame of the cloud, in canonical form."""
    log_axes, (e1, e2), R, centre, (k1, k2) = model.shape
    exponents = (float(e1), float(e2))
    semi_axes, R, taper = canonical_axes(
        np.exp(log_axes) * problem.unit, exponents, R, model.kind, (float(k1), float(k2))
    )
    matrix = np.eye(4)
    matrix[:3, :3] = R
    matrix[:3, 3] = centre * problem.unit + problem.centre
    pose = RigidTransform(matrix, normalize=False)
    return Superquadric(semi_axes, exponents, pose, model.kind, taper)


def is_finite(shape: ShapeParameters) -> bool:
    """Return whether all parameters are finite."""
    return all(np.all(np.isfinite(values)) for values in shape)


def _alternatives(
    selected: CandidateModel,
    candidates: tuple[CandidateSolid, ...],
    problem: FitProblem,
    options: FitOptions,
) -> tuple[CandidateSolid, ...]:
    """Return other solids with a similar criterion whose shape differs by more than the noise."""
    others = list(candidates[1:])
    if selected.rival is not None:
        rival = refine_model(selected.rival, problem, options)
        if is_finite(rival.shape) and not check_size(rival.shape, problem, options):
            others.append(candidate_solid(rival, problem))
    best = candidates[0]
    return tuple(
        other
        for other in others
        if other.criterion - best.criterion < AMBIGUOUS_MARGIN
        and _difference(best.superquadric, other.superquadric) > SHAPE_TOLERANCE * options.noise
    )


def _difference(first: Superquadric, second: Superquadric) -> float:
    """Return the largest difference of the extents of two solids over DIRECTIONS, m."""
    return float(np.abs(first.support(DIRECTIONS) - second.support(DIRECTIONS)).max())
