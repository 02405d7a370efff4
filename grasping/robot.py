"""The robot protocol: the interface between a pick and a real or simulated robot."""

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


class Robot(Protocol):
    """An arm with a hand and a depth camera, stepped one control period at a time."""

    @property
    def hand(self) -> HandModel | ParallelHand:
        """Model of the hand.

        The names in it define the opposing finger (``thumb``), the pinching finger (``middle``)
        and the fingertip pads (``<finger>_distal``). `HandModel` lists the rules.
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
        to the thumb.
        """
        ...

    @property
    def joints(self) -> tuple[str, ...]:
        """Names of the arm's joints in the description, in the order of the readings."""
        ...

    def description(self, excursions: NDArray[np.float64]) -> Any:
        """Describe arm and hand for control, at given tendon excursions (D,), m.

        The result is a description that `eyehand.control.RobotModel.load` accepts. The pose of the
        robot's base is in the world frame, as `T_world_camera` and the tray are. If the base of
        a description is at the origin, move it by `T_world_base`. The keyframe ``home`` holds the
        arm's rest posture, outside the camera's view, and the hand's joints at these excursions.
        """
        ...

    def capture(self) -> DepthFrame:
        """Capture a depth image without the robot.

        The frame's `T_world_camera` comes from hand-eye calibration. The robot does
        not move meanwhile. It is in its rest posture or over the tray
        (`ClearOptions.capture_over_tray`). Pixels that show the robot must be 0 in the depth.
        Otherwise the robot is segmented as an object.
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
