"""Fit the simplest sufficient superquadric to a cloud of points."""

from __future__ import annotations

import time
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
from scipy.spatial.transform import RigidTransform

from eyehand.errors import InputError

from .canonical import canonical_axes
from .cost_kernels import distances
from .model_selection import Rung, climb, criterion, parameter_bounds
from .options import FitOptions
from .outliers import Neighbourly, without_outliers
from .part_cloud import Seen
from .parts import in_parts
from .problem import FitProblem, Guess, in_own_order, pose_problem
from .refine import OPTIMISERS
from .result import WITHIN_NOISE, Candidate, SuperquadricFit, robust_spread
from .shape import Superquadric
from .uncertainty import uncertainty
from .validity import misses, no_solid, ran_away, too_little, unusable

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.typing import ArrayLike, NDArray

FILTER_SHARE = 1.5
"""Outliers are looked for among so many times the points that are fitted ..."""
FILTER_LEAST = 400
"""... and at least so many: a cloud too thin hides who has neighbours."""
LADDER_POINTS = 300
"""Points on which the spread of the ladder's solids is told."""
UNIT_TOLERANCE = 1e-3
OTHER_SHAPE = 3.0
"""Extents that differ by more than so many times the noise make another shape."""
_GRID = np.array([d for d in np.ndindex(3, 3, 3) if d != (1, 1, 1)], dtype=np.float64) - 1.0
DIRECTIONS = _GRID / np.linalg.norm(_GRID, axis=1, keepdims=True)
"""Along and between the axes, (26, 3)."""


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
    cloud = _cloud(points)
    origin = _vector(view_origin, 3, "view_origin")
    plane = _vector(support_plane, 4, "support_plane")
    if plane is not None and abs(np.linalg.norm(plane[:3]) - 1.0) > UNIT_TOLERANCE:
        raise InputError(f"support_plane must have a unit normal, got {plane[:3].tolist()}")

    reason = unusable(cloud, origin, options)
    if reason:
        return SuperquadricFit.none(reason, time.perf_counter() - began)
    near = _without_outliers(cloud, origin, options)
    reason = too_little(near.cloud, origin, plane, options)
    if reason:
        return SuperquadricFit.none(reason, time.perf_counter() - began)
    seen = Seen(near, origin, plane, hidden)
    fit = _one_solid(seen, options)
    if fit.superquadric is not None and origin is not None and fit.superquadric.contains(origin):
        fit = replace(fit, converged=False, reason="the camera would stand inside the solid")
    if options.max_parts > 1:
        fit = in_parts(fit, seen, options, _one_solid)
    return replace(fit, seconds=time.perf_counter() - began)


def _one_solid(seen: Seen, options: FitOptions) -> SuperquadricFit:
    return _climbed(pose_problem(*seen, options), seen.plane is not None, options)


def _climbed(problem: FitProblem, has_plane: bool, options: FitOptions) -> SuperquadricFit:
    rungs, problem = climb(problem, has_plane, options)
    reason = no_solid(problem, rungs[0].criterion, has_plane, options)
    if reason:
        return SuperquadricFit.none(reason)
    rungs = [rung for rung in rungs if _finite(rung.guess)]
    if not rungs:
        return SuperquadricFit.none(
            "the optimiser left the finite numbers: is the cloud one solid?"
        )
    # A richer solid that ran away does not keep a plainer one that did not from being taken.
    usable = [rung for rung in rungs if not ran_away(rung.guess, problem, options)]
    chosen = _refined((usable or rungs)[0], problem, options)
    ladder = [chosen, *(rung for rung in usable or rungs if rung.kind != chosen.kind)]
    residuals = distances(problem.points, *chosen.guess) * problem.unit
    reason = ran_away(chosen.guess, problem, options) or misses(residuals, problem.unit, options)
    few = problem.thinned(LADDER_POINTS, 1)
    candidates = tuple(_candidate(rung, few) for rung in ladder)
    solid = candidates[0].superquadric
    return SuperquadricFit(
        superquadric=solid,
        converged=not reason,
        reason=reason,
        residuals=residuals,
        ladder=candidates,
        seconds=0.0,
        uncertainty=uncertainty(chosen.guess, chosen.kind, solid, problem, options),
        alternatives=_alternatives(chosen, candidates, problem, options),
        parts=(solid,),
    )


