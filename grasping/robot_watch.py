"""Watch a robot while it moves: lost devices, and an arm that does not follow its commands."""

from __future__ import annotations

import logging
import time
from contextlib import suppress
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from eyehand.errors import EyehandError

from .follow_delay import MAX_DELAY, FollowDelay
from .hands import HandReading, JawReading
from .joint_travel import JointTravel
from .robot import RobotReading

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from .hands import AnyCommand, AnyReading
    from .joint_travel import HeldJoint
    from .robot import Robot

STALE_SECONDS = 0.3
"""Time without a new state of the arm, or without a finite one of the hand, after which it counts
as stopped, s. It is ten times the delay of a slow network."""
STOPPED_SECONDS = 0.6
"""Time for which the arm must stand still against its command to count as stopped, s."""
MIN_COMMAND = 0.05
"""Norm of the commanded velocities above which a standing arm does not follow, rad/s."""
FOLLOW_SHARE = 0.05
"""Share of the commanded path below which the arm does not follow."""
LONGEST_STEP = 25
"""Number of periods for which the arm may go on with one command."""
PAUSE_SECONDS = 1.0
"""Time between two steps after which someone may have moved the arm by hand, s."""
SLOW_SHARE, SLOW_CYCLES = 2, 20
"""Number of successive steps, each longer than this many periods, after which a slow driver is
named. The limits of the acceleration hold for the period."""
CLOCK_SHARE, CLOCK_RATIO, CLOCK_CYCLES = 100, 10, 2
"""Number of successive steps, each longer than this many periods and so many times as long as on
this computer's clock, after which the arm's clock is in a wrong unit. More steps would end the
first motion, because its time is over. A clock that is corrected jumps once."""

_log = logging.getLogger("eyehand")


