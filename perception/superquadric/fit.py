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
from .ladder import Rung, climb, criterion, parameter_bounds
from .options import FitOptions
from .problem import FitProblem, Guess, pose_problem
from .refine import refine
from .residual_kernels import distances
from .shape import Kind, Superquadric

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.typing import ArrayLike, NDArray

FILTER_POINTS = 800
"""Points among which outliers are looked for."""
FILTER_NEIGHBOURS = 6
"""Neighbours whose mean distance tells an outlier."""
FILTER_RATIO = 2.5
"""A point whose neighbours lie this many times farther than the median's is an outlier."""
FLAT = 1e-4
"""Smallest ratio of a cloud's singular values that still counts as an extent."""
FARTHEST = 1e6
"""Coordinates beyond this leave too few digits for a solid, m."""
MAD_TO_SIGMA = 1.4826
"""Ratio of standard deviation to median absolute deviation of a normal distribution."""
NOISE_LIMIT = 4.0
"""Spread of the points about a usable solid, in expected noise ..."""
SIZE_LIMIT = 0.12
"""... or as a share of the cloud's radius, whichever is more."""
UNSEEN_LIMIT = 4.0
"""Largest semi-axis of a usable solid, in radii of the points seen."""
UNIT_TOLERANCE = 1e-3
BOUND_TOLERANCE = 1e-6


@dataclass(frozen=True)
class Candidate:
    """One kind of solid on the ladder."""

    superquadric: Superquadric
    """The fitted solid, in the cloud's frame."""
    spread: float
    """Robust standard deviation of the points about its surface, m."""
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
    def spread(self) -> float:
        """Robust standard deviation of the points about the surface, m; infinite without one."""
        return _spread(self.residuals)


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
    try:
        cloud = np.asarray(points, dtype=np.float64)
    except (TypeError, ValueError) as error:
        raise InputError(f"points must be numbers of shape (N, 3): {error}") from error
    if cloud.ndim != 2 or cloud.shape[1] != 3:
        raise InputError(f"points must have shape (N, 3), got {cloud.shape}")
    origin = _vector(view_origin, 3, "view_origin")
    plane = _vector(support_plane, 4, "support_plane")
    if plane is not None and abs(np.linalg.norm(plane[:3]) - 1.0) > UNIT_TOLERANCE:
        raise InputError(f"support_plane must have a unit normal, got {plane[:3].tolist()}")

    reason = _unusable(cloud, options)
    if not reason:
        cloud = _without_outliers(cloud, options)
        reason = _too_little(cloud, plane, options)
    if reason:
        return SuperquadricFit.none(reason, time.perf_counter() - began)
    problem = pose_problem(cloud, origin, plane, hidden, options)
    rungs = climb(problem, plane is not None, options)
    rungs = [_refined(rungs[0], problem, options), *rungs[1:]]
    if not all(np.all(np.isfinite(part)) for rung in rungs for part in rung.guess):
        reason = "the optimiser left the finite numbers: is the cloud one solid?"
        return SuperquadricFit.none(reason, time.perf_counter() - began)
    ladder = tuple(_candidate(rung, problem) for rung in rungs)
    residuals = distances(problem.points, *rungs[0].guess) * problem.unit
    reason = _ran_away(rungs[0].guess, problem, options) or _misses(residuals, problem, options)
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


def _unusable(cloud: NDArray[np.float64], options: FitOptions) -> str:
    if len(cloud) < options.min_points:
        return f"{len(cloud)} points are too few: at least {options.min_points} are needed"
    bad = int(np.count_nonzero(~np.all(np.isfinite(cloud), axis=1)))
    if bad:
        return f"{bad} points are NaN or infinite: leave out pixels without a reading"
    largest = float(np.abs(cloud).max())
    if largest > FARTHEST:
        return f"coordinates reach {largest:.3g} m: move the cloud nearer to the origin"
    return ""


