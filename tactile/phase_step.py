"""The phases of a touch, their outcomes, and the command of one cycle."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

Phase = Literal["move", "hold", "task", "search", "back_off", "ended"]
"""The phase of a touch. A contact starts the task from `move`, `hold` and `search`.

- move: the caller moves the arm to the work area.
- hold: the pad descends, or waits, until contact.
- task: the servo moves the pad.
- search: the pad lifts, shifts and descends to find a lost contact again.
- back_off: the pad moves away from the object.
- ended: no motion.
"""

SensorFault = Literal["sensor_stopped", "sensor_repeats", "tactels_lost", "sensor_fault"]
"""A fault of the tactile sensor.

- sensor_stopped: no image arrives any more, or less than a fifth of the stated rate by the
  sensor's clock.
- sensor_repeats: the same image arrives again and again.
- tactels_lost: too few tactels are neither dead nor saturated, a row has died since the
  calibration, or tactels are stuck at full scale.
- sensor_fault: features that are not finite.
"""

Outcome = Literal[
    "done", "unreachable", "no_contact", "contact_lost", "overload", "overshoot", "oscillation",
    "steady_miss", "unsteady_contact", "at_border", "no_resistance",
    "sensor_stopped", "sensor_repeats", "tactels_lost", "sensor_fault",
]  # fmt: skip
"""The result of a touch.

- done: the time of the task is over, or the caller has finished it.
- unreachable: the arm did not reach the work area in time.
- no_contact: there was no contact within the limits of time and distance.
- contact_lost: the contact was lost too often, or was not found again.
- overload: pressure or force is above its limit, or too many tactels are saturated.
- overshoot: the pressure has settled, but its peak was above `PhaseOptions.peak_limit`.
- oscillation: the pressure oscillates and does not settle. The control loop is close to
  instability, or the object moves.
- steady_miss: the pressure stays away from the goal.
- unsteady_contact: the centre of pressure jumps between places, or the contact comes and goes
  faster than the pad can move. Noise has the same effect.
- at_border: the contact stays at the pad's border.
- no_resistance: pressing does not raise the pressure.
- sensor_stopped, sensor_repeats, tactels_lost, sensor_fault: see `SensorFault`.
"""


@dataclass(frozen=True, slots=True)
class PhaseStep:
    """The command of one cycle."""

    phase: Phase
    """The current phase. In `move` the caller moves the arm, else the twist does."""
    twist: NDArray[np.float64]
    """Sensor twist [v; ω], (6,), m/s and rad/s, in the sensor's frame."""
    outcome: Outcome | None
    """The result, as soon as it is decided. The pad then backs off, and the phase becomes `ended`.
    In `move`, only an overload makes the pad back off."""
    clear: bool
    """Whether the sensor reports no contact. False if the sensor is faulty."""
