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
RETURNS = 0.01
"""Rotation after which a joint that was held back has moved, rad."""
SLOW_SHARE = 0.8
"""An arm is slow if a joint moves less than this share of its command, beyond what `LATE` explains.
Some arms scale all speeds."""
AGAINST = (
    "moves against its command: {}; check the sign, and whether the arm or the hand touches "
    "something"
)
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
        self._time, self._owed = 0.0, np.zeros(len(q))
        self._recent: deque[_Step] = deque()
        self.returning: HeldJoint | None = None
        """A joint that was held back, and that must move now."""
        self.tolerance = np.full(len(q), HELD_BACK)
        """Angle by which a joint may be behind, (n,), rad."""
        self.due = False
        """Whether the commands are those that the joints should show now: the delay is known."""
        self.pause(q)

    def pause(self, q: NDArray[np.float64]) -> None:
        """Start anew at joint angles (n,), to which someone may have moved the resting arm."""
        self._recent.clear()
        self._start = self._last = np.array(q)
        self._commanded, self._start_speed = np.zeros(len(q)), np.zeros(len(q))
        self.held: HeldJoint | None = None
        """The joint that something holds back, if any."""
        self.slow = ""
        """Which joint last moved less than commanded over a whole window; empty if none."""

    def restart(
        self, levers: NDArray[np.float64] | None = None, returning: HeldJoint | None = None
    ) -> None:
        """Start all windows anew, for a new motion.

        With ``levers`` (n,), the motion of the hand per joint motion, m, a joint may be behind only
        as far as the hand may depart from its path. The joint ``returning`` was held back, and must
        move now.
        """
        if returning is not None:
            owed = float(self._owed[returning.joint]) * returning.side
            returning = returning._replace(behind=max(returning.behind, owed))
        self.returning = returning
        self.tolerance = np.full_like(self._start, HELD_BACK)
        if levers is not None:
            self.tolerance = HELD_BACK / np.maximum(levers * HELD_BACK / HAND_OFF, 1.0)
        self._start, self._start_speed = self._last, self._fastest()
        self._commanded, self.held = np.zeros_like(self._start), None

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
        self._owed = self._owed + seconds * velocity - (q - before)
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
            done, asked = np.round([moved[k], self._commanded[k]], 2) + 0.0  # -0.0 prints as -0
            numbers = f"it moved {done:g} rad, and the command was {asked:g} rad"
            if too_far[k]:
                return (
                    f"joint {joints[k]} moves farther than commanded: {numbers}; "
                    "check that the driver takes rad/s for one period and limits no speed, and "
                    "whether the arm or the hand touches something"
                )
            return f"joint {joints[k]} {AGAINST.format(numbers)}"
        if fault := self._returns(moved, slack):
            return fault
        behind = np.sign(self._commanded) * (self._commanded - moved)
        done = travel > WINDOW
        self._note_delay(q, behind, done, joints)
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

        commanded = np.sum([step.command for step in self._recent], axis=0)
        share = (q - self._recent[0].start) / np.where(commanded == 0.0, np.inf, commanded)
        blocked = (share < BLOCKED_SHARE) & (commanded != 0.0)
        drives = np.abs(commanded) > FOLLOWS
        follows = drives & (share > 1.0 - BLOCKED_SHARE)
        self._owed = np.where(follows, 0.0, self._owed)
        follow = follows.any()
        speed = self._start_speed + self._fastest()
        # A new window does not free a joint.
        if self.held is not None and not blocked[self.held.joint]:
            self.held = None
        allowed = self.tolerance + (0.0 if self.due and follow else 2.0 * LATE * speed)
        excess = np.where(blocked, behind - allowed, -1.0)
        k = int(np.argmax(excess))
        if excess[k] > 0.0:
            side = float(np.sign(self._commanded[k]))
            alone = bool(follow or drives.sum() <= drives[k])
            self.held = HeldJoint(k, joints[k], side, float(behind[k]), alone, numbers(k))
        late = (behind - LATE * speed) / np.maximum(np.abs(self._commanded), WINDOW)
        # A joint that stands still is not slow.
        late = np.where(done & ~blocked, late, 0.0)
        k = int(np.argmax(late))
        if late[k] > 1.0 - SLOW_SHARE:
            self.slow = f"joint {joints[k]} is slow: {numbers(k)}"

    def _returns(self, moved: NDArray[np.float64], slack: NDArray[np.float64]) -> str:
        """Note whether a joint that was held back moves; return why it is a fault, or "".

        Some drivers add up the commands while something blocks the joint. It then returns only
        after as much command as it was behind. If it was behind in another motion, it moves on.
        """
        held = self.returning
        if held is None:
            return ""
        k = held.joint
        back = -held.side * moved[k]
        if back > RETURNS:
            self.returning = None
        elif back < -RETURNS:
            return f"joint {held.name} {AGAINST.format(held.numbers)}"
        elif abs(self._commanded[k]) > held.behind + HELD_BACK + slack[k]:
            if held.turned:
                return (
                    f"joint {held.name} does not follow: {held.numbers}, and it moves neither back "
                    "nor on; its drive or its brake has failed, or something holds it"
                )
            self.restart(returning=held._replace(side=-held.side, turned=True))
        return ""

    def _fastest(self) -> NDArray[np.float64]:
        """Return the greatest commanded speed of each joint within the last `LATE` seconds."""
        return np.max([step.speed for step in self._recent], axis=0, initial=0.0)


class HeldJoint(NamedTuple):
    """A joint that something holds back."""

    joint: int
    """Index of the joint."""
    name: str
    """Name of the joint."""
    side: float
    """Sign of its command."""
    behind: float
    """Angle by which it is behind, rad."""
    alone: bool
    """Whether the other joints follow, so that no message is late."""
    numbers: str
    """How far it moved, and how far it was commanded."""
    turned: bool = False
    """Whether it did not move back, so that it is commanded on."""

    @property
    def reason(self) -> str:
        """Why it ends a motion."""
        return (
            f"something holds joint {self.name} back: {self.numbers}. It may touch something, or "
            "the driver is slow: it must take rad/s, and add to the last command, not to the "
            "measured angle"
        )


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
