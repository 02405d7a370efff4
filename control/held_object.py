"""An object that the robot holds: a part of it while it does."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from scipy.spatial.transform import RigidTransform, Rotation

from .collision_pairs import related
from .shapes import check_name, check_pose, check_shape

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from .collision_pairs import Parts
    from .mujoco_binding import Model
    from .robot_model import RobotModel
    from .shapes import Shape


@dataclass(frozen=True, eq=False)
class HeldObject:
    """An object that moves with the controlled frame.

    Raises
    ------
    InputError
        If the name is empty, the shape is none of the known ones, or the pose is not finite.
    """

    name: str
    """Name that :meth:`CollisionWorld.detach` takes."""
    shape: Shape
    """Its shape, in its own frame."""
    pose: RigidTransform
    """Its frame in the controlled frame (T_frame_object)."""

    def __post_init__(self) -> None:
        check_name(self.name, "held object")
        check_shape(self.shape, self.name)
        check_pose(self.pose, self.name)


def held_row(
    robot: RobotModel, model: Model, geom: int, pose: RigidTransform
) -> NDArray[np.float64]:
    """Return a row of :attr:`ProximityTables.held`: the pose of the geom in its holding body."""
    T_body_frame = _pose(*robot.frame_in_body)
    # MuJoCo turns a mesh into its principal axes: where its geom is in the object's frame.
    T_object_geom = _pose(model.geom_pos[geom], model.geom_quat[geom])
    T_body_geom = T_body_frame * pose * T_object_geom
    axes = T_body_geom.rotation.as_matrix().ravel()
    return np.concatenate([[geom, robot.frame_body], T_body_geom.translation, axes])


def beside_frame(robot: RobotModel, parts: Parts) -> set[int]:
    """Return the geoms that may touch a held object: on the frame's body, parent and children."""
    model, frame = robot.model, robot.frame_body
    hanging = {frame}
    for body in range(1, model.nbody):
        if int(model.body_parentid[body]) in hanging:
            hanging.add(body)
    beside = set()
    for geom in (*parts.robot, *parts.fixed):
        body = int(model.geom_bodyid[geom])
        if body in hanging or related(model, body, frame):
            beside.add(geom)
    return beside


def _pose(place: NDArray[np.float64], quat_wxyz: NDArray[np.float64]) -> RigidTransform:
    rotation = Rotation.from_quat(quat_wxyz, scalar_first=True)
    return RigidTransform.from_components(np.array(place), rotation)
