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
"""A joint is held back if it is behind by more than this angle, rad, and moved less than this share
of its command within the last `LATE` seconds. If no other joint follows, or the delay of the arm is
not known, it is behind by more than twice `LATE` explains in addition: messages of a network that
bunch add to the delay."""
HAND_OFF = 0.015
"""Distance by which a joint that is held back may move the hand off its path in free space, m."""
FOLLOWS = 0.01
"""Commanded rotation within `LATE` from which a joint shows that messages arrive, rad."""
STANDS = 0.01
"""Rotation above which a joint that was held back moves again, rad."""
SLOW_SHARE = 0.8
"""An arm is slow if a joint moves less than this share of its command, beyond what `LATE` explains.
Some arms scale all speeds."""
CAUSES = "its drive or its brake has failed, or something holds it"
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
        self.held_alone = False
        """Whether the other joints follow, so that no message is late."""
        self.slow = ""
        """Which joint last moved less than commanded over a whole window; empty if none."""
        self._held = 0
        self._stop: _Stop | None = None
        self._recent: deque[_Step] = deque()
        self.tolerance = np.full_like(self._start, HELD_BACK)
        """Angle by which a joint may be behind, (n,), rad."""
        self.due = False
        """Whether the commands are those that the joints should show now: the delay is known."""

    def pause(self, q: NDArray[np.float64]) -> None:
        """Start anew at joint angles (n,), to which someone may have moved the resting arm."""
        stop, tolerance, due = self._stop, self.tolerance, self.due
        JointTravel.__init__(self, q)
        self._stop, self.tolerance, self.due = stop, tolerance, due

    def restart(self, levers: NDArray[np.float64] | None = None) -> None:
        """Start all windows anew, for a new motion.

        With ``levers`` (n,), the motion of the hand per joint motion, m, a joint may be behind only
        as far as the hand may depart from its path.
        """
        self.tolerance = np.full_like(self._start, HELD_BACK)
        if levers is not None:
            self.tolerance = HELD_BACK / np.maximum(levers * HELD_BACK / HAND_OFF, 1.0)
        self._start, self._start_speed = self._last, self._fastest()
        self._commanded, self.held_back = np.zeros_like(self._start), ""
        if self._stop is not None:
            self._stop = self._stop._replace(path=max(self._stop.path, 0.0))

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
            Commanded velocities, (n,), rad/s. If the delay is known, those that are due now.
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
        behind = np.sign(self._commanded) * (self._commanded - moved)
        done = travel > WINDOW
        if stands := self._note_delay(q, behind, done, joints) or self._stands(
            q, velocity, seconds
        ):
            return f"joint {joints[self._held]} does not follow: {stands}"
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
    ) -> str:
        """Note which joint is held back, and which is slow, from their delays (n,), rad.

        Return why a joint that is held back again does not follow; empty if none.
        """

        def numbers(k: int) -> str:
            moved = q[k] - self._start[k]
            return f"it moved {moved:.2f} of {self._commanded[k]:.2f} rad commanded"

        commanded = np.sum([step.command for step in self._recent], axis=0)
        share = (q - self._recent[0].start) / np.where(commanded == 0.0, np.inf, commanded)
        blocked = (share < BLOCKED_SHARE) & (commanded != 0.0)
        drives = np.abs(commanded) > FOLLOWS
        follow = (drives & (share > 1.0 - BLOCKED_SHARE)).any()
        speed = self._start_speed + self._fastest()
        # A new window does not free a joint.
        if not blocked[self._held]:
            self.held_back = ""
        allowed = self.tolerance + (0.0 if self.due and follow else 2.0 * LATE * speed)
        if self._stop is not None and self._stop.path >= 0.0:
            allowed[self._stop.joint] *= 0.5
        excess = np.where(blocked, behind - allowed, -1.0)
        k = int(np.argmax(excess))
        if excess[k] > 0.0:
            self.held_alone = bool(follow or drives.sum() <= drives[k])
            self._held = k
            self.held_back = (
                f"something holds joint {joints[k]} back: {numbers(k)}. It may touch something, or "
                "the driver is slow: it must take rad/s, and add to the last command, not to the "
                "measured angle"
            )
            side = float(np.sign(self._commanded[k]))
            last = self._stop
            if last is None or last.joint != k:
                self._stop = _Stop(k, q[k], side, behind[k], -np.inf)
            elif last.path >= 0.0 and side == last.side:
                return f"{numbers(k)}, and it did not move in the motion before; {CAUSES}"
        late = (behind - LATE * speed) / np.maximum(np.abs(self._commanded), WINDOW)
        # A joint that stands still is not slow.
        late = np.where(done & ~blocked, late, 0.0)
        k = int(np.argmax(late))
        if late[k] > 1.0 - SLOW_SHARE:
            self.slow = f"joint {joints[k]} is slow: {numbers(k)}"
        return ""

    def _stands(self, q: NDArray[np.float64], velocity: NDArray[np.float64], seconds: float) -> str:
        """Return why a joint does not follow that was held back in a motion before; or "".

        Some drivers add up the commands while something blocks the joint. It may then return only
        after as much command as it was behind.
        """
        stop = self._stop
        if stop is None:
            return ""
        if abs(q[stop.joint] - stop.angle) > STANDS:
            self._stop = None
            return ""
        path = stop.path + seconds * abs(velocity[stop.joint])
        self._stop = stop._replace(path=path)
        slack = LATE * (self._start_speed + self._fastest())
        if path < stop.behind + HELD_BACK + slack[stop.joint]:
            return ""
        self._held = stop.joint
        return f"it stands since the motion before, {path:.2f} rad were commanded; {CAUSES}"

    def _fastest(self) -> NDArray[np.float64]:
        """Return the greatest commanded speed of each joint within the last `LATE` seconds."""
        return np.max([step.speed for step in self._recent], axis=0, initial=0.0)


class _Stop(NamedTuple):
    """A joint that something held back, and that has not moved since."""

    joint: int
    """Index of the joint."""
    angle: float
    """Angle at which it stands, rad."""
    side: float
    """Sign of its command then."""
    behind: float
    """Angle by which it was behind, rad."""
    path: float
    """Commanded rotation in the motions since, rad; -inf in the same motion."""


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