def _too_little(
    cloud: NDArray[np.float64], plane: NDArray[np.float64] | None, options: FitOptions
) -> str:
    """Why a cloud without outliers determines no solid, or an empty string."""
    centre = cloud.mean(axis=0)
    extents = np.linalg.svd(cloud - centre, compute_uv=False) / np.sqrt(len(cloud))
    low, high = options.axis_range
    if extents[0] == 0.0:
        return "all points are the same point"
    if extents[1] < FLAT * extents[0]:
        return "all points lie on one line"
    if extents[2] < FLAT * extents[0] and plane is None:
        return "all points lie on one plane: give the support plane, or another view"
    if len(cloud) < options.min_points:
        return (
            f"{len(cloud)} different points are too few: at least {options.min_points} are needed"
        )
    if not low / 2 <= extents[0] <= 2 * high:
        return (
            f"the cloud spreads over {extents[0]:.3g} m (one σ): solids with semi-axes of "
            f"{low} to {high} m are fitted; are these metres?"
        )
    if plane is not None and abs(plane[:3] @ centre + plane[3]) > 2 * high:
        return f"the support plane passes {abs(plane[:3] @ centre + plane[3]):.3g} m from the cloud"
    return ""


def _without_outliers(cloud: NDArray[np.float64], options: FitOptions) -> NDArray[np.float64]:
    """Points whose neighbours are about as near as everybody's, at most FILTER_POINTS of them."""
    if len(cloud) > FILTER_POINTS:
        rng = np.random.default_rng(options.seed)
        cloud = cloud[rng.permutation(len(cloud))[:FILTER_POINTS]]
    spacing = _neighbour_distance(cloud)
    if np.median(spacing) == 0.0:
        cloud = np.unique(cloud, axis=0)
        spacing = _neighbour_distance(cloud)
    keep = spacing <= FILTER_RATIO * np.median(spacing)
    return cloud[keep] if keep.sum() >= options.min_points else cloud


def _neighbour_distance(cloud: NDArray[np.float64]) -> NDArray[np.float64]:
    count = min(FILTER_NEIGHBOURS, len(cloud) - 1)
    if count < 1:
        return np.zeros(len(cloud))
    spacing, _ = KDTree(cloud).query(cloud, k=count + 1)
    return spacing[:, 1:].mean(axis=1)


def _refined(rung: Rung, problem: FitProblem, options: FitOptions) -> Rung:
    if options.optimiser == "lm":
        return rung
    guess, cost, _ = refine(
        problem,
        rung.guess,
        basis(rung.kind),
        parameter_bounds(rung.kind, problem, options),
        options.optimiser,
        options.max_evaluations,
    )
    return Rung(rung.kind, guess, cost, criterion(cost, rung.kind, problem, options))


def _candidate(rung: Rung, problem: FitProblem) -> Candidate:
    axes, eps, R, c = rung.guess
    exponents = (float(eps[0]), float(eps[1]))
    semi_axes, R, _ = canonical_axes(np.exp(axes) * problem.unit, exponents, R, rung.kind)
    matrix = np.eye(4)
    matrix[:3, :3] = R
    matrix[:3, 3] = c * problem.unit + problem.centre
    pose = RigidTransform.from_matrix(matrix)
    solid = Superquadric(semi_axes, exponents, pose, rung.kind)
    residuals = distances(problem.points, *rung.guess) * problem.unit
    return Candidate(solid, _spread(residuals), rung.criterion)


def _spread(residuals: NDArray[np.float64]) -> float:
    if residuals.size == 0:
        return float("inf")
    return float(MAD_TO_SIGMA * np.median(np.abs(residuals)))


def _misses(residuals: NDArray[np.float64], problem: FitProblem, options: FitOptions) -> str:
    spread = _spread(residuals)
    limit = max(NOISE_LIMIT * options.noise, SIZE_LIMIT * problem.unit)
    if spread <= limit:
        return ""
    return (
        f"points spread {spread * 1e3:.1f} mm about the best solid, more than "
        f"{limit * 1e3:.1f} mm: is the cloud one solid?"
    )


def _ran_away(guess: Guess, problem: FitProblem, options: FitOptions) -> str:
    low, high = np.log(np.array(options.axis_range) / problem.unit)
    seen = float(np.sqrt(np.sum(problem.points**2, axis=1).max()))
    if np.exp(guess.axes.max()) > UNSEEN_LIMIT * seen:
        return f"an extent grew to over {UNSEEN_LIMIT:g} times what was seen"
    if np.any(guess.axes >= high - BOUND_TOLERANCE):
        return f"an extent grew to its bound of {options.axis_range[1]} m: too little was seen"
    if np.any(guess.axes <= low + BOUND_TOLERANCE):
        return f"an extent shrank to its bound of {options.axis_range[0]} m: too little was seen"
    return ""
