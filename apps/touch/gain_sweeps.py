"""Gains raised to twice the limit, and landings that get faster."""

from __future__ import annotations

from typing import TYPE_CHECKING

from eyehand.data_synth.pad import pen, soft_ball, toy_box
from eyehand.tactile import PRESETS, PhaseOptions, ServoOptions, TactileServo, TouchPhases

from ..bench import Sweep
from .stress_trial import judged, lead
from .stress_world import CarriedPad, Electronics

if TYPE_CHECKING:
    from collections.abc import Callable

    from eyehand.data_synth.pad import TouchObject

    from ..bench import Trial

UNCAPPED = 1e3
"""Gain that caps nothing, 1/s, so that the share of the limit alone counts."""
START_HEIGHT = 0.012
"""Room in which a fast approach comes up to speed, m."""


def gain_sweeps() -> tuple[Sweep[None], ...]:
    """Sweeps over gains and speeds of landing, object by object."""
    things = {"pen": pen, "box": toy_box, "ball": soft_ball}
    gains = [
        Sweep(
            name=f"gain-{name}",
            axis="press gain, as a share of the limit",
            unit="",
            values=(0.25, 0.5, 0.75, 1.0, 1.25, 1.5, 2.0, 4.0),
            holds_to=0.5,
            attempt=_gain(thing),
            right="pressure reached and calm",
        )
        for name, thing in things.items()
    ]
    landings = [
        Sweep(
            name=f"landing-{name}{'' if guarded else '-windup'}",
            axis=f"speed of landing, {'with' if guarded else 'without'} anti-windup",
            unit="mm/s",
            values=(10.0, 20.0, 50.0, 100.0, 200.0),
            holds_to=50.0,
            attempt=_landing(thing, guarded),
            right="pressure reached and calm",
        )
        for name, thing in things.items()
        for guarded in (True, False)
    ]
    return (*gains, *landings)


def _gain(thing: Callable[[], TouchObject]) -> Callable[[float, int, None], Trial]:
    def attempt(share: float, seed: int, method: None) -> Trial:
        options = ServoOptions(stability_share=share, press_gain=UNCAPPED)
        servo = TactileServo(selection=PRESETS["track"], options=options)
        pad = CarriedPad((thing(),), Electronics(seed))
        return judged(lead(pad, TouchPhases(servo)), servo.goal.pressure)

    return attempt


def _landing(thing: Callable[[], TouchObject], guarded: bool) -> Callable[..., Trial]:
    def attempt(speed: float, seed: int, method: None) -> Trial:
        servo = TactileServo(selection=PRESETS["track"], options=ServoOptions(anti_windup=guarded))
        phases = TouchPhases(servo, PhaseOptions(approach_speed=1e-3 * speed))
        pad = CarriedPad((thing(),), Electronics(seed), place=(0.0, 0.0, START_HEIGHT))
        return judged(lead(pad, phases, 4.0), servo.goal.pressure)

    return attempt
