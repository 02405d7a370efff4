"""Relative gains of the tactels of a flat pad, from one press of a flat plate."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from eyehand.errors import InputError

from .image import TactileArray

POWERS = ((0, 0), (1, 0), (0, 1), (2, 0), (1, 1), (0, 2), (4, 0), (0, 4), (6, 0), (0, 6))
"""Powers of x and y in the surface of the log pressure. A tilted plate needs the linear ones, and
the rim of the foam the high even ones."""
TACTELS_PER_TERM = 4
"""Minimum number of loaded tactels per term. With fewer, the surface would follow the gains."""
MIN_PRESSURE = 100.0
"""Minimum median pressure of a press, Pa: the bottom of the linear range of the chapter's pad."""
MAX_FACTOR = 4.0
"""Factor of the median pressure up to which a difference is a gain. Gains that spread by 20 %
differ by less than 2. Beyond it, a tactel is broken or not under the plate."""
MIN_LOADED = 0.9
"""Minimum share of the tactels that are loaded, as a plate that covers the pad does."""


def flat_press_gains(array: TactileArray, images: NDArray[np.float64]) -> NDArray[np.float64]:
    """Measure the relative gains of the tactels from a press of a flat plate.

    The pressure under a plate is smooth: it changes with the tilt of the plate, and towards the rim
    of the foam. So a polynomial is fitted to the log of the pressure, and a tactel's gain is its
    pressure over that surface. Gains that change slowly over the pad belong to the surface and are
    not found. Neither is a gain that all tactels share. The pressure needs no gauge.

    Parameters
    ----------
    array
        Geometry of the flat pad, N tactels.
    images
        Calibrated pressures (M, N), Pa, while a plate that covers the pad is held. Some 50 images
        average out the noise. No tactel may be saturated.

    Returns
    -------
    NDArray
        (N,), > 0, for :meth:`Calibration.with_gains`; 1 for a tactel that is not loaded.

    Raises
    ------
    InputError
        If the pad is not flat, the images are not finite or have another number of tactels, the
        median pressure is below 100 Pa, or too few tactels are loaded: under 90 %, or under 40.
    """
    if np.ptp(array.positions[:, 2]) > 0.0:
        raise InputError("a flat press needs a flat pad, got tactels at different heights")
    count = len(array.positions)
    if images.ndim != 2 or images.shape[1] != count or not len(images):
        raise InputError(f"images of a press must be (M, {count}), got {images.shape}")
    pressures = images.mean(axis=0)
    level = float(np.median(pressures))
    # A level that is not finite is no press either.
    if not (np.isfinite(pressures).all() and level >= MIN_PRESSURE):
        raise InputError(
            f"a press needs finite pressures and a median of {MIN_PRESSURE:g} Pa, got {level:g}"
        )
    loaded = (pressures > level / MAX_FACTOR) & (pressures < level * MAX_FACTOR)
    needed = max(MIN_LOADED * count, TACTELS_PER_TERM * len(POWERS))
    if loaded.sum() < needed:
        raise InputError(
            f"a plate must load at least {needed:.0f} tactels alike, got {loaded.sum()} of {count}"
        )
    x, y = (array.positions[loaded, :2] / abs(array.positions[:, :2]).max()).T
    terms = np.column_stack([x**a * y**b for a, b in POWERS])
    logs = np.log(pressures[loaded])
    gains = np.ones(count)
    gains[loaded] = np.exp(logs - terms @ np.linalg.lstsq(terms, logs, rcond=None)[0])
    return gains
