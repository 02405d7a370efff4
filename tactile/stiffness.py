"""How stiff what is touched is: dp/dz by recursive least squares, from motion that is evidence."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numba import njit

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from .servo_options import ServoOptions

STIFFNESS, EVIDENCE, REF_PRESSURE, REF_DEPTH, ROLLED, WAITED, STARTED, EVENTS = range(8)
"""Places in the state: estimate, Pa/m; weight of evidence, m²; pressure (Pa) and depth (m) that
the next evidence counts from; edge travel by rolling since (m); updates since; whether there is a
reference; pieces of evidence so far."""

FIRST, TRAVEL, STEP, NOISE, FORGETTING, LEAST, MOST = range(7)
"""Places in the settings, see :func:`stiffness_settings`."""

CLEAR = 4.0
"""How many times the noise the expected change of pressure must be: the error of one piece of
evidence then stays near a third."""
LONGEST_WAIT = 250
"""Updates after which slow motion is no evidence any more: within a second other things move."""
ROLL_SHARE = 2.0
"""Largest travel of the imprint's edge by rolling, per travel along the normal, that evidence may
have: rolling changes the area and with it the pressure. Less starves
the estimate while a pad rolls flat."""


class StiffnessEstimate:
    """Estimate dp/dz while a pad moves on an object.

    One piece of evidence is a travel along the normal that is long enough to be told from noise;
    without such excitation the estimate stays as it is, and forgets nothing.

    Parameters
    ----------
    options
        First guess, bounds and gates; fields ``stiffness_*``.
    """

    def __init__(self, options: ServoOptions) -> None:
        self._settings = stiffness_settings(options)
        self._state = new_stiffness(self._settings)

    @property
    def value(self) -> float:
        """Estimated dp/dz, Pa/m."""
        return float(self._state[STIFFNESS])

    @property
    def events(self) -> int:
        """How many pieces of evidence came in."""
        return int(self._state[EVENTS])

    def update(self, pressure: float, depth: float, rolled: float = 0.0) -> float:
        """Take one reading and give the estimate, Pa/m.

        Parameters
        ----------
        pressure
            Pressure, Pa; if it is filtered, then ``depth`` must be filtered likewise.
        depth
            Way of the contact's point along the sensor's z, from anywhere, m.
        rolled
            Travel of the imprint's edge by rolling since the last reading, m, >= 0.
        """
        update_stiffness(self._state, self._settings, float(pressure), float(depth), float(rolled))
        return self.value

    def lose_contact(self) -> None:
        """Count the next evidence anew: the way through air changes no pressure."""
        self._state[STARTED] = 0.0


def stiffness_settings(options: ServoOptions) -> NDArray[np.float64]:
    """Give the fields that the update needs, as one array."""
    return np.array(
        [
            options.first_stiffness,
            options.stiffness_travel,
            options.stiffness_step,
            options.stiffness_noise,
            options.stiffness_forgetting,
            options.least_stiffness,
            options.most_stiffness,
        ]
    )


def new_stiffness(settings: NDArray[np.float64]) -> NDArray[np.float64]:
    """Give the state before any contact."""
    state = np.zeros(8)
    state[STIFFNESS] = settings[FIRST]
    state[EVIDENCE] = settings[TRAVEL] ** 2
    return state


@njit(cache=True)
def update_stiffness(state, settings, pressure, depth, rolled):
    """Take one reading: compiled step of :meth:`StiffnessEstimate.update`."""
    if state[STARTED] == 0.0:
        _refer(state, pressure, depth)
        return
    state[ROLLED] += rolled
    state[WAITED] += 1.0
    travel = depth - state[REF_DEPTH]
    # The gate asks for the change that is expected, never for the one that was seen: choosing by
    # what was seen would favour stiff readings.
    enough = max(settings[STEP], CLEAR * settings[NOISE] / state[STIFFNESS])
    if abs(travel) < enough:
        if state[WAITED] > LONGEST_WAIT:
            _refer(state, pressure, depth)
        return
    if state[ROLLED] <= ROLL_SHARE * abs(travel):
        state[EVIDENCE] = settings[FORGETTING] * state[EVIDENCE] + travel * travel
        gap = pressure - state[REF_PRESSURE] - state[STIFFNESS] * travel
        guess = state[STIFFNESS] + travel / state[EVIDENCE] * gap
        state[STIFFNESS] = min(max(guess, settings[LEAST]), settings[MOST])
        state[EVENTS] += 1.0
    _refer(state, pressure, depth)


@njit(cache=True)
def _refer(state, pressure, depth):
    state[REF_PRESSURE] = pressure
    state[REF_DEPTH] = depth
    state[ROLLED] = 0.0
    state[WAITED] = 0.0
    state[STARTED] = 1.0
