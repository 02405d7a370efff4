"""Fit the simplest sufficient superquadric to a cloud of points."""

from __future__ import annotations

import time
from dataclasses import replace
from operator import attrgetter

import numpy as np
from numpy.typing import ArrayLike, NDArray

from eyehand.errors import InputError

from .constrained import refine_in_free_space
from .cost_kernels import normal_equations
from .finish import describe_fit, finish_fit, is_finite, model_solid, refine_model
from .free_space import FreeSpace, OutlineShares, covered_share, outline_shares
from .model_selection import CandidateModel, criterion, select_model
from .occlusion import occlusion_alternatives
from .options import FitOptions
from .outliers import FilteredCloud, remove_outliers
from .parts import split_into_parts
from .problem import FitProblem, Observation, build_problem, sort_by_radius
from .result import SuperquadricFit
from .unseen_depth import depth_alternatives
from .validity import (
    MAX_COVERED_SHARE,
    MIN_POINTS,
    check_cloud,
    check_covered_share,
    check_extent,
    check_not_flat,
    check_size,
)
from .vessel_fit import fit_vessel
from .vessel_handle import add_handle
from .view_evidence import ViewEvidence

FILTER_RATIO = 1.5
"""Number of points in the search for outliers, divided by the number of fitted points."""
MIN_FILTER_POINTS = 400
"""Minimum number of points in the search for outliers. In a cloud with fewer points, neighbours are
too far apart."""
COVERED_NOISE = 3.0
"""A ray may enter a solid this much too early, in multiples of the noise."""
UNIT_TOLERANCE = 1e-3
OUTLINE_WEIGHT = 50.0
"""Increase of the criterion per share of covered and of missed pixels. On the development half of
household meshes, 25 to 400 give the same share of usable fits."""
MENDED_SHARE, MAX_MENDED_SHARE = 0.03, 0.3
"""Covered share of a solid refined under constraints, and the maximum share before. Above that, no
convex solid explains the points."""
MIN_HOLLOW_COVERED, MIN_HOLLOW_MISSED = 0.02, 0.08
"""Shares of wrong pixels below both of which a solid is not hollow. All 37 vessels found in
views of household meshes have at least 0.07 covered or 0.15 missed pixels."""
FREE_KINDS = ("superquadric", "tapered")
"""Kinds that can leave free space by their exponents."""


def fit_superquadric(
    points: ArrayLike,
    *,
    view_origin: ArrayLike | None = None,
    support_plane: ArrayLike | None = None,
    free_space: FreeSpace | None = None,
    whole: bool = False,
    options: FitOptions | None = None,
) -> SuperquadricFit:
    """Fit a superquadric, as simple as the points allow, to the cloud of one object.

    Parameters
    ----------
    points
        (N, 3) points on the visible surface, m, in any frame.
    view_origin
        (3,) position of the camera in the same frame. With it the fit uses the space that the
        view shows to be empty.
    support_plane
        (4,) unit normal and offset of the plane on which the object rests, ``n·x + d = 0`` with n
        towards the object. With it the fit adds a soft contact, which loses its influence if the
        points disagree.
    free_space
        Empty space along the rays of the view, in the same frame; see
        :func:`perception.view_free_space`. With it the fit rejects a solid that fills this space,
        and ignores the outline where a nearer object or the image border hides the object. Its
        origin replaces `view_origin`.
    whole
        Whether the points lie on all sides of the object, as samples of a closed mesh do. Then the
        solid ends where they end. Otherwise it continues where nothing was seen.
    options
        Trade-offs of the fit; see :class:`FitOptions`.

    Returns
    -------
    SuperquadricFit
        With ``converged=False`` and a reason if the cloud does not determine a solid: fewer than
        50 points, NaN, all points on one line, or all on one plane without a support plane.

    Raises
    ------
    InputError
        If an argument has the wrong shape.
    """
    start = time.perf_counter()
    options = options or FitOptions()
    cloud = _check_points(points)
    origin = _check_vector(view_origin, 3, "view_origin")
    if free_space is not None:
        origin = free_space.origin
    plane = _check_vector(support_plane, 4, "support_plane")
    if plane is not None and abs(np.linalg.norm(plane[:3]) - 1.0) > UNIT_TOLERANCE:
        raise InputError(f"support_plane must have a unit normal, got {plane[:3].tolist()}")

    reason = check_cloud(cloud, origin)
    if reason:
        return SuperquadricFit.rejected(reason, time.perf_counter() - start)
    filtered = _filter_cloud(cloud, origin, options)
    reason = check_extent(filtered.points, origin, plane, options)
    if reason:
        return SuperquadricFit.rejected(reason, time.perf_counter() - start)
    observation = Observation(filtered, origin, plane, free_space, whole)
    fit = _fit_one_solid(observation, options)
    opened = None
    shares = _wrong_pixels(fit, free_space, options)
    if _may_be_hollow(shares):
        opened = fit_vessel(fit, observation, options, describe_fit)
    if opened is not None:
        fit, observation = opened
        free_space = observation.free_space
        shares = _wrong_pixels(fit, free_space, options)
    if fit.superquadric is not None and origin is not None and fit.superquadric.contains(origin):
        fit = replace(fit, converged=False, reason="the camera would stand inside the solid")
    fit = _check_free_space(fit, shares, free_space)
    if options.max_parts > 1:
        if fit.vessel is None:
            divided = split_into_parts(fit, observation, options)
        else:
            divided = add_handle(fit, observation, options, finish_fit)
        if divided is not fit:
            wrong = _wrong_pixels(divided, free_space, options)
            fit = _check_free_space(divided, wrong, free_space)
        elif not fit and fit.covered_share > MAX_COVERED_SHARE:
            fit = _constrained_solid(fit, observation, options)
    hidden_ends = occlusion_alternatives(fit, observation, options)
    return replace(
        fit,
        alternatives=fit.alternatives + hidden_ends + depth_alternatives(fit, observation, options),
        evidence=_view_evidence(observation, options),
        seconds=time.perf_counter() - start,
    )


