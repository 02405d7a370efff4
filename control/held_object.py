"""An object that the robot holds: it counts as a part of the robot until it is detached."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import RigidTransform, Rotation

from .collision_pairs import CollisionGeoms, are_connected
from .mujoco_binding import Model
from .robot_model import RobotModel
from .shapes import Shape, check_body


@dataclass(frozen=True, eq=False)
class HeldObject:
    """An object that moves with the controlled frame.

    Raises
    ------
    InputError
        If the name is empty, the shape is of an unknown type, or the pose is not finite.
    """

    name: str
    """Name for :meth:`CollisionWorld.detach`."""
    shape: Shape
    """Shape of the object, in its own frame."""
    pose: RigidTransform
    """Pose of the object in the controlled frame (T_frame_object)."""

    def __post_init__(self) -> None:
        check_body("held object", self.name, self.shape, self.pose)


def held_row(
    robot: RobotModel, model: Model, geom: int, pose: RigidTransform
) -> NDArray[np.float64]:
    """Return a row of :attr:`ProximityTables.held`: the pose of a geom in the body that holds it.

    ``pose`` is T_frame_object.
    """
    T_body_frame = _transform(*robot.frame_in_body)
    # MuJoCo moves the frame of a mesh to its centre and principal axes.
    T_object_geom = _transform(model.geom_pos[geom], model.geom_quat[geom])
    T_body_geom = T_body_frame * pose * T_object_geom
    axes = T_body_geom.rotation.as_matrix().ravel()
    return np.concatenate([[geom, robot.frame_body], T_body_geom.translation, axes])


def touchable_geoms(robot: RobotModel, geoms: CollisionGeoms) -> set[int]:
    """Return the geoms that may touch a held object.

    They are on the body of the controlled frame, on its parent, and on all bodies that hang on it.
    """
    model, frame = robot.model, robot.frame_body
    hanging = {frame}
    for body in range(1, model.nbody):
        if int(model.body_parentid[body]) in hanging:
            hanging.add(body)
    return {
        geom
        for geom in (*geoms.robot, *geoms.fixed)
        if (body := int(model.geom_bodyid[geom])) in hanging or are_connected(model, body, frame)
    }


def held_pairs(
    robot: RobotModel, geoms: CollisionGeoms, held: list[int], moves: NDArray[np.bool_]
) -> list[tuple[int, int]]:
    """Return the pairs of held geoms and parts of the robot's file.

    ``moves`` (geoms, n) is whether a joint moves a geom.
    """
    touchable = touchable_geoms(robot, geoms) if held else set()
    return [
        (a, b)
        for a in held
        for b in (*geoms.robot, *geoms.fixed)
        if b not in touchable and not np.array_equal(moves[a], moves[b])
    ]


def _transform(position: NDArray[np.float64], quat_wxyz: NDArray[np.float64]) -> RigidTransform:
    rotation = Rotation.from_quat(quat_wxyz, scalar_first=True)
    return RigidTransform.from_components(np.array(position), rotation)
