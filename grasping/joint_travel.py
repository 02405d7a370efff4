"""Compare how far each joint of an arm moves with its command."""

from __future__ import annotations

from collections import deque
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray

LATE = 0.06
"""Time by which the arm may follow late, s. Networks add 0.005 to 0.03 s."""
MIN_TRAVEL = 0.1
"""Commanded rotation of a joint from which its direction is judged, rad."""
BACK_SHARE = 0.5
"""A joint moves against its command if it turns back by more than this share of the command, beyond
what `LATE` explains."""
FAR_SHARE, FAR_MARGIN = 1.5, 0.1
"""A joint moves too far if it turns by more than this share of the command and this margin, rad,
beyond what `LATE` explains."""
HELD_BACK = 0.05
"""Angle beyond what `LATE` explains by which a joint that something holds back is behind, rad."""
WINDOW = 0.6
"""Commanded rotation of a joint after which it is judged anew, rad."""


class JointTravel:
    """Judges each joint of an arm in windows of its commanded rotation.

    A late arm is behind at the start of a window and at its end, each time by its speed times its
    delay. Neither is a fault. Each motion starts all windows anew: a contact that moved
    a joint in one motion is no fault of the next.

    Parameters
    ----------
    q
        Joint angles of the resting arm, (n,), rad.
    """

    def __init__(self, q: NDArray[np.float64]) -> None:
        self._start = np.array(q)
        self._commanded, self._start_speed = np.zeros_like(self._start), np.zeros_like(self._start)
        self._time, self._last = 0.0, self._start
        self.held_back = ""
        """Which joint something holds back, and how far it is behind; empty if none."""
        self._speeds: deque[tuple[float, NDArray[np.float64]]] = deque()

    def restart(self) -> None:
        """Start all windows anew, for a new motion."""
        self._start, self._start_speed = self._last, self._fastest()
        self._commanded, self.held_back = np.zeros_like(self._start), ""

    def check(
        self,
        q: NDArray[np.float64],
        velocity: NDArray[np.float64],
        seconds: float,
        joints: tuple[str, ...],
    ) -> str:
        """Return which joint strays from its command; empty if none does.

        Parameters
        ----------
        q
            Joint angles after the command, (n,), rad.
        velocity
            Commanded velocities, (n,), rad/s.
        seconds
            Time for which the arm had them, s.
        joints
            Names of the joints.
        """
        self._last = np.array(q)
        self._commanded = self._commanded + seconds * velocity
        travel, moved = np.abs(self._commanded), q - self._start
        self._time += seconds
        self._speeds.append((self._time, np.abs(velocity)))
        while self._speeds[0][0] < self._time - LATE:
            self._speeds.popleft()
        fastest = self._fastest()
        slack = LATE * (self._start_speed + fastest)
        back = -moved * np.sign(self._commanded)
        against = (travel > MIN_TRAVEL) & (back > BACK_SHARE * travel + slack)
        too_far = np.abs(moved) > FAR_SHARE * travel + FAR_MARGIN + slack
        if (against | too_far).any():
            k = int(np.argmax(against | too_far))
            numbers = f"it moved {moved[k]:.2f} rad, commanded were {self._commanded[k]:.2f}"
            if too_far[k]:
                return (
                    f"joint {joints[k]} moves farther than commanded: {numbers}; "
                    "check that the driver takes rad/s for one period and limits no speed, and "
                    "whether the arm or the hand touches something"
                )
            return (
                f"joint {joints[k]} moves against its command: {numbers}; "
                "check the sign, and whether the arm or the hand touches something"
            )
        behind = np.sign(self._commanded) * (self._commanded - moved) - slack
        k = int(np.argmax(behind))
        self.held_back = ""
        if velocity.any() and behind[k] > HELD_BACK:
            self.held_back = (
                f"something holds joint {joints[k]} back: it moved {moved[k]:.2f} of "
                f"{self._commanded[k]:.2f} rad commanded. It may touch something, or the driver is "
                "slow: it must take rad/s, and add to the last command, not to the measured angle"
            )
        done = travel > WINDOW
        self._start = np.where(done, q, self._start)
        self._start_speed = np.where(done, fastest, self._start_speed)
        self._commanded = np.where(done, 0.0, self._commanded)
        return ""

    def _fastest(self) -> NDArray[np.float64]:
        """Return the greatest commanded speed of each joint within the last `LATE` seconds."""
        return np.max([speeds for _, speeds in self._speeds], axis=0, initial=0.0)
