"""Scores of fitted solids against the true solid: IoU, surface distance, extent errors."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray
from scipy.stats import qmc

from eyehand.perception.io import sample_triangles

from ...open3d_import import import_open3d
from .compound_solids import mesh_area, ray_scene
from .true_solid import TrueSolid, convex_parts, surface_mesh

SAMPLES_LOG2 = 15
"""Binary logarithm of the number of points of an IoU. The standard error of an IoU of 0.998 is
0.0003."""
SURFACE_SAMPLES = 4000
"""Number of points on each surface. It makes the mean distance accurate to 1 %."""
SEAM = 2e-4
"""Maximum distance between two faces that count as touching, m. Touching faces are not part of the
surface of a union."""


@dataclass(frozen=True)
class FitScore:
    """The scores of a fit."""

    iou: float
    """Intersection over union of the solids, 0 to 1; 0 without a fit."""
    mean_distance: float
    """Mean distance between the surfaces, m. Without a fit, this and all below are infinite."""
    max_distance: float
    """Maximum distance between the surfaces, m."""
    extent_error: float
    """Maximum error of a half extent along the axes of the true solid, m."""
    extent_share: float
    """Maximum relative error of a half extent."""


def score_fit(truth: TrueSolid, parts: Sequence[TrueSolid], seed: int = 0) -> FitScore:
    """Score the union of fitted parts against the true solid. No parts get the worst scores."""
    if not parts:
        return FitScore(0.0, np.inf, np.inf, np.inf, np.inf)
    mean, largest = surface_distances(truth, parts, seed)
    error, share = extent_errors(truth, parts)
    return FitScore(overlap(truth, parts, seed), mean, largest, error, share)


def overlap(truth: TrueSolid, parts: Sequence[TrueSolid], seed: int = 0) -> float:
    """Compute the intersection over union of a solid and the union of others, 0 to 1.

    The points are a scrambled Sobol sequence in the common bounds along the true axes. The error
    is about that of the same number of random points for small differences, and up to seven times
    smaller for large ones.
    """
    if not parts:
        return 0.0
    axes = truth.rotation.T
    low, high = _bounds([truth, *parts], axes)
    points = (low + (high - low) * _unit_points(seed)) @ axes
    in_truth = truth.contains(points)
    in_parts = np.any([part.contains(points) for part in parts], axis=0)
    either = np.count_nonzero(in_truth | in_parts)
    return float(np.count_nonzero(in_truth & in_parts) / max(either, 1))


def surface_distances(
    truth: TrueSolid, parts: Sequence[TrueSolid], seed: int = 0
) -> tuple[float, float]:
    """Compute the mean and maximum distance between the surfaces of a solid and a union, m.

    Points are uniform on each surface, and each is compared with the nearest point of the other
    surface. The mean is the mean of both directions. Inside a union, the distance is that to the
    surface of the part in which the point is deepest: a lower bound of the true distance.
    """
    rng = np.random.default_rng(seed)
    true_parts = convex_parts(truth)
    from_truth = union_distances(surface_points(true_parts, rng), parts)
    from_fit = union_distances(surface_points(parts, rng), true_parts)
    mean = (from_truth.mean() + from_fit.mean()) / 2
    return float(mean), float(max(from_truth.max(), from_fit.max()))


def extent_errors(truth: TrueSolid, parts: Sequence[TrueSolid]) -> tuple[float, float]:
    """Return the maximum error of a half extent along the axes of the true solid, m and relative.

    The extents come from the support functions, not from the semi-axes: a superquadric and its
    dual, rotated by 45°, are nearly the same solid with very different semi-axes.
    """
    axes = truth.rotation.T
    true_low, true_high = _bounds([truth], axes)
    low, high = _bounds(parts, axes)
    true_half = (true_high - true_low) / 2
    error = np.abs((high - low) / 2 - true_half)
    return float(error.max()), float((error / true_half).max())


def _bounds(
    solids: Sequence[TrueSolid], axes: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return the minimum and maximum coordinates (3,) of all solids along axes (3, 3), rows, m."""
    low = np.min([-solid.support(-axes) for solid in solids], axis=0)
    return low, np.max([solid.support(axes) for solid in solids], axis=0)


@lru_cache(maxsize=4)
def _unit_points(seed: int) -> NDArray[np.float64]:
    points = qmc.Sobol(3, rng=np.random.default_rng(seed)).random_base2(SAMPLES_LOG2)
    points.setflags(write=False)
    return points


def surface_points(solids: Sequence[TrueSolid], rng: np.random.Generator) -> NDArray[np.float64]:
    """Draw about SURFACE_SAMPLES points (N, 3), uniform on the surface of a union."""
    meshes = [surface_mesh(solid) for solid in solids]
    areas = np.array([mesh_area(*surface) for surface in meshes])
    counts = np.ceil(SURFACE_SAMPLES * areas / areas.sum()).astype(int)
    kept = []
    for index, (surface, count) in enumerate(zip(meshes, counts, strict=True)):
        points = sample_triangles(*surface, int(count), rng)
        others = [solid for other, solid in enumerate(solids) if other != index]
        covered = [_is_covered(solid, points) for solid in others]
        kept.append(points[~np.any(covered, axis=0)] if others else points)
    return np.vstack(kept)


def _is_covered(solid: TrueSolid, points: NDArray[np.float64]) -> NDArray[np.bool_]:
    """Return whether points (N, 3) lie inside a solid or within SEAM of it, (N,)."""
    inward = solid.centre - points
    distance = np.linalg.norm(inward, axis=1, keepdims=True)
    return solid.contains(points + inward * (SEAM / np.maximum(distance, SEAM)))


def union_distances(
    points: NDArray[np.float64], solids: Sequence[TrueSolid]
) -> NDArray[np.float64]:
    """Compute the distances (N,) of points (N, 3) to the surface of a union of solids, m."""
    origin = points.mean(axis=0)
    query = import_open3d().core.Tensor((points - origin).astype(np.float32))
    outside, inside = np.full(len(points), np.inf), np.full(len(points), -np.inf)
    for solid in solids:
        scene = ray_scene(*surface_mesh(solid), origin)
        distance = scene.compute_distance(query, nthreads=1).numpy().astype(np.float64)
        contained = solid.contains(points)
        outside = np.where(contained, outside, np.minimum(outside, distance))
        inside = np.where(contained, np.maximum(inside, distance), inside)
    return np.where(np.isfinite(inside), inside, outside)
