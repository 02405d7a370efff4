"""The messages between a controller and a hand: commands and readings."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal, TypeAlias

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from eyehand.tactile import TactileImage

DriveMode = Literal["position", "pull", "hold"]
"""Mode of a drive.

- position: servo the tendon to an excursion.
- pull: apply a tension.
- hold: keep the excursion, up to a maximum tension.
"""


@dataclass(frozen=True)
class HandCommand:
    """Command for each drive of the hand, in the order of the hand model."""

    modes: tuple[DriveMode, ...]
    """Mode of each drive."""
    values: NDArray[np.float64]
    """Value of each drive, (D,): the excursion from fully open in m (position), the tension in N
    (pull), or the maximum tension in N (hold)."""


@dataclass(frozen=True)
class HandReading:
    """Sensor readings of the hand, in the order of the hand model's drives, joints and pads."""

    excursions: NDArray[np.float64]
    """Excursion of each tendon, (D,), m; 0 is fully open."""
    tensions: NDArray[np.float64]
    """Tension of each tendon, (D,), N."""
    angles: NDArray[np.float64]
    """Joint angles, (J,), rad; 0 is straight, positive bends inwards."""
    forces: NDArray[np.float64]
    """Normal force on each pad of phalanges and palm, (P,), N."""
    tips: tuple[TactileImage, ...]
    """Tactile image of each fingertip; empty for a hand without tactile sensors."""
    touch_fault: str = ""
    """Fault of the sensors, as the driver's `tactile.sensors.SensorMonitor` reports it: stopped,
    repeats old images, or lost tactels. The pick then ends. Empty without one."""
    touch_time: float | None = None
    """Time of the newest measurement of touch, s, from any start. None: touch then counts as
    stopped when its values stay the same while the fingers move. Switches, and sensors with less
    than 10 measurements a second, need the time."""


@dataclass(frozen=True)
class JawCommand:
    """Command for a gripper with two jaws."""

    width: float
    """Distance between the pads to move to, m."""
    force: float
    """Maximum force of each jaw, N."""

    @property
    def values(self) -> NDArray[np.float64]:
        """Width in m and force in N, (2,)."""
        return np.array([self.width, self.force])


@dataclass(frozen=True)
class JawReading:
    """Sensor readings of a gripper with two jaws. Only the width is required."""

    width: float
    """Distance between the pads, m."""
    effort: float | None = None
    """Force of each jaw that the motor measures, N; None without this sense."""
    forces: tuple[float, float] | None = None
    """Normal force on the pads of the jaws at -x and +x, N; None without this sense."""
    tips: tuple[TactileImage, ...] = ()
    """Tactile image of each pad; empty without this sense."""
    touch_fault: str = ""
    """As :attr:`HandReading.touch_fault`."""
    touch_time: float | None = None
    """As :attr:`HandReading.touch_time`."""


AnyCommand: TypeAlias = HandCommand | JawCommand
"""Command of either kind of hand."""
AnyReading: TypeAlias = HandReading | JawReading
"""Reading of either kind of hand."""
