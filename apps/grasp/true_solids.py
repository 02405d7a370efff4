"""The true solids of the objects in a simulated cell, at their current poses."""

from __future__ import annotations

import functools

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import RigidTransform

from eyehand.data_synth.cell import SimRobot
from eyehand.data_synth.scenes import MeshObject, TabletopObject
from eyehand.errors import InputError
from eyehand.perception import FitOptions, fit_superquadric

SURFACE_POINTS = 2000
"""Number of surface samples for the fit of a solid to a mesh."""


def true_solids(robot: SimRobot) -> list[TabletopObject]:
    """Return the solids of all objects outside the tray, at their current poses.

    A mesh is replaced by the solid fitted to its whole surface.

    Raises
    ------
    InputError
        If no solid fits a mesh.
    """
    return [_solid_at(item, robot.object_pose(item.name)) for item in _outside_tray(robot)]


def _distances(robot: SimRobot, point: NDArray[np.float64]) -> dict[str, float]:
    """Return the signed distance of a point to each object outside the tray, by name, m.

    The distance to a solid is negative inside it. For a mesh that no solid fits, it is the distance
    to the nearest vertex.

    Parameters
    ----------
    robot
        The simulated robot.
    point
        Point in the world frame, (3,), m.
    """
    found = {}
    for item in _outside_tray(robot):
        pose = robot.object_pose(item.name)
        try:
            found[item.name] = float(_solid_at(item, pose).shape.distance(point))
        except InputError:
            if not isinstance(item, MeshObject):
                raise
            corners = pose.apply(item.vertices)
            found[item.name] = float(np.linalg.norm(corners - point, axis=1).min())
    return found


def nearest_object(robot: SimRobot, point: NDArray[np.float64]) -> str:
    """Return the name of the object nearest to a point (3,) of the world; empty without objects.

    Distances are signed. The unsigned distance is wrong for a point deep inside an object: a
    neighbour's surface can be nearer.
    """
    apart = _distances(robot, point)
    return min(apart, key=apart.__getitem__) if apart else ""


def _outside_tray(robot: SimRobot) -> list[TabletopObject | MeshObject]:
    return [item for item in robot.world.objects if not robot.is_in_tray(item.name)]


def _solid_at(item: TabletopObject | MeshObject, pose: RigidTransform) -> TabletopObject:
    """Return the solid of an object whose frame is at a pose T_world_object."""
    if not isinstance(item, MeshObject):
        return item.at(pose)
    solid = _fit_mesh(item)
    return solid.at(pose * solid.shape.pose)


@functools.lru_cache(maxsize=64)
def _fit_mesh(item: MeshObject) -> TabletopObject:
    """Fit a solid to a mesh, in the frame of the mesh."""
    fit = fit_superquadric(_sample_mesh(item), options=FitOptions(max_parts=1))
    if fit.superquadric is None:
        raise InputError(f"object {item.name}: no solid fits its mesh: {fit.reason}")
    return TabletopObject(item.name, fit.superquadric, item.mass, item.colour)


def _sample_mesh(item: MeshObject) -> NDArray[np.float64]:
    """Sample points uniformly over the surface of a mesh, (SURFACE_POINTS, 3), m."""
    rng = np.random.default_rng(0)
    corners = item.vertices[item.faces]
    first, second = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    double_area = np.linalg.norm(np.cross(first, second), axis=1)
    chosen = rng.choice(len(double_area), SURFACE_POINTS, p=double_area / double_area.sum())
    s, t = rng.random((2, SURFACE_POINTS, 1))
    # Samples of the parallelogram beyond the triangle are reflected into it.
    fold = s + t > 1.0
    s, t = np.where(fold, 1.0 - s, s), np.where(fold, 1.0 - t, t)
    return corners[chosen, 0] + s * first[chosen] + t * second[chosen]
