"""Sides and widths of a fitted object, with standard deviations and proven bounds.

A deviation has three causes: the noise of the points, the distance of the surface from its model,
and points that the solid does not reach. Their factors were chosen on one half of the household
meshes, seen once from 25° to 65° with 1 mm of noise, so that one and two deviations cover 68 and
95 % of the sides and widths. docs/results.md has the coverage of the other half.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import KDTree

from .shape import Superquadric
from .uncertainty import SIDES, Uncertainty
from .view_evidence import ViewEvidence

MISFIT_POINTS = 800
"""Maximum number of points from which the misfit is computed."""
NOISE_REACH = 1.6
"""Distance by which noise moves the farthest points of a side outwards, in standard deviations."""
BULGE = 1.0
"""Distance of the farthest point of a real surface from the model that averages it, in standard
deviations of the misfit."""
FIRST_ORDER_FACTOR = 0.8
"""Factor on the standard deviation that the curvature of the cost gives. The effective samples
are counted with caution, so that it is too large for exact models."""
MISFIT_GROWTH = 0.58
"""Standard deviation of a side per misfit and square root of the unseen length in mm. Surfaces
leave a model like a random walk."""
SHORTFALL_FACTOR = 0.55
"""Standard deviation of all sides per distance by which points reach beyond the solid."""
OBLIQUE_FACTOR = 0.5
"""Increase of the model's error between its axes: half the sum of the direction's components
above 1. Edges and corners are known worse than faces."""
MIN_SIGMA = 2e-5
"""Minimum standard deviation of a side, m."""
EVEN_SPREAD = 12.0
"""Variance of an even distribution: its squared length over this."""
BOUND_NOISE = 1.0
"""Standard deviation of the bounds themselves, in multiples of the expected noise."""
OPEN_FACTOR = 2.0
"""Without a view the unseen length is this times the distance by which the solid passes the
points."""


# Arrays have no truth value: equality is identity.
@dataclass(frozen=True, eq=False)
class SideEstimate:
    """The position of one side of an object."""

    name: str
    """The side, as in SIDES: +x -x +y -y +z -z in the axes of the solid."""
    direction: NDArray[np.float64]
    """(3,) unit direction outwards, in the frame of the solid's pose."""
    position: float
    """Distance of the object's farthest point along it from the solid's centre, m."""
    sigma: float
    """Standard deviation of the position, m. Two of them cover 95 % of real sides."""
    low: float
    """The object reaches at least this far: points were seen there, m."""
    high: float
    """The object cannot reach farther: the space beyond was seen to be empty. May be infinite."""


@dataclass(frozen=True)
class WidthEstimate:
    """The width of an object along a direction."""

    mean: float
    """Expected width, m."""
    sigma: float
    """Standard deviation, m. Two of them cover 95 % of real widths."""
    low: float
    """Minimum width that the points prove, m."""
    high: float
    """Maximum width that the empty space allows, m. May be infinite."""


@dataclass(frozen=True, eq=False)
class ExtentModel:
    """Everything from which sides and widths are computed."""

    solids: Sequence[Superquadric]
    """Solids of the object; the first one has the axes of the sides."""
    uncertainty: Uncertainty | None
    """First-order uncertainty of the first solid."""
    evidence: ViewEvidence | None
    """The view of the object. Without it nothing bounds the sides."""
    misfit: float
    """Standard deviation of the surface about the model, m."""
    noise: float
    """Standard deviation of the points' noise, m."""
    shortfall: float
    """Distance by which points reach beyond the sides of the solids, m."""
    alternatives: Sequence[Superquadric] = ()
    """Solids that explain the points of a single solid as well."""


class _Ends(NamedTuple):
    """Reach of an object along K directions, each (K,), m."""

    mean: NDArray[np.float64]
    model_variance: NDArray[np.float64]
    """Variance of the model's error, m²."""
    low: NDArray[np.float64]
    high: NDArray[np.float64]
    gap: NDArray[np.float64]
    """Unseen length."""


