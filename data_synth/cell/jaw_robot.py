"""Join an arm and a gripper with two jaws to a robot of a grasping cell."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from .arm_check import check_arm, check_rest_posture
from .grasp_robot import GraspRobot
from .jaw_assembly import TOOL_FRAME

if TYPE_CHECKING:
    from scipy.spatial.transform import RigidTransform

    from eyehand.grasping import ParallelHand


def jaw_robot(
    arm: Path,
    hand: Path | None,
    jaws: ParallelHand,
    *,
    flange: str = "attachment_site",
    rest: tuple[float, ...] | None = None,
    mount: RigidTransform | None = None,
) -> GraspRobot:
    """Join an arm and a gripper with two jaws.

    Parameters
    ----------
    arm
        MJCF file of the arm, or of the whole robot.
    hand
        MJCF file of the gripper; None if the arm's file contains it.
    jaws
        Description of the gripper.
    flange
        Site of the arm that carries the gripper.
    rest
        Arm joint angles at rest, rad; None means the keyframe ``home``.
    mount
        Pose of the gripper's file in the flange; None for the flange itself.

    Raises
    ------
    InputError
        If a file cannot be read, has no gripper or no flange, or its arm cannot move it.
    """
    made = GraspRobot(Path(arm), hand, TOOL_FRAME, flange, rest, jaws=jaws, mount=mount)
    model = made.compiled()
    check_arm(made.arm, model, made.joints, made.hand_joints, (), TOOL_FRAME)
    check_rest_posture(made.arm, model, made.joints, made.home)
    return made
