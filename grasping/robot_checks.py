"""Check a robot class and its drivers before the first motion."""

from __future__ import annotations

from numbers import Real
from typing import TYPE_CHECKING, Any

import numpy as np

from eyehand.errors import InputError
from eyehand.perception import DepthFrame

from .hands import HandModel, HandReading, JawReading, ParallelHand
from .robot import RobotReading
from .tray import Tray

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from eyehand.control import RobotModel

    from .robot import Robot

ROBOT = ("hand", "hand_frame", "joints", "period", "description", "capture", "read", "step")
ARM = ("joints", "period", "read", "step")
HAND = ("model", "read", "move")
CAMERA = ("capture",)
"""Members of the protocols `Robot`, `Arm`, `Hand` and `Camera`."""
METHODS = {"description", "capture", "read", "step", "move"}
HOME = "home"
"""Name of the keyframe with the rest posture."""
JOINT_MARGIN = 0.1
"""Distance by which a measured joint may exceed its limit, rad or m. It covers errors of encoders
and of the robot's file."""
FULL_TURN = 2.0 * np.pi
"""Angle beyond which a joint far outside its limits is taken for one in degrees, rad."""
WIDTH_MARGIN = 0.02
"""Distance by which a measured width may exceed the stroke of the hand, m."""


def check_members(part: object, members: tuple[str, ...], protocol: str) -> None:
    """Raise an `InputError` that lists the members that an object lacks for a protocol."""
    name = type(part).__name__
    if isinstance(part, type):
        raise InputError(f"{protocol}: {part.__name__} is a class, pass an object of it")
    missing = [member for member in members if not hasattr(part, member)]
    if missing:
        raise InputError(
            f"{name} lacks {', '.join(missing)}: "
            f"eyehand.grasping.{protocol} has {', '.join(members)}"
        )
    values = [name for name in members if name in METHODS and not callable(getattr(part, name))]
    if values:
        raise InputError(f"{name}.{values[0]} must be a method, got {getattr(part, values[0])!r}")


def check_type(value: object, kinds: type | tuple[type, ...], what: str) -> None:
    """Raise an `InputError` if a value has none of the types."""
    if not isinstance(value, kinds):
        names = [kind.__name__ for kind in (kinds if isinstance(kinds, tuple) else (kinds,))]
        raise InputError(f"{what} must be of type {' or '.join(names)}, got {type(value).__name__}")


def check_robot(robot: Robot) -> None:
    """Check the members of a robot.

    Raises
    ------
    InputError
        If a member is missing or has a wrong type.
    """
    check_members(robot, ROBOT, "Robot")
    check_type(robot.hand, (HandModel, ParallelHand), "robot.hand")
    check_type(robot.hand_frame, str, "robot.hand_frame")
    if isinstance(robot.joints, str) or not all(isinstance(name, str) for name in robot.joints):
        raise InputError(
            f"robot.joints must be the names of the arm's joints, got {robot.joints!r}"
        )
    if not 0.0 < robot.period < 1.0:
        raise InputError(f"robot.period must be 0 to 1 s, got {robot.period}")


def check_start(reading: Any, robot: Robot, model: RobotModel) -> None:
    """Check the rest posture in the model of a robot, and the first reading.

    Raises
    ------
    InputError
        If the model has no keyframe ``home``, a type or shape is wrong, a number is not finite, or
        a joint or the width of the hand is far outside its range.
    """
    if HOME not in [model.model.key(k).name for k in range(model.model.nkey)]:
        raise InputError(
            f"robot.description() has no keyframe {HOME!r}: add the rest posture of the arm, "
            f"outside the image, with MjSpec.add_key(name={HOME!r}, qpos=...)"
        )
    check_type(reading, RobotReading, "robot.read()")
    jaws = isinstance(robot.hand, ParallelHand)
    check_type(reading.hand, JawReading if jaws else HandReading, "robot.read().hand")
    for name in ("q", "velocity"):
        value = np.asarray(getattr(reading, name), dtype=np.float64)
        if value.shape != (model.n,) or not np.isfinite(value).all():
            raise InputError(
                f"robot.read().{name} must be {model.n} finite numbers, one for each of "
                f"robot.joints, got {value.tolist()}"
            )
    q = np.asarray(reading.q)
    outside = (q < model.lower - JOINT_MARGIN) | (q > model.upper + JOINT_MARGIN)
    if outside.any():
        k = int(np.argmax(outside))
        raise InputError(
            f"robot.read().q: joint {model.joint_names[k]} is at {q[k]:.4g}, its limits are "
            f"{model.lower[k]:.4g} to {model.upper[k]:.4g}; {_cause(q)}"
        )
    if isinstance(robot.hand, ParallelHand):
        width, effort, stroke = reading.hand.width, reading.hand.effort, robot.hand.stroke
        for name, value in (("width", width), ("effort", effort)):
            if not isinstance(value, Real) and (name == "width" or value is not None):
                raise InputError(f"robot.read().hand.{name} must be a number, got {value!r}")
        if not -WIDTH_MARGIN <= width <= stroke + WIDTH_MARGIN:
            raise InputError(
                f"robot.read().hand.width must be 0 to {stroke:g} m, got {width:.4g}: "
                "write it in m, not in mm"
            )


def _cause(q: NDArray[np.float64]) -> str:
    """Say what joint angles far outside their limits may come from."""
    if np.abs(q).max() > FULL_TURN:
        return "angles must be in rad, not in degrees"
    return "check the order of robot.joints, the signs and the zero positions"


def check_tray(tray: Tray, model: RobotModel) -> None:
    """Raise an `InputError` if a tray is out of the arm's reach, or larger than all it reaches."""
    check_type(tray, Tray, "tray")
    state, anchors = model.at(model.home), model.data.xanchor[model.joints]
    points = np.vstack([anchors[np.argsort(model.joints)], state.position])
    reach = float(np.linalg.norm(np.diff(points, axis=0), axis=1).sum())
    if not model.hinge.all():
        return
    if max(*tray.size) > 2.0 * reach or tray.wall_height > reach:
        raise InputError(
            f"the tray has size {tray.size} m and wall_height {tray.wall_height:g} m, the arm "
            f"reaches {reach:.2g} m: give them in m, not in mm"
        )
    far = tray.distance(points[0])
    if far > reach:
        raise InputError(
            f"the tray at {np.round(tray.centre, 3).tolist()} m is {far:.3g} m from the base of "
            f"the arm, which reaches {reach:.2g} m: give its place in the world frame in m"
        )


def check_frame(frame: Any) -> None:
    """Raise an `InputError` if what ``capture()`` returned is no depth frame with a pose."""
    check_type(frame, DepthFrame, "robot.capture()")
    if frame.T_world_camera is None:
        raise InputError(
            "robot.capture() returned a frame without a pose: "
            "pass DepthFrame(depth, intrinsics, T_world_camera)"
        )
