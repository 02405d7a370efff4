"""Assignment of points to several rough solids: fit each, reassign points, repeat."""

from __future__ import annotations

from dataclasses import replace
from itertools import combinations
from operator import attrgetter, itemgetter
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from .cost_kernels import distances
from .kinds import EDGE_EXPONENT, basis
from .levenberg_marquardt import levenberg_marquardt
from .model_selection import MAX_ITERATIONS
from .multi_start import START_EXPONENT
from .part_proposals import propose_splits
from .problem import Observation, build_problem, parameter_bounds
from .starts import starting_boxes

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from .options import FitOptions
    from .parameters import ShapeParameters
    from .part_cloud import PartCloud
    from .problem import FitProblem
    from .shape import Kind

MIN_PART_POINTS = 25
"""Minimum number of points of a part."""
COARSE_POINTS, COARSE_ITERATIONS = 50, 6
"""Points and descent steps on which splits are compared: enough to find points on one convex
surface."""
SCORE_POINTS = 400
"""Points from which the first scores are computed."""
MEDIUM_POINTS, MEDIUM_ITERATIONS, MEDIUM_RAYS = 100, 5, 12
"""Points, descent steps and rays of the fits between two assignments."""
FIRST_ROUNDS, LAST_ROUNDS = 2, 4
"""Rounds of assignment of the best splits of the first comparison, and of the second."""
FIRST_BEST, LAST_BEST = 4, 2
"""Number of best splits that enter the second comparison, and the third."""
BURIED_NOISE = 2.0
"""Minimum depth of a buried point inside a part, in multiples of the noise."""
TOLERANCE = 1e-3
"""Relative decrease of the cost below which a descent ends."""
SEAM_WEIGHT = 2.0
"""Cost of a seam through all points, in units of the log mean square. Real parts meet at narrow
necks; flat slices that fit equally well meet along their whole face."""


class PartAssignment(NamedTuple):
    """Rough solids and the points that belong to each."""

    shapes: tuple[ShapeParameters, ...]
    """One general solid per part, in m about the centre of the cloud."""
    labels: NDArray[np.int64]
    """(N,) index of the part of each point."""
    residuals: NDArray[np.float64]
    """(N,) signed distances from the union, m."""
    score: float
    """Log mean square of the residuals plus the cost of the seam; lower is better."""


def robust_cost(residuals: NDArray[np.float64], options: FitOptions) -> float:
    """Return half the mean square of residuals (N,), m, with the Cauchy loss of the fit, m²."""
    scale = 2.0 * options.noise
    return float(np.mean(0.5 * scale**2 * np.log1p((residuals / scale) ** 2)))


def log_square(residuals: NDArray[np.float64], options: FitOptions) -> float:
    """Return the log of a robust mean square with the noise floor of the model selection."""
    return float(np.log(2.0 * robust_cost(residuals, options) + (0.5 * options.noise) ** 2))


def split_part(
    assignment: PartAssignment, index: int, cloud: PartCloud, options: FitOptions
) -> PartAssignment | None:
    """Split one part in two; return the best split, or None if a side has too few points.

    All proposals are compared by short descents on the points alone. The best continue with the
    silhouette and the support plane.
    """
    members = np.flatnonzero(assignment.labels == index)
    position = np.full(len(cloud.points), -1)
    position[members] = np.arange(len(members))
    points, shape = cloud.points[members], assignment.shapes[index]
    neighbours, gaps = position[cloud.neighbours[members]], distances(points, shape)
    few = cloud.points[:SCORE_POINTS]
    others = [distances(few, one) for k, one in enumerate(assignment.shapes) if k != index]
    coarse: list[tuple[float, tuple[ShapeParameters, ...], NDArray[np.int64]]] = []
    for mask in propose_splits(points, neighbours, gaps, shape.R, options.noise, MIN_PART_POINTS):
        one, two = (_coarse_fit(points[side], cloud, options) for side in (~mask, mask))
        labels = assignment.labels.copy()
        labels[members[mask]] = len(assignment.shapes)
        shapes = (*assignment.shapes[:index], one, *assignment.shapes[index + 1 :], two)
        residuals = np.min([*others, distances(few, one), distances(few, two)], axis=0)
        coarse.append((_score(labels, residuals, cloud, options), shapes, labels))
    coarse = sorted(coarse, key=itemgetter(0))[:FIRST_BEST]
    splits = [
        _reassign(_assignment(shapes, labels, cloud, options), FIRST_ROUNDS, cloud, options)
        for _, shapes, labels in coarse
    ]
    if not splits:
        return None
    splits = sorted(splits, key=attrgetter("score"))[:LAST_BEST]
    splits = [_reassign(one, LAST_ROUNDS, cloud, options) for one in splits]
    return min(splits, key=attrgetter("score"))


def merge_parts(
    assignment: PartAssignment, cloud: PartCloud, options: FitOptions
) -> PartAssignment:
    """Merge the two parts that fit best as one."""
    parts = range(len(assignment.shapes))
    merged: list[PartAssignment] = []
    for one, two in combinations(parts, 2):
        # The parts after the second move up.
        labels = np.where(assignment.labels == two, one, assignment.labels)
        labels = labels - (labels > two)
        shape = _coarse_fit(cloud.points[labels == one], cloud, options)
        shape = _medium_fit(shape, cloud.part(labels, one, options), options)
        shapes = tuple(shape if k == one else assignment.shapes[k] for k in parts if k != two)
        merged.append(_assignment(shapes, labels, cloud, options))
    return min(merged, key=attrgetter("score"))


