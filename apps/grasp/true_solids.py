"""The true solids of a simulated cell: what its objects are, where they are now."""

from __future__ import annotations

import functools
from typing import TYPE_CHECKING

import numpy as np

from eyehand.data_synth.mesh_object import MeshObject
from eyehand.data_synth.tabletop_scene import TabletopObject
from eyehand.errors import InputError
from eyehand.perception import fit_superquadric

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from eyehand.data_synth.robot import SimRobot

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
        pose = robot.object_pose(item.name)
        if isinstance(item, MeshObject):
            solid = _solid_of(item)
            found.append(solid.at(pose * solid.shape.pose))
        else:
            found.append(item.at(pose))
    return found


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
