"""What the pick needs of a robot: a small protocol that a real cell or a simulated one fulfils."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Literal, Protocol

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from eyehand.perception import DepthFrame
    from eyehand.tactile import TactileImage

    from .hand_model import HandModel

DriveMode = Literal["place", "pull", "hold"]
"""place: servo the tendon to an excursion; pull: a tension; hold: stay, up to a tension."""


@dataclass(frozen=True)
class HandCommand:
    """What each drive of the hand does until the next command, in the hand model's order."""

    modes: tuple[DriveMode, ...]
    """Mode of each drive."""
    values: NDArray[np.float64]
    """(D,): excursion in m from fully open (place), tension in N (pull), largest tension in N at
    which the drive stays where it is (hold)."""


@dataclass(frozen=True)
class HandReading:
    """What the hand feels, in the order of the hand model's drives, joints, pads and tips."""

    excursions: NDArray[np.float64]
    """How far each tendon is pulled in, (D,), m; 0 is fully open."""
    tensions: NDArray[np.float64]
    """Tension of each tendon, (D,), N."""
    angles: NDArray[np.float64]
    """Joint angles, (J,), rad; 0 is straight, inwards is positive."""
    forces: NDArray[np.float64]
    """Normal force on each pad (phalanges and palm), (P,), N."""
    tips: tuple[TactileImage, ...]
    """Tactile image of each fingertip."""


@dataclass(frozen=True)
class RobotReading:
    """The robot's state at the end of a control period."""

    time: float
    """s since the start."""
    q: NDArray[np.float64]
    """Arm joint angles, (n,), rad."""
    speed: NDArray[np.float64]
    """Arm joint speeds, (n,), rad/s."""
    hand: HandReading
    """What the hand feels."""
    fault: str = ""
    """Why the robot stopped by itself; empty while all is well."""


class Robot(Protocol):
    """An arm with a hand and an eye, one control period at a time."""

    @property
    def hand(self) -> HandModel:
        """What is known of the hand before it touches anything.

        Its names tell closing which finger opposes (``thumb``), which pinches (``middle``) and
        which pads are tips (``<finger>_distal``): `HandModel` has the rules.
        """
        ...

    @property
    def period(self) -> float:
        """Control period, s."""
        ...

    @property
    def frame(self) -> str:
        """Name of the hand's frame in the description.

        Its origin is the middle of the palm's face, z points out of the palm, x from the fingers
        to the thumb.
        """
        ...

    @property
    def joints(self) -> tuple[str, ...]:
        """Names of the arm's joints in the description, in the order of the readings."""
        ...

    def description(self, excursions: NDArray[np.float64]) -> Any:
        """Describe arm and hand for control, the tendons pulled in so far, (D,), m.

        Its base stands in it where it stands in the world, the frame of `T_world_camera` and of
        the tray: a description whose base is at the origin is moved there (`T_world_base`).
        The keyframe ``home`` holds the arm's rest posture, out of the camera's view, and the
        hand's joints at that opening. Whatever `eyehand.control.RobotModel.load` takes.
        """
        ...

    def look(self) -> DepthFrame:
        """Take a depth image whose pixels of the robot itself have no reading.

        `T_world_camera`, from hand-eye calibration, is known; the robot stands still meanwhile.
        It stands at rest or, unless `ClearOptions.look_from_tray` is False, over the tray; what
        shows of it is 0 in the depth, or would be taken for an object.
        """
        ...

    def read(self) -> RobotReading:
        """Give the state now, without moving."""
        ...

    def step(
        self, velocity: NDArray[np.float64], command: HandCommand | None = None
    ) -> RobotReading:
        """Move for one period and give the state at its end.

        Parameters
        ----------
        velocity
            Arm joint velocities, (n,), rad/s; finite and within the joints' limits.
        command
            For the hand's drives; as before when None.
        """
        ...
