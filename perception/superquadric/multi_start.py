"""Multi-start search: short descents from many starts, longer ones from the best."""

from __future__ import annotations

from collections.abc import Iterable
from operator import attrgetter
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from .kinds import basis
from .levenberg_marquardt import levenberg_marquardt_from
from .options import FitOptions
from .parameters import ShapeParameters
from .problem import FitProblem
from .shape import Kind
from .starts import axis_permutations, rotated_dual, swapped_axes

START_EXPONENT = 0.7
"""Exponent between round and square from which general superquadrics start."""
START_ITERATIONS = 6
"""Levenberg-Marquardt steps of a short descent: enough to compare the starts."""
SHORT_TOLERANCE = 1e-3
"""Relative decrease of the cost below which a short descent ends."""
SAME_COST = 1e-3
"""Minima whose costs differ by a smaller share count as the same solid."""
SWITCHED_MINIMA = 2
"""Best minima from which switched starts are derived."""
_EXTRA_MINIMA = 2
"""Minima of the first round beyond ``max_minima`` that enter the second round."""


class Minimum(NamedTuple):
    """The end of a descent."""

    shape: ShapeParameters
    cost: float


def short_descents(
    kind: Kind,
    starts: Iterable[ShapeParameters],
    problem: FitProblem,
    bounds: NDArray[np.float64],
) -> list[Minimum]:
    """Descend a few steps from every start; return the ends, best first."""
    starts = list(starts)
    if not starts:
        return []
    ends = levenberg_marquardt_from(
        problem, starts, basis(kind), bounds, START_ITERATIONS, SHORT_TOLERANCE
    )
    return sorted((Minimum(*end) for end in ends), key=attrgetter("cost"))


def search_superquadric(
    boxes: list[ShapeParameters],
    seeds: list[ShapeParameters],
    problem: FitProblem,
    bounds: NDArray[np.float64],
    options: FitOptions,
) -> list[Minimum]:
    """Return the best general superquadrics on a thinned problem, best first.

    Descents start from the boxes with each axis as z, and from `seeds`. The best ends are
    switched: their axes are exchanged together with the exponents, or they are rotated to their
    45° dual. Both describe nearly the same surface by other numbers, and no descent passes from
    one to the other (Liu et al. 2022 switch in the same way).
    """
    exponents = np.clip([START_EXPONENT, START_EXPONENT], *bounds[1])
    starts = [
        start._replace(exponents=exponents) for box in boxes for start in axis_permutations(box)
    ][: options.starts]
    starts += [seed._replace(exponents=np.clip(seed.exponents, *bounds[1])) for seed in seeds]
    count = options.max_minima + _EXTRA_MINIMA
    minima = two_rounds("superquadric", starts, problem, bounds, count)
    switched = [
        shape._replace(exponents=np.clip(shape.exponents, *bounds[1]))
        for minimum in distinct(minima, SWITCHED_MINIMA)
        for shape in (rotated_dual(minimum.shape), *swapped_axes(minimum.shape))
    ]
    minima += short_descents("superquadric", switched, problem, bounds)
    return distinct(sorted(minima, key=lambda end: end.cost), options.max_minima)


def two_rounds(
    kind: Kind,
    starts: Iterable[ShapeParameters],
    problem: FitProblem,
    bounds: NDArray[np.float64],
    count: int,
) -> list[Minimum]:
    """Descend from every start, then again from the `count` best distinct ends; best first."""
    ends = short_descents(kind, starts, problem, bounds)
    best = [end.shape for end in distinct(ends, count)]
    return short_descents(kind, best, problem, bounds)


def distinct(minima: list[Minimum], count: int) -> list[Minimum]:
    """Return the first `count` of sorted minima that differ in cost."""
    kept: list[Minimum] = []
    for minimum in minima:
        if all(abs(minimum.cost - other.cost) > SAME_COST * other.cost for other in kept):
            kept.append(minimum)
        if len(kept) == count:
            break
    return kept
