"""The foam's memory of an earlier load: fitted from one press and its release, then removed."""

from __future__ import annotations

from dataclasses import dataclass
from math import exp

import numpy as np
from numpy.typing import NDArray

from eyehand.errors import InputError

MIN_SHARE = 0.01
"""Smallest share of a load that counts as memory. Less is lost in the noise."""
FIT_SHARE = 0.3
"""Images are used until the remaining share has fallen to this part of the first one."""


@dataclass(frozen=True)
class FoamMemory:
    """The share of an earlier load that a pad still reads after its release, and its decay time."""

    share: float
    """Share of the load that is read just after the release, 0..1."""
    recovery: float
    """Time constant with which it fades, s."""


def fit_memory(
    loaded: NDArray[np.float64], released: NDArray[np.float64], times: NDArray[np.float64]
) -> FoamMemory:
    """Fit the memory from a press with a flat punch and its release.

    Parameters
    ----------
    loaded
        Calibrated pressures (N,), Pa, just before the release.
    released
        Pressures (R, N), Pa, after the release, R >= 3.
    times
        Times (R,) of these images since the release, s, > 0 and increasing.

    Returns
    -------
    FoamMemory
        A share of 0 if less than 1 % of the load remains.

    Raises
    ------
    InputError
        If shapes disagree, values are not finite, times do not increase, the press has no
        pressure, or the remaining pressure does not fade.
    """
    if len(times) < 3 or released.shape != (len(times), len(loaded)):
        raise InputError(
            f"need at least 3 images of {len(loaded)} tactels after the release and as many "
            f"times, got {released.shape} and {times.shape}"
        )
    if not all(np.isfinite(values).all() for values in (loaded, released, times)):
        raise InputError("pressures and times of a release must be finite")
    if not (times[0] > 0 and (np.diff(times) > 0).all()):
        raise InputError(f"times after the release must be > 0 s and increase, got {times}")
    if not loaded.sum() > 0:
        raise InputError(f"the press must have pressure, got {loaded.sum()} Pa over all tactels")
    remaining = released.sum(axis=1) / loaded.sum()
    if remaining[0] < MIN_SHARE:
        return FoamMemory(0.0, 1.0)
    used = np.logical_and.accumulate(remaining > FIT_SHARE * remaining[0])
    slope, start = np.polyfit(times[used], np.log(remaining[used]), 1) if used.sum() > 2 else (0, 0)
    if not slope < 0:
        raise InputError("the pressure after the release does not fade; record it for longer")
    return FoamMemory(min(float(np.exp(start)), 1.0), -1.0 / float(slope))


class MemoryFilter:
    """Remove the foam's memory from the images of a pad, one after the other.

    A tactel reads (1 - share) of its pressure and `share` of its earlier load. The load follows a
    rising pressure at once and fades towards a lower one.

    Parameters
    ----------
    memory
        Memory of the foam.
    """

    def __init__(self, memory: FoamMemory) -> None:
        self._memory = memory
        self._load: NDArray[np.float64] | None = None

    def correct(
        self,
        pressures: NDArray[np.float64],
        dt: float,
        saturated: NDArray[np.bool_] | None = None,
    ) -> NDArray[np.float64]:
        """Return the pressures of an image without memory.

        A pressure below `share` of the earlier load is returned as 0: it cannot be distinguished
        from memory. The load of a saturated tactel is unknown. It is taken as the largest one that
        its reading can be the memory of, and its pressure is returned as it is read.

        Parameters
        ----------
        pressures
            (N,), Pa.
        dt
            Time since the last image, s.
        saturated
            Mask (N,) of the saturated tactels; none if not given.

        Returns
        -------
        NDArray
            (N,), Pa.
        """
        share = self._memory.share
        if share == 0.0:
            return pressures
        load = pressures if self._load is None else self._load
        kept = exp(-dt / self._memory.recovery)
        # Reading = (1 - share) p + share m, with m = p + (m_before - p) kept, for p below m_before.
        below = (pressures - share * kept * load) / (1.0 - share * kept)
        true = np.where(pressures >= load, pressures, np.maximum(below, 0.0))
        self._load = np.maximum(true + (load - true) * kept, true)
        if saturated is None:
            return np.where(true > share * self._load, true, 0.0)
        self._load = np.where(saturated, pressures / share, self._load)
        corrected = np.where(true > share * self._load, true, 0.0)
        return np.where(saturated, pressures, corrected)