class RobotWatch:
    """Steps a robot, and reports as `RobotReading.fault` what the robot does not report itself.

    These are errors of a driver, readings that are not finite, an arm whose state does not change
    any more, and an arm that does not follow its commands, moves farther or moves against them.
    After a fault the arm brakes within its limits. The next command is 0 at once if the arm has
    stopped itself or stands still, or if a joint strays from its command: it may not brake either.

    Parameters
    ----------
    reading
        State of the robot before its first step.
    acceleration
        Maximum accelerations of the joints, (n,), rad/s².
    """

    def __init__(self, reading: RobotReading, acceleration: NDArray[np.float64]) -> None:
        self.reading = reading
        """Last state of the robot."""
        self._acceleration, self._velocity = acceleration, np.zeros_like(acceleration)
        self._stale, self._blind, self._slow, self._long = 0.0, 0.0, 0, 0
        self._since: float | None = None
        self._newest, self._stepped = reading.time, time.monotonic()
        self._start_q = self._path = np.zeros_like(reading.q)
        self._travel, self._warned = JointTravel(reading.q), False
        self._delay = FollowDelay()

    def begin_motion(
        self, levers: NDArray[np.float64] | None = None, returning: HeldJoint | None = None
    ) -> None:
        """Compare the joints with their commands from the present state on.

        In free space ``levers`` (n,) is the motion of the hand per joint motion, m. If a joint is
        ``returning``, it was held back, and it is a fault if it does not move now.
        """
        self._travel.restart(levers, returning)

    @property
    def held(self) -> HeldJoint | None:
        """The joint that something holds back, if any."""
        return self._travel.held

    @property
    def returning(self) -> HeldJoint | None:
        """A joint that was held back and must move against its side; None once it does."""
        return self._travel.returning

    def expected_q(self) -> NDArray[np.float64]:
        """Return where the last commands lead the joints after the arm's delay, (n,), rad."""
        return self.reading.q + self._delay.pending()

    def step(
        self, robot: Robot, velocity: NDArray[np.float64], command: AnyCommand | None
    ) -> RobotReading:
        """Move for one period, as `Robot.step`, and return the state at its end."""
        if self.reading.fault:
            return self.reading
        self._velocity = velocity
        try:
            reading, fault = robot.step(velocity, command), ""
        except Exception as error:
            # A driver raises what its library raises, often a RuntimeError.
            _log.debug("the robot's driver failed", exc_info=True)
            reading, fault = self.reading, f"the robot's driver failed: {one_line(error)}"
        if stopped := getattr(reading, "fault", ""):
            self._velocity = np.zeros_like(velocity)
        fault = fault or stopped or self._doubt(reading, velocity, robot)
        if not _usable(reading, len(self._path)):
            reading = self.reading
        elif not _finite(reading.hand):
            reading = replace(reading, hand=self.reading.hand)
        self.reading = replace(reading, fault=fault)
        if fault:
            self.stop(robot)
        return self.reading

    def _due(
        self, q: NDArray[np.float64], velocity: NDArray[np.float64], seconds: float
    ) -> NDArray[np.float64]:
        """Note the delay of the arm; return the velocities (n,) that it should have now, rad/s."""
        known = self._delay.known
        due = self._delay.add(q, velocity, seconds) / seconds
        if self._delay.known and not known:
            self._travel.pause(q)
            self._travel.due = True
        if not known and self._delay.seconds > MAX_DELAY:
            _log.warning(
                "the arm follows its commands %.0f ms late; up to %.0f ms are expected",
                1e3 * self._delay.seconds,
                1e3 * MAX_DELAY,
            )
        return due

    def stop(self, robot: Robot) -> None:
        """Brake the arm, whatever its driver raises.

        A driver that raises may have passed the command on: only its hand may have failed. One that
        takes longer than `STALE_SECONDS` gets no more commands.
        """
        change = self._acceleration * robot.period
        try:
            while (np.abs(self._velocity) > change).any():
                self._velocity = self._velocity - np.clip(self._velocity, -change, change)
                began = time.monotonic()
                try:
                    robot.step(self._velocity, None)
                except Exception:
                    passed = time.monotonic() - began
                    if passed > STALE_SECONDS:
                        break
                    time.sleep(max(robot.period - passed, 0.0))
        finally:
            # Also after a second Ctrl-C, while the arm brakes.
            self._velocity = np.zeros_like(change)
            with suppress(Exception):
                robot.step(self._velocity, None)

    def _doubt(self, reading: RobotReading, velocity: NDArray[np.float64], robot: Robot) -> str:
        """Return what is wrong with a new state; empty if nothing."""
        if not _usable(reading, len(velocity)):
            got = " ".join(str(getattr(reading, "q", reading)).split())
            return (
                f"robot.step() must return a RobotReading with {len(velocity)} finite joint "
                f"angles, got {got}"
            )
        # After a newer state an older one may arrive. No time passes with it.
        period, passed = robot.period, reading.time - self._newest
        self._newest = max(self._newest, reading.time)
        if passed > STALE_SECONDS and np.linalg.norm(velocity) > MIN_COMMAND:
            _log.warning(
                "a step took %.2g s while the arm moved: it must stop by itself when no command "
                "comes",
                passed,
            )
        if passed > PAUSE_SECONDS:
            self._travel.pause(reading.q)
        # A driver may take longer than a period, while the arm goes on.
        if passed > 0.0:
            seconds = min(passed, LONGEST_STEP * period)
            due = self._due(reading.q, velocity, seconds)
            if strayed := self._travel.check(reading.q, due, seconds, robot.joints):
                self._velocity = np.zeros_like(velocity)
                return strayed
        if self._travel.slow and not self._warned:
            self._warned = True
            _log.warning("%s; check the driver's unit and its limit of speed", self._travel.slow)
        self._blind = 0.0 if _finite(reading.hand) else self._blind + period
        if self._blind > STALE_SECONDS:
            return f"the hand has sent no finite reading for {self._blind:.1f} s"
        self._stale = self._stale + period if passed <= 0.0 else 0.0
        if self._stale > STALE_SECONDS:
            return f"the arm has sent no new state for {self._stale:.1f} s"
        self._slow = self._slow + 1 if passed > SLOW_SHARE * period else 0
        if self._slow == SLOW_CYCLES:
            _log.warning("a step takes %.3g s, robot.period is %.3g s: correct it", passed, period)
        # Planning takes as long between two steps, on both clocks.
        stepped, self._stepped = self._stepped, time.monotonic()
        long = max(CLOCK_SHARE * period, CLOCK_RATIO * (self._stepped - stepped))
        self._long = self._long + 1 if passed > long else 0
        if self._long >= CLOCK_CYCLES:
            return (
                f"the arm's clock advances by {passed:.4g} s in a period of {period:g} s; "
                "write the times in s"
            )
        if self.returning is not None or np.linalg.norm(velocity) < MIN_COMMAND:
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
            self._velocity = np.zeros_like(velocity)
            return f"the arm does not follow: it moved {distance:.3f} rad of {path:.2f} commanded"
        return ""


def _usable(reading: object, count: int) -> bool:
    return (
        isinstance(reading, RobotReading)
        and np.shape(reading.q) == (count,)
        and bool(np.isfinite(reading.q).all())
    )


def _finite(hand: AnyReading) -> bool:
    """Return whether a hand's reading is finite. Missing forces of pads are a fault of touch."""
    if isinstance(hand, JawReading):
        return bool(np.isfinite([hand.width, hand.effort or 0.0]).all())
    return isinstance(hand, HandReading) and all(
        np.isfinite(part).all() for part in (hand.excursions, hand.tensions, hand.angles)
    )


def one_line(error: BaseException) -> str:
    """Return the message of an error in one line. Only errors of devices need no type."""
    text = " ".join(str(error).split())
    if text and isinstance(error, EyehandError | OSError | EOFError):
        return text
    return f"{type(error).__name__}: {text}".removesuffix(": ")
