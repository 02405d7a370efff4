"""Detection of an error that stays large, or of a small oscillation that does not decay."""

from __future__ import annotations

import math
from typing import Literal

MAX_MEAN = 0.1
"""Maximum mean error of a good period, as a share of the goal pressure."""
MAX_DEVIATION = 0.08
"""Maximum standard deviation of the error in a good period, as a share of the goal pressure. Pens,
boxes and spheres within the limits stay below 0.01."""
PERIOD_SECONDS = 0.5
"""Length of a period, s. The transient of a contact must not fill one."""
FAULT_PERIODS = 3
"""Minimum number of successive bad periods without improvement that counts as a fault. When a
person turns the object, two periods are bad and the third is better."""
IMPROVEMENT = 0.9
"""A period whose error is below this share of the one before is an improvement."""


class ErrorWatchdog:
    """Judge the error period by period, by its mean and its standard deviation.

    After contact, after a jolt, and while the object moves, the error is large too, but then the
    next period is better. Without improvement, the servo is stuck beside its goal, or it oscillates
    with a small amplitude that does not decay.
    """

    def __init__(self) -> None:
        self.reset()

    def reset(self) -> None:
        """Clear all periods."""
        self.settled = False
        """Whether the last period was good."""
        self._last_mean = self._last_deviation = 0.0
        self._misses = self._oscillations = 0
        self._start_period()

    def update(self, error: float, dt: float) -> Literal["steady_miss", "oscillation"] | None:
        """Process one error and return the fault, or None.

        Parameters
        ----------
        error
            Pressure error divided by the goal pressure.
        dt
            Time since the last error, s.
        """
        self._time += dt
        self._count += 1
        self._sum += error
        self._squares += error * error
        if self._time < PERIOD_SECONDS:
            return None
        mean = self._sum / self._count
        deviation = math.sqrt(max(self._squares / self._count - mean * mean, 0.0))
        # An error of the other sign has another cause.
        sustained = mean * self._last_mean >= 0.0 and _no_better(mean, self._last_mean)
        self._misses = _successive(self._misses, abs(mean) > MAX_MEAN, sustained)
        sustained = _no_better(deviation, self._last_deviation)
        self._oscillations = _successive(self._oscillations, deviation > MAX_DEVIATION, sustained)
        self._last_mean, self._last_deviation = mean, deviation
        self.settled = abs(mean) <= MAX_MEAN and deviation <= MAX_DEVIATION
        self._start_period()
        if self._oscillations >= FAULT_PERIODS:
            return "oscillation"
        return "steady_miss" if self._misses >= FAULT_PERIODS else None

    def _start_period(self) -> None:
        self._time = self._sum = self._squares = 0.0
        self._count = 0


def _no_better(now: float, before: float) -> bool:
    return abs(now) >= IMPROVEMENT * abs(before)


def _successive(count: int, bad: bool, sustained: bool) -> int:
    """Return the new number of successive bad periods. An improved bad period starts at 1."""
    if not bad:
        return 0
    return count + 1 if sustained else 1
