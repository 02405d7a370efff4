"""Zeroing of a tactile sensor: readings at rest drift with temperature and are tracked."""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

from eyehand.errors import InputError

from ..calibration import Calibration

MIN_IMAGES = 20
"""Minimum number of images for zeroing. Their mean has a quarter of the noise of an image."""
MAX_MOVING_SHARE = 0.1
"""Maximum share of tactels whose reading may change while the sensor is zeroed."""
MOVING_SIGMAS = 6.0
"""Deviation from its mean, in standard deviations of the noise, at which a reading changes."""
MAX_REST_CHANGE = 300.0
"""Maximum difference between the readings at rest and those of the calibration, counts of a 12-bit
converter. The harshest sensor model drifts by 6 counts per minute with a spread of 50 %: three
standard deviations are 15. Ten minutes of warming up give 150 counts; this is twice as much."""
FREE_SIGMAS = 4.0
"""Deviation from rest, in standard deviations of the noise, below which a tactel is untouched."""
TRACK_TIME = 5.0
"""Time constant of the tracking, s. It averages the noise of a second at 5 images and more."""
MAX_DRIFT_RATE = 0.3
"""Maximum rate of the tracking, counts per second of a 12-bit converter: three times the drift of
the harshest sensor model. A contact just below `FREE_SIGMAS`, 8 counts with a noise of 2, is
absorbed in 27 s at the least."""


class RestTracker:
    """Remove the drift of the readings at rest.

    Tactels without contact follow their own reading slowly. Tactels in contact follow the mean
    drift of the others, because temperature moves all tactels in one direction. Readings that are
    dead or at full scale stay unchanged.

    Parameters
    ----------
    calibration
        Calibration of the sensor.
    """

    def __init__(self, calibration: Calibration) -> None:
        self._rest, self._noise = calibration.rest, calibration.noise.copy()
        self._limits, self._dead = calibration.limits, calibration.dead
        self._top = 2**calibration.bits - 1
        scale = 2.0 ** (calibration.bits - 12)
        self._max_rate, self._max_change = MAX_DRIFT_RATE * scale, MAX_REST_CHANGE * scale
        self.offsets: NDArray[np.float64] = np.zeros(len(self._rest))
        """Present drift of each tactel since its calibration, (N,), counts."""
        self._corrected = np.zeros(len(self._rest), np.uint16)

    def zero(self, raws: NDArray[np.uint16]) -> None:
        """Take the mean of images (M, N) as the readings at rest. Nothing may touch the sensor.

        The images also show the noise. It replaces that of the calibration where it is higher: a
        bench run with few readings cannot show it.

        Raises
        ------
        InputError
            If there are fewer than 20 images, readings of many tactels change meanwhile, or a
            reading differs from the calibration by more than drift explains.
        """
        if raws.ndim != 2 or raws.shape[1] != len(self._rest) or len(raws) < MIN_IMAGES:
            raise InputError(
                f"zeroing needs {MIN_IMAGES} images or more of {len(self._rest)} tactels, got "
                f"{raws.shape}"
            )
        means = raws.mean(axis=0)
        # Differences of successive images: a contact that moves slowly does not count as noise.
        steps = np.diff(raws.astype(np.float64), axis=0)
        np.maximum(self._noise, steps.std(axis=0) / np.sqrt(2.0), out=self._noise)
        # The second half against the first: noise averages out, a contact that moves does not.
        halves = raws[: len(raws) // 2].mean(axis=0) - raws[len(raws) // 2 :].mean(axis=0)
        limit = MOVING_SIGMAS * self._noise * np.sqrt(4.0 / len(raws))
        moving = float(np.mean((abs(halves) > np.maximum(limit, 1.0)) & ~self._dead))
        if moving > MAX_MOVING_SHARE:
            raise InputError(
                f"readings of {100 * moving:.0f} % of the tactels change while the sensor is "
                f"zeroed, at most {100 * MAX_MOVING_SHARE:.0f} % may; keep it free of contact"
            )
        self._check_free(means)
        self.offsets[:] = np.where(self._dead, 0.0, means - self._rest)

    def _check_free(self, means: NDArray[np.float64]) -> None:
        """Check that the mean readings (N,) are those of a free pad, apart from drift."""
        # Dead tactels are faults that `correct` leaves visible. At full scale they look loaded.
        read = ~self._dead & (means >= self._limits[:, 0])
        change = np.where(read, abs(means - self._rest), 0.0)
        worst = int(change.argmax())
        if change[worst] > self._max_change:
            raise InputError(
                f"zeroing needs a free pad: tactel {worst} reads {means[worst]:.0f} counts, "
                f"{self._rest[worst]:.0f} when it was calibrated, and drift explains at most "
                f"{self._max_change:.0f}; free the pad, or calibrate it again. A tactel with a "
                "broken wire is marked by Calibration.mark_dead_at_rest"
            )

    def correct(self, raw: NDArray[np.uint16], dt: float) -> NDArray[np.uint16]:
        """Return the readings (N,) without drift, and follow the drift by one image.

        The next call overwrites the returned array.

        Parameters
        ----------
        raw
            Readings of the tactels, (N,).
        dt
            Time since the last image, s; 0 does not track.
        """
        track_rest(
            raw,
            self._rest,
            self._noise,
            self._limits,
            (self._top, min(max(dt, 0.0) / TRACK_TIME, 1.0), self._max_rate * max(dt, 0.0)),
            self.offsets,
            self._corrected,
        )
        return self._corrected


@njit(cache=True)
def track_rest(raw, rest, noise, limits, rule, offsets, corrected):
    """Subtract the offsets from readings and update the offsets (see :class:`RestTracker`).

    Parameters
    ----------
    raw, rest, noise
        (N,), counts.
    limits
        `Calibration.limits`.
    rule
        Highest reading, share by which offsets follow, and maximum change of an offset, counts.
    offsets, corrected
        (N,) float64 and (N,) uint16, overwritten.
    """
    top, share, max_change = rule
    total, free = 0.0, 0
    for k in range(len(raw)):
        reading = float(raw[k])
        if reading < limits[k, 0] or reading >= top:
            corrected[k] = raw[k]
            continue
        corrected[k] = min(max(round(reading - offsets[k]), 0), top)
        error = reading - offsets[k] - rest[k]
        if abs(error) <= FREE_SIGMAS * noise[k]:
            change = min(max(share * error, -max_change), max_change)
            offsets[k] += change
            total += change
            free += 1
    if free == 0:
        return
    for k in range(len(raw)):
        touched = raw[k] - offsets[k] - rest[k] > FREE_SIGMAS * noise[k]
        if touched and raw[k] >= limits[k, 0] and raw[k] < top:
            offsets[k] += total / free
