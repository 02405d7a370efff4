"""Home posture and joint speed limits of a robot, from an argument, its file, or a default."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from eyehand.errors import InputError

from .mujoco_binding import mujoco
from .robot_source import SPEED_NUMERIC

if TYPE_CHECKING:
    from numpy.typing import ArrayLike, NDArray

    from .mujoco_binding import Model

DEFAULT_TURN_SPEED = 1.5
"""Speed limit of a turning joint that has none, rad/s: what light arms reach in every joint."""
DEFAULT_SLIDE_SPEED = 0.5
"""Speed limit of a sliding joint that has none, m/s: a brisk linear axis near people."""
HOME_KEYFRAME = "home"
"""Name of the keyframe that holds the home posture."""

_HINGE = int(mujoco.mjtJoint.mjJNT_HINGE)
_SLIDE = int(mujoco.mjtJoint.mjJNT_SLIDE)
SCALAR_JOINTS = (_HINGE, _SLIDE)
"""Kinds of joint with one position, which can be controlled."""


def home_posture(
    model: Model, joints: NDArray[np.int64], home: ArrayLike | None
) -> NDArray[np.float64]:
    """Return all joint positions (nq,) at home; ``home`` (n,) has priority over the file.

    Raises
    ------
    InputError
        If ``home`` is not n finite numbers, or the posture is outside the joint limits.
    """
    posture = model.qpos0.copy()
    for joint in range(model.njnt):
        if model.jnt_limited[joint] and int(model.jnt_type[joint]) in SCALAR_JOINTS:
            posture[model.jnt_qposadr[joint]] = model.jnt_range[joint].mean()
    for key in range(model.nkey):
        if model.key(key).name == HOME_KEYFRAME:
            posture = model.key_qpos[key].copy()
    if home is not None:
        posture[model.jnt_qposadr[joints]] = _numbers(home, len(joints), "home")
    for joint in joints:
        low, high = model.jnt_range[joint]
        value = posture[model.jnt_qposadr[joint]]
        if model.jnt_limited[joint] and not low <= value <= high:
            name = model.joint(int(joint)).name
            raise InputError(f"home of joint {name} must be in [{low:g}, {high:g}], got {value:g}")
    return posture


def joint_speed(
    model: Model,
    joints: NDArray[np.int64],
    speed: ArrayLike | None,
    urdf_speed: dict[str, float],
) -> NDArray[np.float64]:
    """Return the speed limits (n,) of the controlled joints, rad/s or m/s.

    Raises
    ------
    InputError
        If a limit is not a number above zero, or their number fits no set of joints.
    """
    n = len(joints)
    if speed is not None:
        limits = np.broadcast_to(_numbers(speed, n, "speed"), (n,)).copy()
    else:
        limits = _numeric_speed(model, joints)
    if limits is None:
        turns = model.jnt_type[joints] == _HINGE
        limits = np.where(turns, DEFAULT_TURN_SPEED, DEFAULT_SLIDE_SPEED)
        for column, joint in enumerate(joints):
            told = urdf_speed.get(model.joint(int(joint)).name, 0.0)
            # Many URDF files write 0 for a limit that nobody looked up.
            limits[column] = told if told != 0.0 else limits[column]
    if not np.all(limits > 0.0):
        raise InputError(f"joint speed limits must be > 0, got {limits.tolist()}")
    return limits


def _numeric_speed(model: Model, joints: NDArray[np.int64]) -> NDArray[np.float64] | None:
    names = [model.numeric(k).name for k in range(model.nnumeric)]
    if SPEED_NUMERIC not in names:
        return None
    values = np.array(model.numeric(SPEED_NUMERIC).data, dtype=np.float64)
    scalar = [j for j in range(model.njnt) if int(model.jnt_type[j]) in SCALAR_JOINTS]
    if len(values) == len(scalar):
        return values[[scalar.index(int(joint)) for joint in joints]]
    if len(values) in (1, len(joints)):
        return np.broadcast_to(values, (len(joints),)).copy()
    raise InputError(
        f"numeric {SPEED_NUMERIC} must have 1 number, {len(joints)} (controlled joints) or "
        f"{len(scalar)} (hinge and slide joints), got {len(values)}"
    )


def _numbers(values: ArrayLike, n: int, what: str) -> NDArray[np.float64]:
    try:
        numbers = np.array(values, dtype=np.float64)
    except (TypeError, ValueError):
        raise InputError(f"{what} must be {n} numbers, got {values!r}") from None
    one = what == "speed" and numbers.shape == ()
    if not one and numbers.shape != (n,):
        raise InputError(f"{what} must have shape ({n},), got {numbers.shape}")
    if np.any(np.isnan(numbers)) or (what == "home" and np.any(np.isinf(numbers))):
        raise InputError(f"{what} must be finite, got {numbers.tolist()}")
    return numbers
