"""Estimate of the contact stiffness dp/dz by recursive least squares."""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

STIFFNESS, WEIGHT, REF_PRESSURE, REF_DEPTH, ROLLED, WAITED, STARTED, UPDATES = range(8)
"""Indices of the state: the estimate (Pa/m), the weight of the past measurements (m²), pressure
(Pa) and depth (m) of the reference, edge travel by rolling since the reference (m), readings since
the reference, whether there is a reference, and the number of measurements so far."""

INITIAL_STIFFNESS = 1e7
"""First guess, Pa/m. It is stiffer than real objects, so that the first gain is too low."""
MIN_STIFFNESS, MAX_STIFFNESS = 2e4, 1e8
"""Bounds of the estimate, Pa/m. They bound the press gain from above and from below."""
INITIAL_TRAVEL = 2e-5
"""Travel that has the same weight as the first guess, m. A smaller value trusts the first readings
more."""
MIN_TRAVEL = 5e-6
"""Minimum travel along the normal that is a measurement, m."""
PRESSURE_NOISE = 3.0
"""Standard deviation of the averaged pressure, Pa."""
NOISE_FACTOR = 4.0
"""The expected change of pressure must be this many times the noise. The error of one measurement
then stays near a third."""
FORGETTING = 0.9
"""Factor of the past weight at each new measurement. A smaller factor follows changes faster."""
MAX_WAIT = 250
"""Readings after which slow motion is no longer a measurement. Within a second, other things
move."""
MAX_ROLL_SHARE = 2.0
"""Maximum edge travel by rolling, per travel along the normal, of a valid measurement. Rolling
changes the area and thus the pressure. A smaller share would reject nearly all measurements while
a pad rolls flat."""


def new_stiffness(initial: float) -> NDArray[np.float64]:
    """Return the state of the estimator before any contact, (8,); `initial` in Pa/m."""
    state = np.zeros(8)
    reset_stiffness(state, initial)
    return state


@njit(cache=True)
def reset_stiffness(state, initial):
    """Set the estimate back to a first guess `initial`, Pa/m."""
    state[STIFFNESS] = initial
    state[WEIGHT] = INITIAL_TRAVEL**2
    state[UPDATES] = 0.0


@njit(cache=True)
def min_travel(state):
    """Return the shortest travel (m) whose expected change of pressure is above the noise.

    The limit depends on the expected change and never on the measured one: a selection by the
    measured change would prefer stiff readings.
    """
    return max(MIN_TRAVEL, NOISE_FACTOR * PRESSURE_NOISE / state[STIFFNESS])


@njit(cache=True)
def update_stiffness(state, pressure, depth, rolled):
    """Update the estimate with one reading.

    A measurement is a travel along the normal since the reference that is long enough. Without
    such motion the estimate stays as it is, and forgets nothing.

    Parameters
    ----------
    state
        (8,), updated in place.
    pressure
        Pressure, Pa. If it is filtered, `depth` must have the same filter.
    depth
        Position of the contact point along the sensor's z, from any origin, m.
    rolled
        Travel of the imprint's edge by rolling since the last reading, m, >= 0.
    """
    if state[STARTED] == 0.0:
        _set_reference(state, pressure, depth)
        return
    state[ROLLED] += rolled
    state[WAITED] += 1.0
    travel = depth - state[REF_DEPTH]
    if abs(travel) < min_travel(state):
        if state[WAITED] > MAX_WAIT:
            _set_reference(state, pressure, depth)
        return
    if state[ROLLED] <= MAX_ROLL_SHARE * abs(travel):
        state[WEIGHT] = FORGETTING * state[WEIGHT] + travel * travel
        rise = pressure - state[REF_PRESSURE]
        if rise * travel < 0.0:
            # The mean falls while the imprint grows, though the force rises. A softness from that
            # would raise the gain: a pad on a pen then reached 1.23 times its goal, now 1.15.
            rise = 0.0
        residual = rise - state[STIFFNESS] * travel
        estimate = state[STIFFNESS] + travel / state[WEIGHT] * residual
        state[STIFFNESS] = min(max(estimate, MIN_STIFFNESS), MAX_STIFFNESS)
        state[UPDATES] += 1.0
    _set_reference(state, pressure, depth)


@njit(cache=True)
def _set_reference(state, pressure, depth):
    state[REF_PRESSURE] = pressure
    state[REF_DEPTH] = depth
    state[ROLLED] = 0.0
    state[WAITED] = 0.0
    state[STARTED] = 1.0
