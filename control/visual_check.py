"""Whether the collision shapes of a robot contain its visual meshes."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from .mujoco_binding import Data, Model, mujoco
from .robot_model import RobotModel

MAX_POINTS = 400
"""Maximum number of points of a visual mesh that are checked, evenly chosen from its vertices."""
POINT_RADIUS = 1e-4
"""Radius of the sphere that stands for a point, m."""
FAR = 1.0
"""Gap that is reported for a link without collision shapes, m."""


class VisualGap(NamedTuple):
    """How far the visual meshes of a link stand out of its collision shapes."""

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
    before and after count too, at home, because they cover the housing of the joint between.
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
    for body in range(1, model.nbody):
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
    """Return some vertices (N, 3) of a mesh geom in the world."""
    mesh = int(model.geom_dataid[geom])
    start, count = int(model.mesh_vertadr[mesh]), int(model.mesh_vertnum[mesh])
    chosen = np.unique(np.linspace(0, count - 1, min(count, MAX_POINTS)).astype(int))
    points = model.mesh_vert[start + chosen].astype(np.float64)
    axes = data.geom_xmat[geom].reshape(3, 3)
    return points @ axes.T + data.geom_xpos[geom]
