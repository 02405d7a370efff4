"""Canonical form: equal shapes have equal numbers, whatever axes the optimiser ended on."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import RigidTransform, Rotation

from ..perpendicular import cross
from .shape import Kind, Superquadric


def canonical(solid: Superquadric) -> Superquadric:
    """Return a superquadric in canonical form, with the same surface.

    - A sphere has no rotation.
    - With equal exponents and no taper any axis can be z. The order is a1 >= a2 >= a3.
    - Otherwise z is the axis of ε1, and a1 >= a2.
    - Of the rotations with the same shape, the one with z and then x pointing up is taken. A
      cylinder takes the smallest rotation of z.
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
    """Return semi-axes (3,), rotation (3, 3) and taper in canonical form; see :func:`canonical`."""
    if kind == "sphere":
        return axes, np.eye(3), taper
    if kind == "cylinder":
        return axes, _smallest_rotation(_pointing_up(R[:, 2])), taper
    round_all = exponents[0] == exponents[1] and not any(taper)
    order = np.argsort(-axes, kind="stable") if round_all else np.array(_swap(axes))
    if not round_all and order[0] == 1:
        taper = (taper[1], taper[0])
    axes, R = axes[order], R[:, order]
    z = _pointing_up(R[:, 2])
    x = _pointing_up(R[:, 0])
    if z @ R[:, 2] < 0:
        taper = (-taper[0], -taper[1])
    return axes, np.column_stack([x, cross(z, x), z]), taper


def _swap(axes: NDArray[np.float64]) -> list[int]:
    return [0, 1, 2] if axes[0] >= axes[1] else [1, 0, 2]


def _pointing_up(axis: NDArray[np.float64]) -> NDArray[np.float64]:
    """Flip an axis so that its z is positive; if z is 0 its y, and if y is 0 its x."""
    for k in (2, 1, 0):
        if abs(axis[k]) > 1e-9:
            return axis if axis[k] > 0 else -axis
    return axis


def _smallest_rotation(axis: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the rotation matrix with this z-axis and the smallest angle."""
    turn = cross(np.array([0.0, 0.0, 1.0]), axis)
    sine = float(np.linalg.norm(turn))
    if sine < 1e-12:
        return np.eye(3)
    return Rotation.from_rotvec(turn / sine * np.arctan2(sine, axis[2])).as_matrix()
