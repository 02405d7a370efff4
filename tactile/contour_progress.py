"""Options of a contour follower, its path so far, and when it must give up."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from eyehand.errors import InputError

from .contour_step import ContourOutcome

MAX_LOST_SECONDS = 3.0
"""Maximum time without contact, s. A search may find the contact again."""
MAX_BLOCKED_SECONDS = 1.0
"""Maximum time for which the pad moves too slowly, s."""
MAX_TRAVEL_M = 1.2
"""Maximum total distance, m."""
MIN_SPEED_SHARE = 0.25
"""Share of the commanded speed below which the pad moves too slowly."""


@dataclass(frozen=True)
class ContourOptions:
    """Start direction, speed and time limit of a contour follower.

    Raises
    ------
    InputError
        If a value is out of its range.
    """

    heading: float = 0.0
    """Direction of the first motion over the surface, rad, in the sensor's frame."""
    speed: float = 0.03
    """Speed over the surface, m/s. A lower speed locates corners and ends more precisely."""
    seconds: float = 60.0
    """Limit of the total time, s."""

    def __post_init__(self) -> None:
        for name in ("speed", "seconds"):
            if not 0 < getattr(self, name) < np.inf:
                raise InputError(f"{name} must be finite and > 0, got {getattr(self, name)}")
        if not np.isfinite(self.heading):
            raise InputError(f"heading must be finite, got {self.heading}")


class ContourProgress:
    """The position, distances and times of a contour follower.

    Parameters
    ----------
    options
        Speed and time limit.
    """

    def __init__(self, options: ContourOptions) -> None:
        self.position = np.zeros(2)
        """Position of the pad since the start, (2,), m."""
        self.travel = self.line_travel = self.contour_travel = 0.0
        """Distances since the start, on the current line, and on the contour, m. The follower sets
        the last two at the start of each line and contour."""
        self._options = options
        self._time = self._lost_for = self._blocked_for = 0.0

    def update(
        self, velocity: NDArray[np.float64], dt: float, *, commanded: bool, touching: bool
    ) -> None:
        """Add one cycle.

        Parameters
        ----------
        velocity
            Measured velocity of the pad over the surface, (2,), m/s. Without a measurement, the
            commanded one.
        dt
            Duration of the cycle, s.
        commanded
            Whether a motion was commanded.
        touching
            Whether there is a contact.
        """
        distance = float(np.hypot(*velocity)) * dt
        self.position = self.position + velocity * dt
        self.travel += distance
        self.line_travel += distance
        self.contour_travel += distance
        slow = commanded and distance < MIN_SPEED_SHARE * self._options.speed * dt
        self._time += dt
        self._blocked_for = self._blocked_for + dt if slow else 0.0
        self._lost_for = 0.0 if touching else self._lost_for + dt

    def exceeded_limit(self, points: int) -> ContourOutcome | None:
        """Return the outcome if a limit is exceeded, else None.

        `points` is the number of contour points found so far.
        """
        if self._lost_for > MAX_LOST_SECONDS:
            return "lost"
        if self._blocked_for > MAX_BLOCKED_SECONDS:
            return "blocked"
        if self._time > self._options.seconds:
            return "limit_reached"
        if self.travel > MAX_TRAVEL_M:
            return "limit_reached" if points else "nothing_found"
        return None
