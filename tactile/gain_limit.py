"""Limit of the loop gain of a servo with filter, lag and delay."""

from __future__ import annotations

import math

from scipy.optimize import brentq

from eyehand.errors import InputError

HOLD_CYCLES = 0.5
"""Mean delay of a velocity command, cycles. The command is held for one cycle."""


def gain_limit(window: int, rate: float, lag: float, latency: float) -> float:
    """Compute the loop gain beyond which a proportional servo oscillates, 1/s.

    The loop: error times gain is a velocity command, an arm with first-order lag follows it, and
    the plant integrates the velocity. A moving average filters the reading, which acts `latency`
    cycles later. The limit is the gain at which the loop has phase π and amplitude 1.

    Parameters
    ----------
    window
        Samples of the moving average, >= 1; 1 means no filter.
    rate
        Control rate, Hz, > 0.
    lag
        Time constant of the arm's velocity, s, >= 0.
    latency
        Cycles between a reading and the motion that it causes, >= 0.

    Returns
    -------
    float
        1/s; to be compared with Kp times the plant's gain, for example Kp dp/dz.

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

    def phase_margin(omega: float) -> float:
        return 0.5 * math.pi - omega * delay - math.atan(omega * lag)

    omega = float(brentq(phase_margin, 0.0, 0.5 * math.pi / delay * (1 + 1e-9)))  # pyright: ignore[reportArgumentType] - without full_output it is a float
    return omega * math.hypot(1.0, omega * lag) / _average_amplitude(omega * period, window)


def _average_amplitude(angle: float, window: int) -> float:
    """Return the amplitude of a moving average at `angle` rad per sample."""
    if window == 1 or angle == 0.0:
        return 1.0
    return abs(math.sin(0.5 * window * angle) / (window * math.sin(0.5 * angle)))
