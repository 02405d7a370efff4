"""How much gain a servo loop can bear: what the filter, the arm and the wait leave of its phase."""

from __future__ import annotations

import math

from scipy.optimize import brentq

from eyehand.errors import InputError

HOLD_CYCLES = 0.5
"""A velocity command is held for a cycle: on average that is half a cycle's delay."""


def gain_limit(window: int, rate: float, lag: float, latency: float) -> float:
    """Give the loop gain beyond which a proportional servo oscillates, 1/s.

    The loop: the error times the gain is a velocity, which a first-order arm follows, the plant
    integrates, a moving average smooths, and which acts ``latency`` cycles later. The limit is the
    gain at which its phase reaches π with amplitude 1.

    Parameters
    ----------
    window
        Samples of the moving average, >= 1; 1 is no filter.
    rate
        Control rate, Hz, > 0.
    lag
        Time constant of the arm's velocity, s, >= 0.
    latency
        Cycles between the reading and the motion it causes, >= 0.

    Returns
    -------
    float
        In 1/s, to be compared with Kp times the plant's gain, e.g. Kp dp/dz.

    Raises
    ------
    InputError
        If a value is out of its range.
    """
    if window < 1 or not rate > 0 or not lag >= 0 or not latency >= 0:
        raise InputError(
            "a gain limit needs window >= 1, rate > 0, lag >= 0, latency >= 0, got "
            f"{window}, {rate}, {lag}, {latency}"
        )
    period = 1.0 / rate
    delay = period * (latency + HOLD_CYCLES + 0.5 * (window - 1))

    def phase_left(omega: float) -> float:
        return 0.5 * math.pi - omega * delay - math.atan(omega * lag)

    omega = float(brentq(phase_left, 0.0, 0.5 * math.pi / delay * (1 + 1e-9)))  # pyright: ignore[reportArgumentType] - without full_output it is a float
    return omega * math.hypot(1.0, omega * lag) / _average_amplitude(omega * period, window)


def _average_amplitude(angle: float, window: int) -> float:
    """Amplitude of a moving average at ``angle`` rad a sample."""
    if window == 1 or angle == 0.0:
        return 1.0
    return abs(math.sin(0.5 * window * angle) / (window * math.sin(0.5 * angle)))
