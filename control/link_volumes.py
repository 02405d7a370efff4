"""The shapes of a robot's links as points, and their poses at a posture: for masks in images."""

from __future__ import annotations

from itertools import product

import numpy as np
from numpy.typing import ArrayLike, NDArray

from eyehand.errors import InputError

from .array_checks import read_only
from .mujoco_binding import Model, mujoco
from .robot_model import RobotModel
from .robot_source import Source, read_robot

CIRCLE_POINTS = 16
"""Points around each end of a cylinder. They lie outside it, so that their hull contains it."""
BALL_POINTS, BALL_GROWTH = 200, 1.02
"""Points around a ball and their distance from its centre, radii. Their hull contains the ball."""

_GEOM = mujoco.mjtGeom
_ROUND = (_GEOM.mjGEOM_SPHERE, _GEOM.mjGEOM_ELLIPSOID, _GEOM.mjGEOM_CAPSULE, _GEOM.mjGEOM_CYLINDER)


class LinkVolumes:
    """The geoms of a robot as points in their own frames.

    All geoms of the robot's bodies count, those for display too, because cameras see them. Geoms of
    the world body and of bodies without a joint of the robot, such as a table, do not count.
    """

    joint_names: tuple[str, ...]
    """Names of the hinge and slide joints, in the order of `q`."""
    points: tuple[NDArray[np.float64], ...]
    """Points (V, 3) of each geom in its own frame, m. Their convex hull contains the geom."""

    def __init__(self, source: Source | RobotModel) -> None:
        """Load a robot from an MJCF or URDF file, or from an ``MjSpec``.

        A `RobotModel` has the joints that it controls. Those of its gripper stay at home.

        Raises
        ------
        InputError
            If the file cannot be read, or holds no body or joint.
        """
        robot = source if isinstance(source, RobotModel) else _load_with_all_joints(source)
        self._robot = robot
        self.joint_names = robot.joint_names
        model = robot.model
        roots = {int(model.body_rootid[model.jnt_bodyid[joint]]) for joint in robot.joints}
        shapes = (int(_GEOM.mjGEOM_BOX), int(_GEOM.mjGEOM_MESH), *map(int, _ROUND))
        self._geoms = [
            geom
            for geom in range(model.ngeom)
            if int(model.body_rootid[model.geom_bodyid[geom]]) in roots
            and int(model.geom_type[geom]) in shapes
        ]
        self.points = tuple(read_only(_geom_points(model, geom)) for geom in self._geoms)

    def poses(self, q: ArrayLike) -> NDArray[np.float64]:
        """Return the poses (N, 4, 4) of the geoms in the robot's base frame.

        Parameters
        ----------
        q
            Joint positions, rad (m for a slide joint), of the first joints in `joint_names`. The
            others stay at home.

        Raises
        ------
        InputError
            If there are more numbers than joints, or a number is not finite.
        """
        robot = self._robot
        given = np.atleast_1d(np.asarray(q, np.float64))
        if given.ndim != 1 or not 1 <= len(given) <= robot.n:
            raise InputError(
                f"q must be 1 to {robot.n} numbers for {', '.join(self.joint_names)}, "
                f"got {len(given)}"
            )
        posture = robot.home.copy()
        posture[: len(given)] = given
        robot.at(posture)
        poses = np.tile(np.eye(4), (len(self._geoms), 1, 1))
        data = robot.data
        poses[:, :3, :3] = data.geom_xmat[self._geoms].reshape(-1, 3, 3)
        poses[:, :3, 3] = data.geom_xpos[self._geoms]
        return poses


def _load_with_all_joints(source: Source) -> RobotModel:
    """Load a robot with the joints of grippers too: the camera sees the fingers where they are."""
    spec = read_robot(source)
    if len(spec.bodies) < 2:
        raise InputError(f"robot: {source} holds no body")
    # Any body can be the controlled frame, which is not used here.
    named = next((body.name for body in spec.bodies[1:] if body.name), "")
    moving = (mujoco.mjtJoint.mjJNT_HINGE, mujoco.mjtJoint.mjJNT_SLIDE)
    joints = [joint.name for joint in spec.joints if joint.type in moving]
    return RobotModel.load(spec, named, joints=joints if all(joints) else None)


def _geom_points(model: Model, geom: int) -> NDArray[np.float64]:
    """Return points (V, 3) in a geom's frame whose convex hull contains it."""
    kind = model.geom_type[geom]
    size = model.geom_size[geom].astype(np.float64)
    if kind == _GEOM.mjGEOM_MESH:
        mesh = int(model.geom_dataid[geom])
        first = int(model.mesh_vertadr[mesh])
        vertices = model.mesh_vert[first : first + int(model.mesh_vertnum[mesh])]
        return vertices.astype(np.float64)
    if kind == _GEOM.mjGEOM_BOX:
        return np.array(list(product((-1.0, 1.0), repeat=3))) * size
    if kind == _GEOM.mjGEOM_CYLINDER:
        turns = 2 * np.pi * np.arange(CIRCLE_POINTS) / CIRCLE_POINTS
        radius = size[0] / np.cos(np.pi / CIRCLE_POINTS)
        ring = radius * np.column_stack([np.cos(turns), np.sin(turns)])
        return np.vstack(
            [np.column_stack([ring, np.full(len(ring), z)]) for z in (-size[1], size[1])]
        )
    ball = _ball()
    if kind == _GEOM.mjGEOM_CAPSULE:
        return np.vstack([ball * size[0] + [0.0, 0.0, z] for z in (-size[1], size[1])])
    return ball * (size if kind == _GEOM.mjGEOM_ELLIPSOID else size[0])


def _ball() -> NDArray[np.float64]:
    """Return points around the unit ball, on a spiral."""
    heights = 1.0 - (2.0 * np.arange(BALL_POINTS) + 1.0) / BALL_POINTS
    turns = np.pi * (1.0 + np.sqrt(5.0)) * np.arange(BALL_POINTS)
    around = np.sqrt(1.0 - heights**2)
    return BALL_GROWTH * np.column_stack([around * np.cos(turns), around * np.sin(turns), heights])
