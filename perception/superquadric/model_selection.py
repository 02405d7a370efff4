"""Model selection: fit each kind of solid and keep the simplest that explains the cloud."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from operator import attrgetter
from typing import NamedTuple

import numpy as np

from .cost_kernels import distances, normal_equations
from .effective_samples import effective_sample_size
from .kinds import basis, fixed_exponents, starting_axes
from .levenberg_marquardt import levenberg_marquardt
from .multi_start import Minimum, distinct, search_superquadric, short_descents, two_rounds
from .options import FitOptions
from .parameters import ShapeParameters
from .problem import EXPONENT_RANGE, FitProblem, parameter_bounds
from .shape import PARAMETER_COUNT, Kind
from .starts import axis_permutations, starting_boxes, swapped_axes

COARSE_POINTS, COARSE_RAY_STEP = 80, 4
"""Points, and rays (every n-th), on which starts are compared: enough to separate the minima."""
MEDIUM_POINTS, MEDIUM_RAY_STEP = 300, 2
"""Points, and rays (every n-th), on which the kinds are compared."""
MIN_SOFT_EXPONENT = 0.3
"""A general solid starts from a sharp-edged one with at least this exponent: at 0.1 the descent
does not leave the sharp edges."""
MAX_ITERATIONS = 25
"""Levenberg-Marquardt steps of each kind from its best start."""
TOLERANCE = 1e-4
"""Relative decrease of the cost below which these steps end. The selected solid is refined
further."""
PRUNE_MARGIN = 30.0
"""Kinds whose criterion on few points exceeds the best by more are not refined. A lower value is
faster, a higher value safer."""
RIVAL_MARGIN = 12.0
"""Two solids of one kind whose criteria on few points differ by less are compared on all."""
MAX_STRAIGHT_NOISE = 0.75
"""A taper is fitted only if straight solids leave residuals above this share of the expected
noise, because irregularities of a surface look like a taper."""
CRITERION_NOISE = 0.5
"""Share of the expected noise that is added to the residuals in the criterion: below it a better
residual is no evidence for a richer solid."""


class CandidateModel(NamedTuple):
    """The best fit of one kind of solid."""

    kind: Kind
    shape: ShapeParameters
    cost: float
    """Robust cost without the prior."""
    criterion: float
    """Bayesian information criterion (Schwarz 1978); lower is better."""
    rival: CandidateModel | None = None
    """Another solid of the same kind with a similar criterion, not refined."""


def select_model(
    problem: FitProblem, has_plane: bool, options: FitOptions
) -> tuple[list[CandidateModel], FitProblem]:
    """Fit every kind in the options; return the fits, best criterion first.

    First all kinds are compared on few points: each starts from the boxes around the cloud;
    cylinders try each axis; general superquadrics are searched by :mod:`multi_start`; tapered
    solids start from all others. Then the kinds that can still win are refined on all points.

    Returns
    -------
    candidates, problem
        The fits, and the problem with its effective number of samples.
    """
    # The pull of the rays separates no minima and takes most of the time.
    coarse = problem.thinned(COARSE_POINTS, COARSE_RAY_STEP, pull=False)
    medium = problem.thinned(MEDIUM_POINTS, MEDIUM_RAY_STEP)
    minima = _fit_kinds(starting_boxes(problem, has_plane), coarse, has_plane, options)
    candidates = [
        _best_candidate(kind, ends, medium if len(ends) > 1 else coarse, options)
        for kind, ends in minima.items()
    ]
    limit = min(one.criterion for one in candidates) + PRUNE_MARGIN
    candidates = [
        _refine(one, medium, options) if one.criterion <= limit else one for one in candidates
    ]
    if len(candidates) == 1:
        return _refine_on_all_points(candidates, problem, options), problem
    closest = min(candidates, key=attrgetter("cost"))
    residuals = distances(problem.points, closest.shape)
    samples = effective_sample_size(problem.points, residuals)
    medium, problem = replace(medium, samples=samples), replace(problem, samples=samples)
    candidates = [_evaluate(one, medium, options) for one in candidates]
    return _refine_on_all_points(candidates, problem, options), problem


def criterion(cost: float, kind: Kind, problem: FitProblem, options: FitOptions) -> float:
    """Return the BIC of a fit with robust cost `cost` (half a mean square)."""
    n = problem.samples
    floor = CRITERION_NOISE * options.noise / problem.unit
    return n * float(np.log(2.0 * cost + floor**2)) + PARAMETER_COUNT[kind] * float(np.log(n))


def _fit_kinds(
    boxes: list[ShapeParameters], problem: FitProblem, has_plane: bool, options: FitOptions
) -> dict[Kind, list[Minimum]]:
    """Return the best minima of each kind that can win, on a thinned problem."""
    minima: dict[Kind, list[Minimum]] = {}
    for kind in sorted(options.kinds, key=lambda kind: PARAMETER_COUNT[kind]):
        if _cannot_win(kind, minima, problem, options):
            continue
        bounds = parameter_bounds(kind, problem, options)
        if kind == "superquadric":
            seeds = [
                shape._replace(exponents=np.clip(shape.exponents, MIN_SOFT_EXPONENT, 1.0))
                for shape in (
                    ends[0].shape for simple, ends in minima.items() if simple != "sphere"
                )
            ]
            minima[kind] = search_superquadric(boxes, seeds, problem, bounds, options)
            continue
        if kind == "tapered":
            starts = _tapered_starts(boxes, minima, options)
        else:
            starts = list(_simple_starts(kind, boxes[: 1 + has_plane]))
        ends = two_rounds(kind, starts, problem, bounds, options.max_minima)
        minima[kind] = distinct(ends, 2 if kind == "tapered" else 1)
    # The boxes may lie across the object. A general solid has found the axes of the object.
    for kind in ("cylinder", "ellipsoid", "box"):
        if kind in minima and "superquadric" in minima:
            starts = [_as_kind(kind, end.shape) for end in minima["superquadric"]]
            bounds = parameter_bounds(kind, problem, options)
            ends = short_descents(kind, starts, problem, bounds)
            minima[kind] = sorted([*minima[kind], *ends], key=attrgetter("cost"))[:1]
    return minima


def _cannot_win(
    kind: Kind, minima: dict[Kind, list[Minimum]], problem: FitProblem, options: FitOptions
) -> bool:
    """Return whether even a perfect fit of a kind would not pay for its parameters."""
    if not minima:
        return False
    lowest = min(ends[0].cost for ends in minima.values())
    noise = MAX_STRAIGHT_NOISE * options.noise / problem.unit
    if kind == "tapered" and 2.0 * lowest < noise**2:
        return True
    best = min(criterion(ends[0].cost, k, problem, options) for k, ends in minima.items())
    return criterion(0.0, kind, problem, options) > best


def _simple_starts(kind: Kind, boxes: list[ShapeParameters]) -> Iterator[ShapeParameters]:
    for box in boxes[:1] if kind == "cylinder" else boxes:
        for start in axis_permutations(box) if kind == "cylinder" else [box]:
            yield _as_kind(kind, start)


def _as_kind(kind: Kind, shape: ShapeParameters) -> ShapeParameters:
    """Return the most similar solid of a kind with fixed exponents."""
    log_axes = np.log(starting_axes(kind, np.exp(shape.log_axes)))
    return shape._replace(log_axes=log_axes, exponents=np.array(fixed_exponents(kind)))


def _tapered_starts(
    boxes: list[ShapeParameters], minima: dict[Kind, list[Minimum]], options: FitOptions
) -> list[ShapeParameters]:
    """Return every straight solid, the best general one along each of its axes, and the boxes."""
    shapes = [ends[0].shape for kind, ends in minima.items() if kind != "sphere"]
    if "superquadric" in minima:
        shapes += swapped_axes(minima["superquadric"][0].shape)
    permuted = [start for box in boxes for start in axis_permutations(box)]
    shapes += permuted[: options.starts]
    low, high = max(MIN_SOFT_EXPONENT, EXPONENT_RANGE[0]), EXPONENT_RANGE[1]
    return [shape._replace(exponents=np.clip(shape.exponents, low, high)) for shape in shapes]


def _best_candidate(
    kind: Kind, minima: list[Minimum], problem: FitProblem, options: FitOptions
) -> CandidateModel:
    """Return the best of the minima of a kind; several are compared on more points first."""
    if len(minima) > 1:
        bounds = parameter_bounds(kind, problem, options)
        minima = short_descents(kind, [end.shape for end in minima], problem, bounds)
        minima = distinct(minima, 2)
    best, *others = (
        CandidateModel(kind, shape, cost, criterion(cost, kind, problem, options))
        for shape, cost in minima
    )
    return best._replace(rival=others[0] if others else None)


def _evaluate(one: CandidateModel, problem: FitProblem, options: FitOptions) -> CandidateModel:
    """Return a candidate with its cost and criterion on another problem."""
    cost = float(normal_equations(problem.terms, one.shape, one.kind == "tapered")[0])
    return one._replace(
        cost=cost,
        criterion=criterion(cost, one.kind, problem, options),
        rival=None if one.rival is None else _evaluate(one.rival, problem, options),
    )


def _refine_on_all_points(
    candidates: list[CandidateModel], problem: FitProblem, options: FitOptions
) -> list[CandidateModel]:
    """Refine the candidates that can still win on all points; return all, best first.

    The others keep the difference to the best that they have on few points.
    """
    before = min(one.criterion for one in candidates)
    limit = before + 0.5 * PRUNE_MARGIN
    refined = [_refine(one, problem, options) for one in candidates if one.criterion <= limit]
    shift = min(one.criterion for one in refined) - before
    others = [
        one._replace(criterion=one.criterion + shift) for one in candidates if one.criterion > limit
    ]
    return sorted([*refined, *others], key=attrgetter("criterion"))


def _refine(one: CandidateModel, problem: FitProblem, options: FitOptions) -> CandidateModel:
    """Descend from a candidate, and from its rival if that is similar; return the better one."""
    refined = _descend(one, problem, options)
    if one.rival is None or one.rival.criterion > one.criterion + RIVAL_MARGIN:
        return refined._replace(rival=None)
    first, second = sorted(
        (refined, _descend(one.rival, problem, options)), key=attrgetter("criterion")
    )
    return first._replace(rival=second._replace(rival=None))


def _descend(one: CandidateModel, problem: FitProblem, options: FitOptions) -> CandidateModel:
    bounds = parameter_bounds(one.kind, problem, options)
    shape, cost, _ = levenberg_marquardt(
        problem, one.shape, basis(one.kind), bounds, MAX_ITERATIONS, TOLERANCE
    )
    return one._replace(
        shape=shape, cost=cost, criterion=criterion(cost, one.kind, problem, options)
    )