def nearest_parts(gaps: Sequence[NDArray[np.float64]], cloud: PartCloud) -> NDArray[np.int64]:
    """Assign each point to the part nearest to it and its neighbours, by majority, (N,).

    `gaps` are the signed distances (N,) from each part.
    """
    nearest = np.eye(len(gaps))[np.abs(gaps).argmin(axis=0)]
    return (nearest + nearest[cloud.neighbours].sum(axis=1)).argmax(axis=1)


def buried_points(gaps: Sequence[NDArray[np.float64]], options: FitOptions) -> NDArray[np.bool_]:
    """Return a mask (N,) of the points that lie deep inside any part."""
    return np.min(gaps, axis=0) < -BURIED_NOISE * options.noise


def fit_box_behind_face(observation: Observation, options: FitOptions) -> ShapeParameters | None:
    """Fit a box to a part that shows only one face. The box is as deep as the face is wide.

    Return None without a camera: then a flat part is a sheet.
    """
    if observation.view_origin is None:
        return None
    problem = build_problem(observation, options)
    box = starting_boxes(problem, has_plane=False)[0]
    log_axes = box.log_axes.copy()
    log_axes[2] = log_axes[1]
    normal = box.R[:, 2]
    away = normal * np.sign(normal @ (box.centre - problem.terms.view_origin))
    start = box._replace(
        log_axes=log_axes,
        exponents=np.full(2, EDGE_EXPONENT),
        centre=box.centre + np.exp(log_axes[2]) * away,
    )
    return _descend("box", start, problem, MAX_ITERATIONS, options)


def _reassign(
    assignment: PartAssignment, rounds: int, cloud: PartCloud, options: FitOptions
) -> PartAssignment:
    """Alternate between assigning the points and fitting the parts; return the best round."""
    best = assignment
    for _ in range(rounds):
        gaps = [distances(cloud.points, shape) for shape in assignment.shapes]
        labels = nearest_parts(gaps, cloud)
        if np.bincount(labels, minlength=len(gaps)).min() < MIN_PART_POINTS:
            break
        shapes = tuple(
            _medium_fit(shape, cloud.part(labels, index, options), options)
            for index, shape in enumerate(assignment.shapes)
        )
        assignment = _assignment(shapes, labels, cloud, options)
        best = min(best, assignment, key=attrgetter("score"))
    return best


def _assignment(
    shapes: tuple[ShapeParameters, ...],
    labels: NDArray[np.int64],
    cloud: PartCloud,
    options: FitOptions,
) -> PartAssignment:
    # The distance from the union is the smallest signed distance from any part.
    residuals = np.min([distances(cloud.points, shape) for shape in shapes], axis=0)
    return PartAssignment(shapes, labels, residuals, _score(labels, residuals, cloud, options))


def _score(
    labels: NDArray[np.int64],
    residuals: NDArray[np.float64],
    cloud: PartCloud,
    options: FitOptions,
) -> float:
    """Return the score of the first points, those with residuals (M,)."""
    few = len(residuals)
    neighbour_labels = labels[cloud.neighbours[:few]]
    seam = float(np.mean(np.any(neighbour_labels != labels[:few, None], axis=1)))
    return log_square(residuals, options) + SEAM_WEIGHT * seam


def _coarse_fit(
    points: NDArray[np.float64], cloud: PartCloud, options: FitOptions
) -> ShapeParameters:
    """Fit a solid to points (M, 3) from the box around them, without silhouette and plane."""
    observation = Observation(cloud.observation.cloud._replace(points=points))
    problem = build_problem(observation, replace(options, points=COARSE_POINTS))
    box = _most_similar_across(starting_boxes(problem, has_plane=False)[0])
    start = box._replace(exponents=np.full(2, START_EXPONENT))
    return _descend("superquadric", start, problem, COARSE_ITERATIONS, options)


def _medium_fit(
    shape: ShapeParameters, observation: Observation, options: FitOptions
) -> ShapeParameters:
    """Fit a solid to a part, starting from a shape."""
    rays = min(options.silhouette_rays, MEDIUM_RAYS)
    problem = build_problem(
        observation, replace(options, points=MEDIUM_POINTS, silhouette_rays=rays)
    )
    start = shape._replace(
        log_axes=shape.log_axes - np.log(problem.unit),
        centre=(shape.centre - problem.centre) / problem.unit,
    )
    return _descend("superquadric", start, problem, MEDIUM_ITERATIONS, options)


def _descend(
    kind: Kind, start: ShapeParameters, problem: FitProblem, iterations: int, options: FitOptions
) -> ShapeParameters:
    """Descend from a start in the scaled frame; return the end in m."""
    bounds = parameter_bounds(kind, problem, options)
    start = start._replace(
        log_axes=np.clip(start.log_axes, *bounds[0]), exponents=np.clip(start.exponents, *bounds[1])
    )
    end, _, _ = levenberg_marquardt(problem, start, basis(kind), bounds, iterations, TOLERANCE)
    return end._replace(
        log_axes=end.log_axes + np.log(problem.unit),
        centre=end.centre * problem.unit + problem.centre,
    )


def _most_similar_across(box: ShapeParameters) -> ShapeParameters:
    """Permute the axes of a box so that its two most similar extents are x and y."""
    a, b, c = box.log_axes
    last = int(np.argmin(np.abs([b - c, c - a, a - b])))
    order = [(last + 1) % 3, (last + 2) % 3, last]
    return box._replace(log_axes=box.log_axes[order], R=np.ascontiguousarray(box.R[:, order]))
