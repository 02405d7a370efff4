"""Drives of a simulated gripper: its motors open and close two jaws with a limited force."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from eyehand.errors import InputError
from eyehand.grasping.hands import AnyCommand, JawCommand, JawReading

from .jaw_mechanism import SERVO_RATE

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from eyehand.grasping import ParallelHand
    from eyehand.tactile import TactileImage

    from .jaw_mechanism import JawMechanism

SPEED = 0.1
"""Speed of the pads relative to each other, m/s, as the data sheets of common grippers state it."""
MAX_LEAD = 0.03
"""Maximum lead of the commanded width over the measured one, m. It is enough for the full force."""
SLIDE_RATE = 60.0
"""Natural frequency at which the width of two fingers follows its goal, rad/s."""

END_STOP = 0.002
"""Width above that of the closed fingers below which their force fades, m."""


class JawDrives:
    """Executes commands of a gripper with one motor, one physics step at a time.

    Parameters
    ----------
    model, data
        `MjModel` and `MjData` with the gripper in it. The model's limits of the motors change.
    mechanism
        The gripper, with motors that :func:`~.jaw_mechanism.make_servo` made servos.
    prefix
        Prefix of the gripper's names in the model.
    """

    def __init__(self, model: Any, data: Any, mechanism: JawMechanism, *, prefix: str = "") -> None:
        self._model, self._data, self._mechanism = model, data, mechanism
        self._motors = np.array([int(model.actuator(prefix + m).id) for m in mechanism.motors])
        self._max_force = mechanism.force
        self._ratio = float(mechanism.slopes[0, 0])
        addresses = model.jnt_qposadr[[model.joint(prefix + name).id for name in mechanism.joints]]
        # Before the first step the transmission's length is not computed yet.
        away = np.abs(mechanism.postures - data.qpos[addresses]).sum(axis=1)
        self._goal = self._target = float(mechanism.widths[int(np.argmin(away))])
        self._set_force(self._max_force)
        self.apply()

    def command(self, command: AnyCommand) -> None:
        """Set a command.

        Raises
        ------
        InputError
            If it is not a finite `JawCommand`.
        """
        if not isinstance(command, JawCommand) or not np.isfinite(command.values).all():
            raise InputError(f"the command of a gripper must be a finite JawCommand, got {command}")
        if command.width > self._target:
            # An opening gripper starts where it is, not at the lead of its grip.
            self._goal = max(self._goal, self.width())
        self._target = command.width
        self._set_force(command.force)

    def width(self) -> float:
        """Return the distance between the pads by the motor's position, m."""
        length = float(self._data.actuator_length[self._motors[0]])
        lengths = self._mechanism.lengths[:, 0]
        order = np.argsort(lengths)
        return float(np.interp(length, lengths[order], self._mechanism.widths[order]))

    def apply(self) -> None:
        """Set the motors for the next physics step."""
        stride = SPEED * float(self._model.opt.timestep)
        # In a grip the goal lies behind the faces of the object, and the force is limited.
        low = -MAX_LEAD if self._target <= self._mechanism.widths[0] else self._target
        self._goal += float(np.clip(low - self._goal, -stride, stride))
        self._data.ctrl[self._motors] = self._controls()

    def reading(self, tips: tuple[TactileImage, ...] = ()) -> JawReading:
        """Return the width and the effort."""
        return JawReading(self.width(), self._effort(), None, tips)

    def _controls(self) -> NDArray[np.float64]:
        """Return the goals of the servos, (M,). Beyond the closed jaws they continue linearly."""
        mechanism = self._mechanism
        inside = float(np.interp(self._goal, mechanism.widths, mechanism.lengths[:, 0]))
        beyond = min(self._goal - float(mechanism.widths[0]), 0.0)
        return np.array([inside + beyond / self._ratio])

    def _effort(self) -> float:
        return abs(float(self._data.actuator_force[self._motors[0]]) / self._ratio)

    def _set_force(self, force: float) -> None:
        limit = min(max(force, 0.0), self._max_force) * abs(self._ratio)
        self._model.actuator_forcelimited[self._motors] = 1
        self._model.actuator_forcerange[self._motors] = [-limit, limit]