def extent_model(
    solids: Sequence[Superquadric],
    uncertainty: Uncertainty | None,
    evidence: ViewEvidence | None,
    alternatives: Sequence[Superquadric] = (),
) -> ExtentModel:
    """Measure the misfit of the solids, and how far points reach beyond them."""
    if evidence is None:
        return ExtentModel(solids, uncertainty, None, 0.0, 0.0, 0.0)
    points = evidence.points
    points = points[np.random.default_rng(0).permutation(len(points))[:MISFIT_POINTS]]
    distances = np.array([solid.distance(points) for solid in solids])
    nearest = distances.argmin(axis=0)
    normals = np.zeros_like(points)
    for index, solid in enumerate(solids):
        own = nearest == index
        normals[own] = solid.normals(points[own])
    misfit, noise = correlated_misfit(points, normals, distances.min(axis=0))
    axes = solids[0].rotation.T
    sides = np.concatenate([axes, -axes])
    beyond = evidence.seen_reach(sides) - NOISE_REACH * noise - _support(solids, sides)
    shortfall = max(float(beyond.max()), 0.0)
    # Those of several parts are alternatives of the largest part only.
    alternatives = alternatives if len(solids) == 1 else ()
    return ExtentModel(solids, uncertainty, evidence, misfit, noise, shortfall, alternatives)


def estimate_sides(model: ExtentModel) -> tuple[SideEstimate, ...]:
    """Return the six sides along the axes of the first solid, in the order of SIDES."""
    solid = model.solids[0]
    axes = solid.rotation.T
    directions = np.stack([axes, -axes], axis=1).reshape(6, 3)
    ends = _ends(model, directions)
    variance = _first_order(model, directions) + ends.model_variance
    sigma = np.minimum(np.sqrt(variance), _even_sigma(ends.gap, model))
    centre = directions @ solid.centre
    return tuple(
        SideEstimate(name, directions[k], *(float(values[k]) for values in numbers))
        for numbers in [(ends.mean - centre, sigma, ends.low - centre, ends.high - centre)]
        for k, name in enumerate(SIDES)
    )


def estimate_widths(
    model: ExtentModel, directions: NDArray[np.float64]
) -> tuple[WidthEstimate, ...]:
    """Return the widths along unit directions (K, 3)."""
    both = np.stack([directions, -directions], axis=1).reshape(-1, 3)
    ends = _ends(model, both)
    mean, low, high = (part.reshape(-1, 2).sum(axis=1) for part in (ends.mean, ends.low, ends.high))
    variance = _first_order(model, directions, width=True)
    variance += ends.model_variance.reshape(-1, 2).sum(axis=1)
    bounded = np.linalg.norm(_even_sigma(ends.gap, model).reshape(-1, 2), axis=1)
    sigma = np.minimum(np.sqrt(variance), bounded)
    return tuple(
        WidthEstimate(float(mean[k]), float(sigma[k]), max(float(low[k]), 0.0), float(high[k]))
        for k in range(len(directions))
    )


def inflated_covariance(model: ExtentModel) -> NDArray[np.float64] | None:
    """Return the covariance (13, 13) of the first solid, with the model's error of each side.

    The errors of two opposite sides are independent. The semi-axis is half their sum, the shift of
    the centre half their difference.
    """
    if model.uncertainty is None:
        return None
    solid = model.solids[0]
    axes = solid.rotation.T
    variance = _ends(model, np.concatenate([axes, -axes])).model_variance
    up, down = variance[:3], variance[3:]
    covariance = FIRST_ORDER_FACTOR**2 * model.uncertainty.covariance
    covariance[:3, :3] += np.diag(up + down) / 4.0
    covariance[8:11, 8:11] += axes.T @ np.diag(up + down) @ axes / 4.0
    across = np.diag(up - down) @ axes / 4.0
    covariance[:3, 8:11] += across
    covariance[8:11, :3] += across.T
    return covariance


