"""The views of a fit stress test: cloud, camera, support plane and truth."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import KDTree
from scipy.spatial.transform import RigidTransform

from eyehand.perception import FreeSpace, Superquadric, perpendicular_pair

from .clouds import DEFAULT_NOISE, POINTS, fit_case, visible_points
from .true_solid import TrueSolid

GRID_SIDE = 35
"""Rays along a side of the grid of a free space."""


@dataclass(frozen=True)
class CloudView:
    """One view of an object: its cloud, camera and support plane."""

    points: NDArray[np.float64]
    """(N, 3), m."""
    truth: TrueSolid | None = None
    """The true solid; None if the points belong to no solid."""
    view_origin: NDArray[np.float64] | None = None
    """(3,) camera position, m."""
    support_plane: NDArray[np.float64] | None = None
    """(4,) unit normal and offset."""
    free_space: FreeSpace | None = None
    """Empty space around the object; None for a cloud without an image."""
    margin: float = 0.0
    """Distance of the object's outline beyond that of the points, m."""
    unit: float = 1.0
    """Unit of the numbers above, m. Options are scaled by it."""


def one_view(
    solid: Superquadric,
    origin: NDArray[np.float64],
    rng: np.random.Generator,
    count: int = POINTS,
    noise: float = DEFAULT_NOISE,
) -> CloudView:
    """Return the view from `origin` (3,): `count` points, uniform on the visible surface."""
    points = visible_points(solid, origin, count, rng)
    return CloudView(points + noise * rng.normal(size=points.shape), solid, origin)


def free_space_around(points: NDArray[np.float64], origin: NDArray[np.float64]) -> FreeSpace:
    """Return the free space of a camera at `origin` (3,) that sees points (N, 3) before nothing."""
    offsets = points - origin
    depths = np.linalg.norm(offsets, axis=1)
    directions = offsets / depths[:, None]
    forward = directions.mean(axis=0) / np.linalg.norm(directions.mean(axis=0))
    pair = perpendicular_pair(forward)
    reach = 2.0 * np.abs(directions @ pair.T).max()
    steps = np.linspace(-reach, reach, GRID_SIDE)
    across = np.stack(np.meshgrid(steps, steps), axis=-1).reshape(-1, 2)
    rays = across @ pair + forward
    rays /= np.linalg.norm(rays, axis=1, keepdims=True)
    pitch = 2.0 * reach / (GRID_SIDE - 1)
    gaps, nearest = KDTree(directions).query(rays)
    on_object = np.asarray(gaps) < pitch
    depth = np.where(on_object, depths[nearest], np.inf)
    return FreeSpace(origin, rays, depth, on_object, pitch)


def usual_solid(seed: int) -> tuple[Superquadric, NDArray[np.float64]]:
    """Return a random solid of the usual sizes and exponents, and a camera (3,) at 0.7 m."""
    case = fit_case("view-1mm", seed, points=1)
    assert isinstance(case.truth, Superquadric)
    assert case.view_origin is not None
    return case.truth, case.view_origin


def moved(view: CloudView, T: RigidTransform) -> CloudView:
    """Return the view in another frame, without truth and free space."""
    origin, plane = view.view_origin, view.support_plane
    if plane is not None:
        normal = T.rotation.apply(plane[:3])
        plane = np.append(normal, plane[3] - normal @ T.translation)
    return replace(
        view,
        points=T.apply(view.points),
        truth=None,
        view_origin=None if origin is None else T.apply(origin),
        support_plane=plane,
        free_space=None,
    )


def scaled(view: CloudView, times: float) -> CloudView:
    """Return the view with all its numbers multiplied, without truth and free space."""
    origin, plane = view.view_origin, view.support_plane
    return replace(
        view,
        points=times * view.points,
        truth=None,
        free_space=None,
        view_origin=None if origin is None else times * origin,
        support_plane=None if plane is None else plane * [1.0, 1.0, 1.0, times],
    )
