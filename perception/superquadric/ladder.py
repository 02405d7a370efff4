"""The ladder of solids: fit each kind, keep the simplest that explains the cloud."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from .kinds import basis, fixed_exponents, starting_axes
from .levenberg_marquardt import levenberg_marquardt
from .shape import MAX_EXPONENT, MIN_EXPONENT, PARAMETER_COUNT, Kind
from .starts import axis_permutations, starting_boxes, turned_dual

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from .options import FitOptions
    from .problem import FitProblem, Guess

START_POINTS = 100
"""Points on which starts compete: enough to tell basins apart."""
SOFT_EDGE = 0.3
"""Exponent from which a sharp-edged solid starts as a general one: at 0.1 edges hold it fast."""
MIDDLE = 0.7
"""Exponent between round and square that general solids start from."""
FULL_EXPONENT_RANGE = (MIN_EXPONENT, MAX_EXPONENT)
START_EVERY_RAY = 4
"""One of so many silhouette rays takes part in the starts."""
START_TOLERANCE = 5e-3
"""Relative gain below which a start is done."""


class Rung(NamedTuple):
    """One kind of solid, fitted."""

    kind: Kind
    guess: Guess
    cost: float
    criterion: float
    """Bayesian information criterion (Schwarz 1978); lower is better."""


def climb(problem: FitProblem, has_plane: bool, options: FitOptions) -> list[Rung]:
    """Fit every kind in the options, best criterion first.

    First all kinds compete on few points: each starts from the boxes around the cloud; cylinders
    and general superquadrics try each axis as their own, general superquadrics also what the
    simpler kinds found and the 45°-turned dual of their best. Then those that can still win are
    finished on all points.
    """
    boxes = starting_boxes(problem, has_plane)
    thin = problem.thinned(START_POINTS, START_EVERY_RAY)
    rungs: list[Rung] = []
    for kind in sorted(options.kinds, key=lambda kind: PARAMETER_COUNT[kind]):
        starts = list(_starts(kind, boxes, rungs, options))
        rung = _best_of(kind, starts, thin, options)
        if kind == "superquadric":
            dual = _best_of(kind, [turned_dual(rung.guess)], thin, options)
            rung = min(rung, dual, key=lambda r: r.cost)
        rungs.append(rung)
    limit = min(rung.criterion for rung in rungs) + options.prune
    finished = [
        _finished(rung, problem, options) if rung.criterion <= limit else rung for rung in rungs
    ]
    return sorted(finished, key=lambda rung: rung.criterion)


def criterion(cost: float, kind: Kind, problem: FitProblem, options: FitOptions) -> float:
    """BIC of a fit with robust cost `cost` (half a mean square), on effective readings.

    Half the expected noise is added to the mean square: below it a better residual is no
    evidence for a richer solid.
    """
    n = options.effective_points
    floor = 0.5 * options.noise / problem.unit
    return n * float(np.log(2.0 * cost + floor**2)) + PARAMETER_COUNT[kind] * float(np.log(n))


def parameter_bounds(kind: Kind, problem: FitProblem, options: FitOptions) -> NDArray[np.float64]:
    """Rows of [low, high]: log semi-axes in the problem's unit, and exponents.

    The range of exponents binds only the kind that fits them: a box's edges are what they are.
    """
    low, high = np.log(np.array(options.axis_range) / problem.unit)
    free = fixed_exponents(kind, options.edge_exponent) is None
    return np.array([[low, high], options.exponent_range if free else FULL_EXPONENT_RANGE])


def _starts(kind: Kind, boxes: list[Guess], rungs: list[Rung], options: FitOptions):
    exponents = fixed_exponents(kind, options.edge_exponent)
    if kind == "superquadric":
        for rung in rungs:
            if rung.kind != "sphere":
                eps = np.clip(rung.guess.eps, SOFT_EDGE, 1.0)
                yield rung.guess._replace(eps=np.clip(eps, *options.exponent_range))
        for turned in axis_permutations(boxes[0]):
            yield turned._replace(eps=np.clip([MIDDLE, MIDDLE], *options.exponent_range))
        return
    assert exponents is not None
    for box in boxes[:1] if kind == "cylinder" else boxes:
        for turned in axis_permutations(box) if kind == "cylinder" else [box]:
            yield turned._replace(
                axes=np.log(starting_axes(kind, np.exp(turned.axes))), eps=np.array(exponents)
            )


def _best_of(
    kind: Kind,
    starts: list[Guess],
    problem: FitProblem,
    options: FitOptions,
) -> Rung:
    steps, bounds = basis(kind), parameter_bounds(kind, problem, options)
    ends = [
        levenberg_marquardt(
            problem,
            start,
            steps,
            bounds,
            options.extent_prior,
            options.start_iterations,
            START_TOLERANCE,
        )
        for start in starts
    ]
    guess, cost, _ = min(ends, key=lambda end: end[1])
    return Rung(kind, guess, cost, criterion(cost, kind, problem, options))


def _finished(rung: Rung, problem: FitProblem, options: FitOptions) -> Rung:
    guess, cost, _ = levenberg_marquardt(
        problem,
        rung.guess,
        basis(rung.kind),
        parameter_bounds(rung.kind, problem, options),
        options.extent_prior,
        options.ladder_iterations,
    )
    return Rung(rung.kind, guess, cost, criterion(cost, rung.kind, problem, options))
