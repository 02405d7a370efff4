"""Share a cloud out among several rough solids: descend, give points to the nearest, again."""

from __future__ import annotations

from dataclasses import replace
from itertools import combinations
from operator import itemgetter
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from .cost_kernels import distances
from .kinds import basis
from .levenberg_marquardt import levenberg_marquardt
from .model_selection import parameter_bounds
from .part_proposals import cuts
from .problem import Guess, pose_problem
from .starts import starting_boxes

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from .options import FitOptions
    from .part_cloud import PartCloud, Seen
    from .problem import FitProblem
    from .shape import Kind

FEWEST = 25
"""Points that a part must have."""
FIRST_POINTS, FIRST_STEPS = 50, 6
"""Points on which cuts compete, and steps: enough to tell what lies on one convex surface."""
JUDGES = 400
"""Points that judge the first competition."""
POINTS, STEPS, RAYS = 100, 5, 12
"""Points, steps and rays of the descents between which points change parts."""
ROUNDS, LAST_ROUNDS = 2, 4
"""Times that points change parts: of every finalist, then of the best."""
FINALISTS, LAST = 4, 2
"""Cuts that go on from the first competition, and from the second."""
BURIED = 2.0
"""Points that lie deeper inside a part than so many times the noise tell where it ends."""
TOLERANCE = 1e-3
"""Relative gain of a step below which a descent ends."""
MIDDLE = 0.7
"""Exponent between round and square that parts start from."""
SEAM = 2.0
"""What a seam through all points costs, in units of the log mean square: parts meet at necks, and
flat slices that explain as much meet all along."""


class Shares(NamedTuple):
    """A cloud shared out among rough solids."""

    guesses: tuple[Guess, ...]
    """One general solid per part, in m about the cloud's middle."""
    labels: NDArray[np.int64]
    """(N,) which part each point belongs to."""
    residuals: NDArray[np.float64]
    """(N,) signed distances from the union, m."""
    score: float
    """Log mean square of the residuals, and what the seam costs; lower is better."""


def robust_cost(residuals: NDArray[np.float64], options: FitOptions) -> float:
    """Half a mean square of residuals (N,), m, with the Cauchy loss of the fit, m²."""
    scale = 2.0 * options.noise
    return float(np.mean(0.5 * scale**2 * np.log1p((residuals / scale) ** 2)))


def log_square(residuals: NDArray[np.float64], options: FitOptions) -> float:
    """Log of a robust mean square, half the expected noise added as in the ladder's criterion."""
    return float(np.log(2.0 * robust_cost(residuals, options) + (0.5 * options.noise) ** 2))


def split_further(
    shares: Shares, index: int, cloud: PartCloud, options: FitOptions
) -> Shares | None:
    """Split one part of a cloud in two, as well as any cut of its points leads to.

    All cuts compete by short descents to the points alone; the best go on with all that the view
    says. None where no cut leaves both sides enough points.
    """
    members = np.flatnonzero(shares.labels == index)
    place = np.full(len(cloud.points), -1)
    place[members] = np.arange(len(members))
    points, guess = cloud.points[members], shares.guesses[index]
    around, gaps = place[cloud.neighbours[members]], distances(points, *guess)
    few = cloud.points[:JUDGES]
    others = [distances(few, *g) for k, g in enumerate(shares.guesses) if k != index]
    first: list[tuple[float, tuple[Guess, ...], NDArray[np.int64]]] = []
    for mask in cuts(points, around, gaps, guess.R, options.noise, FEWEST):
        one, two = (_first_descent(points[side], cloud, options) for side in (~mask, mask))
        labels = shares.labels.copy()
        labels[members[mask]] = len(shares.guesses)
        guesses = (*shares.guesses[:index], one, *shares.guesses[index + 1 :], two)
        apart = [*others, distances(few, *one), distances(few, *two)]
        first.append((_score(labels, np.min(apart, axis=0), cloud, options), guesses, labels))
    first = sorted(first, key=itemgetter(0))[:FINALISTS]
    ends = [
        _alternated(_shares(guesses, labels, cloud, options), ROUNDS, cloud, options)
        for _, guesses, labels in first
    ]
    if not ends:
        return None
    ends = sorted(ends, key=lambda one: one.score)[:LAST]
    ends = [_alternated(one, LAST_ROUNDS, cloud, options) for one in ends]
    return min(ends, key=lambda one: one.score)


def merged(shares: Shares, cloud: PartCloud, options: FitOptions) -> Shares:
    """Give the points of two parts to one, of the two that lose least by it."""
    parts = range(len(shares.guesses))
    ends: list[Shares] = []
    for one, two in combinations(parts, 2):
        # The parts after the second move up.
        labels = np.where(shares.labels == two, one, shares.labels)
        labels = labels - (labels > two)
        guess = _first_descent(cloud.points[labels == one], cloud, options)
        guess = _further_descent(guess, cloud.part(labels, one, options), options)
        guesses = tuple(guess if k == one else shares.guesses[k] for k in parts if k != two)
        ends.append(_shares(guesses, labels, cloud, options))
    return min(ends, key=lambda one: one.score)


