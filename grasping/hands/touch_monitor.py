"""Detect a hand whose sense of touch has failed: a fault, missing forces, or no change."""

from __future__ import annotations

from collections import deque
from statistics import median

import numpy as np
from numpy.typing import NDArray

from .hand_messages import AnyReading, JawReading

REPEAT_SECONDS, REPEAT_PERIODS = 0.1, 5
"""Time for which touch must not repeat itself, s and in its periods; the longer one counts."""
PERIOD_GAPS = 9
"""Last gaps between two measurements whose median is the period. Up to four late ones or bursts
among them do not change it."""
FIRST_PERIOD = 0.2
"""Assumed time between two measurements before the second one, s."""
MIN_MOTION = 1e-7
"""Change of a finger's drive or angle between two cycles that counts as motion, m or rad."""


class TouchMonitor:
    """Check the readings of a hand, one control cycle after the other.

    A driver whose sensor has stopped repeats the last reading. With the time of a measurement, a
    time that stays the same is a fault. Without it, a reading that stays the same to the last bit,
    although something is touched and the fingers move, is one: forces of a contact change in every
    cycle. Readings without any touch are equal in working sensors too, and are not judged.
    """

    def __init__(self) -> None:
        self._last: NDArray[np.float64] | None = None
        self._posture: NDArray[np.float64] | None = None
        self._time: float | None = None
        self._gaps: deque[float] = deque(maxlen=PERIOD_GAPS)
        self._repeated = 0.0

    def check(self, reading: AnyReading, dt: float) -> str:
        """Return what is wrong with the touch of a reading, or an empty string.

        Parameters
        ----------
        reading
            The hand's reading. Hands without touch are never wrong.
        dt
            Time since the last reading, s.
        """
        if reading.touch_fault:
            return reading.touch_fault
        forces = np.ravel(() if reading.forces is None else reading.forces).astype(float)
        missing = int(np.count_nonzero(~np.isfinite(forces)))
        if missing:
            return f"{missing} of {len(forces)} pad forces are missing"
        if reading.touch_time is not None:
            return self._check_time(reading.touch_time, dt)
        felt = np.concatenate([forces, *(tip.pressures for tip in reading.tips)])
        posture = _posture(reading)
        moved = self._posture is not None and bool(
            np.abs(posture - self._posture).max(initial=0.0) > MIN_MOTION
        )
        same = self._last is not None and np.array_equal(felt, self._last)
        self._last, self._posture = felt, posture
        if not same or not felt.any():
            self._repeated = 0.0
        elif moved:
            self._repeated += dt
        if self._repeated > REPEAT_SECONDS:
            return f"touch has not changed for {REPEAT_SECONDS:g} s of motion"
        return ""

    def _check_time(self, time: float, dt: float) -> str:
        """Return what is wrong with the time of a measurement, or an empty string."""
        if self._time is None or time > self._time:
            if self._time is not None:
                self._gaps.append(time - self._time)
            self._time, self._repeated = time, 0.0
        else:
            self._repeated += dt
        period = median(self._gaps) if self._gaps else FIRST_PERIOD
        limit = max(REPEAT_SECONDS, REPEAT_PERIODS * period)
        return f"no measurement of touch for {limit:g} s" if self._repeated > limit else ""


def _posture(reading: AnyReading) -> NDArray[np.float64]:
    """Return what moves with the fingers: drives and joints, or the width of jaws."""
    if isinstance(reading, JawReading):
        return np.array([reading.width])
    return np.concatenate([reading.excursions, reading.angles])
