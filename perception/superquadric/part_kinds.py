"""The kind of each part, from its general solid."""

from __future__ import annotations

from dataclasses import replace
from operator import attrgetter

import numpy as np
from numpy.typing import NDArray

from .cost_kernels import distances
from .effective_samples import effective_sample_size
from .kinds import basis, fixed_exponents, starting_axes
from .levenberg_marquardt import levenberg_marquardt
from .model_selection import CandidateModel, criterion
from .options import FitOptions
from .parameters import ShapeParameters
from .part_cloud import PartCloud
from .problem import FitProblem, parameter_bounds
from .shape import Kind
from .starts import axis_permutations, rotated_dual

POINTS, ITERATIONS = 200, 10
"""Points and descent steps on which the kinds are compared."""
DIAMOND_EXPONENT = 1.2
"""With a larger ε2 a section is a diamond, whose axes are no axes of a box."""
TOLERANCE = 1e-3
"""Relative decrease of the cost below which a descent ends."""


def fit_kinds(
    shape: ShapeParameters, mask: NDArray[np.bool_], cloud: PartCloud, options: FitOptions
) -> list[CandidateModel]:
    """Fit each kind of solid to the points in a mask (N,), best criterion first.

    The general solid `shape` gives the axes of all kinds. A cylinder may lie along any of them.
    """
    problem = cloud.part_problem(mask, POINTS)
    if shape.exponents[1] > DIAMOND_EXPONENT:
        shape = rotated_dual(shape)
    models: list[CandidateModel] = []
    for kind in options.kinds:
        if kind == "tapered":
            continue
        starts = axis_permutations(shape) if kind == "cylinder" else [shape]
        ends = [_fit_kind(kind, start, problem, options) for start in starts]
        models.append(min(ends, key=attrgetter("cost")))
    closest = min(models, key=attrgetter("cost"))
    residuals = distances(problem.points, closest.shape)
    problem = replace(problem, samples=effective_sample_size(problem.points, residuals))
    models = [
        model._replace(criterion=criterion(model.cost, model.kind, problem, options))
        for model in models
    ]
    return sorted(models, key=attrgetter("criterion"))


def _fit_kind(
    kind: Kind, shape: ShapeParameters, problem: FitProblem, options: FitOptions
) -> CandidateModel:
    bounds = parameter_bounds(kind, problem, options)
    exponents = fixed_exponents(kind)
    log_axes = np.log(starting_axes(kind, np.exp(shape.log_axes)))
    start = shape._replace(
        log_axes=np.clip(log_axes, *bounds[0]),
        exponents=np.clip(shape.exponents if exponents is None else exponents, *bounds[1]),
        taper=np.zeros(2),
    )
    end, cost, _ = levenberg_marquardt(problem, start, basis(kind), bounds, ITERATIONS, TOLERANCE)
    return CandidateModel(kind, end, cost, criterion(cost, kind, problem, options))
