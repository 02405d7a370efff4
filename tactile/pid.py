"""PID of one feature with anti-windup, eq. (13), compiled."""

from __future__ import annotations

from typing import NamedTuple

from numba import njit

from .servo_memory import HAS_LAST, INTEGRAL_X, LAST_X

INTEGRAL_SHARE = 0.25
"""Maximum share of a speed limit that an integral part may command. A smaller share gives a softer
contact, a larger one compensates faster drifts."""


class PidLaw(NamedTuple):
    """Gains and limits of one feature in eq. (13)."""

    gain: float
    """m/s per unit of the error."""
    band: float
    """Error within which the integral grows."""
    min_speed: float
    """m/s."""
    max_speed: float
    """m/s."""
    lead: float
    """Lead of the derivative part, s."""


@njit(cache=True)
def pid_speed(settings, memory, feature, error, law, dt):
    """Return the speed (m/s) of eq. (13) for feature 0 (x), 1 (y) or 2 (pressure).

    With anti-windup, the integral grows only near the goal and below the speed limit. Far from the
    goal, an error of the opposite sign reduces the integral to zero.
    """
    total, last = INTEGRAL_X + feature, LAST_X + feature
    slope = (error - memory[last]) / dt if memory[HAS_LAST] > 0.0 else 0.0
    memory[last] = error
    before = memory[total]
    speed = law.gain * (error + law.lead * slope) + before
    growth = law.gain / settings.integral_time * error * dt
    low, high = law.min_speed, law.max_speed
    if settings.anti_windup == 0.0:
        memory[total] += growth
    elif abs(error) <= law.band:
        if not ((speed > high and growth > 0.0) or (speed < low and growth < 0.0)):
            memory[total] = min(max(before + growth, INTEGRAL_SHARE * low), INTEGRAL_SHARE * high)
    elif before * growth < 0.0:
        # A kept integral would hold the error at which it balances the proportional part.
        memory[total] = before + growth if abs(growth) < abs(before) else 0.0
    return min(max(speed, low), high)
