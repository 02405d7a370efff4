"""The robot protocols: the interface between a pick and a real or simulated robot.

A driver of a real robot implements `Arm`, `Hand` and `Camera`, and `JoinedRobot` joins them. A
`Robot` is all three at once.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Protocol

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from eyehand.perception import DepthFrame

    from .hands import AnyCommand, AnyReading, HandModel, ParallelHand


@dataclass(frozen=True)
class RobotReading:
    """State of the robot at the end of a control period."""

    time: float
    """Robot time since the start, s."""
    q: NDArray[np.float64]
    """Joint angles of the arm, (n,), rad."""
    velocity: NDArray[np.float64]
    """Joint velocities of the arm, (n,), rad/s."""
    hand: AnyReading
    """Readings of the hand."""
    fault: str = ""
    """Reason why the robot stopped itself; empty without a fault."""
    wrench: NDArray[np.float64] | None = None
    """Force, N, and torque about the origin, Nm, on the hand by what it touches, (6,), in the
    hand's frame. The driver subtracts weight and inertia of the hand. None without this sense."""


@dataclass(frozen=True)
class ArmReading:
    """State of an arm."""

    time: float
    """Time of the measurement by the arm's clock, s."""
    q: NDArray[np.float64]
    """Joint angles, (n,), rad."""
    velocity: NDArray[np.float64]
    """Joint velocities, (n,), rad/s."""
    fault: str = ""
    """Reason why the arm stopped itself; empty without a fault."""
    wrench: NDArray[np.float64] | None = None
    """As :attr:`RobotReading.wrench`, by a sensor in the wrist or from the joint torques."""


class Arm(Protocol):
    """The driver of an arm.

    It raises an exception for a lost connection. The arm must stop by itself when commands stay
    away.
    """

    @property
    def joints(self) -> tuple[str, ...]:
        """Names of the joints in the description, in the order of the readings."""
        ...

    @property
    def period(self) -> float:
        """Control period, s."""
        ...

    def read(self) -> ArmReading:
        """Return the newest state without moving."""
        ...

    def step(self, velocity: NDArray[np.float64]) -> ArmReading:
        """Command joint velocities (n,), rad/s, wait for one period, return the newest state."""
        ...


class Hand(Protocol):
    """The driver of a hand. Its methods return at once.

    A gripper with two jaws must sense its width. Its other senses are optional: effort, pad forces
    and tactile images. It leaves them out of its readings.
    """

    @property
    def model(self) -> HandModel | ParallelHand:
        """Description of the hand."""
        ...

    def read(self) -> AnyReading:
        """Return the newest readings."""
        ...

    def move(self, command: AnyCommand) -> None:
        """Start to execute a command instead of the one before. Often both are equal."""
        ...


class Camera(Protocol):
    """The driver of a depth camera."""

    def capture(self) -> DepthFrame:
        """Capture a depth image, as `Robot.capture`.

        It raises an exception for a dropped frame.
        """
        ...


class Robot(Protocol):
    """An arm with a hand and a depth camera, stepped one control period at a time."""

    @property
    def hand(self) -> HandModel | ParallelHand:
        """Model of the hand.

        For a hand with fingers, the names in it define the opposing finger (``thumb``), the
        pinching finger (``middle``) and the fingertip pads (``<finger>_distal``). `HandModel` lists
        the rules. A gripper with two jaws has a `ParallelHand`.
        """
        ...

    @property
    def period(self) -> float:
        """Control period, s."""
        ...

    @property
    def hand_frame(self) -> str:
        """Name of the hand's frame in the robot description (`description`).

        Its origin is the middle of the palm's face. z points out of the palm, x from the fingers
        to the thumb. For a gripper with two jaws it is the tool frame of `ParallelHand`.
        """
        ...

    @property
    def joints(self) -> tuple[str, ...]:
        """Names of the arm's joints in the description, in the order of the readings."""
        ...

    def description(self, posture: NDArray[np.float64]) -> Any:
        """Describe arm and hand for control, in a posture of the hand.

        The posture holds the tendon excursions (D,), m, of a hand with fingers, or the width (1,),
        m, of a gripper.

        The result is a description that `eyehand.control.RobotModel.load` accepts. The pose of the
        robot's base is in the world frame, as `T_world_camera` and the tray are. If the base of
        a description is at the origin, move it by `T_world_base`. The keyframe ``home`` holds the
        arm's rest posture, outside the camera's view, and the hand's joints in this posture.
        """
        ...

    def capture(self) -> DepthFrame:
        """Capture a depth image.

        The frame's `T_world_camera` comes from hand-eye calibration. The robot does
        not move meanwhile. It is in its rest posture or over the tray
        (`ClearOptions.capture_over_tray`). `observe` removes the readings of what `description`
        holds. Cables, and a pedestal outside the description, are the driver's to mask.
        """
        ...

    def read(self) -> RobotReading:
        """Return the current state without moving."""
        ...

    def step(
        self, velocity: NDArray[np.float64], command: AnyCommand | None = None
    ) -> RobotReading:
        """Move for one period and return the state at its end.

        Parameters
        ----------
        velocity
            Joint velocities of the arm, (n,), rad/s; finite and within the joints' limits.
        command
            Command of the hand; None keeps the previous command.
        """
        ...
