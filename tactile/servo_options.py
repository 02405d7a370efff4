"""Every choice of the tactile servo, with its unit and what it trades."""

from __future__ import annotations

from dataclasses import dataclass, fields

from eyehand.errors import InputError

from .gain_limit import gain_limit


@dataclass(frozen=True)
class ServoOptions:
    """Options of the servo; one setting serves soft and stiff objects.

    Raises
    ------
    InputError
        If a value is out of its range.
    """

    rate: float = 250.0
    """Control rate, Hz; only the allowed gains are derived from it, steps bring their own dt."""
    window: int = 6
    """Samples of pressure averaged: more is calmer, and costs phase and so gain. The chapter has
    10."""
    orientation_window: int = 10
    """Samples of the orientation averaged, in the doubled angle."""
    arm_lag: float = 0.015
    """Time constant with which the arm follows a velocity, s: too small a guess allows too much
    gain."""
    latency: float = 1.0
    """Cycles between a reading and the motion that it causes."""
    stability_share: float = 0.25
    """Share of the limit of the loop gain that is used: a quarter settles without ringing, 1 is
    the verge, more is for seeing what happens."""
    press_gain: float = 14.0
    """Largest loop gain Kp dp/dz of the pressure, 1/s: higher answers faster and rings more."""
    slide_gain: float = 24.0
    """Largest loop gain of the centre of pressure by sliding, 1/s."""
    roll_gain: float = 16.0
    """Largest loop gain of the centre of pressure by rolling, 1/s."""
    roll_ratio: float = 40.0
    """Largest angular velocity per offset of the centre of pressure, rad/(m s)."""
    turn_gain: float = 8.0
    """Largest loop gain of the orientation, 1/s."""
    slide_while_rolling: float = 0.02
    """Share of the sliding gain that is left along an axis where rolling is on: sliding to an
    edge's imprint takes away the offset that rolling needs."""
    press_integral_time: float = 0.3
    """Time in which the integral doubles the press velocity of a constant error, s; inf is none.
    Four over the loop gain leaves no slow tail."""
    slide_integral_time: float = 0.3
    """Likewise of sliding."""
    press_integral_band: float = 0.2
    """Error within which the integral grows, as a share of the goal's pressure: wider holds
    against faster drifts, and overshoots more after landing."""
    slide_integral_band: float = 0.002
    """Likewise of sliding, m."""
    press_derivative_time: float = 0.0
    """Lead of the press loop, s: takes back some of the arm's lag and amplifies noise."""
    slide_derivative_time: float = 0.0
    """Lead of the sliding loop, s."""
    press_speed: float = 0.04
    """Fastest pressing, m/s: together with the lag this bounds the overshoot on a stiff object."""
    retreat_speed: float = 0.05
    """Fastest giving way along the normal, m/s."""
    slide_speed: float = 0.1
    """Fastest sliding, m/s."""
    roll_speed: float = 0.6
    """Fastest rolling, rad/s."""
    turn_speed: float = 1.0
    """Fastest turning, rad/s."""
    integral_share: float = 0.25
    """Largest share of a speed limit that the integral may ask for: less lands softer, more holds
    against faster drifts."""
    anti_windup: bool = True
    """Whether integrals are clamped, stopped at the speed limit, and forgotten when contact is
    lost. Only for seeing what happens without."""
    confidence_low: float = 0.25
    """Confidence of the orientation up to which the pad does not turn at all."""
    confidence_high: float = 0.6
    """Confidence from which it turns with the full gain."""
    confidence_area: float = 1.5e-4
    """Least area of an imprint whose orientation counts, m²: two touched tactels are a line too,
    whatever touches them."""
    adapt: bool = True
    """Whether the press gain follows the estimated stiffness; else the first guess stays."""
    first_stiffness: float = 1e7
    """First guess of dp/dz, Pa/m: stiffer than the objects, so that the first gain is too low."""
    least_stiffness: float = 2e4
    """Lower bound of dp/dz, Pa/m: bounds the gain from above."""
    most_stiffness: float = 1e8
    """Upper bound of dp/dz, Pa/m: bounds the gain from below."""
    stiffness_travel: float = 2e-5
    """Travel that weighs as much as the first guess, m: smaller trusts the first readings more."""
    stiffness_step: float = 5e-6
    """Least motion along the normal that is evidence of stiffness, m."""
    stiffness_noise: float = 3.0
    """Noise of the averaged pressure, Pa: motion that should change the pressure by less than a
    few times this is no evidence."""
    stiffness_forgetting: float = 0.9
    """Weight that old evidence keeps with each new one: less follows changes faster."""
    reference_area: float = 1e-3
    """Area by which a goal of force is made a pressure, m²: so that the bounds of dp/dz hold."""
    printed_signs: bool = False
    """Whether rows 4 and 5 of eq. 15 are both +1, as printed: rolling about x then tilts the pad
    more and more. Only for seeing that."""

    def __post_init__(self) -> None:
        for field in fields(self):
            value = getattr(self, field.name)
            if field.name.endswith("integral_time"):
                _check(field.name, value, value > 0, "> 0 s")
            elif not isinstance(value, bool):
                _check(field.name, value, 0 <= value < float("inf"), "finite and >= 0")
        for name in ("rate", "first_stiffness", "least_stiffness", "reference_area",
                     "stiffness_step", "stiffness_travel"):  # fmt: skip
            _check(name, getattr(self, name), getattr(self, name) > 0, "> 0")
        for name in ("window", "orientation_window"):
            _check(name, getattr(self, name), 1 <= getattr(self, name) <= MOST_SAMPLES, "1 to 100")
        _check("stiffness_forgetting", self.stiffness_forgetting,
               0 < self.stiffness_forgetting <= 1, "in (0, 1]")  # fmt: skip
        _check("confidence_low", self.confidence_low,
               self.confidence_low < self.confidence_high, "below confidence_high")  # fmt: skip
        _check("confidence_high", self.confidence_high, self.confidence_high <= 1, "<= 1")
        for low, high in (("least_stiffness", "first_stiffness"),
                          ("first_stiffness", "most_stiffness")):  # fmt: skip
            _check(low, getattr(self, low), getattr(self, low) <= getattr(self, high), f"<= {high}")

    def press_loop_gain(self) -> float:
        """Loop gain Kp dp/dz that the filter, the arm and the wait allow, 1/s."""
        return self._allowed(self.press_gain, self.window)

    def slide_loop_gain(self) -> float:
        """Loop gain of sliding, whose feature is not filtered, 1/s."""
        return self._allowed(self.slide_gain, 1)

    def roll_loop_gain(self) -> float:
        """Loop gain of rolling, 1/s."""
        return self._allowed(self.roll_gain, 1)

    def turn_loop_gain(self) -> float:
        """Loop gain of turning, 1/s."""
        return self._allowed(self.turn_gain, self.orientation_window)

    def press_limit(self) -> float:
        """Loop gain Kp dp/dz at which pressing oscillates, 1/s."""
        return gain_limit(self.window, self.rate, self.arm_lag, self.latency)

    def _allowed(self, gain: float, window: int) -> float:
        limit = gain_limit(window, self.rate, self.arm_lag, self.latency)
        return min(gain, self.stability_share * limit)


MOST_SAMPLES = 100
"""Longest moving average: at 250 Hz more than 0.4 s would leave no gain worth having."""


def _check(name: str, value: object, good: bool, want: str) -> None:
    if not good:
        raise InputError(f"{name} must be {want}, got {value}")
