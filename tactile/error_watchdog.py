"""Detection of an error that stays large, or of a small oscillation that does not decay."""

from __future__ import annotations

import math
from typing import Literal

MAX_MEAN = 0.1
"""Mean error of a period above which it is a miss, as a share of the goal."""
MAX_DEVIATION = 0.08
"""Standard deviation of a period above which it oscillates, as a share of the goal. Pens, boxes
and spheres within the limits stay below 0.01."""
PERIOD_SECONDS = 0.5
"""Length of a period, s. The transient of a contact must not fill one."""
MAX_PERIODS = 3
"""Number of successive bad periods without improvement that is an error. When a person turns the
object, two periods are bad and the third is better."""
IMPROVEMENT = 0.9
"""A period whose error is below this share of the one before is an improvement."""


class ErrorWatchdog:
    """Judge the error period by period, by its mean and its standard deviation.

    After contact, after a jolt, and while the object moves, the error is large too, but the next
    period is better. What remains is a servo that is stuck beside its goal, or a small oscillation
    that nothing damps.
    """

    def __init__(self) -> None:
        self.reset()

    def reset(self) -> None:
        """Clear all periods."""
        self._last_mean = self._last_deviation = 0.0
        self._misses = self._oscillations = 0
        self._start_period()

    def update(self, error: float, dt: float) -> Literal["steady_miss", "oscillation"] | None:
        """Process one error and return what is wrong, if anything.

        Parameters
        ----------
        error
            As a share of the goal.
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
        # An error that changes its sign is another one.
        lasting = mean * self._last_mean >= 0.0 and _no_better(mean, self._last_mean)
        self._misses = _successive(self._misses, abs(mean) > MAX_MEAN, lasting)
        lasting = _no_better(deviation, self._last_deviation)
        self._oscillations = _successive(self._oscillations, deviation > MAX_DEVIATION, lasting)
        self._last_mean, self._last_deviation = mean, deviation
        self._start_period()
        if self._oscillations >= MAX_PERIODS:
            return "oscillation"
        return "steady_miss" if self._misses >= MAX_PERIODS else None

    def _start_period(self) -> None:
        self._time = self._sum = self._squares = 0.0
        self._count = 0


def _no_better(now: float, before: float) -> bool:
    return abs(now) >= IMPROVEMENT * abs(before)


def _successive(before: int, bad: bool, lasting: bool) -> int:
    """Return the number of successive bad periods; an improved bad period starts at 1."""
    if not bad:
        return 0
    return before + 1 if lasting else 1