def _constrained_solid(
    fit: SuperquadricFit, observation: Observation, options: FitOptions
) -> SuperquadricFit:
    """Return one solid under constraints in place of a fit that fills space seen to be empty.

    Returns `fit` if the constraints do not help.
    """
    single = replace(options, max_parts=1)
    mended = _fit_one_solid(observation, single)
    if not mended.constrained:
        return fit
    shares = _wrong_pixels(mended, observation.free_space, options)
    return _check_free_space(mended, shares, observation.free_space)


def _view_evidence(observation: Observation, options: FitOptions) -> ViewEvidence:
    return ViewEvidence(
        points=observation.cloud.points,
        noise=options.noise,
        view_origin=observation.view_origin,
        plane=observation.plane,
        free_space=observation.free_space,
    )


def _fit_one_solid(observation: Observation, options: FitOptions) -> SuperquadricFit:
    has_plane = observation.plane is not None
    models, problem = select_model(build_problem(observation, options), has_plane, options)
    reason = check_not_flat(problem, models[0].criterion, has_plane, options)
    if reason:
        return SuperquadricFit.rejected(reason)
    models = [model for model in models if is_finite(model.shape)]
    if not models:
        return SuperquadricFit.rejected(
            "the parameters are not finite after the optimisation: is the cloud one solid?"
        )
    # A richer solid of undetermined size must not displace a simpler one of determined size.
    usable = [model for model in models if not check_size(model.shape, problem, options)]
    models = _sort_by_outline(usable or models, problem, observation, options)
    selected = refine_model(models[0], problem, options)
    refined = _avoid_free_space(selected, models, problem, observation, options)
    constrained = refined is not selected
    if constrained:
        # Solids with a better criterion fill space that the view shows to be empty.
        models = [model for model in models if model.criterion > refined.criterion]
    selected = refined
    models = [selected, *(model for model in models if model.kind != selected.kind)]
    return replace(describe_fit(models, problem, options), constrained=constrained)


def _wrong_pixels(
    fit: SuperquadricFit, free_space: FreeSpace | None, options: FitOptions
) -> OutlineShares | None:
    """Return the wrong pixels of the outline of a fit; None without a free space."""
    if free_space is None:
        return None
    return outline_shares(fit.parts, free_space, COVERED_NOISE * options.noise)


def _may_be_hollow(shares: OutlineShares | None) -> bool:
    """Return whether the outline lets the object be a vessel.

    The outer solid of a vessel covers the pixels of the inside, which lie behind it, or misses
    the rim. This saves the search for an opening on most convex objects.
    """
    if shares is None:
        return True
    return shares.covered > MIN_HOLLOW_COVERED or shares.missed > MIN_HOLLOW_MISSED


