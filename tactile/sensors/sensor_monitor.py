"""Detect sensors that stop, repeat old images, or lose tactels."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..calibration import Calibration
from ..phase_step import SensorFault
from .protocol import SensorInfo, TactileFrame

STOP_SECONDS, STOP_IMAGES = 0.04, 5
"""Time without an image after which a sensor has stopped, s and in its periods; the longer one
counts. A pad that approaches at 10 mm/s moves 0.4 mm meanwhile."""
REPEATS = 5
"""Successive equal images after which a sensor repeats old ones. With noise of half a count in 16
tactels, two images are equal once in 10^4."""
MIN_REPEAT_NOISE = 0.4
"""Median noise, counts, below which equal images are no fault: quantisation hides the noise."""
MIN_TRUSTED = 0.75
"""Share of tactels that are neither dead nor at full scale below which tactels are lost. Contact
saturates a tactel below the full scale of the converter."""


class SensorMonitor:
    """Check each image of a sensor. Call :meth:`check` once per control cycle.

    Parameters
    ----------
    info
        Description of the sensor.
    calibration
        Calibration of the sensor.
    """

    def __init__(self, info: SensorInfo, calibration: Calibration) -> None:
        self._lowest, self._top = calibration.limits[:, 0], 2**calibration.bits - 1
        self._noisy = float(np.median(calibration.noise)) >= MIN_REPEAT_NOISE
        self._stop_seconds = max(STOP_SECONDS, STOP_IMAGES / info.rate)
        self._silence = 0.0
        self._repeats = 0
        self._time = -np.inf
        self._last: NDArray[np.uint16] | None = None
        self.trusted = 1.0
        """Share of tactels of the last image that are neither dead nor at full scale, 0..1."""

    def check(self, frame: TactileFrame | None, dt: float) -> SensorFault | None:
        """Return the fault of the sensor in this cycle, or None.

        Parameters
        ----------
        frame
            The newest image; None if none arrived since the last cycle.
        dt
            Time since the last cycle, s.
        """
        if frame is None:
            self._silence += dt
            return "sensor_stopped" if self._silence > self._stop_seconds else None
        self._silence = 0.0
        same = self._last is not None and np.array_equal(frame.raw, self._last)
        old = frame.time <= self._time or (same and self._noisy)
        self._repeats = self._repeats + 1 if old else 0
        self._last, self._time = frame.raw.copy(), frame.time
        self.trusted = float(np.mean((frame.raw >= self._lowest) & (frame.raw < self._top)))
        if self._repeats >= REPEATS:
            return "sensor_repeats"
        return "tactels_lost" if self.trusted < MIN_TRUSTED else None
