"""Find the basin of a general superquadric: many short descents, the best go on."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from .kinds import basis
from .levenberg_marquardt import levenberg_marquardt
from .starts import axis_permutations, swapped_axes, turned_dual

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from .options import FitOptions
    from .problem import FitProblem, Guess
    from .shape import Kind

MIDDLE = 0.7
"""Exponent between round and square that general solids start from."""
SHORT_TOLERANCE = 1e-3
"""Relative gain of a step below which a short descent ends."""
SAME_COST = 1e-3
"""Descents whose costs differ by less than this share ended at the same solid."""
SWITCHED = 2
"""So many of the best solids are switched: an axis or a dual mistaken costs most there."""


class End(NamedTuple):
    """Where a descent ended."""

    guess: Guess
    cost: float


def short_descents(
    kind: Kind,
    starts: list[Guess],
    problem: FitProblem,
    bounds: NDArray[np.float64],
    steps: int,
) -> list[End]:
    """Descend a few steps from every start, best end first."""
    columns = basis(kind)
    ends = [
        levenberg_marquardt(problem, start, columns, bounds, steps, SHORT_TOLERANCE)
        for start in starts
    ]
    return sorted((End(guess, cost) for guess, cost, _ in ends), key=lambda end: end.cost)


def search(
    boxes: list[Guess],
    seeds: list[Guess],
    problem: FitProblem,
    bounds: NDArray[np.float64],
    options: FitOptions,
) -> list[End]:
    """Find the best general superquadrics on a thinned problem, best first.

    Descents start from the boxes with each axis as z and from `seeds`; the ends that are distinct
    go on, and the best of those are switched: axes exchanged together with the exponents, or
    turned to their 45° dual, since both describe nearly the same surface by other numbers and
    no descent passes from one to the other (Liu et al. 2022 switch likewise).
    """
    middle = np.clip([MIDDLE, MIDDLE], *bounds[1])
    starts = [turned._replace(eps=middle) for box in boxes for turned in axis_permutations(box)][
        : options.starts
    ]
    starts += [seed._replace(eps=np.clip(seed.eps, *bounds[1])) for seed in seeds]
    steps = options.start_iterations
    ends = in_two_rounds("superquadric", starts, problem, bounds, steps, options.finalists + 2)
    switched = [
        guess._replace(eps=np.clip(guess.eps, *bounds[1]))
        for end in distinct(ends, SWITCHED)
        for guess in (turned_dual(end.guess), *swapped_axes(end.guess))
    ]
    ends += short_descents("superquadric", switched, problem, bounds, steps)
    return distinct(sorted(ends, key=lambda end: end.cost), options.finalists)


def in_two_rounds(
    kind: Kind,
    starts: list[Guess],
    problem: FitProblem,
    bounds: NDArray[np.float64],
    steps: int,
    kept: int,
) -> list[End]:
    """Descend from every start, then go on from the `kept` best distinct ends; best end first."""
    ends = short_descents(kind, starts, problem, bounds, steps)
    best = [end.guess for end in distinct(ends, kept)]
    return short_descents(kind, best, problem, bounds, steps)


def distinct(ends: list[End], count: int) -> list[End]:
    """Keep the first `count` of sorted ends whose costs tell them apart."""
    kept: list[End] = []
    for end in ends:
        if all(abs(end.cost - other.cost) > SAME_COST * other.cost for other in kept):
            kept.append(end)
        if len(kept) == count:
            break
    return kept