def _ends(model: ExtentModel, directions: NDArray[np.float64]) -> _Ends:
    evidence = model.evidence
    support = _support(model.solids, directions)
    if evidence is None:
        nothing = np.zeros_like(support)
        unbounded = nothing + np.inf
        return _Ends(support, nothing + MIN_SIGMA**2, -unbounded, unbounded, unbounded)
    low = evidence.seen_reach(directions) - NOISE_REACH * model.noise
    high = np.maximum(evidence.free_reach(directions), low)
    mean = np.clip(support + BULGE * model.misfit, low, high)
    open_gap = OPEN_FACTOR * np.maximum(support - low, 0.0)
    limit = evidence.diameter if evidence.view_origin is not None else open_gap
    gap = np.where(np.isfinite(high), high - low, limit)
    components = np.abs(directions @ model.solids[0].rotation).sum(axis=1)
    grown = MISFIT_GROWTH * model.misfit * np.sqrt(1e3 * gap)
    grown = grown * (1.0 + OBLIQUE_FACTOR * (components - 1.0))
    variance = grown**2 + (SHORTFALL_FACTOR * model.shortfall) ** 2 + MIN_SIGMA**2
    if model.alternatives:
        reaches = np.array([support, *(other.support(directions) for other in model.alternatives)])
        variance += np.ptp(np.clip(reaches, low, high), axis=0) ** 2 / EVEN_SPREAD
    # Single noisy points lie beyond the bounds.
    return _Ends(mean, variance, low - model.noise, high, gap)


def _support(
    solids: Sequence[Superquadric], directions: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Return the support function (K,) of a union of solids along directions (K, 3), m."""
    return np.max([solid.support(directions) for solid in solids], axis=0)


def _first_order(
    model: ExtentModel, directions: NDArray[np.float64], *, width: bool = False
) -> NDArray[np.float64]:
    """Return the first-order variance (K,) of the reach along directions (K, 3), or of the width.

    The support of a solid along d is at most c·d + Σ a_k |d·e_k|, linear in centre and semi-axes.
    The centre cancels in a width.
    """
    if model.uncertainty is None:
        return np.zeros(len(directions))
    covariance = model.uncertainty.covariance
    slopes = np.zeros((len(directions), len(covariance)))
    slopes[:, :3] = np.abs(directions @ model.solids[0].rotation)
    if width:
        slopes *= 2.0
    else:
        slopes[:, 8:11] = directions
    variance = np.einsum("ki,ij,kj->k", slopes, covariance, slopes)
    return FIRST_ORDER_FACTOR**2 * np.maximum(variance, 0.0)


def _even_sigma(gap: NDArray[np.float64], model: ExtentModel) -> NDArray[np.float64]:
    """Return the standard deviation (K,) of an even distribution between noisy bounds, m."""
    noise = BOUND_NOISE * model.evidence.noise if model.evidence is not None else 0.0
    return np.sqrt(gap**2 / EVEN_SPREAD + noise**2)


PATCH_SIZE = 20
"""Neighbours of a patch. Their noise averages out; the distance of the surface does not."""
PATCHES = 200
"""Points whose patches are evaluated."""
CLIP = 3.0
"""Residuals are clipped at this many robust standard deviations, against outliers."""


def correlated_misfit(
    points: NDArray[np.float64], normals: NDArray[np.float64], residuals: NDArray[np.float64]
) -> tuple[float, float]:
    """Separate the residuals of a model into the model's misfit and the noise of the points.

    The misfit is the square root of the mean product of a residual and those of its neighbours.
    Neighbours are those of the points projected onto the model. Neighbours of the points
    themselves would have similar noise, because noise moves points towards each other.

    Parameters
    ----------
    points
        (N, 3) in random order, m.
    normals
        (N, 3) unit normals of the model at the points.
    residuals
        (N,) signed distances of the points from the model, m.

    Returns
    -------
    misfit, noise
        Standard deviations, m. The misfit is 0 with fewer points than two patches.
    """
    limit = CLIP * 1.4826 * float(np.median(np.abs(residuals)))
    clipped = np.clip(residuals, -limit, limit)
    square = float(np.mean(clipped**2))
    if len(points) <= 2 * PATCH_SIZE:
        return 0.0, float(np.sqrt(square))
    flat = points - residuals[:, None] * normals
    patches = np.asarray(KDTree(flat).query(flat[:PATCHES], k=PATCH_SIZE + 1)[1])
    product = float(np.mean(clipped[:PATCHES, None] * clipped[patches[:, 1:]]))
    product = min(max(product, 0.0), square)
    return float(np.sqrt(product)), float(np.sqrt(square - product))
