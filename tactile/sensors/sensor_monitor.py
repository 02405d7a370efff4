"""Detect sensors that stop, repeat old images, or lose tactels."""

from __future__ import annotations

import time
from collections import deque
from collections.abc import Callable
from itertools import pairwise
from statistics import median

import numpy as np
from numpy.typing import NDArray

from ..calibration import Calibration
from ..phase_step import SensorFault
from .protocol import SensorInfo, TactileFrame

STOP_SECONDS, STOP_IMAGES = 0.04, 5
"""Time without an image after which a sensor has stopped, s and in its periods; the longer one
counts. A pad that approaches at 10 mm/s moves 0.4 mm meanwhile."""
STEPS = 20
"""Number of images whose median interval by the sensor's clock is checked, and of cycles whose
median time by the host's clock is known. A single gap is none."""
REPEATS = 5
"""Successive equal images after which a sensor repeats old ones. With noise of half a count in 16
tactels, two images are equal once in 10^4."""
MIN_REPEAT_NOISE = 0.4
"""Median noise, counts, below which equal images are no fault: quantisation hides the noise."""
MIN_TRUSTED = 0.75
"""Share of tactels that are neither dead nor at full scale below which tactels are lost. Contact
saturates a tactel below the full scale of the converter."""
MAX_DIED = 0.05
"""Maximum share of tactels that read nothing although they worked when they were calibrated. A row
of 16 x 16 tactels is 6 %. Fewer are interpolated with little error, and one always is."""
MIN_STUCK = 2
"""Number of tactels stuck at full scale that are a fault. Contacts have two tactels or more."""
PRESSED_SHARE = 0.01
"""Mean rise of a stuck tactel's neighbours, as a share of the range, from which a contact explains
it. It is 41 counts of 12 bits: 14 standard deviations of a noise of 2 counts."""
TOUCHED_SHARE = 0.1
"""Share of the range of readings from which a tactel is touched for the search of stuck ones. Drift
explains at most 7 %."""


class SensorMonitor:
    """Check each image of a sensor. Call :meth:`check` once per control cycle.

    Parameters
    ----------
    info
        Description of the sensor.
    calibration
        Calibration of the sensor.
    clock
        Time of the host, s.
    """

    def __init__(
        self,
        info: SensorInfo,
        calibration: Calibration,
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        self._lowest, self._top = calibration.limits[:, 0], 2**calibration.bits - 1
        self._dead, rest = calibration.dead, calibration.rest
        self._touch = np.where(self._dead, np.inf, rest + TOUCHED_SHARE * (self._top - rest))
        self._touched = np.zeros(len(rest), bool)
        a, b = info.array.neighbours.T
        self._pairs = np.concatenate([a, b]), np.concatenate([b, a])
        self._before = rest
        self._pressed = PRESSED_SHARE * self._top
        self._died = self._stuck = np.zeros(len(rest), np.int64)
        self._noisy = float(np.median(calibration.noise)) >= MIN_REPEAT_NOISE
        self._stop_seconds = max(STOP_SECONDS, STOP_IMAGES / info.rate)
        self._silence = 0.0
        self._period = 1.0 / info.rate
        self._steps: deque[float] = deque(maxlen=STEPS)
        self._clock, self._cycles = clock, deque[float](maxlen=STEPS + 1)
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
        self._cycles.append(self._clock())
        if frame is None:
            self._silence += dt
            return "sensor_stopped" if self._silence > self._stop_seconds else None
        self._silence = 0.0
        same = self._last is not None and np.array_equal(frame.raw, self._last)
        old = frame.time <= self._time or (same and self._noisy)
        self._repeats = self._repeats + 1 if old else 0
        self._steps.append(frame.time - self._time)
        self._last, self._time = frame.raw.copy(), frame.time
        if self._lost(frame.raw) or self.trusted < MIN_TRUSTED:
            return "tactels_lost" if self._repeats < REPEATS else "sensor_repeats"
        if self._repeats >= REPEATS:
            return "sensor_repeats"
        if len(self._steps) < STEPS:
            return None
        # A cycle that takes longer than it should leaves out images.
        cycle = median(b - a for a, b in pairwise(self._cycles))
        longest = max(self._period, dt, cycle)
        return "sensor_stopped" if median(self._steps) > STOP_IMAGES * longest else None

    def _lost(self, raw: NDArray[np.uint16]) -> bool:
        """Count the images in which each tactel was dead or stuck; return if too many are.

        A broken wire raises tactels from rest to full scale at once, and no other tactel. A contact
        also raises their neighbours.
        """
        low, full = raw < self._lowest, raw >= self._top
        self.trusted = 1.0 - float(np.mean(low | full))
        self._died = np.where(low & ~self._dead, self._died + 1, 0)
        touched = raw > self._touch
        jumped = full & ((touched & ~self._touched) | (self._stuck > 0))
        if jumped.any():
            alone = self._neighbours_rest(raw, full) | (self._stuck >= REPEATS)
            jumped = jumped & alone
        self._stuck = np.where(jumped, self._stuck + 1, 0)
        if not jumped.any():
            self._before = raw.astype(np.float64)
        self._touched = touched
        died = int(np.sum(self._died >= REPEATS))
        stuck = int(np.sum(self._stuck >= REPEATS))
        return died > max(1.0, MAX_DIED * len(raw)) or stuck >= MIN_STUCK

    def _neighbours_rest(
        self, raw: NDArray[np.uint16], full: NDArray[np.bool_]
    ) -> NDArray[np.bool_]:
        """Return where the neighbours below full scale read as before the jump, on average, (N,).

        It is false for tactels without such a neighbour.
        """
        tactel, neighbour = self._pairs
        count, usable = len(raw), (~full & ~self._dead)[neighbour]
        rises = np.where(usable, (raw - self._before)[neighbour], 0.0)
        number = np.bincount(tactel, usable, count)
        return (number > 0) & (np.bincount(tactel, rises, count) < self._pressed * number)
