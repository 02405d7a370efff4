"""Extent of the geoms of a MuJoCo model along a direction."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..mujoco_import import import_mujoco


def extent(
    model: Any, data: Any, geoms: Iterable[int], axis: NDArray[np.float64]
) -> tuple[float, float]:
    """Return the smallest and largest coordinate of geoms along a unit vector of the world, m.

    The result is exact for primitives and for the convex hulls of meshes. Planes have no bounds and
    are ignored. Without geoms the interval is empty: (inf, -inf).
    """
    low, high = np.inf, -np.inf
    for geom in geoms:
        turn = data.geom_xmat[geom].reshape(3, 3)
        middle = float(axis @ data.geom_xpos[geom])
        below, above = _reach(model, geom, turn.T @ axis)
        low, high = min(low, middle + below), max(high, middle + above)
    return float(low), float(high)


def _reach(model: Any, geom: int, axis: NDArray[np.float64]) -> tuple[float, float]:
    """Return the bounds of a geom along an axis in its own frame, m."""
    kinds = import_mujoco().mjtGeom
    kind, size = int(model.geom_type[geom]), model.geom_size[geom]
    if kind == int(kinds.mjGEOM_PLANE):
        return np.inf, -np.inf
    if kind == int(kinds.mjGEOM_SPHERE):
        half = size[0]
    elif kind == int(kinds.mjGEOM_CAPSULE):
        half = size[0] + abs(axis[2]) * size[1]
    elif kind == int(kinds.mjGEOM_CYLINDER):
        half = size[0] * np.hypot(axis[0], axis[1]) + abs(axis[2]) * size[1]
    elif kind == int(kinds.mjGEOM_ELLIPSOID):
        half = float(np.linalg.norm(axis * size))
    elif kind == int(kinds.mjGEOM_BOX):
        half = float(np.abs(axis) @ size)
    elif kind == int(kinds.mjGEOM_MESH):
        mesh = model.geom_dataid[geom]
        first = model.mesh_vertadr[mesh]
        along = model.mesh_vert[first : first + model.mesh_vertnum[mesh]] @ axis
        return float(along.min()), float(along.max())
    else:
        half = float(model.geom_rbound[geom])
    return -float(half), float(half)
