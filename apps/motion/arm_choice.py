"""The arm of reaching scenes, by name or by file, with or without a hand, and its control model."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import lru_cache
from pathlib import Path

import numpy as np

from eyehand.control import RobotModel, visual_gaps
from eyehand.data_synth import ReachingArm
from eyehand.data_synth.cell import (
    ARMS,
    INCLUDED_ARM,
    GraspRobot,
    make_robot,
    named_file,
    write_rigid_hand,
)
from eyehand.errors import InputError

from ..console import say

FLANGE = "attachment_site"
"""Site that carries the tool in files of the MuJoCo Menagerie."""


def choose_arm(arm: str = "", frame: str = "") -> ReachingArm:
    """Return the arm of a name or a file.

    Parameters
    ----------
    arm
        A name of :data:`ARMS`, or an MJCF or URDF file; empty for the included arm.
    frame
        Site or body that reaches; empty for the flange of a named arm.

    Raises
    ------
    InputError
        If the name is unknown, the file cannot be read, or it has no such frame.
    """
    included = ReachingArm()
    if arm in ("", INCLUDED_ARM):
        chosen = included
    elif arm in ARMS:
        known = ARMS[arm]
        chosen = ReachingArm(
            named_file(arm), known.flange, speed=known.speed, acceleration=known.acceleration
        )
    else:
        chosen = ReachingArm(named_file(arm).resolve(), FLANGE)
    if frame:
        chosen = replace(chosen, frame=frame)
    if chosen == included:
        return included
    return replace(chosen, joints=reaching_robot(chosen).joint_names)


def robot_with_hand(arm: str, hand: str, mount: Sequence[float] | None) -> GraspRobot | None:
    """Return the robot of ``--arm``, ``--hand`` and ``--mount``; None without a hand.

    Raises
    ------
    InputError
        If arm and hand cannot be joined, or ``--mount`` has no ``--hand``.
    """
    if hand:
        return make_robot(arm or INCLUDED_ARM, hand, None if mount is None else tuple(mount))
    if mount is not None:
        raise InputError("--mount needs --hand")
    return None


def carry_hand(arm: str, robot: GraspRobot, file: Path, frame: str = "") -> ReachingArm:
    """Write an arm with its open hand, and return it as the arm of reaching scenes.

    Parameters
    ----------
    arm
        Name of the arm, for its published limits.
    robot
        Arm and hand. The hand is rigid.
    file
        MJCF file to write.
    frame
        Site or body that reaches; empty for the point between the fingertips, or the palm.

    Raises
    ------
    InputError
        If the robot cannot be compiled, or there is no such frame.
    """
    write_rigid_hand(robot, file)
    known = ARMS.get(arm)
    limits = (known.speed, known.acceleration) if known else ((), ())
    made = ReachingArm(file.resolve(), frame or robot.frame, robot.joints, *limits)
    reaching_robot(made)
    return made


@lru_cache(maxsize=2)
def reaching_robot(arm: ReachingArm) -> RobotModel:
    """Return the control model of an arm. Controllers of one process may share it."""

    def given(limits: tuple[float, ...]) -> np.ndarray | None:
        return np.array(limits) if limits else None

    robot = RobotModel.load(
        arm.file,
        arm.frame,
        joints=arm.joints or None,
        speed=given(arm.speed),
        acceleration=given(arm.acceleration),
    )
    if not np.all(np.isfinite([robot.lower, robot.upper])):
        raise InputError(
            f"{arm.file}: random postures need a range of every joint, but at least one of "
            f"{', '.join(robot.joint_names)} has none"
        )
    return robot


def report_visual_gap(robot: RobotModel) -> None:
    """Print the largest distance by which a link stands out of its collision shapes, if any."""
    for gap in visual_gaps(robot)[:1]:
        say(
            f"obstacles may come {1e3 * gap.gap:.1f} mm nearer than the margin: the visual mesh of "
            f"{gap.link} stands out of its collision shapes"
        )
