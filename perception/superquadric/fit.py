"""Fit the simplest sufficient superquadric to a cloud of points."""

from __future__ import annotations

import time
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from scipy.spatial import KDTree
from scipy.spatial.transform import RigidTransform

from eyehand.errors import InputError

from .canonical import canonical_axes
from .kinds import basis
from .ladder import Rung, climb, parameter_bounds
from .options import FitOptions
from .problem import FitProblem, Guess, pose_problem
from .refine import refine
from .residual_kernels import distances
from .shape import Kind, Superquadric

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.typing import ArrayLike, NDArray

FILTER_POINTS = 1200
"""Points among which outliers are looked for."""
FILTER_NEIGHBOURS = 6
"""Neighbours whose mean distance tells an outlier."""
FILTER_RATIO = 2.5
"""A point whose neighbours lie this many times farther than the median's is an outlier."""
FLAT = 1e-4
"""Smallest ratio of a cloud's singular values that still counts as an extent."""
BOUND_TOLERANCE = 1e-6


@dataclass(frozen=True)
class Candidate:
    """One kind of solid on the ladder."""

    superquadric: Superquadric
    """The fitted solid, in the cloud's frame."""
    rms: float
    """Robust root mean square of the residuals, m."""
    criterion: float
    """Bayesian information criterion; lower is better."""

    @property
    def kind(self) -> Kind:
        """Kind of the solid."""
        return self.superquadric.kind


@dataclass(frozen=True)
class SuperquadricFit:
    """What a fit says. False in a condition when it did not converge."""

    superquadric: Superquadric | None
    """The chosen solid in the cloud's frame; None when there is none."""
    converged: bool
    """Whether the solid can be used."""
    reason: str
    """Why it cannot, or an empty string."""
    residuals: NDArray[np.float64]
    """Signed first-order distances of the points used, (M,), m."""
    ladder: tuple[Candidate, ...]
    """All kinds tried, best first."""
    seconds: float
    """Time the fit took."""

    @classmethod
    def none(cls, reason: str, seconds: float = 0.0) -> SuperquadricFit:
        """Make the result that holds no solid, with the reason why."""
        return cls(None, False, reason, np.zeros(0), (), seconds)

    def __bool__(self) -> bool:
        return self.converged

    @property
    def rms(self) -> float:
        """Root median square of the residuals, m: the spread that outliers do not move."""
        if self.residuals.size == 0:
            return float("inf")
        return float(1.4826 * np.median(np.abs(self.residuals)))


def fit_superquadric(
    points: ArrayLike,
    *,
    view_origin: ArrayLike | None = None,
    support_plane: ArrayLike | None = None,
    hidden: Callable[[NDArray[np.float64]], NDArray[np.bool_]] | None = None,
    options: FitOptions | None = None,
) -> SuperquadricFit:
    """Fit a superquadric, as simple as the points allow, to one object's cloud.

    Parameters
    ----------
    points
        (N, 3) points on the visible surface, m, any frame.
    view_origin
        (3,) place of the camera in the same frame: adds what the view shows to be empty.
    support_plane
        (4,) unit normal and offset of the plane the object rests on, ``n·x + d = 0`` with n
        towards the object: adds soft contact, which lets go where the points disagree.
    hidden
        Tells of unit directions (K, 3) from the view's origin which are hidden, (K,) bool: where
        something nearer or the image's border cuts the object off, its outline says nothing.
    options
        What to spend where.

    Returns
    -------
    SuperquadricFit
        With ``converged=False`` and a reason for clouds that hold too little: fewer than
        ``min_points`` points, NaN, all on one line, or all on one plane without a support.

    Raises
    ------
    InputError
        If an argument has the wrong shape.
    """
    began = time.perf_counter()
    options = options or FitOptions()
    cloud = np.asarray(points, dtype=np.float64)
    if cloud.ndim != 2 or cloud.shape[1] != 3:
        raise InputError(f"points must have shape (N, 3), got {cloud.shape}")
    origin = _vector(view_origin, 3, "view_origin")
    plane = _vector(support_plane, 4, "support_plane")

    reason = _refusal(cloud, plane is not None, options)
    if reason:
        return SuperquadricFit.none(reason, time.perf_counter() - began)
    problem = pose_problem(_without_outliers(cloud, options), origin, plane, hidden, options)
    rungs = climb(problem, plane is not None, options)
    best = _refined(rungs[0], problem, options)
    ladder = tuple(_candidate(rung, problem) for rung in [best, *rungs[1:]])
    residuals = distances(problem.points, *best.guess) * problem.unit
    if not np.all(np.isfinite(residuals)):
        reason = "the optimiser left the finite numbers: is the cloud one solid?"
        return SuperquadricFit.none(reason, time.perf_counter() - began)
    reason = _ran_away(best.guess, problem, options)
    return SuperquadricFit(
        superquadric=ladder[0].superquadric,
        converged=not reason,
        reason=reason,
        residuals=residuals,
        ladder=ladder,
        seconds=time.perf_counter() - began,
    )


