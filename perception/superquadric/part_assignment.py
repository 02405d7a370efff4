"""Assignment of points to several rough solids: cut, fit each, reassign points, repeat."""

from __future__ import annotations

import functools
from collections.abc import Sequence
from operator import attrgetter
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from .cost_kernels import distances
from .kinds import basis
from .levenberg_marquardt import levenberg_marquardt
from .multi_start import START_EXPONENT
from .options import FitOptions
from .parameters import ShapeParameters
from .part_cloud import PartCloud
from .part_cuts import propose_cuts
from .part_kernels import seam_share, vote_parts
from .problem import FitProblem, parameter_bounds
from .shape import Kind

MIN_PART_POINTS = 25
"""Minimum number of points of a part."""
COARSE_POINTS, COARSE_ITERATIONS = 60, 6
"""Points and descent steps on which cuts are compared."""
MEDIUM_POINTS, MEDIUM_ITERATIONS = 120, 5
"""Points and descent steps of the fits between two assignments."""
BEST_CUTS, ROUNDS = 2, 2
"""Number of best cuts that continue, and rounds of assignment of each."""
MIN_THICKNESS = 0.1
"""Minimum extent of the first box around a part, as a share of its largest."""
TOLERANCE = 1e-3
"""Relative decrease of the cost below which a descent ends."""
SEAM_WEIGHT = 2.0
"""Cost of a seam through all points, in units of the log mean square. Real parts meet at narrow
necks; flat slices that fit equally well meet along their whole face."""


class RoughPart(NamedTuple):
    """A rough solid of a part."""

    shape: ShapeParameters
    """In the scaled frame of the cloud."""
    gaps: NDArray[np.float64]
    """(N,) signed distances of the points."""
    covered: NDArray[np.bool_] | None
    """(M,) mask of the empty rays that the solid covers."""


class PartAssignment(NamedTuple):
    """Rough solids and the points that belong to each."""

    parts: tuple[RoughPart, ...]
    labels: NDArray[np.int64]
    """(N,) index of the part of each point."""
    square: float
    """Robust mean square of the residuals of points and empty rays."""
    score: float
    """Log of it plus the cost of the seam; lower is better."""


def rough_part(shape: ShapeParameters, cloud: PartCloud) -> RoughPart:
    """Evaluate a solid on a cloud."""
    return RoughPart(shape, distances(cloud.points, shape), cloud.covered(shape))


def assignment_of(
    parts: Sequence[RoughPart], labels: NDArray[np.int64], cloud: PartCloud
) -> PartAssignment:
    """Evaluate parts with points assigned by labels (N,)."""
    # The distance from the union is the smallest signed distance from any part.
    gaps = functools.reduce(np.minimum, [part.gaps for part in parts])
    masks = [part.covered for part in parts if part.covered is not None]
    square = cloud.square_error(gaps, functools.reduce(np.logical_or, masks) if masks else None)
    score = float(np.log(square)) + SEAM_WEIGHT * seam_share(labels, cloud.neighbours)
    return PartAssignment(tuple(parts), labels, square, score)


def worst_part(assignment: PartAssignment, cloud: PartCloud) -> int:
    """Return the index of the part whose points and empty rays it explains worst."""
    return int(
        np.argmax(
            [
                np.mean(assignment.labels == index)
                * cloud.square_error(part.gaps[assignment.labels == index], None)
                + cloud.square_error(np.zeros(1), part.covered)
                for index, part in enumerate(assignment.parts)
            ]
        )
    )


def cut_part(
    assignment: PartAssignment, index: int, cloud: PartCloud, options: FitOptions
) -> PartAssignment | None:
    """Cut one part in two; return the best cut, or None if a side has too few points."""
    members = np.flatnonzero(assignment.labels == index)
    position = np.full(len(cloud.points), -1)
    position[members] = np.arange(len(members))
    proposals = propose_cuts(
        cloud.points[members],
        None if cloud.image is None else cloud.image[: len(position)][members],
        position[cloud.neighbours[members]],
        assignment.parts[index].gaps[members],
        cloud.noise,
        MIN_PART_POINTS,
    )
    cuts: list[PartAssignment] = []
    for mask in proposals:
        labels = assignment.labels.copy()
        labels[members[mask]] = len(assignment.parts)
        one, two = (coarse_fit(labels == k, cloud, options) for k in (index, len(assignment.parts)))
        parts = [*assignment.parts, two]
        parts[index] = one
        cuts.append(assignment_of(parts, labels, cloud))
    cuts = sorted(cuts, key=attrgetter("score"))[:BEST_CUTS]
    if not cuts:
        return None
    return min((reassign(one, ROUNDS, cloud, options) for one in cuts), key=attrgetter("score"))


def reassign(
    assignment: PartAssignment, rounds: int, cloud: PartCloud, options: FitOptions
) -> PartAssignment:
    """Alternate between assigning the points and fitting the parts; return the best round."""
    best = assignment
    for _ in range(rounds):
        labels = vote_parts(np.array([part.gaps for part in assignment.parts]), cloud.neighbours)
        if np.bincount(labels, minlength=len(assignment.parts)).min() < MIN_PART_POINTS:
            break
        parts = [
            _refit(part.shape, labels == index, cloud, options)
            for index, part in enumerate(assignment.parts)
        ]
        assignment = assignment_of(parts, labels, cloud)
        best = min(best, assignment, key=attrgetter("score"))
    return best


def coarse_fit(mask: NDArray[np.bool_], cloud: PartCloud, options: FitOptions) -> RoughPart:
    """Fit a solid to the points in a mask (N,) from the box around them."""
    problem = cloud.part_problem(mask, COARSE_POINTS)
    box = principal_box(problem.points)
    return rough_part(_descend("superquadric", box, problem, COARSE_ITERATIONS, options), cloud)


def _refit(
    shape: ShapeParameters, mask: NDArray[np.bool_], cloud: PartCloud, options: FitOptions
) -> RoughPart:
    """Continue the fit of a solid on the points in a mask (N,)."""
    problem = cloud.part_problem(mask, MEDIUM_POINTS)
    return rough_part(_descend("superquadric", shape, problem, MEDIUM_ITERATIONS, options), cloud)


def _descend(
    kind: Kind, start: ShapeParameters, problem: FitProblem, iterations: int, options: FitOptions
) -> ShapeParameters:
    bounds = parameter_bounds(kind, problem, options)
    start = start._replace(
        log_axes=np.clip(start.log_axes, *bounds[0]), exponents=np.clip(start.exponents, *bounds[1])
    )
    return levenberg_marquardt(problem, start, basis(kind), bounds, iterations, TOLERANCE)[0]


def principal_box(points: NDArray[np.float64]) -> ShapeParameters:
    """Return a rounded box around points (K, 3) along their principal axes.

    The two most similar extents become x and y.
    """
    centre = np.ones(len(points)) @ points / len(points)
    offsets = points - centre
    _, R = np.linalg.eigh(offsets.T @ offsets)
    local = offsets @ R
    low, high = local.min(axis=0), local.max(axis=0)
    half = 0.5 * (high - low)
    half = np.maximum(half, MIN_THICKNESS * half.max())
    a, b, c = np.log(half)
    gaps = (abs(b - c), abs(c - a), abs(a - b))
    last = gaps.index(min(gaps))
    order = [(last + 1) % 3, (last + 2) % 3, last]
    middle = centre + R @ (0.5 * (low + high))
    R = R[:, order] * np.array([1.0, 1.0, np.linalg.det(R[:, order])])
    return ShapeParameters(
        np.log(half[order]), np.full(2, START_EXPONENT), np.ascontiguousarray(R), middle
    )
