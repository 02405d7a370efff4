"""How well fitted solids meet the true one: overlap, distance of the surfaces, extents."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import TYPE_CHECKING

import numpy as np
from scipy.stats import qmc

from eyehand.perception.io import sample_triangles

from ...open3d_import import import_open3d
from .true_solid import convex_parts, surface_mesh

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from .true_solid import TrueSolid

SAMPLES_LOG2 = 15
"""2^15 points for an overlap: with those of Sobol an IoU of 0.998 is right to 0.0003 (one σ)."""
SURFACE_SAMPLES = 4000
"""Points on either surface: the mean distance is right to 1 %, the largest is one of a sample."""

SEAM = 2e-4
"""Faces of two parts closer than this are a seam inside their union, m."""


@dataclass(frozen=True)
class FitScore:
    """How well a fit meets the truth."""

    iou: float
    """Intersection over union of the solids, in [0, 1]; 0 without a fit."""
    mean_distance: float
    """Mean distance between the surfaces, in both directions, m; infinite without a fit, like all
    errors below."""
    max_distance: float
    """Maximum distance between the surfaces, m."""
    extent_error: float
    """Maximum error of a half extent along the true solid's own axes, m."""
    extent_share: float
    """Maximum error of a half extent as a share of the true one."""


def score_fit(truth: TrueSolid, parts: Sequence[TrueSolid], seed: int = 0) -> FitScore:
    """Score the union of fitted parts against the true solid; no part at all is the worst fit."""
    if not parts:
        return FitScore(0.0, np.inf, np.inf, np.inf, np.inf)
    mean, largest = surface_distances(truth, parts, seed)
    error, share = extent_errors(truth, parts)
    return FitScore(overlap(truth, parts, seed), mean, largest, error, share)


def overlap(truth: TrueSolid, parts: Sequence[TrueSolid], seed: int = 0) -> float:
    """Intersection over union of a solid and the union of others, in [0, 1].

    By points spread evenly (scrambled Sobol) over what bounds all of them along the true axes:
    several times as exact as as many random ones.
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
    """Mean and largest distance between a solid's surface and that of a union, m.

    Of points spread evenly over either surface to the nearest point of the other; the mean is
    that of both ways. From inside a union of several parts the distance is that to the surface
    of the part it lies deepest in, which is no more than the true one.
    """
    rng = np.random.default_rng(seed)
    true_parts = convex_parts(truth)
    there = _distances(_surface_points(true_parts, rng), parts)
    back = _distances(_surface_points(parts, rng), true_parts)
    return float((there.mean() + back.mean()) / 2), float(max(there.max(), back.max()))


def extent_errors(truth: TrueSolid, parts: Sequence[TrueSolid]) -> tuple[float, float]:
    """Maximum error of a half extent along the true solid's own axes, in m and as a share.

    Taken from the support functions: a superquadric and its dual, turned by 45°, are nearly the
    same solid with very different semi-axes.
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
    """Minimum and maximum coordinate of all solids along axes (rows), (3,) each, m."""
    low = np.min([-solid.support(-axes) for solid in solids], axis=0)
    return low, np.max([solid.support(axes) for solid in solids], axis=0)


@lru_cache(maxsize=4)
def _unit_points(seed: int) -> NDArray[np.float64]:
    points = qmc.Sobol(3, rng=np.random.default_rng(seed)).random_base2(SAMPLES_LOG2)
    points.setflags(write=False)
    return points


def _surface_points(solids: Sequence[TrueSolid], rng: np.random.Generator) -> NDArray[np.float64]:
    """Points (about SURFACE_SAMPLES, 3) spread evenly over the surface of a union."""
    meshes = [surface_mesh(solid) for solid in solids]
    areas = np.array([_area(*one) for one in meshes])
    counts = np.ceil(SURFACE_SAMPLES * areas / areas.sum()).astype(int)
    kept = []
    for index, (one, count) in enumerate(zip(meshes, counts, strict=True)):
        points = sample_triangles(*one, int(count), rng)
        others = [solid for other, solid in enumerate(solids) if other != index]
        buried = np.any([_nearly_inside(solid, points) for solid in others], axis=0)
        kept.append(points[~buried] if others else points)
    return np.vstack(kept)


def _nearly_inside(solid: TrueSolid, points: NDArray[np.float64]) -> NDArray[np.bool_]:
    inward = solid.centre - points
    distance = np.linalg.norm(inward, axis=1, keepdims=True)
    return solid.contains(points + inward * (SEAM / np.maximum(distance, SEAM)))


def _area(vertices: NDArray[np.float64], faces: NDArray[np.int64]) -> float:
    first, second, third = np.moveaxis(vertices[faces], 1, 0)
    return float(np.linalg.norm(np.cross(second - first, third - first), axis=1).sum() / 2)


def _distances(points: NDArray[np.float64], solids: Sequence[TrueSolid]) -> NDArray[np.float64]:
    """Distance of points (N, 3) to the surface of a union of solids, (N,), m."""
    open3d = import_open3d()
    origin = points.mean(axis=0)
    query = open3d.core.Tensor((points - origin).astype(np.float32))
    outside, inside = np.full(len(points), np.inf), np.full(len(points), -np.inf)
    for solid in solids:
        vertices, faces = surface_mesh(solid)
        scene = open3d.t.geometry.RaycastingScene(nthreads=1)
        # Single precision is enough near the origin.
        scene.add_triangles(
            open3d.core.Tensor((vertices - origin).astype(np.float32)),
            open3d.core.Tensor(faces.astype(np.uint32)),
        )
        distance = scene.compute_distance(query, nthreads=1).numpy().astype(np.float64)
        within = solid.contains(points)
        outside = np.where(within, outside, np.minimum(outside, distance))
        inside = np.where(within, np.maximum(inside, distance), inside)
    return np.where(np.isfinite(inside), inside, outside)
