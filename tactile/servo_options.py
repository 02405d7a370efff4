"""Options of the tactile servo, and the largest gain at which it is stable."""

from __future__ import annotations

import math
from dataclasses import dataclass, fields

from scipy.optimize import brentq

from eyehand.errors import InputError

from .stiffness import MAX_STIFFNESS, MIN_STIFFNESS

MAX_WINDOW = 100
"""Maximum length of a moving average, samples. At 250 Hz, a longer one leaves no useful gain."""
ORIENTATION_WINDOW = 10
"""Number of samples in the average of the orientation, as in Haschke's chapter."""
ROLL_GAIN = 16.0
"""Upper bound of the loop gain of rolling, 1/s."""
TURN_GAIN = 8.0
"""Upper bound of the loop gain of turning, 1/s."""

REST_FACTOR, REST_SHARE = 2.0, 0.5
"""Factor of the loop gain of pressing after a landing, and its maximum as a share of the gain at
which the loop oscillates. With the sensor `real`, a box that comes at 8 mm/s raised the pressure to
1.46 times its goal before, and to 1.11 times with it."""

HOLD_CYCLES = 0.5
"""Mean delay of a velocity command, cycles. The command is held for one cycle."""


@dataclass(frozen=True)
class ServoOptions:
    """Gains, filter, limits, and the timing of the robot.

    One setting serves soft and stiff objects, because the servo estimates the stiffness. Set
    `rate`, `arm_lag` and `latency` to the values of your robot: the allowed gains follow from them.

    Raises
    ------
    InputError
        If a value is out of its range.
    """

    rate: float = 250.0
    """Control rate, Hz. It only serves to compute the allowed gains; each step has its own dt."""
    arm_lag: float = 0.015
    """Time constant with which the arm follows a velocity command, s. A value below the true one
    allows too much gain."""
    latency: float = 1.0
    """Delay between a reading and the motion that it causes, control cycles."""
    window: int = 6
    """Samples of the pressure that are averaged, 1 to 100. More samples reduce noise, but their
    delay reduces the allowed gain. Haschke's chapter averages 10."""
    shear_lever: float = 0.0
    """Height of the foam, m, by which friction moves the centre of pressure (h Ft / Fn). With it,
    the servo estimates the true place from its own motion and `TactileServo.side_force`; 0 takes
    the measured centre."""
    stability_share: float = 0.25
    """Used share of the loop gain at which the loop oscillates. 0.25 settles without ringing. A pad
    that has landed uses twice the share for its pressure, up to half."""
    press_gain: float = 14.0
    """Upper bound of the loop gain Kp dp/dz of the pressure while the pad lands, 1/s. A higher gain
    answers faster and rings more. After the landing it is up to twice as high, while the pad
    lacks less than 0.6 of its goal."""
    slide_gain: float = 24.0
    """Upper bound of the loop gain of sliding, 1/s."""
    integral_time: float = 0.3
    """Time in which the integral part doubles the response to a constant error, s; inf switches it
    off. A shorter time removes an error faster and overshoots more. It is at least 33 times the
    latency."""
    derivative_time: float = 0.0
    """Lead of the derivative part, s. It compensates some of the arm's lag and amplifies noise."""
    anti_windup: bool = True
    """Whether the integrals are bounded, and cleared when contact is lost."""
    known_stiffness: float | None = None
    """Stiffness dp/dz of the object, Pa/m, if it is known; None estimates it during contact."""
    press_speed: float = 0.04
    """Speed limit towards the object, m/s. A lower limit reduces the overshoot on stiff objects."""
    slide_speed: float = 0.1
    """Speed limit along x and along y, m/s."""
    roll_speed: float = 0.6
    """Speed limit about x and about y, rad/s."""
    turn_speed: float = 1.0
    """Speed limit about z, rad/s."""

    def __post_init__(self) -> None:
        for field in fields(self):
            value = getattr(self, field.name)
            if value is None or isinstance(value, bool):
                continue
            if field.name == "integral_time":
                _check(field.name, value, value > 0, "> 0 s")
            else:
                _check(field.name, value, 0 <= value < float("inf"), "finite and >= 0")
        _check("rate", self.rate, self.rate > 0, "> 0 Hz")
        _check("window", self.window, 1 <= self.window <= MAX_WINDOW, f"1 to {MAX_WINDOW}")
        known = self.known_stiffness
        if known is not None:
            good = MIN_STIFFNESS <= known <= MAX_STIFFNESS
            _check("known_stiffness", known, good, f"{MIN_STIFFNESS:g} to {MAX_STIFFNESS:g} Pa/m")

    def press_loop_gain(self) -> float:
        """Return the loop gain Kp dp/dz of pressing, 1/s, within the stability limit."""
        return self._allowed(self.press_gain, self.window)

    def rest_loop_gain(self) -> float:
        """Return the loop gain of pressing after the landing, 1/s."""
        landing = self.press_loop_gain()
        limit = gain_limit(self.window, self.rate, self.arm_lag, self.latency)
        return max(landing, min(REST_FACTOR * landing, REST_SHARE * limit))

    def slide_loop_gain(self) -> float:
        """Return the loop gain of sliding, 1/s; the centre of pressure is not filtered."""
        return self._allowed(self.slide_gain, 1)

    def roll_loop_gain(self) -> float:
        """Return the loop gain of rolling, 1/s; the centre of pressure is not filtered."""
        return self._allowed(ROLL_GAIN, 1)

    def turn_loop_gain(self) -> float:
        """Return the loop gain of turning, 1/s."""
        return self._allowed(TURN_GAIN, ORIENTATION_WINDOW)

    def _allowed(self, gain: float, window: int) -> float:
        limit = gain_limit(window, self.rate, self.arm_lag, self.latency)
        return min(gain, self.stability_share * limit)


def _check(name: str, value: object, good: bool, want: str) -> None:
    if not good:
        raise InputError(f"{name} must be {want}, got {value}")


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
