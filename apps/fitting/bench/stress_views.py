"""The views of a fit stress test: cloud, camera, support plane and truth."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from eyehand.perception import Superquadric

from .clouds import DEFAULT_NOISE, POINTS, fit_case, visible_points

if TYPE_CHECKING:
    from numpy.typing import NDArray
    from scipy.spatial.transform import RigidTransform

    from .true_solid import TrueSolid


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
    hidden: Callable[[NDArray[np.float64]], NDArray[np.bool_]] | None = None
    """Returns a mask (K,) of the view directions (K, 3) that a nearer object hides."""
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


def usual_solid(seed: int) -> tuple[Superquadric, NDArray[np.float64]]:
    """Return a random solid of the usual sizes and exponents, and a camera (3,) at 0.7 m."""
    case = fit_case("view-1mm", seed, points=1)
    assert isinstance(case.truth, Superquadric)
    assert case.view_origin is not None
    return case.truth, case.view_origin


def moved(view: CloudView, T: RigidTransform) -> CloudView:
    """Return the view in another frame, without truth and occlusion."""
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
        hidden=None,
    )


def scaled(view: CloudView, times: float) -> CloudView:
    """Return the view with all its numbers multiplied, without truth."""
    origin, plane = view.view_origin, view.support_plane
    return replace(
        view,
        points=times * view.points,
        truth=None,
        view_origin=None if origin is None else times * origin,
        support_plane=None if plane is None else plane * [1.0, 1.0, 1.0, times],
    )
