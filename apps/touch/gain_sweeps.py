"""Stress sweeps over the press gain and the landing speed."""

from __future__ import annotations

from collections.abc import Callable

from eyehand.data_synth.pad import SensorModel, TouchObject, pen, soft_ball, toy_box
from eyehand.errors import InputError
from eyehand.tactile import PhaseOptions, TouchPhases

from ..bench import Sweep, Trial, as_sweep
from .stress_trial import CALM_CONTACT, hold_contact, servo_phases
from .stress_world import CYCLE, LAG, CarriedPad, Electronics

UNCAPPED = 1e3
"""Press gain far above the stability limit, 1/s. The loop gain is then the chosen fraction of the
limit."""
LANDING_SPEEDS = {"pen": 50.0, "box": 20.0, "ball": 50.0}
"""Landing speeds up to which each object must be held with anti-windup, mm/s."""
START_HEIGHT = 0.012
"""Initial height of the pad, m. A fast approach reaches its speed within it."""


def gain_sweeps() -> tuple[Sweep[SensorModel], ...]:
    """Return the sweeps over gains and landing speeds, for each object."""
    objects = {"pen": pen, "box": toy_box, "ball": soft_ball}
    gains = [_gain_sweep(name, make_object) for name, make_object in objects.items()]
    landings = [
        _landing_sweep(name, make_object, anti_windup)
        for name, make_object in objects.items()
        for anti_windup in (True, False)
    ]
    return (*gains, *landings)


def _gain_sweep(name: str, make_object: Callable[[], TouchObject]) -> Sweep[SensorModel]:
    @as_sweep(
        f"gain-{name}", "press gain as a fraction of the stability limit", "",
        (0.25, 0.5, 0.75, 1.0, 1.25, 1.5, 2.0, 4.0), holds_to=0.5, right=CALM_CONTACT,
    )  # fmt: skip
    def attempt(share: float, seed: int, sensor: SensorModel) -> Trial:
        # The share refers to the true limit, so the servo has the true delay and lags here.
        timing = {"latency": 1 + round(sensor.wait / CYCLE), "arm_lag": LAG + sensor.lag}
        gains = {"stability_share": share, "press_gain": UNCAPPED}
        phases = servo_phases("track", sensor, **timing, **gains)
        return hold_contact(CarriedPad((make_object(),), Electronics(seed, sensor)), phases)

    return attempt


def _landing_sweep(
    name: str, make_object: Callable[[], TouchObject], anti_windup: bool
) -> Sweep[SensorModel]:
    @as_sweep(
        f"landing-{name}{'' if anti_windup else '-windup'}",
        f"landing speed {'with' if anti_windup else 'without'} anti-windup", "mm/s",
        (10.0, 20.0, 50.0, 100.0, 200.0), right=CALM_CONTACT,
        # Without anti-windup the peak is too high from the slowest landing on.
        holds_to=LANDING_SPEEDS[name] if anti_windup else None,
    )  # fmt: skip
    def attempt(speed: float, seed: int, sensor: SensorModel) -> Trial:
        servo = servo_phases("track", sensor, anti_windup=anti_windup).servo
        try:
            phases = TouchPhases(servo, PhaseOptions(approach_speed=1e-3 * speed))
        except InputError as error:
            return Trial(passed=False, refused=True, note=str(error).split(",")[0])
        pad = CarriedPad(
            (make_object(),), Electronics(seed, sensor), place=(0.0, 0.0, START_HEIGHT)
        )
        return hold_contact(pad, phases, 4.0)

    return attempt
