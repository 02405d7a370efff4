"""Delay and lag of a sensor and its arm, identified from one press."""

from __future__ import annotations

from dataclasses import dataclass
from math import exp

import numpy as np
from numpy.typing import NDArray
from scipy.signal import lfilter

from eyehand.errors import InputError

MAX_LATENCY = 20
"""Maximum latency that is tried, cycles."""
LAG_STEP, MAX_LAG = 0.001, 0.08
"""Step and maximum of the lags that are tried, s."""
MIN_READINGS = 100
"""Minimum number of readings in contact: 0.4 s at 250 Hz."""


@dataclass(frozen=True)
class Timing:
    """The delay and the lag between a command and its effect on the sensor."""

    latency: int
    """Cycles from a command to its first effect on the reading."""
    lag: float
    """Time constant of that effect, s."""
    residual: float
    """Rms error of the fitted pressure over the deviation of the measured one: below 0.1 the fit
    can be trusted."""


def identify_timing(
    commands: NDArray[np.float64], pressures: NDArray[np.float64], dt: float
) -> Timing:
    """Identify delay and lag from a press: commanded velocities and measured pressures.

    The commands, delayed and with a first-order lag, integrate to the depth. The pressure is a
    cubic function of the depth and, because foam has hysteresis, a quadratic one of the largest
    depth so far. The delay and the lag with the smallest squared error are chosen.

    Parameters
    ----------
    commands
        (M,), commanded velocity towards the object in each cycle, m/s. It must change its sign
        several times within the contact.
    pressures
        (M,), pressure read in each cycle after the command of the cycle before, Pa; 0 without
        contact.
    dt
        Duration of a cycle, s.

    Returns
    -------
    Timing
        The delay counts from a command to the reading.

    Raises
    ------
    InputError
        If shapes differ, something is not finite, or the contact is too short.
    """
    if commands.shape != pressures.shape or commands.ndim != 1:
        raise InputError(
            f"commands and pressures must be (M,), got {commands.shape} and {pressures.shape}"
        )
    if not (np.isfinite(commands).all() and np.isfinite(pressures).all() and 0 < dt < np.inf):
        raise InputError(f"commands and pressures must be finite and dt > 0 s, got dt {dt}")
    touching = pressures > 0
    if np.count_nonzero(touching) < MIN_READINGS:
        raise InputError(
            f"a press needs {MIN_READINGS} readings in contact, got {np.count_nonzero(touching)}"
        )
    best = (np.inf, 0, 0.0)
    for lag in np.arange(0.0, MAX_LAG, LAG_STEP):
        kept = exp(-dt / lag) if lag > 0 else 0.0
        depth = np.cumsum(lfilter([1.0 - kept], [1.0, -kept], commands)) * dt
        for latency in range(MAX_LATENCY + 1):
            late = np.concatenate([np.zeros(latency), depth[: len(depth) - latency]])
            error = _misfit(late[touching], pressures[touching])
            best = min(best, (error, latency, float(lag)))
    return Timing(best[1], best[2], best[0])


def _misfit(depth: NDArray[np.float64], pressure: NDArray[np.float64]) -> float:
    """Return the relative rms error of the pressure as a function of depth and past depth."""
    scaled = (depth - depth.mean()) / max(float(np.ptp(depth)), 1e-9)
    past = np.maximum.accumulate(scaled)
    terms = np.column_stack([np.ones_like(scaled), scaled, scaled**2, scaled**3, past, past**2])
    fitted = terms @ np.linalg.lstsq(terms, pressure, rcond=None)[0]
    return float(np.sqrt(np.mean((pressure - fitted) ** 2)) / max(float(pressure.std()), 1e-9))
