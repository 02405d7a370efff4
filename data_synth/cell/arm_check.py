"""Check that the arm of a robot file can move its hand, before a world is built with it."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from eyehand.errors import InputError

from ..arms import HOME_KEY
from ..mujoco_import import import_mujoco
from .arm_servos import servo_of


def check_file_format(path: Path) -> None:
    """Raise an `InputError` for a URDF, which cannot describe servos."""
    if path.suffix.lower() == ".urdf":
        raise InputError(
            f"{path}: a URDF has no servos; write it as MJCF "
            f"(mujoco.MjSpec.from_file({path.name!r}).to_xml()) and give each of its joints a "
            "<position> actuator"
        )


def check_arm(
    path: Path,
    model: Any,
    joints: Sequence[str],
    hand_joints: Sequence[str],
    finger_joints: Sequence[str],
    frame: str,
) -> None:
    """Refuse a robot whose arm cannot move its hand.

    Parameters
    ----------
    path
        MJCF file of the robot, for messages.
    model
        Its `MjModel`.
    joints
        Names of the arm's joints, from base to tip.
    hand_joints
        Names of the hand's joints.
    finger_joints
        Joints that the hand's description names; empty for a tendon hand.
    frame
        Site or body that is the hand's frame, for messages.

    Raises
    ------
    InputError
        If the base floats, no joint moves the hand's frame, or an arm joint is not a hinge, belongs
        to a finger, or has no name.
    """
    if not joints:
        raise InputError(
            f"{path} has no arm: no joint lies between its base and the hand's frame {frame!r}; "
            "give one file of arm and hand (CONTRIBUTING.md, Add a simulated robot, joins two)"
        )
    kinds = import_mujoco().mjtJoint
    if (model.jnt_type == int(kinds.mjJNT_FREE)).any():
        raise InputError(f"{path} has a free joint: the base of a robot must be fixed; remove it")
    if not all((*joints, *hand_joints)):
        raise InputError(f"{path} has joints without a name: name all of them")
    for name in joints:
        if int(model.joint(name).type[0]) != int(kinds.mjJNT_HINGE):
            raise InputError(
                f"joint {name} of {path} is not a hinge: all joints between the base and the "
                f"hand's frame {frame!r} must be hinges"
            )
    shared = [name for name in finger_joints if name in joints]
    if shared:
        raise InputError(
            f"joint {shared[0]} is described as a finger's, but lies between the base of {path} "
            f"and the hand's frame {frame!r}: it is the arm's"
        )


def check_rest_posture(
    path: Path, model: Any, joints: Sequence[str], home: NDArray[np.float64]
) -> None:
    """Refuse an arm without position servos or with a rest posture outside its limits.

    Parameters
    ----------
    path
        MJCF file of the robot, for messages.
    model
        Its `MjModel`.
    joints
        Names of the arm's joints, from base to tip.
    home
        Arm joint angles at rest, (n,), rad.

    Raises
    ------
    InputError
        If a joint has no position servo, or its rest angle is not finite or outside its limits.
    """
    for name, angle in zip(joints, home, strict=True):
        number = int(model.joint(name).id)
        servo_of(model, number, name)
        low, high = model.jnt_range[number] if model.jnt_limited[number] else (-np.inf, np.inf)
        if not (np.isfinite(angle) and low <= angle <= high):
            raise InputError(
                f"{path}: joint {name} rests at {angle:g} rad, must lie in [{low:.4g}, {high:.4g}];"
                f" the keyframe {HOME_KEY!r} sets the rest posture"
            )
