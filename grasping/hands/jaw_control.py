"""Commands and senses of a gripper with two jaws. The width between its pads is enough.

Contact is a width that stops closing, a held object is a width above that of the empty gripper, and
a lost object is a width that falls to it. The motor's effort and pad forces are used where they
exist.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from eyehand.errors import InputError

from ..prototypes import Prototype
from .grip_options import GripOptions
from .hand_control import ClosingController, HeldState
from .hand_messages import AnyReading, JawCommand, JawReading
from .jaw_closing import JawClosing, empty_width
from .parallel_hand import ParallelHand

JAWS = ("left jaw", "right jaw")
"""Names of the jaws at -x and +x in records and messages."""
MOVE_FORCE_SHARE = 0.3
"""Share of the maximum force with which the empty gripper moves."""


@dataclass(frozen=True)
class JawControl:
    """`HandControl` of a gripper with two jaws. The hand frame is the tool frame."""

    model: ParallelHand
    """The gripper."""

    @property
    def fingers(self) -> tuple[str, ...]:
        """Names of the jaws."""
        return JAWS

    @property
    def max_opening(self) -> float:
        """Maximum distance between the pads, m."""
        return self.model.stroke

    def reach(self, opening: float) -> float:
        """Return the distance of the fingertips from the tool frame along z at an opening, m."""
        return -self.model.tip_advance * opening / self.model.stroke

    def half_width(self, opening: float) -> float:
        """Return half the width of the gripper at an opening in m, m."""
        boxes = np.concatenate([self.model.jaw_boxes(opening), self.model.fixed_boxes()])
        return float(np.abs(boxes[:, :, 0]).max())

    def posture(self, opening: float, prototype: Prototype | None = None) -> NDArray[np.float64]:
        """Return the opening as array (1,), m, for `Robot.description`."""
        return np.array([opening])

    def preshape(self, opening: float, prototype: Prototype) -> JawCommand:
        """Return the command that opens the jaws to an opening in m."""
        return JawCommand(min(opening, self.model.stroke), self._move_force)

    def opened(self) -> JawCommand:
        """Return the command that opens the jaws fully."""
        return JawCommand(self.model.stroke, self._move_force)

    def closing(
        self, prototype: Prototype, opening: float, options: GripOptions
    ) -> ClosingController:
        """Return the controller that closes the jaws."""
        return JawClosing(self.model, options)

    def contacts(self, reading: AnyReading, min_force: float) -> tuple[str, ...]:
        """Return the jaws with a pad force above ``min_force``, N; none without this sense."""
        forces = jaw_reading(reading).forces
        if forces is None:
            return ()
        return tuple(name for name, force in zip(JAWS, forces, strict=True) if force > min_force)

    def touched_side(self, reading: AnyReading, min_force: float) -> float:
        """Return the touched side along x: 1 right jaw, -1 left jaw, 0 both or neither."""
        touched = self.contacts(reading, min_force)
        return float(JAWS[1] in touched) - float(JAWS[0] in touched)

    def touches_outside(self, reading: AnyReading, min_force: float) -> bool:
        """Return whether a jaw touches something while it is open: nothing is between the pads."""
        return bool(self.contacts(reading, min_force))

    def forces(self, reading: AnyReading) -> NDArray[np.float64]:
        """Return the force on each jaw and 0 for the palm, (3,), N."""
        jaws = jaw_reading(reading)
        if jaws.forces is not None:
            return np.array([*jaws.forces, 0.0])
        effort = jaws.effort or 0.0
        return np.array([effort, effort, 0.0])

    def width(self, reading: AnyReading) -> float:
        """Return the distance between the pads, m."""
        return jaw_reading(reading).width

    def holds(self, reading: AnyReading) -> bool:
        """Return whether the jaws are wider apart than those of the empty gripper."""
        return jaw_reading(reading).width > empty_width(self.model)

    def held(self, reading: AnyReading) -> HeldState:
        """Return what the gripper senses of the object that it holds."""
        return HeldState(len(JAWS) if self.holds(reading) else 0)

    @property
    def _move_force(self) -> float:
        low, high = self.model.force
        return max(low, MOVE_FORCE_SHARE * high)


def jaw_reading(reading: AnyReading) -> JawReading:
    """Return the reading of a gripper with two jaws.

    Raises
    ------
    InputError
        If it is that of a hand with fingers.
    """
    if not isinstance(reading, JawReading):
        raise InputError(
            f"the reading of a gripper must be a JawReading, got {type(reading).__name__}"
        )
    return reading
