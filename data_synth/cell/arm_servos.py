"""Servos of the simulated arm: position servos that follow joint velocities without lag."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from eyehand.errors import InputError

from ..mujoco_import import import_mujoco

MAX_LEAD_RAD = 0.04
"""Maximum lead of the commanded angle over the joint. A larger lead pushes harder against
obstacles; a smaller one yields under load."""


class ArmServos:
    """Position servos whose goals are integrated from commanded velocities.

    A position servo damps the joint's speed, so it lags behind a moving goal by damping over
    stiffness, 25 to 50 ms here. The goal is set ahead by this time.

    Parameters
    ----------
    model, data
        `MjModel`, `MjData` of the world.
    joints
        Names of the arm's hinges.
    start
        Initial joint angles, (n,), rad, which are set.

    Raises
    ------
    InputError
        If a joint has no position servo.
    """

    def __init__(
        self, model: Any, data: Any, joints: Sequence[str], start: NDArray[np.float64]
    ) -> None:
        self._data = data
        self._dt = float(model.opt.timestep)
        numbers = np.array([model.joint(name).id for name in joints])
        self._places, self._rates = model.jnt_qposadr[numbers], model.jnt_dofadr[numbers]
        self._motors = np.array(
            [servo_of(model, int(j), name) for j, name in zip(numbers, joints, strict=True)]
        )
        stiffness = model.actuator_gainprm[self._motors, 0]
        self._ahead = -model.actuator_biasprm[self._motors, 2] / stiffness
        limited = model.jnt_limited[numbers].astype(bool)
        self._low = np.where(limited, model.jnt_range[numbers, 0], -np.inf)
        self._high = np.where(limited, model.jnt_range[numbers, 1], np.inf)
        data.qpos[self._places] = start
        self._goal = np.array(start, dtype=np.float64)
        data.ctrl[self._motors] = self._goal

    def apply(self, velocity: NDArray[np.float64]) -> None:
        """Set the servos for the next physics step."""
        now = self._data.qpos[self._places]
        goal = self._goal + self._dt * velocity
        goal = np.minimum(np.maximum(goal, now - MAX_LEAD_RAD), now + MAX_LEAD_RAD)
        self._goal = np.minimum(np.maximum(goal, self._low), self._high)
        self._data.ctrl[self._motors] = self._goal + self._ahead * velocity

    def positions(self) -> NDArray[np.float64]:
        """Return the joint angles (n,), rad."""
        return self._data.qpos[self._places].copy()

    def speeds(self) -> NDArray[np.float64]:
        """Return the joint speeds (n,), rad/s."""
        return self._data.qvel[self._rates].copy()


def servo_of(model: Any, joint: int, name: str) -> int:
    """Return the actuator number of a joint's position servo.

    Raises
    ------
    InputError
        If the joint has no position servo.
    """
    mujoco = import_mujoco()
    for motor in range(model.nu):
        drives = int(model.actuator_trntype[motor]) == int(mujoco.mjtTrn.mjTRN_JOINT)
        placed = model.actuator_gainprm[motor, 0] > 0 and model.actuator_biasprm[motor, 1] < 0
        if drives and placed and int(model.actuator_trnid[motor, 0]) == joint:
            return motor
    raise InputError(
        f"joint {name} has no position servo: give the robot's file a <position> actuator for it"
    )