class FingerDrives(JawDrives):
    """Executes commands of two fingers with a motor for each joint, as if one slide moved both.

    The servos keep the joints on the path of the closing fingers, at the width that the joints
    have. A virtual spring pulls the width to its goal, with the force of the command at most. The
    motors add the torques of this force at the pads.

    Parameters
    ----------
    model, data, mechanism, prefix
        As of `JawDrives`.
    max_force
        Maximum force of each finger, N, where the file does not limit its motors.
    """

    def __init__(
        self,
        model: Any,
        data: Any,
        mechanism: JawMechanism,
        *,
        max_force: float,
        prefix: str = "",
    ) -> None:
        self._force = self._spring_force = 0.0
        path = np.gradient(mechanism.lengths, mechanism.widths, axis=0)
        # The pads turn while they close: the point that touches is not the one of the slopes.
        self._along = mechanism.slopes / np.sum(mechanism.slopes * path, axis=1)[:, None]
        stiffness = mechanism.stiffness * (SLIDE_RATE / SERVO_RATE) ** 2
        self._spring = float(np.min(np.sum(path**2 * stiffness, axis=1)))
        self._width = 0.0
        super().__init__(model, data, mechanism, prefix=prefix)
        self._max_force = min(max_force, mechanism.force)
        torques = np.abs(mechanism.slopes).max() * self._max_force
        limited = model.actuator_forcelimited[self._motors].astype(bool)
        own = np.abs(model.actuator_forcerange[self._motors]).max(axis=1)
        limits = np.where(limited, own, torques)
        model.actuator_forcelimited[self._motors] = 1
        model.actuator_forcerange[self._motors] = np.column_stack([-limits, limits])
        self._force = self._max_force

    def width(self) -> float:
        """Return the distance between the pads by the positions of all joints, m."""
        if not self._data.time:
            return self._goal
        lengths = self._data.actuator_length[self._motors]
        for _ in range(2):
            on_path, along = self._at(self._width)
            self._width += float(along @ (lengths - on_path))
        return self._width

    def _at(self, width: float) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Return the lengths on the path (M,) and the change of the width with them (M,)."""
        mechanism = self._mechanism
        place = np.interp(width, mechanism.widths, np.arange(len(mechanism.widths)))
        first = min(int(place), len(mechanism.widths) - 2)
        share = place - first
        lengths, along = mechanism.lengths, self._along
        return (
            (1.0 - share) * lengths[first] + share * lengths[first + 1],
            (1.0 - share) * along[first] + share * along[first + 1],
        )

    def _controls(self) -> NDArray[np.float64]:
        width = self.width()
        on_path, along = self._at(width)
        pull = self._spring * (width - self._goal)
        # At the closed end of the path nothing would stop fingers that miss each other.
        left = max(width - float(self._mechanism.widths[0]), 0.0) / END_STOP
        self._spring_force = float(np.clip(pull, -self._force, self._force * min(left, 1.0)))
        return on_path - along * self._spring_force / self._mechanism.stiffness

    def _effort(self) -> float:
        return abs(self._spring_force)

    def _set_force(self, force: float) -> None:
        self._force = min(max(force, 0.0), self._max_force)


def create_jaw_drives(
    model: Any, data: Any, mechanism: JawMechanism, hand: ParallelHand, *, prefix: str = ""
) -> JawDrives:
    """Return the drives of a gripper: `JawDrives` of one motor, `FingerDrives` of several.

    Parameters
    ----------
    model, data, mechanism, prefix
        As of `JawDrives`.
    hand
        Description of the gripper.
    """
    if len(mechanism.motors) == 1:
        return JawDrives(model, data, mechanism, prefix=prefix)
    return FingerDrives(model, data, mechanism, max_force=hand.force[1], prefix=prefix)
