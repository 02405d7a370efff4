"""Notice a feature that stays off its goal, or swings about it, and does not get better."""

from __future__ import annotations

import math
from typing import Literal

NOT_BETTER = 0.9
"""A span whose error is below this share of that of the span before gets better."""


class ErrorWatchdog:
    """Judge the error span by span: by its mean, and by its deviation from that.

    A landing, a jolt and an object that is moved on are off too, but the next span is better. What
    is left is a servo that is stuck beside its goal, or a small swing that nothing damps.

    Parameters
    ----------
    miss
        Mean error of a span that counts as a miss, as a share of the goal.
    calm
        Standard deviation of a span up to which it counts as calm, likewise.
    seconds
        Length of a span, s, > 0.
    spans
        How many in a row must be no better than the one before, >= 1.
    """

    def __init__(self, miss: float, calm: float, seconds: float, spans: int) -> None:
        self._miss, self._calm, self._seconds, self._spans = miss, calm, seconds, spans
        self.reset()

    def reset(self) -> None:
        """Forget all spans."""
        self._last_mean = self._last_deviation = 0.0
        self._misses = self._swings = 0
        self._begin()

    def update(self, error: float, dt: float) -> Literal["steady_miss", "oscillation"] | None:
        """Take one error, as a share of the goal, after ``dt`` s, and tell what it has come to."""
        self._time += dt
        self._count += 1
        self._sum += error
        self._squares += error * error
        if self._time < self._seconds:
            return None
        mean = self._sum / self._count
        deviation = math.sqrt(max(self._squares / self._count - mean * mean, 0.0))
        # An error that changes its side is another one.
        lasting = mean * self._last_mean >= 0.0 and _no_better(mean, self._last_mean)
        self._misses = _in_a_row(self._misses, abs(mean) > self._miss, lasting)
        lasting = _no_better(deviation, self._last_deviation)
        self._swings = _in_a_row(self._swings, deviation > self._calm, lasting)
        self._last_mean, self._last_deviation = mean, deviation
        self._begin()
        if self._swings >= self._spans:
            return "oscillation"
        return "steady_miss" if self._misses >= self._spans else None

    def _begin(self) -> None:
        self._time = self._sum = self._squares = 0.0
        self._count = 0


def _no_better(now: float, before: float) -> bool:
    return abs(now) >= NOT_BETTER * abs(before)


def _in_a_row(before: int, bad: bool, lasting: bool) -> int:
    """Spans in a row; one that is bad but better than the one before begins a new row."""
    if not bad:
        return 0
    return before + 1 if lasting else 1
