"""The ladder of solids: fit each kind, keep the simplest that explains the cloud."""

from __future__ import annotations

from dataclasses import replace
from operator import attrgetter
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from .cost_kernels import normal_equations
from .effective_samples import independent_readings
from .kinds import basis, fixed_exponents, starting_axes
from .levenberg_marquardt import levenberg_marquardt
from .multi_start import End, distinct, in_two_rounds, search, short_descents
from .shape import MAX_EXPONENT, MAX_TAPER, MIN_EXPONENT, PARAMETER_COUNT, Kind
from .starts import axis_permutations, starting_boxes, swapped_axes

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from .options import FitOptions
    from .problem import FitProblem, Guess

START_POINTS = 80
"""Points on which starts compete: enough to tell basins apart."""
SOFT_EDGE = 0.3
"""Exponent from which a sharp-edged solid starts as a general one: at 0.1 edges hold it fast."""
LADDER_TOLERANCE = 1e-4
"""Relative gain below which a rung is told apart well enough; the chosen one is refined."""
FULL_EXPONENT_RANGE = (MIN_EXPONENT, MAX_EXPONENT)
START_EVERY_RAY = 4
"""One of so many silhouette rays takes part in the starts."""
RIVAL_MARGIN = 12.0
"""Two solids of one kind whose criteria differ by less on few points are told apart on all."""
MIDDLE_POINTS = 300
"""Points on which finalists are told apart."""


class Rung(NamedTuple):
    """One kind of solid, fitted."""

    kind: Kind
    guess: Guess
    cost: float
    criterion: float
    """Bayesian information criterion (Schwarz 1978); lower is better."""
    rival: Rung | None = None
    """Another solid of the same kind that came close, not finished."""


def climb(
    problem: FitProblem, has_plane: bool, options: FitOptions
) -> tuple[list[Rung], FitProblem]:
    """Fit every kind in the options, best criterion first; also the problem with its readings.

    First all kinds compete on few points: each starts from the boxes around the cloud; cylinders
    try each axis as their own, general superquadrics are searched for (:mod:`search`), tapered
    ones start from all others. Then those that can still win are finished on all points.
    """
    boxes = starting_boxes(problem, has_plane)
    # That rays also pull tells no basin apart, and costs most.
    thin = problem.thinned(START_POINTS, START_EVERY_RAY, pull=False)
    middle = problem.thinned(MIDDLE_POINTS, 2)
    climbed: dict[Kind, list[End]] = {}
    for kind in sorted(options.kinds, key=lambda kind: PARAMETER_COUNT[kind]):
        if _needless(kind, climbed, thin, options):
            continue
        bounds = parameter_bounds(kind, problem, options)
        if kind == "superquadric":
            seeds = [
                ends[0].guess._replace(eps=np.clip(ends[0].guess.eps, SOFT_EDGE, 1.0))
                for simple, ends in climbed.items()
                if simple != "sphere"
            ]
            climbed[kind] = search(boxes, seeds, thin, bounds, options)
        else:
            starts = (
                _tapered_starts(boxes, climbed, options)
                if kind == "tapered"
                else list(_simple_starts(kind, boxes[: 1 + has_plane], options))
            )
            ends = in_two_rounds(
                kind, starts, thin, bounds, options.start_iterations, options.finalists
            )
            climbed[kind] = distinct(ends, 1 if kind != "tapered" else 2)
    # A simple kind's own boxes may lie across the object; a general solid has found its axes.
    for kind in ("cylinder", "ellipsoid", "box"):
        if kind in climbed and "superquadric" in climbed:
            ends = short_descents(
                kind,
                list(_as_kind(kind, climbed["superquadric"], options)),
                thin,
                parameter_bounds(kind, problem, options),
                options.start_iterations,
            )
            climbed[kind] = sorted([*climbed[kind], *ends], key=attrgetter("cost"))[:1]
    rungs = [
        _rung(kind, ends, middle if len(ends) > 1 else thin, options)
        for kind, ends in climbed.items()
    ]
    limit = min(rung.criterion for rung in rungs) + options.prune
    rungs = [
        _finished(rung, middle, options) if rung.criterion <= limit else rung for rung in rungs
    ]
    if len(rungs) == 1:
        return _finals(rungs, problem, options), problem
    closest = min(rungs, key=attrgetter("cost"))
    readings = independent_readings(problem, closest.guess, options)
    middle, problem = replace(middle, readings=readings), replace(problem, readings=readings)
    rungs = [_judged(rung, middle, options) for rung in rungs]
    return _finals(rungs, problem, options), problem


def _finals(rungs: list[Rung], problem: FitProblem, options: FitOptions) -> list[Rung]:
    """Finish the rungs that can still win on all points; all rungs, best first.

    Criteria on few points compare with those on all by how far they trail alone.
    """
    before = min(rung.criterion for rung in rungs)
    limit = before + 0.5 * options.prune
    done = [_finished(rung, problem, options) for rung in rungs if rung.criterion <= limit]
    shift = min(rung.criterion for rung in done) - before
    trailing = [
        rung._replace(criterion=rung.criterion + shift) for rung in rungs if rung.criterion > limit
    ]
    return sorted([*done, *trailing], key=attrgetter("criterion"))


