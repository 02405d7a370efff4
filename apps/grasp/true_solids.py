"""The true solids of a simulated cell: what its objects are, where they are now."""

from __future__ import annotations

import functools
from typing import TYPE_CHECKING

import numpy as np

from eyehand.data_synth.scenes import MeshObject, TabletopObject
from eyehand.errors import InputError
from eyehand.perception import fit_superquadric

if TYPE_CHECKING:
    from numpy.typing import NDArray
    from scipy.spatial.transform import RigidTransform

    from eyehand.data_synth.cell import SimRobot

POINTS = 2000
"""Points over a mesh's surface that its solid is fitted to."""


def true_solids(robot: SimRobot) -> list[TabletopObject]:
    """Give the solids of all objects outside the tray, where they are now.

    A mesh is the solid that fits its whole surface best.

    Raises
    ------
    InputError
        If no solid fits a mesh at all.
    """
    found = []
    for item in robot.world.objects:
        if robot.in_tray(item.name):
            continue
        found.append(_placed(item, robot.object_pose(item.name)))
    return found


def distances(robot: SimRobot, point: NDArray[np.float64]) -> dict[str, float]:
    """Give the signed distance of a point to each object outside the tray, by name, m.

    It is that to the object's solid, negative inside; to the nearest corner of a mesh that no
    solid fits.

    Parameters
    ----------
    robot
        The simulated cell.
    point
        In the world, (3,), m.
    """
    found = {}
    for item in robot.world.objects:
        if robot.in_tray(item.name):
            continue
        pose = robot.object_pose(item.name)
        try:
            found[item.name] = float(_placed(item, pose).shape.distance(point))
        except InputError:
            if not isinstance(item, MeshObject):
                raise
            corners = pose.apply(item.vertices)
            found[item.name] = float(np.linalg.norm(corners - point, axis=1).min())
    return found


def _placed(item: TabletopObject | MeshObject, pose: RigidTransform) -> TabletopObject:
    """Give the solid of an object whose frame is at a pose."""
    if not isinstance(item, MeshObject):
        return item.at(pose)
    solid = _solid_of(item)
    return solid.at(pose * solid.shape.pose)


@functools.lru_cache(maxsize=64)
def _solid_of(item: MeshObject) -> TabletopObject:
    """Fit a mesh in its own frame."""
    fit = fit_superquadric(_surface(item))
    if fit.superquadric is None:
        raise InputError(f"object {item.name}: no solid fits its mesh: {fit.reason}")
    return TabletopObject(item.name, fit.superquadric, item.mass, item.colour)


def _surface(item: MeshObject) -> NDArray[np.float64]:
    """Draw points evenly over a mesh, (POINTS, 3), m."""
    rng = np.random.default_rng(0)
    corners = item.vertices[item.faces]
    first, second = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    area = np.linalg.norm(np.cross(first, second), axis=1)
    chosen = rng.choice(len(area), POINTS, p=area / area.sum())
    s, t = rng.random((2, POINTS, 1))
    fold = s + t > 1.0
    s, t = np.where(fold, 1.0 - s, s), np.where(fold, 1.0 - t, t)
    return corners[chosen, 0] + s * first[chosen] + t * second[chosen]
