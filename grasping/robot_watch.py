"""Watch a robot while it moves: lost devices, and an arm that does not follow its commands."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager, suppress
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from eyehand.errors import EyehandError

from .robot import RobotReading

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from .hands import AnyCommand
    from .robot import Robot

STALE_SECONDS = 0.3
"""Time without a new state of the arm after which it counts as stopped, s. It is ten times the
delay of a slow network."""
STOPPED_SECONDS = 0.6
"""Time for which the arm must stand still against its command to count as stopped, s."""
MIN_COMMAND = 0.05
"""Norm of the commanded velocities above which a standing arm does not follow, rad/s."""
FOLLOW_SHARE = 0.05
"""Share of the commanded path below which the arm does not follow."""
OPPOSITE = 0.1
"""Commanded rotation of a joint after which its direction is judged, rad."""
OPPOSITE_SHARE, LATE = 0.5, 0.05
"""A joint moves backwards if it turns by more than this share of its command and this margin, rad,
against it. The margin covers a late joint that reverses."""
JUDGED = 0.6
"""Commanded rotation of a joint after which it is judged anew, rad."""
FAR_SHARE, FAR_MARGIN = 1.5, 0.3
"""A joint moves too far if it moves farther than this share of its command and this margin, rad.
The margin covers a joint that is 0.1 s late at 3 rad/s."""
LONGEST_STEP = 10
"""Number of periods for which the arm may go on with one command."""
CLOCK_SHARE, CLOCK_CYCLES = 100, 5
"""Number of successive steps, each of which takes this many periods by the arm's clock, after which
the clock is in a wrong unit. Planning takes as long between two steps, but not five times."""


class RobotWatch:
    """Steps a robot, and reports as `RobotReading.fault` what the robot does not report itself.

    These are errors of a driver, readings that are not finite, an arm whose state does not change
    any more, and an arm that does not follow its commands, moves farther or moves against them.
    After a fault the arm is commanded to stand still.

    Parameters
    ----------
    reading
        State of the robot before its first step.
    """

    def __init__(self, reading: RobotReading) -> None:
        self.reading = reading
        """Last state of the robot."""
        self._stale, self._long = 0.0, 0
        self._since: float | None = None
        self._start_q = self._path = np.zeros_like(reading.q)
        self._turn_q, self._shift = np.array(reading.q), np.zeros_like(reading.q)

    def step(
        self, robot: Robot, velocity: NDArray[np.float64], command: AnyCommand | None
    ) -> RobotReading:
        """Move for one period, as `Robot.step`, and return the state at its end."""
        if self.reading.fault:
            return self.reading
        try:
            reading = robot.step(velocity, command)
            fault = getattr(reading, "fault", "") or self._doubt(reading, velocity, robot)
        except Exception as error:
            # A driver raises what its library raises, often a RuntimeError.
            reading, fault = self.reading, f"the robot's driver failed: {one_line(error)}"
        if not _usable(reading, len(self._path)):
            reading = self.reading
        self.reading = replace(reading, fault=fault)
        if fault:
            stop(robot)
        return self.reading

    def _doubt(self, reading: RobotReading, velocity: NDArray[np.float64], robot: Robot) -> str:
        """Return what is wrong with a new state; empty if nothing."""
        if not _usable(reading, len(velocity)):
            return (
                f"robot.step() must return a RobotReading with {len(velocity)} finite joint "
                f"angles, got {getattr(reading, 'q', reading)}"
            )
        period, passed = robot.period, reading.time - self.reading.time
        # A driver may take longer than a period, while the arm goes on.
        lasted = min(max(passed, period), LONGEST_STEP * period)
        if strayed := self._strayed(reading, lasted * velocity, robot.joints):
            return strayed
        self._stale = self._stale + period if passed <= 0.0 else 0.0
        if self._stale > STALE_SECONDS:
            return f"the arm has sent no new state for {self._stale:.1f} s"
        self._long = self._long + 1 if passed > CLOCK_SHARE * period else 0
        if self._long >= CLOCK_CYCLES:
            return (
                f"the arm's clock advances by {passed:.4g} s in a period of {period:g} s; "
                "write the times in s"
            )
        if np.linalg.norm(velocity) < MIN_COMMAND:
            self._since = None
            return ""
        if self._since is None:
            self._since, self._start_q = reading.time, np.array(reading.q)
            self._path = np.zeros_like(velocity)
        self._path = self._path + period * np.abs(velocity)
        if reading.time - self._since < STOPPED_SECONDS:
            return ""
        self._since = None
        path = float(np.linalg.norm(self._path))
        distance = float(np.linalg.norm(reading.q - self._start_q))
        if distance < FOLLOW_SHARE * path:
            return f"the arm does not follow: it moved {distance:.3f} rad of {path:.2f} commanded"
        return ""

    def _strayed(
        self, reading: RobotReading, shift: NDArray[np.float64], joints: tuple[str, ...]
    ) -> str:
        """Compare the way of each joint with its command, however slowly that is commanded."""
        self._shift = self._shift + shift
        way, moved = np.abs(self._shift), reading.q - self._turn_q
        back = -moved * np.sign(self._shift)
        against = (way > OPPOSITE) & (back > OPPOSITE_SHARE * way + LATE)
        too_far = np.abs(moved) > FAR_SHARE * way + FAR_MARGIN
        if (against | too_far).any():
            k = int(np.argmax(against | too_far))
            numbers = f"it moved {moved[k]:.2f} rad, commanded were {self._shift[k]:.2f}"
            if too_far[k]:
                return (
                    f"joint {joints[k]} moves farther than commanded: {numbers}; "
                    "check that the driver takes rad/s, for one period"
                )
            return (
                f"joint {joints[k]} moves against its command: {numbers}; "
                "check the sign, and whether the arm or the hand touches something"
            )
        self._turn_q = np.where(way > JUDGED, reading.q, self._turn_q)
        self._shift = np.where(way > JUDGED, 0.0, self._shift)
        return ""


@contextmanager
def stopped_at_error(robot: Robot) -> Iterator[None]:
    """Command the arm to stand still before an error or Ctrl-C leaves the block."""
    try:
        yield
    except BaseException:
        stop(robot)
        raise


def stop(robot: Robot) -> None:
    """Command the arm to stand still for one period, whatever its driver raises."""
    with suppress(Exception):
        robot.step(np.zeros(len(robot.joints)), None)


def _usable(reading: object, count: int) -> bool:
    return (
        isinstance(reading, RobotReading)
        and np.shape(reading.q) == (count,)
        and bool(np.isfinite(reading.q).all())
    )


def one_line(error: BaseException) -> str:
    """Return the message of an error in one line. Only errors of devices need no type."""
    text = " ".join(str(error).split())
    if text and isinstance(error, EyehandError | OSError | EOFError):
        return text
    return f"{type(error).__name__}: {text}".removesuffix(": ")
