"""Whether the collision shapes of a robot contain its visual meshes."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from .mujoco_binding import Data, Model, mujoco
from .robot_model import RobotModel

POINT_RADIUS = 1e-4
"""Radius of the sphere that stands for a point, m."""
FAR = 1.0
"""Gap that is reported for a link without collision shapes, m."""


class VisualGap(NamedTuple):
    """The distance by which the visual meshes of a link stand out of its collision shapes."""

    link: str
    """Name of the body."""
    gap: float
    """Largest distance of a vertex from the collision shapes, m; at most FAR."""
    point: NDArray[np.float64]
    """This vertex (3,), m, in the frame of the body."""


def visual_gaps(robot: RobotModel) -> tuple[VisualGap, ...]:
    """Return the gap of each link whose visual meshes stand out, the largest first.

    Distances count from the collision shapes. So an obstacle can come nearer to such a link than
    the margin, by the gap. A mesh counts as visual if it does not collide. The shapes of the links
    before and after count too, at home, because they cover the housing of the joint between. Links
    that no controlled joint moves are left out: nothing keeps them away from obstacles.
    """
    if not (np.any(robot.model.geom_contype) or np.any(robot.model.geom_conaffinity)):
        # Then the visual meshes are the collision shapes.
        return ()
    spec = robot.spec.copy()
    probe = spec.worldbody.add_body(name="eyehand_probe", mocap=True)
    probe.add_geom(
        name="eyehand_probe", type=mujoco.mjtGeom.mjGEOM_SPHERE, size=[POINT_RADIUS, 0.0, 0.0]
    )
    model = spec.compile()
    data = mujoco.MjData(model)
    data.qpos[:] = robot.home_qpos
    mujoco.mj_kinematics(model, data)
    collides = (model.geom_contype | model.geom_conaffinity) != 0
    sphere = model.geom("eyehand_probe").id
    gaps = []
    for body in np.flatnonzero(robot.moves.any(axis=1)).tolist():
        near = [model.body_parentid[body], body, *np.flatnonzero(model.body_parentid == body)]
        shapes = np.flatnonzero(collides & np.isin(model.geom_bodyid, near))
        shapes = shapes[shapes != sphere]
        meshes = np.flatnonzero(~collides & (model.geom_bodyid == body))
        meshes = meshes[model.geom_type[meshes] == mujoco.mjtGeom.mjGEOM_MESH]
        worst, at = 0.0, np.zeros(3)
        for geom in meshes:
            for point in _vertices(model, data, int(geom)):
                data.geom_xpos[sphere] = point
                gap = FAR
                for shape in shapes:
                    gap = min(
                        gap, mujoco.mj_geomDistance(model, data, sphere, int(shape), gap, None)
                    )
                if gap > worst:
                    worst, at = gap, point
        if worst > 0.0:
            inside = data.xmat[body].reshape(3, 3).T @ (at - data.xpos[body])
            gaps.append(VisualGap(model.body(body).name, worst + POINT_RADIUS, inside))
    return tuple(sorted(gaps, key=lambda one: -one.gap))


def _vertices(model: Model, data: Data, geom: int) -> NDArray[np.float64]:
    """Return the vertices (N, 3) of a mesh geom in the world."""
    mesh = int(model.geom_dataid[geom])
    start, count = int(model.mesh_vertadr[mesh]), int(model.mesh_vertnum[mesh])
    points = model.mesh_vert[start : start + count].astype(np.float64)
    axes = data.geom_xmat[geom].reshape(3, 3)
    return points @ axes.T + data.geom_xpos[geom]
