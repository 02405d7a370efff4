"""Estimate how late an arm follows its commands."""

from __future__ import annotations

from collections import deque
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
MAX_DELAY = 0.05
"""Delay that is assumed until it is known, s. An arm with a longer one is named."""


class FollowDelay:
    """Estimates the delay once, from the first motion that is long enough."""

    def __init__(self) -> None:
        self.known = False
        """Whether the delay has been estimated."""
        self.seconds = MAX_DELAY
        """Delay of the measured angles behind the commanded ones, s."""
        self._steps: list[tuple[float, NDArray[np.float64], NDArray[np.float64]]] = []
        self._time = 0.0
        self._recent: deque[tuple[float, NDArray[np.float64]]] = deque()

    def add(
        self, q: NDArray[np.float64], velocity: NDArray[np.float64], seconds: float
    ) -> NDArray[np.float64]:
        """Add a step of the arm, and return the rotation (n,) that it should show, rad.

        Parameters
        ----------
        q
            Joint angles after the step, (n,), rad.
        velocity
            Commanded velocities, (n,), rad/s.
        seconds
            Time for which the arm had them, s.
        """
        pending = self.pending()
        self._recent.append((seconds, velocity))
        while sum(duration for duration, _ in self._recent) - self._recent[0][0] > self.seconds:
            self._recent.popleft()
        if not self.known:
            self._estimate(q, velocity, seconds)
            return seconds * velocity
        return pending + seconds * velocity - self.pending()

    def pending(self) -> NDArray[np.float64]:
        """Return the commanded rotation that the measured angles do not show yet, (n,), rad."""
        left, rotation = self.seconds, np.zeros(1)
        for seconds, velocity in reversed(self._recent):
            rotation = rotation + min(seconds, left) * velocity
            left = max(left - seconds, 0.0)
        return rotation

    def _estimate(
        self, q: NDArray[np.float64], velocity: NDArray[np.float64], seconds: float
    ) -> None:
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
            self.known = True


def _delay(
    times: NDArray[np.float64], moved: NDArray[np.float64], commanded: NDArray[np.float64]
) -> float:
    """Return the delay at which a multiple of the commanded rotation (K,) explains that moved."""
    late = np.array([np.interp(times - delay, times, commanded, left=0.0) for delay in DELAYS])
    # Some arms scale all speeds.
    explained = (late @ moved) ** 2 / np.maximum((late**2).sum(axis=1), 1e-12)
    return float(DELAYS[np.argmax(explained)])
