"""The messages between a controller and a hand: commands and readings."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal

if TYPE_CHECKING:
    import numpy as np
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