def _check_free_space(
    fit: SuperquadricFit, shares: OutlineShares | None, free_space: FreeSpace | None
) -> SuperquadricFit:
    """Return the fit with its shares of pixels, not converged if it covers too much."""
    if shares is None or free_space is None:
        return fit
    # The solid of an object with a hole is right outside, and its outline differs.
    reason = fit.reason or check_covered_share(shares.beside, free_space, len(fit.parts))
    return replace(
        fit,
        covered_share=shares.covered,
        missed_share=shares.missed,
        converged=not reason,
        reason=reason,
    )


def _check_points(points: ArrayLike) -> NDArray[np.float64]:
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


def _check_vector(value: ArrayLike | None, size: int, name: str) -> NDArray[np.float64] | None:
    if value is None:
        return None
    vector = np.asarray(value, dtype=np.float64)
    if vector.shape != (size,) or not np.all(np.isfinite(vector)):
        raise InputError(f"{name} must be {size} finite numbers, got {vector.tolist()}")
    return vector


def _filter_cloud(
    cloud: NDArray[np.float64], origin: NDArray[np.float64] | None, options: FitOptions
) -> FilteredCloud:
    """Thin a cloud and remove its outliers. A sparse cloud keeps all its points."""
    max_points = max(int(FILTER_RATIO * options.points), MIN_FILTER_POINTS)
    if len(cloud) > max_points:
        rng = np.random.default_rng(options.seed)
        cloud = sort_by_radius(cloud)[rng.permutation(len(cloud))[:max_points]]
    filtered = remove_outliers(cloud, origin)
    if len(filtered.points) >= MIN_POINTS:
        return filtered
    return filtered._replace(points=np.unique(cloud, axis=0))


def _sort_by_outline(
    models: list[CandidateModel],
    problem: FitProblem,
    observation: Observation,
    options: FitOptions,
) -> list[CandidateModel]:
    """Return the models with the wrong pixels of their outlines in the criterion, best first.

    Pixels count relative to the best model. Models that cannot become the best are not projected.
    """
    free_space = observation.free_space
    if free_space is None:
        return models

    def wrong_share(model: CandidateModel) -> float:
        solid = model_solid(model, problem)
        return sum(outline_shares([solid], free_space, COVERED_NOISE * options.noise)[:2])

    first = wrong_share(models[0])
    limit = models[0].criterion + OUTLINE_WEIGHT * first
    wrong = [wrong_share(model) if model.criterion < limit else first for model in models[1:]]
    terms = [
        model.criterion + OUTLINE_WEIGHT * share
        for model, share in zip(models, [first, *wrong], strict=True)
    ]
    best = int(np.argmin(terms))
    offset = terms[best] - models[best].criterion
    sorted_models = [
        model._replace(criterion=term - offset) for model, term in zip(models, terms, strict=True)
    ]
    return sorted(sorted_models, key=attrgetter("criterion"))


def _avoid_free_space(
    selected: CandidateModel,
    models: list[CandidateModel],
    problem: FitProblem,
    observation: Observation,
    options: FitOptions,
) -> CandidateModel:
    """Return a model that leaves the space free which the view shows to be empty.

    Only a solid that covers some of it is refined under constraints. Kinds with free exponents
    are tried too, because they avoid more. The one with the best criterion is kept.
    """
    free_space = observation.free_space
    # Parts are tried first: they explain such objects better.
    if free_space is None or options.optimiser == "lm" or options.max_parts > 1:
        return selected
    tolerance = COVERED_NOISE * options.noise

    def share(model: CandidateModel) -> float:
        return covered_share([model_solid(model, problem)], free_space, tolerance)

    before = share(selected)
    if not MAX_COVERED_SHARE < before < MAX_MENDED_SHARE:
        return selected
    mended = []
    for model in [selected, *(one for one in models[1:] if one.kind in FREE_KINDS)]:
        shape = refine_in_free_space(
            problem, model.shape, model.kind, free_space, tolerance, options
        )
        cost = float(normal_equations(problem.terms, shape, model.kind == "tapered")[0])
        value = criterion(cost, model.kind, problem, options)
        mended.append(model._replace(shape=shape, cost=cost, criterion=value, rival=None))
    valid = [
        model
        for model in mended
        if is_finite(model.shape)
        and not check_size(model.shape, problem, options)
        and share(model) <= MENDED_SHARE
    ]
    return min(valid, key=attrgetter("criterion"), default=selected)
