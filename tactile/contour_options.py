"""Options of the contour follower."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from eyehand.errors import InputError


@dataclass(frozen=True)
class ContourOptions:
    """Start direction, speed, and limits of a contour follower.

    Raises
    ------
    InputError
        If a value is out of its range.
    """

    heading: float = 0.0
    """Direction of the first motion over the surface, rad, in the sensor's frame."""
    speed: float = 0.03
    """Speed over the surface, m/s. A lower speed locates corners and ends more precisely."""
    max_points: int = 16
    """Number of contour points after which the follower is done."""
    travel: float = 1.2
    """Limit of the total distance, m."""
    seconds: float = 60.0
    """Limit of the total time, s."""

    def __post_init__(self) -> None:
        for name in ("speed", "travel", "seconds"):
            if not 0 < getattr(self, name) < np.inf:
                raise InputError(f"{name} must be finite and > 0, got {getattr(self, name)}")
        if not np.isfinite(self.heading):
            raise InputError(f"heading must be finite, got {self.heading}")
        if self.max_points < 1:
            raise InputError(f"max_points must be >= 1, got {self.max_points}")
