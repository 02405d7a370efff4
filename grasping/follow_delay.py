"""Estimate how late an arm follows its commands."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray

SECONDS = 0.6
"""Duration of the motion from which the delay is estimated, s."""
MIN_TRAVEL = 0.15
"""Minimum rotation of a joint within it, rad."""
DELAYS = np.arange(0.0, 0.2, 0.005)
"""Delays that are tried, s."""


class FollowDelay:
    """Estimates the delay once, from the first motion that is long enough."""

    def __init__(self) -> None:
        self.seconds = 0.0
        """Delay of the measured angles behind the commanded ones, s; 0 until it is known."""
        self._steps: list[tuple[float, NDArray[np.float64], NDArray[np.float64]]] = []
        self._time = 0.0

    def add(self, q: NDArray[np.float64], velocity: NDArray[np.float64], seconds: float) -> None:
        """Add a step of the arm: angles (n,) after it, rad; commanded (n,), rad/s; duration, s."""
        if self.seconds:
            return
        if not self._steps and not velocity.any():
            return
        self._time += seconds
        self._steps.append((self._time, np.array(q), seconds * velocity))
        if self._time < SECONDS:
            return
        times, angles, commands = map(np.array, zip(*self._steps, strict=True))
        self._steps, self._time = [], 0.0
        moved, commanded = angles - angles[0], np.cumsum(commands, axis=0)
        joint = int(np.argmax(np.abs(moved).max(axis=0)))
        if np.abs(moved[:, joint]).max() > MIN_TRAVEL:
            self.seconds = _delay(times, moved[:, joint], commanded[:, joint])


def _delay(
    times: NDArray[np.float64], moved: NDArray[np.float64], commanded: NDArray[np.float64]
) -> float:
    """Return the delay at which a multiple of the commanded rotation (K,) explains that moved."""
    late = np.array([np.interp(times - delay, times, commanded, left=0.0) for delay in DELAYS])
    # Some arms scale all speeds.
    explained = (late @ moved) ** 2 / np.maximum((late**2).sum(axis=1), 1e-12)
    return float(max(DELAYS[np.argmax(explained)], DELAYS[1]))