def _cloud(points: ArrayLike) -> NDArray[np.float64]:
    try:
        cloud = np.asarray(points)
    except (TypeError, ValueError) as error:
        raise InputError(f"points must be numbers of shape (N, 3): {error}") from error
    if cloud.size == 0:
        return np.zeros((0, 3))
    if cloud.dtype.kind not in "fiu":
        raise InputError(f"points must be real numbers of shape (N, 3), got {cloud.dtype}")
    if cloud.ndim != 2 or cloud.shape[1] != 3:
        raise InputError(f"points must have shape (N, 3), got {cloud.shape}")
    return cloud.astype(np.float64)


def _vector(value: ArrayLike | None, size: int, name: str) -> NDArray[np.float64] | None:
    if value is None:
        return None
    vector = np.asarray(value, dtype=np.float64)
    if vector.shape != (size,) or not np.all(np.isfinite(vector)):
        raise InputError(f"{name} must be {size} finite numbers, got {vector.tolist()}")
    return vector


def _without_outliers(
    cloud: NDArray[np.float64], origin: NDArray[np.float64] | None, options: FitOptions
) -> Neighbourly:
    """Points with neighbours, of a few times those to be fitted; all of a cloud that has few."""
    most = max(int(FILTER_SHARE * options.points), FILTER_LEAST)
    if len(cloud) > most:
        rng = np.random.default_rng(options.seed)
        cloud = in_own_order(cloud)[rng.permutation(len(cloud))[:most]]
    kept = without_outliers(cloud, origin)
    if len(kept.cloud) >= options.min_points:
        return kept
    return kept._replace(cloud=np.unique(cloud, axis=0))


def _refined(rung: Rung, problem: FitProblem, options: FitOptions) -> Rung:
    guess, cost, _ = OPTIMISERS[options.optimiser](
        problem,
        rung.guess,
        rung.kind,
        parameter_bounds(rung.kind, problem, options),
        options.max_evaluations,
    )
    value = criterion(cost, rung.kind, problem, options)
    return rung._replace(guess=guess, cost=cost, criterion=value)


def _candidate(rung: Rung, problem: FitProblem) -> Candidate:
    axes, eps, R, c, taper = rung.guess
    exponents = (float(eps[0]), float(eps[1]))
    semi_axes, R, leans = canonical_axes(
        np.exp(axes) * problem.unit, exponents, R, rung.kind, (float(taper[0]), float(taper[1]))
    )
    matrix = np.eye(4)
    matrix[:3, :3] = R
    matrix[:3, 3] = c * problem.unit + problem.centre
    pose = RigidTransform(matrix, normalize=False)
    solid = Superquadric(semi_axes, exponents, pose, rung.kind, leans)
    residuals = distances(problem.points, *rung.guess) * problem.unit
    return Candidate(solid, robust_spread(residuals), rung.criterion)


def _finite(guess: Guess) -> bool:
    return all(np.all(np.isfinite(part)) for part in guess)


def _alternatives(
    chosen: Rung, candidates: tuple[Candidate, ...], problem: FitProblem, options: FitOptions
) -> tuple[Candidate, ...]:
    """Other solids within the noise of the chosen one whose shape differs by more than it."""
    near = [
        candidate
        for candidate in candidates[1:]
        if candidate.criterion - candidates[0].criterion < WITHIN_NOISE
    ]
    if chosen.rival is not None:
        rival = _refined(chosen.rival, problem, options)
        if _finite(rival.guess) and not ran_away(rival.guess, problem, options):
            candidate = _candidate(rival, problem)
            if candidate.criterion - candidates[0].criterion < WITHIN_NOISE:
                near.append(candidate)
    solid = candidates[0].superquadric
    return tuple(
        candidate
        for candidate in near
        if _difference(solid, candidate.superquadric) > OTHER_SHAPE * options.noise
    )


def _difference(first: Superquadric, second: Superquadric) -> float:
    """Largest difference of two solids' extents over some directions, m."""
    return float(np.abs(first.support(DIRECTIONS) - second.support(DIRECTIONS)).max())