def _vector(value: ArrayLike | None, size: int, name: str) -> NDArray[np.float64] | None:
    if value is None:
        return None
    vector = np.asarray(value, dtype=np.float64)
    if vector.shape != (size,) or not np.all(np.isfinite(vector)):
        raise InputError(f"{name} must be {size} finite numbers, got {vector.tolist()}")
    return vector


def _refusal(cloud: NDArray[np.float64], has_plane: bool, options: FitOptions) -> str:
    if len(cloud) < options.min_points:
        return f"{len(cloud)} points are too few: at least {options.min_points} are needed"
    bad = int(np.count_nonzero(~np.all(np.isfinite(cloud), axis=1)))
    if bad:
        return f"{bad} points are NaN or infinite: leave out pixels without a reading"
    extents = np.linalg.svd(cloud - cloud.mean(axis=0), compute_uv=False)
    if extents[0] == 0.0:
        return "all points are the same point"
    if extents[1] < FLAT * extents[0]:
        return "all points lie on one line"
    if extents[2] < FLAT * extents[0] and not has_plane:
        return "all points lie on one plane: give the support plane, or another view"
    return ""


def _without_outliers(cloud: NDArray[np.float64], options: FitOptions) -> NDArray[np.float64]:
    """Points whose neighbours are about as near as everybody's, at most FILTER_POINTS of them."""
    if len(cloud) > FILTER_POINTS:
        rng = np.random.default_rng(options.seed)
        cloud = cloud[rng.permutation(len(cloud))[:FILTER_POINTS]]
    spacing, _ = KDTree(cloud).query(cloud, k=FILTER_NEIGHBOURS + 1)
    mean = spacing[:, 1:].mean(axis=1)
    keep = mean <= FILTER_RATIO * np.median(mean)
    return cloud[keep] if keep.sum() >= options.min_points else cloud


def _refined(rung: Rung, problem: FitProblem, options: FitOptions) -> Rung:
    if options.optimiser == "lm":
        return rung
    guess, cost, _ = refine(
        problem,
        rung.guess,
        basis(rung.kind),
        parameter_bounds(problem, options),
        options.optimiser,
        options.max_evaluations,
    )
    return rung._replace(guess=guess, cost=cost)


def _candidate(rung: Rung, problem: FitProblem) -> Candidate:
    axes, eps, R, c = rung.guess
    exponents = (float(eps[0]), float(eps[1]))
    semi_axes, R = canonical_axes(np.exp(axes) * problem.unit, exponents, R, rung.kind)
    matrix = np.eye(4)
    matrix[:3, :3] = R
    matrix[:3, 3] = c * problem.unit + problem.centre
    pose = RigidTransform.from_matrix(matrix)
    solid = Superquadric(semi_axes, exponents, pose, rung.kind)
    rms = float(np.sqrt(2.0 * rung.cost)) * problem.unit
    return Candidate(solid, rms, rung.criterion)


def _ran_away(guess: Guess, problem: FitProblem, options: FitOptions) -> str:
    low, high = parameter_bounds(problem, options)[0]
    if np.any(guess.axes >= high - BOUND_TOLERANCE):
        return f"an extent grew to its bound of {options.axis_range[1]} m: too little was seen"
    if np.any(guess.axes <= low + BOUND_TOLERANCE):
        return f"an extent shrank to its bound of {options.axis_range[0]} m: too little was seen"
    return ""
