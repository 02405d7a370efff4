"""The simulated arm's servos: joint velocities followed by position servos without lag."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from eyehand.errors import InputError

from ..mujoco_import import import_mujoco

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

LEASH_RAD = 0.04
"""How far the commanded place may run ahead of a joint that is held up: more pushes harder against
what is in the way, less gives way under a load."""


class ArmServos:
    """Position servos whose goals are integrated from commanded velocities.

    A position servo damps the joint's own speed, and so lags behind a moving goal by damping over
    stiffness, 25 to 50 ms here; the goal is set ahead by as much.

    Parameters
    ----------
    model, data
        `MjModel`, `MjData` of the world.
    joints
        Names of the arm's hinges in it.
    start
        Their angles to begin with, (n,), rad, which are set.

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
        goal = np.minimum(np.maximum(goal, now - LEASH_RAD), now + LEASH_RAD)
        self._goal = np.minimum(np.maximum(goal, self._low), self._high)
        self._data.ctrl[self._motors] = self._goal + self._ahead * velocity

    def positions(self) -> NDArray[np.float64]:
        """Joint angles (n,), rad."""
        return self._data.qpos[self._places].copy()

    def speeds(self) -> NDArray[np.float64]:
        """Joint speeds (n,), rad/s."""
        return self._data.qvel[self._rates].copy()


def servo_of(model: Any, joint: int, name: str) -> int:
    """Find the position servo of a joint by its number: the number of the actuator.

    Raises
    ------
    InputError
        If it has none.
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
