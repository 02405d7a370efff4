"""One form per shape: equal solids compare equal whatever axes the optimiser ended on."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from scipy.spatial.transform import RigidTransform, Rotation

from ..perpendicular import cross
from .shape import Kind, Superquadric

if TYPE_CHECKING:
    from numpy.typing import NDArray


def canonical(solid: Superquadric) -> Superquadric:
    """Rewrite a superquadric in canonical form without changing its surface.

    - a sphere has no rotation;
    - equal exponents without taper let any axis be z: the semi-axes then fall, a1 >= a2 >= a3;
    - otherwise the special axis is z and a1 >= a2;
    - of the rotations that leave the shape as it is, z points up (largest component positive)
      and so does x as far as it can; a cylinder takes the shortest turn of z.
    """
    axes, R, taper = canonical_axes(
        solid.semi_axes, solid.exponents, solid.rotation, solid.kind, solid.taper
    )
    pose = RigidTransform.from_components(solid.centre, Rotation.from_matrix(R))
    return Superquadric(axes, solid.exponents, pose, solid.kind, taper)


def canonical_axes(
    axes: NDArray[np.float64],
    exponents: tuple[float, float],
    R: NDArray[np.float64],
    kind: Kind,
    taper: tuple[float, float] = (0.0, 0.0),
) -> tuple[NDArray[np.float64], NDArray[np.float64], tuple[float, float]]:
    """Semi-axes (3,), rotation (3, 3) and taper of the canonical form; see :func:`canonical`."""
    if kind == "sphere":
        return axes, np.eye(3), taper
    if kind == "cylinder":
        return axes, _shortest_turn(_upwards(R[:, 2])), taper
    round_all = exponents[0] == exponents[1] and not any(taper)
    order = np.argsort(-axes, kind="stable") if round_all else np.array(_swap(axes))
    if not round_all and order[0] == 1:
        taper = (taper[1], taper[0])
    axes, R = axes[order], R[:, order]
    z = _upwards(R[:, 2])
    x = _upwards(R[:, 0])
    if z @ R[:, 2] < 0:
        taper = (-taper[0], -taper[1])
    return axes, np.column_stack([x, cross(z, x), z]), taper


def _swap(axes: NDArray[np.float64]) -> list[int]:
    return [0, 1, 2] if axes[0] >= axes[1] else [1, 0, 2]


def _upwards(axis: NDArray[np.float64]) -> NDArray[np.float64]:
    """Flip an axis so that z is positive, or y, or x, where those before vanish."""
    for k in (2, 1, 0):
        if abs(axis[k]) > 1e-9:
            return axis if axis[k] > 0 else -axis
    return axis


def _shortest_turn(axis: NDArray[np.float64]) -> NDArray[np.float64]:
    """Rotation matrix with the given z-axis and the smallest angle from the identity."""
    turn = cross(np.array([0.0, 0.0, 1.0]), axis)
    sine = float(np.linalg.norm(turn))
    if sine < 1e-12:
        return np.eye(3)
    return Rotation.from_rotvec(turn / sine * np.arctan2(sine, axis[2])).as_matrix()
