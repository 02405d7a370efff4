"""The foam's memory of an earlier load: fitted from presses and a release, then removed."""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import exp

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import curve_fit

from eyehand.errors import InputError

MIN_SHARE = 0.01
"""Smallest share of a load that counts as memory. Less is lost in the noise."""
FIT_SHARE = 0.3
"""Images are used until the remaining share has fallen to this part of the first one."""
CREEP_TIMES_S = (0.5, 60.0)
"""Shortest and longest time constant of a creep, s. A faster one looks like a lag, and a slower one
like drift."""


@dataclass(frozen=True)
class FoamMemory:
    """What a pad reads of an earlier load after its release, and its creep under a load."""

    share: float
    """Share of the load that is read just after the release, 0..1."""
    recovery: float
    """Time constant with which it fades, s."""
    creep: float = 0.0
    """Share by which the reading of a constant load rises in time, >= 0."""
    creep_time: float = 1.0
    """Time constant of this rise, and of the fall after the release, s."""


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


def fit_creep(
    memory: FoamMemory, held: NDArray[np.float64], times: NDArray[np.float64]
) -> FoamMemory:
    """Add the creep of a press that is held still to a fitted memory.

    The sum of the tactels is fitted by A (1 + creep (1 - exp(-t / creep_time))).

    Parameters
    ----------
    memory
        Memory fitted by :func:`fit_memory` after a short press, which creeps little.
    held
        Calibrated pressures (H, N), Pa, while the punch is held at one depth, H >= 3.
    times
        Times (H,) of these images since the punch pressed, s, increasing.

    Raises
    ------
    InputError
        If shapes disagree, or the press has no pressure.
    """
    total = held.sum(axis=1)
    if len(times) < 3 or total.shape != times.shape or not total.min() > 0:
        raise InputError(
            f"need at least 3 images of a held press with pressure, got {held.shape} at "
            f"{times.shape} times"
        )
    (_, creep, time), _ = curve_fit(
        lambda t, load, creep, time: load * (1.0 + creep * (1.0 - np.exp(-t / time))),
        times,
        total,
        (total[0], MIN_SHARE, float(np.ptp(times))),
        bounds=((0.0, 0.0, CREEP_TIMES_S[0]), (np.inf, 1.0, CREEP_TIMES_S[1])),
    )
    return (
        replace(memory, creep=float(creep), creep_time=float(time)) if creep > MIN_SHARE else memory
    )


class MemoryFilter:
    """Remove the foam's memory from the images of a pad, one after the other.

    A tactel reads (1 - share) of its pressure and `share` of its earlier load. The load follows a
    rising pressure at once and fades towards a lower one. A part of this reading creeps: it follows
    the reading slowly.

    Parameters
    ----------
    memory
        Memory of the foam.
    doubt
        Share of the memory up to which a pressure cannot be distinguished from it, and is returned
        as 0. 1 for points, which must not lie in the air; 0 for the force of a grip that is eased.
    """

    def __init__(self, memory: FoamMemory, doubt: float = 1.0) -> None:
        self._memory, self._doubt = memory, doubt
        self._load: NDArray[np.float64] | None = None
        self._crept: NDArray[np.float64] | None = None

    def correct(
        self,
        pressures: NDArray[np.float64],
        dt: float,
        saturated: NDArray[np.bool_] | None = None,
    ) -> NDArray[np.float64]:
        """Return the pressures of an image without memory.

        The load of a saturated tactel is unknown. It is taken as the largest one that
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
        memory = self._memory
        if memory.share == memory.creep == 0.0:
            return pressures
        true = self._without_load(self._without_creep(pressures, dt), dt, saturated)
        return true if saturated is None else np.where(saturated, pressures, true)

    def _without_creep(self, pressures: NDArray[np.float64], dt: float) -> NDArray[np.float64]:
        """Return the pressures (N,) that have not crept."""
        creep, kept = self._memory.creep, exp(-dt / self._memory.creep_time)
        crept = np.zeros(len(pressures)) if self._crept is None else self._crept
        # Reading = p + creep c, with c = p + (c_before - p) kept.
        fresh = (pressures - creep * kept * crept) / (1.0 + creep * (1.0 - kept))
        self._crept = fresh + (crept - fresh) * kept
        return fresh

    def _without_load(
        self, pressures: NDArray[np.float64], dt: float, saturated: NDArray[np.bool_] | None
    ) -> NDArray[np.float64]:
        """Return the pressures (N,) without the share of the earlier load."""
        share, kept = self._memory.share, exp(-dt / self._memory.recovery)
        load = pressures if self._load is None else self._load
        # Reading = (1 - share) p + share m, with m = p + (m_before - p) kept, for p below m_before.
        below = (pressures - share * kept * load) / (1.0 - share * kept)
        true = np.where(pressures >= load, pressures, np.maximum(below, 0.0))
        self._load = np.maximum(true + (load - true) * kept, true)
        if saturated is not None and share > 0.0:
            self._load = np.where(saturated, pressures / share, self._load)
        return np.where(true > self._doubt * share * self._load, true, 0.0)