def nearest_parts(gaps: Sequence[NDArray[np.float64]], cloud: PartCloud) -> NDArray[np.int64]:
    """Give each point to the part whose surface is nearest, as most of its neighbours do, (N,).

    `gaps` are the signed distances (N,) from each part.
    """
    return _as_neighbours(np.abs(gaps).argmin(axis=0), len(gaps), cloud)


def buried_points(gaps: Sequence[NDArray[np.float64]], options: FitOptions) -> NDArray[np.bool_]:
    """Whether points lie deep inside a part, whichever surface they lie on, (N,)."""
    return np.min(gaps, axis=0) < -BURIED * options.noise


def box_behind(seen: Seen, options: FitOptions) -> Guess | None:
    """Fit a box to a part that shows one face alone: as deep as the face is wide, away from us.

    None without a view: then a flat part is a sheet, and no solid.
    """
    if seen.origin is None:
        return None
    problem = pose_problem(*seen, options)
    box = starting_boxes(problem, has_plane=False)[0]
    axes = box.axes.copy()
    axes[2] = axes[1]
    across = box.R[:, 2]
    away = across * np.sign(across @ (box.c - problem.origin))
    start = box._replace(axes=axes, c=box.c + np.exp(axes[2]) * away)
    start = start._replace(eps=np.full(2, options.edge_exponent))
    return _descent("box", start, problem, options.ladder_iterations, options)


def _alternated(shares: Shares, rounds: int, cloud: PartCloud, options: FitOptions) -> Shares:
    """Let points change parts while it helps."""
    best = shares
    for _ in range(rounds):
        gaps = [distances(cloud.points, *guess) for guess in shares.guesses]
        labels = nearest_parts(gaps, cloud)
        if np.bincount(labels, minlength=len(gaps)).min() < FEWEST:
            break
        guesses = tuple(
            _further_descent(guess, cloud.part(labels, index, options), options)
            for index, guess in enumerate(shares.guesses)
        )
        shares = _shares(guesses, labels, cloud, options)
        best = min(best, shares, key=lambda one: one.score)
    return best


def _as_neighbours(labels: NDArray[np.int64], parts: int, cloud: PartCloud) -> NDArray[np.int64]:
    chosen = np.eye(parts)[labels]
    return (chosen + chosen[cloud.neighbours].sum(axis=1)).argmax(axis=1)


def _shares(
    guesses: tuple[Guess, ...],
    labels: NDArray[np.int64],
    cloud: PartCloud,
    options: FitOptions,
) -> Shares:
    # Deep inside any part is deep inside the union.
    residuals = np.min([distances(cloud.points, *guess) for guess in guesses], axis=0)
    return Shares(guesses, labels, residuals, _score(labels, residuals, cloud, options))


def _score(
    labels: NDArray[np.int64],
    residuals: NDArray[np.float64],
    cloud: PartCloud,
    options: FitOptions,
) -> float:
    """Log mean square of the first points' residuals (M,), and what the seam costs."""
    few = len(residuals)
    beside = labels[cloud.neighbours[:few]]
    seam = float(np.mean(np.any(beside != labels[:few, None], axis=1)))
    return log_square(residuals, options) + SEAM * seam


def _first_descent(points: NDArray[np.float64], cloud: PartCloud, options: FitOptions) -> Guess:
    """Descend from the box around points (M, 3), without what the view says."""
    near = cloud.seen.near._replace(cloud=points)
    problem = pose_problem(near, None, None, None, replace(options, points=FIRST_POINTS))
    box = _best_axis(starting_boxes(problem, has_plane=False)[0])
    start = box._replace(eps=np.full(2, MIDDLE))
    return _descent("superquadric", start, problem, FIRST_STEPS, options)


def _further_descent(guess: Guess, seen: Seen, options: FitOptions) -> Guess:
    rays = min(options.silhouette_rays, RAYS)
    problem = pose_problem(*seen, replace(options, points=POINTS, silhouette_rays=rays))
    start = guess._replace(
        axes=guess.axes - np.log(problem.unit), c=(guess.c - problem.centre) / problem.unit
    )
    return _descent("superquadric", start, problem, STEPS, options)


def _descent(
    kind: Kind, start: Guess, problem: FitProblem, steps: int, options: FitOptions
) -> Guess:
    bounds = parameter_bounds(kind, problem, options)
    start = start._replace(axes=np.clip(start.axes, *bounds[0]), eps=np.clip(start.eps, *bounds[1]))
    end, _, _ = levenberg_marquardt(problem, start, basis(kind), bounds, steps, TOLERANCE)
    return end._replace(
        axes=end.axes + np.log(problem.unit), c=end.c * problem.unit + problem.centre
    )


def _best_axis(box: Guess) -> Guess:
    """Turn a box so that its most similar extents lie across z."""
    a, b, c = box.axes
    last = int(np.argmin(np.abs([b - c, c - a, a - b])))
    order = [(last + 1) % 3, (last + 2) % 3, last]
    return box._replace(axes=box.axes[order], R=np.ascontiguousarray(box.R[:, order]))
