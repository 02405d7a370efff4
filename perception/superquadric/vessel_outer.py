"""Fit the outer solid of a vessel about the axis of its rim."""

from __future__ import annotations

from dataclasses import replace
from operator import attrgetter

import numpy as np
from numpy.typing import NDArray

from ..perpendicular import cross
from .cost_kernels import distances
from .effective_samples import effective_sample_size
from .kinds import EDGE_EXPONENT, basis
from .levenberg_marquardt import levenberg_marquardt
from .model_selection import (
    COARSE_POINTS,
    COARSE_RAY_STEP,
    MAX_ITERATIONS,
    TOLERANCE,
    CandidateModel,
    criterion,
)
from .multi_start import SHORT_TOLERANCE, START_ITERATIONS
from .opening import Opening
from .options import FitOptions
from .parameters import N_PARAMETERS, ShapeParameters
from .problem import FitProblem, parameter_bounds
from .shape import Kind

STARTS = ((0.1, 0.0), (0.1, 0.25), (0.4, 0.0), (0.4, 0.4), (0.8, 0.4))
"""Exponent along the axis and taper from which the outer solid is searched: mugs, tumblers, vases,
bowls."""
REFINED = 2
"""Best starts that are refined on all points."""
MIN_EXPONENT = 0.05
"""Minimum exponent along the axis. Cups have sharper edges than boxes and cans."""


def fit_outer_solids(
    problem: FitProblem, opening: Opening, plane: NDArray[np.float64] | None, options: FitOptions
) -> tuple[list[CandidateModel], float]:
    """Fit a cylinder and a tapered solid of revolution about the axis of the rim.

    Returns
    -------
    models, samples
        The fits, best first, and the effective number of samples.
    """
    rim = opening.rim
    is_round = rim.semi_axes[0] == rim.semi_axes[1]
    coarse = problem.thinned(COARSE_POINTS, COARSE_RAY_STEP, pull=False)
    starts = [_start(problem, opening, plane, *shape) for shape in STARTS]
    models = _descended("tapered", starts, coarse, problem, options, _revolved(is_round))
    if is_round:
        models += _descended("cylinder", starts[:1], coarse, problem, options, basis("cylinder"))
    closest = min(models, key=attrgetter("cost"))
    samples = effective_sample_size(problem.points, distances(problem.points, closest.shape))
    problem = replace(problem, samples=samples)
    models = [
        one._replace(criterion=criterion(one.cost, one.kind, problem, options)) for one in models
    ]
    return sorted(models, key=attrgetter("criterion")), samples


def _revolved(is_round: bool) -> NDArray[np.float64]:
    """Return the basis of tapered solids over a circle or an ellipse of fixed ratio."""
    unit = np.eye(N_PARAMETERS)
    turns = [unit[5], unit[6]] if is_round else [unit[5], unit[6], unit[7]]
    columns = [unit[0] + unit[1], unit[2], unit[3], *turns, *unit[8:11], unit[11] + unit[12]]
    return np.ascontiguousarray(np.column_stack(columns))


def _start(
    problem: FitProblem,
    opening: Opening,
    plane: NDArray[np.float64] | None,
    exponent: float,
    taper: float,
) -> ShapeParameters:
    """Return a solid below the rim, down to the support plane or the lowest point."""
    rim = opening.rim
    centre, axis = (rim.centre - problem.centre) / problem.unit, rim.opening
    height = float(((centre - problem.points) @ axis).max())
    if plane is not None and plane[:3] @ axis > 0.0:
        height = float((plane[:3] @ rim.centre + plane[3]) / (plane[:3] @ axis)) / problem.unit
    half = 0.5 * max(height, 0.1)
    semi_axes = np.append(rim.semi_axes / problem.unit / (1.0 + taper), half)
    first = rim.directions[0]
    R = np.column_stack([first, cross(axis, first), axis])
    return ShapeParameters(
        np.log(semi_axes),
        np.array([max(exponent, EDGE_EXPONENT), 1.0]),
        np.ascontiguousarray(R),
        centre - half * axis,
        np.array([taper, taper]),
    )


def _descended(
    kind: Kind,
    starts: list[ShapeParameters],
    coarse: FitProblem,
    problem: FitProblem,
    options: FitOptions,
    columns: NDArray[np.float64],
) -> list[CandidateModel]:
    """Return the best of the starts after descents on few and then on all points."""
    bounds = parameter_bounds(kind, problem, options)
    bounds[1, 0] = min(bounds[1, 0], MIN_EXPONENT)
    ends = [
        levenberg_marquardt(coarse, start, columns, bounds, START_ITERATIONS, SHORT_TOLERANCE)
        for start in starts
    ]
    ends.sort(key=lambda end: end[1])
    ends = [
        levenberg_marquardt(problem, shape, columns, bounds, MAX_ITERATIONS, TOLERANCE)
        for shape, _, _ in ends[:REFINED]
    ]
    shape, cost, _ = min(ends, key=lambda end: end[1])
    return [CandidateModel(kind, shape, cost, criterion(cost, kind, problem, options))]
