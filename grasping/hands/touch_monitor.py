"""Detect a hand whose sense of touch has failed: a fault, missing forces, or no change."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from .hand_messages import AnyReading, JawReading

REPEAT_SECONDS = 0.1
"""Time for which touch must not repeat itself while the hand moves, s. No contact does: its forces
change in every cycle."""
MIN_MOTION = 1e-7
"""Change of a finger's drive or angle between two cycles that counts as motion, m or rad."""


class TouchMonitor:
    """Check the readings of a hand, one control cycle after the other.

    A driver whose sensor has stopped repeats the last reading. So a reading that stays the same to
    the last bit, although something is touched and the fingers move, is a fault. Readings without
    any touch are equal in working sensors too, and are not judged.
    """

    def __init__(self) -> None:
        self._last: NDArray[np.float64] | None = None
        self._posture: NDArray[np.float64] | None = None
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


def _posture(reading: AnyReading) -> NDArray[np.float64]:
    """Return what moves with the fingers: drives and joints, or the width of jaws."""
    if isinstance(reading, JawReading):
        return np.array([reading.width])
    return np.concatenate([reading.excursions, reading.angles])