def _judged(rung: Rung, problem: FitProblem, options: FitOptions) -> Rung:
    """Give a rung the criterion that it has on another problem, as it stands."""
    tapered = rung.kind == "tapered"
    cost = float(normal_equations(*problem.data(), *rung.guess, tapered, *problem.weighting())[0])
    rival = rung.rival
    return rung._replace(
        cost=cost,
        criterion=criterion(cost, rung.kind, problem, options),
        rival=None if rival is None else _judged(rival, problem, options),
    )


def _needless(
    kind: Kind, climbed: dict[Kind, list[End]], problem: FitProblem, options: FitOptions
) -> bool:
    """Whether a kind cannot win: what is left to explain would not pay for its numbers.

    A taper must find more than the expected noise, since a surface's own irregularities look
    like one.
    """
    if not climbed:
        return False
    best = min(ends[0].cost for ends in climbed.values())
    if kind == "tapered" and 2.0 * best < (0.75 * options.noise / problem.unit) ** 2:
        return True
    now = min(criterion(ends[0].cost, k, problem, options) for k, ends in climbed.items())
    return criterion(0.0, kind, problem, options) > now


def criterion(cost: float, kind: Kind, problem: FitProblem, options: FitOptions) -> float:
    """BIC of a fit with robust cost `cost` (half a mean square), on effective readings.

    Half the expected noise is added to the mean square: below it a better residual is no
    evidence for a richer solid.
    """
    n = problem.readings
    floor = 0.5 * options.noise / problem.unit
    return n * float(np.log(2.0 * cost + floor**2)) + PARAMETER_COUNT[kind] * float(np.log(n))


def parameter_bounds(kind: Kind, problem: FitProblem, options: FitOptions) -> NDArray[np.float64]:
    """Rows of [low, high]: log semi-axes in the problem's unit, exponents, taper.

    The range of exponents binds only kinds that fit them: a box's edges are what they are.
    """
    low, high = np.log(np.array(options.axis_range) / problem.unit)
    free = fixed_exponents(kind, options.edge_exponent) is None
    exponents = options.exponent_range if free else FULL_EXPONENT_RANGE
    return np.array([[low, high], exponents, [-MAX_TAPER, MAX_TAPER]])


def _simple_starts(kind: Kind, boxes: list[Guess], options: FitOptions):
    exponents = fixed_exponents(kind, options.edge_exponent)
    assert exponents is not None
    for box in boxes[:1] if kind == "cylinder" else boxes:
        for turned in axis_permutations(box) if kind == "cylinder" else [box]:
            yield turned._replace(
                axes=np.log(starting_axes(kind, np.exp(turned.axes))), eps=np.array(exponents)
            )


def _as_kind(kind: Kind, ends: list[End], options: FitOptions):
    exponents = fixed_exponents(kind, options.edge_exponent)
    assert exponents is not None
    for guess, _ in ends:
        axes = np.log(starting_axes(kind, np.exp(guess.axes)))
        yield guess._replace(axes=axes, eps=np.array(exponents))


def _tapered_starts(
    boxes: list[Guess], climbed: dict[Kind, list[End]], options: FitOptions
) -> list[Guess]:
    """Every straight solid found, the best general one along each of its axes, and the boxes."""
    guesses = [ends[0].guess for kind, ends in climbed.items() if kind != "sphere"]
    if "superquadric" in climbed:
        guesses += swapped_axes(climbed["superquadric"][0].guess)
    low, high = max(SOFT_EDGE, options.exponent_range[0]), options.exponent_range[1]
    turned = [turned for box in boxes for turned in axis_permutations(box)]
    guesses += turned[: options.starts]
    return [guess._replace(eps=np.clip(guess.eps, low, high)) for guess in guesses]


def _rung(kind: Kind, ends: list[End], problem: FitProblem, options: FitOptions) -> Rung:
    """Best of a kind's ends, told apart on more points where there are several."""
    if len(ends) > 1:
        bounds = parameter_bounds(kind, problem, options)
        steps = options.start_iterations
        ends = short_descents(kind, [end.guess for end in ends], problem, bounds, steps)
        ends = distinct(ends, 2)
    first, *others = (
        Rung(kind, guess, cost, criterion(cost, kind, problem, options)) for guess, cost in ends
    )
    return first._replace(rival=others[0] if others else None)


def _finished(rung: Rung, problem: FitProblem, options: FitOptions) -> Rung:
    """Bring a rung, and a rival that is near, to its optimum on all points."""
    done = _descended(rung, problem, options)
    if rung.rival is None or rung.rival.criterion > rung.criterion + RIVAL_MARGIN:
        return done._replace(rival=None)
    first, second = sorted(
        (done, _descended(rung.rival, problem, options)), key=lambda one: one.criterion
    )
    return first._replace(rival=second._replace(rival=None))


def _descended(rung: Rung, problem: FitProblem, options: FitOptions) -> Rung:
    guess, cost, _ = levenberg_marquardt(
        problem,
        rung.guess,
        basis(rung.kind),
        parameter_bounds(rung.kind, problem, options),
        options.ladder_iterations,
        LADDER_TOLERANCE,
    )
    value = criterion(cost, rung.kind, problem, options)
    return rung._replace(guess=guess, cost=cost, criterion=value)
