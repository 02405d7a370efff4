"""The home posture and the joint limits of motion, from an argument, a file, or a default."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from eyehand.errors import InputError

from .array_checks import checked_array
from .mujoco_binding import Model, mujoco
from .robot_source import ACCELERATION_NUMERIC, JERK_NUMERIC, SPEED_NUMERIC

DEFAULT_TURN_SPEED = 1.5
"""Speed limit of a hinge joint without one, rad/s. Light arms reach it in every joint."""
DEFAULT_SLIDE_SPEED = 0.5
"""Speed limit of a slide joint without one, m/s: that of a fast linear axis near people."""
DEFAULT_TURN_ACCELERATION = 7.5
"""Acceleration limit of a hinge joint without one, rad/s²: the lowest of the Franka Panda."""
DEFAULT_SLIDE_ACCELERATION = 2.5
"""Acceleration limit of a slide joint without one, m/s². It stops from the default speed as fast as
a hinge joint from its own."""
JERK_PER_ACCELERATION = 500.0
"""Jerk limit of a joint without one, per its acceleration limit, 1/s: as published for the Franka
Panda."""
HOME_KEYFRAME = "home"
"""Name of the keyframe that holds the home posture."""

_HINGE = int(mujoco.mjtJoint.mjJNT_HINGE)
_SLIDE = int(mujoco.mjtJoint.mjJNT_SLIDE)
SCALAR_JOINTS = (_HINGE, _SLIDE)
"""Types of joint with one position. Only these can be controlled."""


def home_posture(
    model: Model, joints: NDArray[np.int64], home: ArrayLike | None
) -> NDArray[np.float64]:
    """Return MuJoCo's joint positions (nq,) at home. ``home`` (n,) has priority over the file.

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
        posture[model.jnt_qposadr[joints]] = checked_array("home", home, (len(joints),))
    for joint in joints:
        low, high = model.jnt_range[joint]
        value = posture[model.jnt_qposadr[joint]]
        if model.jnt_limited[joint] and not low <= value <= high:
            name = model.joint(int(joint)).name
            raise InputError(f"home of joint {name} must be in [{low:g}, {high:g}], got {value:g}")
    return posture


def joint_speed(
    model: Model, joints: NDArray[np.int64], speed: ArrayLike | None
) -> NDArray[np.float64]:
    """Return the speed limits (n,) of the controlled joints, rad/s or m/s.

    Raises
    ------
    InputError
        If a limit is not a number above zero, or the number of limits does not fit the joints.
    """
    limits = _given_limits("speed", model, joints, speed, SPEED_NUMERIC)
    if limits is None:
        limits = _by_type(model, joints, DEFAULT_TURN_SPEED, DEFAULT_SLIDE_SPEED)
        numerics = [model.numeric(k) for k in range(model.nnumeric)]
        mark = f"{SPEED_NUMERIC}."
        # A prefix of an attached spec stands before the names of its numerics and joints.
        by_joint = {
            one.name.replace(mark, "", 1): one.data[0] for one in numerics if mark in one.name
        }
        for column, joint in enumerate(joints):
            limits[column] = by_joint.get(model.joint(int(joint)).name, limits[column])
    if not np.all(limits > 0.0):
        raise InputError(f"joint speed limits must be > 0, got {limits.tolist()}")
    return limits


def joint_acceleration(
    model: Model,
    joints: NDArray[np.int64],
    acceleration: ArrayLike | None,
    jerk: ArrayLike | None,
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return the limits (n,) of acceleration and jerk of the controlled joints.

    Raises
    ------
    InputError
        If a limit is not a number above zero, or the number of limits does not fit the joints.
    """
    limits = _given_limits("acceleration", model, joints, acceleration, ACCELERATION_NUMERIC)
    if limits is None:
        limits = _by_type(model, joints, DEFAULT_TURN_ACCELERATION, DEFAULT_SLIDE_ACCELERATION)
    changes = _given_limits("jerk", model, joints, jerk, JERK_NUMERIC)
    if changes is None:
        changes = JERK_PER_ACCELERATION * limits
    for name, values in (("acceleration", limits), ("jerk", changes)):
        if not np.all(values > 0.0):
            raise InputError(f"joint {name} limits must be > 0, got {values.tolist()}")
    return limits, changes


def _by_type(
    model: Model, joints: NDArray[np.int64], hinge: float, slide: float
) -> NDArray[np.float64]:
    return np.where(model.jnt_type[joints] == _HINGE, hinge, slide)


def _given_limits(
    name: str, model: Model, joints: NDArray[np.int64], given: ArrayLike | None, numeric: str
) -> NDArray[np.float64] | None:
    """Return the limits (n,) of an argument, or else those of an MJCF, or None if it has none."""
    n = len(joints)
    if given is not None:
        every = np.full(n, given) if np.ndim(given) == 0 else given
        return checked_array(name, every, (n,), finite=False)
    if numeric not in [model.numeric(k).name for k in range(model.nnumeric)]:
        return None
    values = np.array(model.numeric(numeric).data, dtype=np.float64)
    scalar = [j for j in range(model.njnt) if int(model.jnt_type[j]) in SCALAR_JOINTS]
    if len(values) == len(scalar):
        return values[[scalar.index(int(joint)) for joint in joints]]
    if len(values) in (1, n):
        return np.broadcast_to(values, (n,)).copy()
    raise InputError(
        f"numeric {numeric} must have 1 number, {n} (controlled joints) or "
        f"{len(scalar)} (hinge and slide joints), got {len(values)}"
    )
