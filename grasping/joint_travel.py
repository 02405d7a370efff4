"""Compare how far each joint of an arm moves with its command."""

from __future__ import annotations

from collections import deque
from typing import TYPE_CHECKING, NamedTuple

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
MOVES = 0.002
"""Rotation within `LATE` above which a joint moves, rad. One that stands still does not stray: an
arm that freezes in a motion is behind, also where its command turns back."""
HELD_BACK, BLOCKED_SHARE = 0.05, 0.25
"""A joint is held back if it is behind by more than this angle, rad, beyond what twice `LATE`
explains, and moved less than this share of its command within the last `LATE` seconds. Messages of
a network that bunch add to the delay."""
SLOW_SHARE = 0.8
"""An arm is slow if a joint moves less than this share of its command, beyond what `LATE` explains.
Some arms scale all speeds."""
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
        self.held_seconds = 0.0
        """Time for which something has held a joint back while others moved, s."""
        self.slow = ""
        """Which joint last moved less than commanded over a whole window; empty if none."""
        self._held = 0
        self._recent: deque[_Step] = deque()

    def restart(self) -> None:
        """Start all windows anew, for a new motion."""
        self._start, self._start_speed = self._last, self._fastest()
        self._commanded, self.held_back = np.zeros_like(self._start), ""
        self.held_seconds = 0.0

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
        before, self._last = self._last, np.array(q)
        self._commanded = self._commanded + seconds * velocity
        travel, moved = np.abs(self._commanded), q - self._start
        self._time += seconds
        self._recent.append(_Step(self._time, seconds * velocity, np.abs(velocity), before))
        while self._recent[0].time < self._time - LATE:
            self._recent.popleft()
        fastest = self._fastest()
        slack = LATE * (self._start_speed + fastest)
        back = -moved * np.sign(self._commanded)
        against = (travel > MIN_TRAVEL) & (back > BACK_SHARE * travel + slack)
        too_far = np.abs(moved) > FAR_SHARE * travel + FAR_MARGIN + slack
        strays = (against | too_far) & (np.abs(q - self._recent[0].start) > MOVES)
        if strays.any():
            k = int(np.argmax(strays))
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
        done = travel > WINDOW
        self._note_delay(q, behind, done, joints)
        moves = (np.abs(q - self._recent[0].start) > MOVES).any()
        self.held_seconds = self.held_seconds + seconds if self.held_back and moves else 0.0
        self._start = np.where(done, q, self._start)
        self._start_speed = np.where(done, fastest, self._start_speed)
        self._commanded = np.where(done, 0.0, self._commanded)
        return ""

    def _note_delay(
        self,
        q: NDArray[np.float64],
        behind: NDArray[np.float64],
        done: NDArray[np.bool_],
        joints: tuple[str, ...],
    ) -> None:
        """Note which joint is held back, and which is slow, from their delays (n,), rad."""

        def numbers(k: int) -> str:
            moved = q[k] - self._start[k]
            return f"it moved {moved:.2f} of {self._commanded[k]:.2f} rad commanded"

        blocked = self._blocked(q)
        held = np.where(blocked, behind, 0.0)
        k = int(np.argmax(held))
        # A new window does not free a joint.
        if not blocked[self._held]:
            self.held_back = ""
        # `behind` leaves out one `LATE`.
        if held[k] > HELD_BACK + LATE * (self._start_speed + self._fastest())[k]:
            self._held = k
            self.held_back = (
                f"something holds joint {joints[k]} back: {numbers(k)}. It may touch something, or "
                "the driver is slow: it must take rad/s, and add to the last command, not to the "
                "measured angle"
            )
        late = np.where(done, behind / np.maximum(np.abs(self._commanded), WINDOW), 0.0)
        k = int(np.argmax(late))
        if late[k] > 1.0 - SLOW_SHARE:
            self.slow = f"joint {joints[k]} is slow: {numbers(k)}"

    def _blocked(self, q: NDArray[np.float64]) -> NDArray[np.bool_]:
        """Return which joints have hardly moved within the last `LATE` seconds, (n,)."""
        commanded = np.sum([step.command for step in self._recent], axis=0)
        moved = np.sign(commanded) * (q - self._recent[0].start)
        return moved < BLOCKED_SHARE * np.abs(commanded)

    def _fastest(self) -> NDArray[np.float64]:
        """Return the greatest commanded speed of each joint within the last `LATE` seconds."""
        return np.max([step.speed for step in self._recent], axis=0, initial=0.0)


class _Step(NamedTuple):
    """One control period."""

    time: float
    """Time at its end, s."""
    command: NDArray[np.float64]
    """Commanded rotation, (n,), rad."""
    speed: NDArray[np.float64]
    """Commanded speed, (n,), rad/s."""
    start: NDArray[np.float64]
    """Joint angles at its start, (n,), rad."""
