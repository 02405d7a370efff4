"""What a foam sensor remembers: lag, hysteresis, creep, gains, drift, and waiting images."""

from __future__ import annotations

from collections import deque
from math import exp
from typing import TYPE_CHECKING

import numpy as np
from numba import njit

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from .sensor_model import SensorModel
    from .tactile_readout import TactileReadout

RECOVERY_TIME_S = 2.0
"""Time constant with which the foam forgets an earlier load. Soft open-cell foams take seconds."""
CREEP_TIME_S = 5.0
"""Time constant of the creep under a constant load."""
_DRIFT_SPREAD = 0.5
"""Standard deviation of the tactels' drift, as a share of the mean drift."""
_SECONDS_PER_MINUTE = 60.0
_SAME_TIME_S = 1e-9
"""Times closer than this are equal."""


class SensorMemory:
    """The state of one sensor between its images.

    A tactel's pressure p passes four stages, each exact for a pressure that is constant between two
    images:

    - lag: s' = (p - s) / lag;
    - hysteresis h: q = s + h (m - s), where m is the previous load. It follows s upwards at once
      and downwards with `RECOVERY_TIME_S`. So loading reads s, and quick unloading from P reads
      (1 - h) s + h P;
    - creep c: y = q + c r, with r' = (q - r) / `CREEP_TIME_S`. A load P reads
      P (1 + c (1 - exp(-t / CREEP_TIME_S)));
    - gain: each tactel's own factor.

    Drift is added to the counts and grows linearly with time. The reading arrives after the wait.

    Parameters
    ----------
    model
        The sensor's imperfections.
    readout
        The electronics.
    seed
        Source of gains and drifts, >= 0.
    """

    def __init__(self, model: SensorModel, readout: TactileReadout, seed: int = 0) -> None:
        count = readout.tactels
        rng = np.random.default_rng((seed, 1))
        self._model, self._readout = model, readout
        self._gains = np.exp(model.gain_spread * rng.standard_normal(count))
        spread = 1.0 + _DRIFT_SPREAD * rng.standard_normal(count)
        self._drifts = model.drift / _SECONDS_PER_MINUTE * spread
        self._remembers = model.lag > 0 or model.hysteresis > 0 or model.creep > 0
        self._states = np.zeros((3, count))
        self._sensed = np.zeros(count)
        self._start: float | None = None
        self._time = 0.0
        self._waiting: deque[tuple[float, NDArray[np.uint16]]] = deque()

    def sense(self, time: float, pressures: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the pressures that the electronics sense, (N,), Pa.

        Parameters
        ----------
        time
            Current time, s. The pressures are taken as constant since the last call.
        pressures
            (N,), Pa; negative ones, where the foam pulls, count as 0.
        """
        if self._start is None:
            self._start = self._time = time
        dt, self._time = max(time - self._time, 0.0), time
        model, sensed = self._model, self._sensed
        if not self._remembers:
            return np.maximum(pressures, 0.0) * self._gains
        kept = (
            exp(-dt / model.lag) if model.lag > 0 else 0.0,
            exp(-dt / RECOVERY_TIME_S),
            exp(-dt / CREEP_TIME_S),
        )
        shares = (model.hysteresis, model.creep)
        remember(pressures, self._gains, kept, shares, self._states, sensed)
        return sensed

    def read(
        self, time: float, pressures: NDArray[np.float64], rng: np.random.Generator
    ) -> NDArray[np.uint16]:
        """Take an image, and return the image that arrives now, (N,) uint16.

        Until the first image has arrived, that one is returned.

        Parameters
        ----------
        time
            Current time, s; not before that of the last image.
        pressures
            (N,), Pa.
        rng
            Source of the noise.
        """
        sensed = self.sense(time, pressures)
        shift = self._drifts * (time - (self._start or 0.0)) if self._model.drift > 0 else None
        raw = self._readout.raw(sensed, rng, shift)
        if self._model.wait == 0.0:
            return raw
        queue = self._waiting
        queue.append((time, raw))
        due = time - self._model.wait + _SAME_TIME_S
        while len(queue) > 1 and queue[1][0] <= due:
            queue.popleft()
        return queue[0][1]


@njit(cache=True)
def remember(pressures, gains, kept, shares, states, sensed):
    """Advance the memory of N tactels by one image (see :class:`SensorMemory`).

    Parameters
    ----------
    pressures, gains
        (N,) float64.
    kept
        Shares of the lag, of the previous load and of the creep that remain since the last image.
    shares
        Hysteresis and creep.
    states
        (3, N) float64, overwritten: the lagged pressure, the previous load, the crept load, Pa.
    sensed
        (N,) float64, overwritten, Pa.
    """
    for k in range(len(pressures)):
        pressure = max(pressures[k], 0.0)
        lagged = pressure + (states[0, k] - pressure) * kept[0]
        load = max(lagged + (states[1, k] - lagged) * kept[1], lagged)
        felt = lagged + shares[0] * (load - lagged)
        crept = felt + (states[2, k] - felt) * kept[2]
        states[0, k], states[1, k], states[2, k] = lagged, load, crept
        sensed[k] = gains[k] * (felt + shares[1] * crept)
