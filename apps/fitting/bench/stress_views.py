"""What a fit is put before: a cloud, where it was seen from, what it stands on, and the truth."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from eyehand.perception import Superquadric

from .clouds import POINTS, USUAL_NOISE, fit_case, seen_points

if TYPE_CHECKING:
    from numpy.typing import NDArray
    from scipy.spatial.transform import RigidTransform

    from .true_solid import TrueSolid


@dataclass(frozen=True)
class Look:
    """What is known of one object: its cloud, the camera, what it stands on."""

    points: NDArray[np.float64]
    """(N, 3), m."""
    truth: TrueSolid | None = None
    """What the points were taken from; None where they are of no solid."""
    view_origin: NDArray[np.float64] | None = None
    """(3,) place of the camera, m."""
    support_plane: NDArray[np.float64] | None = None
    """(4,) unit normal and offset."""
    hidden: Callable[[NDArray[np.float64]], NDArray[np.bool_]] | None = None
    """Returns a mask (K,) of the view directions (K, 3) that a nearer object hides."""
    unit: float = 1.0
    """Length in m by which the numbers above are to be read: options are scaled by it."""


def one_view(
    solid: Superquadric,
    origin: NDArray[np.float64],
    rng: np.random.Generator,
    count: int = POINTS,
    noise: float = USUAL_NOISE,
) -> Look:
    """What a camera at `origin` (3,) sees of a solid: `count` points evenly over what faces it."""
    points = seen_points(solid, origin, count, rng)
    return Look(points + noise * rng.normal(size=points.shape), solid, origin)


def usual_solid(seed: int) -> tuple[Superquadric, NDArray[np.float64]]:
    """A solid of the usual sizes and exponents, and a camera (3,) at 0.7 m, both anyhow turned."""
    case = fit_case("view-1mm", seed, points=1)
    assert isinstance(case.truth, Superquadric)
    assert case.view_origin is not None
    return case.truth, case.view_origin


def moved(look: Look, T: RigidTransform) -> Look:
    """The same look in another frame; its truth stays behind, and nothing may be hidden."""
    origin, plane = look.view_origin, look.support_plane
    if plane is not None:
        normal = T.rotation.apply(plane[:3])
        plane = np.append(normal, plane[3] - normal @ T.translation)
    return replace(
        look,
        points=T.apply(look.points),
        truth=None,
        view_origin=None if origin is None else T.apply(origin),
        support_plane=plane,
        hidden=None,
    )


def scaled(look: Look, times: float) -> Look:
    """The same look with all its numbers multiplied; its truth stays behind."""
    origin, plane = look.view_origin, look.support_plane
    return replace(
        look,
        points=times * look.points,
        truth=None,
        view_origin=None if origin is None else times * origin,
        support_plane=None if plane is None else plane * [1.0, 1.0, 1.0, times],
    )
