"""Whether a robot's file has an arm that can move its hand, told before anything is built of it."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from eyehand.errors import InputError

from ..arms import HOME_KEY
from ..mujoco_import import import_mujoco
from .arm_servos import servo_of

if TYPE_CHECKING:
    from .grasp_robot import GraspRobot


def check_arm(robot: GraspRobot, model: Any) -> None:
    """Refuse a robot that cannot move its hand.

    Parameters
    ----------
    robot
        Whose joints and rest posture are looked at.
    model
        Its `MjModel`.

    Raises
    ------
    InputError
        If the file is a URDF, its base floats, no joint moves the hand's frame, one of those is no
        hinge or a finger's as well, a joint has no name or no position servo, or the rest posture
        is not finite or beyond the joints' limits.
    """
    path, frame = Path(robot.arm), robot.frame
    if path.suffix.lower() == ".urdf":
        raise InputError(
            f"{path}: a URDF has no servos; write it as MJCF "
            f"(mujoco.MjSpec.from_file({path.name!r}).to_xml()) and give each of its joints a "
            "<position> actuator"
        )
    if not robot.joints:
        raise InputError(
            f"{path} has no arm: no joint lies between its base and the hand's frame {frame!r}; "
            "give one file of arm and hand (CONTRIBUTING.md, Add a simulated robot, joins two)"
        )
    kinds = import_mujoco().mjtJoint
    if (model.jnt_type == int(kinds.mjJNT_FREE)).any():
        raise InputError(f"{path} has a free joint: a robot's base is to stand still, take it out")
    if not all((*robot.joints, *robot.hand_joints)):
        raise InputError(f"{path} has joints without a name: name all of them")
    for name in robot.joints:
        if int(model.joint(name).type[0]) != int(kinds.mjJNT_HINGE):
            raise InputError(
                f"joint {name} of {path} is no hinge: all joints between the base and the hand's "
                f"frame {frame!r} must be"
            )
    told = [] if robot.fingers is None else [j for f in robot.fingers.fingers for j in f.joints]
    shared = [name for name in told if name in robot.joints]
    if shared:
        raise InputError(
            f"joint {shared[0]} is told as a finger's, but lies between the base of {path} and the "
            f"hand's frame {frame!r}: it is the arm's"
        )
    for name, place in zip(robot.joints, robot.home, strict=True):
        number = int(model.joint(name).id)
        servo_of(model, number, name)
        low, high = model.jnt_range[number] if model.jnt_limited[number] else (-np.inf, np.inf)
        if not (np.isfinite(place) and low <= place <= high):
            raise InputError(
                f"{path}: joint {name} rests at {place:g} rad, must lie in [{low:.4g}, {high:.4g}];"
                f" the keyframe {HOME_KEY!r} sets the rest posture"
            )
