"""Watch a robot while it moves: lost devices, and an arm that does not follow its commands."""

from __future__ import annotations

from contextlib import suppress
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from eyehand.errors import DeviceError

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
"""Commanded rotation of a joint after which its direction is judged, rad. A delayed joint that
reverses at 1 rad/s can be 0.06 rad behind."""
OPPOSITE_SHARE = 0.5
"""Share of the commanded rotation by which a joint moves backwards if a sign is wrong."""
DRIVER_ERRORS = (DeviceError, OSError, EOFError)
"""Exceptions by which a driver reports that it lost its device. TimeoutError is an OSError."""


class RobotWatch:
    """Steps a robot, and reports as `RobotReading.fault` what the robot does not report itself.

    These are errors of a driver, readings that are not finite, an arm whose state does not change
    any more, and an arm that does not follow its commands or moves against them. After a fault
    the arm is commanded to stand still.

    Parameters
    ----------
    reading
        State of the robot before its first step.
    """

    def __init__(self, reading: RobotReading) -> None:
        self.reading = reading
        """Last state of the robot."""
        self._stale = 0.0
        self._since: float | None = None
        self._start_q = self._path = np.zeros_like(reading.q)
        self._turn_q, self._shift = np.array(reading.q), np.zeros_like(reading.q)

    def step(
        self, robot: Robot, velocity: NDArray[np.float64], command: AnyCommand | None
    ) -> RobotReading:
        """Move for one period, as `Robot.step`, and return the state at its end."""
        if self.reading.fault:
            return self.reading
        still = np.zeros_like(self._path)
        try:
            reading = robot.step(velocity, command)
            fault = getattr(reading, "fault", "") or self._doubt(reading, velocity, robot)
        except DRIVER_ERRORS as error:
            reading, fault = self.reading, f"the robot's driver failed: {one_line(error)}"
        if not _usable(reading, len(still)):
            reading = self.reading
        self.reading = replace(reading, fault=fault)
        if fault:
            with suppress(*DRIVER_ERRORS):
                robot.step(still, None)
        return self.reading

    def _doubt(self, reading: RobotReading, velocity: NDArray[np.float64], robot: Robot) -> str:
        """Return what is wrong with a new state; empty if nothing."""
        if not _usable(reading, len(velocity)):
            return (
                f"robot.step() must return a RobotReading with {len(velocity)} finite joint "
                f"angles, got {getattr(reading, 'q', reading)}"
            )
        if turned := self._turned_back(reading, robot.period * velocity, robot.joints):
            return turned
        period = robot.period
        self._stale = self._stale + period if reading.time <= self.reading.time else 0.0
        if self._stale > STALE_SECONDS:
            return f"the arm has sent no new state for {self._stale:.1f} s"
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

    def _turned_back(
        self, reading: RobotReading, shift: NDArray[np.float64], joints: tuple[str, ...]
    ) -> str:
        """Judge each joint after `OPPOSITE` of command, however slowly that is commanded."""
        self._shift = self._shift + shift
        judged = np.abs(self._shift) > OPPOSITE
        moved = reading.q - self._turn_q
        against = judged & (moved * self._shift < -OPPOSITE_SHARE * self._shift**2)
        if against.any():
            k = int(np.argmax(against))
            return (
                f"joint {joints[k]} moves against its command: it moved {moved[k]:.2f} rad, "
                f"commanded were {self._shift[k]:.2f}; check the sign"
            )
        self._turn_q = np.where(judged, reading.q, self._turn_q)
        self._shift = np.where(judged, 0.0, self._shift)
        return ""


def _usable(reading: object, count: int) -> bool:
    return (
        isinstance(reading, RobotReading)
        and np.shape(reading.q) == (count,)
        and bool(np.isfinite(reading.q).all())
    )


def one_line(error: BaseException) -> str:
    """Return the message of an error in one line, or its type."""
    return " ".join(str(error).split()) or type(error).__name__
