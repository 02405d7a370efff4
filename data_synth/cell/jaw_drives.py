"""Drives of a simulated gripper: one motor opens and closes two jaws with a limited force."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from eyehand.errors import InputError
from eyehand.grasping.hands import AnyCommand, JawCommand, JawReading

if TYPE_CHECKING:
    from eyehand.tactile import TactileImage

    from .jaw_mechanism import JawMechanism

SPEED = 0.1
"""Speed of the pads relative to each other, m/s, as the data sheets of common grippers state it."""
MAX_LEAD = 0.03
"""Maximum lead of the commanded width over the measured one, m. It is enough for the full force."""


class JawDrives:
    """Executes commands of a gripper with two jaws, one physics step at a time.

    Parameters
    ----------
    model, data
        `MjModel` and `MjData` with the gripper in it. The model's limit of the motor changes.
    mechanism
        The gripper, with a motor that :func:`~.jaw_mechanism.make_servo` made a servo.
    prefix
        Prefix of the gripper's names in the model.
    """

    def __init__(self, model: Any, data: Any, mechanism: JawMechanism, *, prefix: str = "") -> None:
        self._model, self._data, self._mechanism = model, data, mechanism
        self._motor = int(model.actuator(prefix + mechanism.motor).id)
        self._max_force = mechanism.force
        numbers = [model.joint(prefix + name).id for name in mechanism.joints]
        self._addresses = model.jnt_qposadr[np.array(numbers)]
        self._order = np.argsort(mechanism.lengths)
        posture = data.qpos[self._addresses]
        # Before the first step the transmission's length is not computed yet.
        nearest = int(np.argmin(np.abs(mechanism.postures - posture).sum(axis=1)))
        self._goal = self._target = float(mechanism.widths[nearest])
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
        length = float(self._data.actuator_length[self._motor])
        lengths = self._mechanism.lengths[self._order]
        return float(np.interp(length, lengths, self._mechanism.widths[self._order]))

    def apply(self) -> None:
        """Set the motor for the next physics step."""
        stride = SPEED * float(self._model.opt.timestep)
        # In a grip the goal lies behind the faces of the object, and the motor's limit acts.
        low = -MAX_LEAD if self._target <= self._mechanism.widths[0] else self._target
        self._goal += float(np.clip(low - self._goal, -stride, stride))
        self._data.ctrl[self._motor] = self._length(self._goal)

    def reading(self, tips: tuple[TactileImage, ...] = ()) -> JawReading:
        """Return the width and the effort."""
        effort = abs(float(self._data.actuator_force[self._motor]) / self._mechanism.ratio)
        return JawReading(self.width(), effort, None, tips)

    def _length(self, width: float) -> float:
        """Return the length of the transmission at a width in m, also beyond the closed jaws."""
        mechanism = self._mechanism
        inside = float(np.interp(width, mechanism.widths, mechanism.lengths))
        beyond = min(width - float(mechanism.widths[0]), 0.0)
        return inside + beyond / mechanism.ratio

    def _set_force(self, force: float) -> None:
        limit = min(max(force, 0.0), self._max_force) * abs(self._mechanism.ratio)
        self._model.actuator_forcelimited[self._motor] = 1
        self._model.actuator_forcerange[self._motor] = [-limit, limit]
