"""Stress sweeps over sensor faults: threshold in the noise, dead tactels, saturated tactels."""

from __future__ import annotations

from eyehand.data_synth.pad import SensorModel, pen, soft_ball
from eyehand.errors import InputError
from eyehand.tactile import FeatureOptions

from ..bench import Sweep, Trial, as_sweep
from .stress_trial import CALM_CONTACT, hold_contact, servo_phases
from .stress_world import CarriedPad, Electronics

FAULTS = (0.0, 2.0, 5.0, 10.0, 15.0, 20.0, 24.0, 26.0, 30.0, 50.0, 75.0, 95.0, 100.0)
"""Percentages of faulty tactels. The phase machine rejects a pad from 25 % on. A pad without any
working tactel cannot be calibrated."""


@as_sweep(
    "threshold", "contact threshold above the rest reading, in standard deviations of the noise",
    "", (6.0, 4.0, 3.0, 2.5, 2.0, 1.5, 1.0, 0.5), holds_to=4.0,
    right=f"{CALM_CONTACT} on a pen",
)  # fmt: skip
def _threshold(sigmas: float, seed: int, method: None) -> Trial:
    pad = CarriedPad((pen(),), Electronics(seed), features=FeatureOptions(sigmas=sigmas))
    return hold_contact(pad, servo_phases("track"))


def _fault_sweep(fault: str, axis: str) -> Sweep[None]:
    @as_sweep(fault, axis, "%", FAULTS, holds_to=5.0, right=f"{CALM_CONTACT} on a soft ball")
    def attempt(percent: float, seed: int, method: None) -> Trial:
        try:
            pad = CarriedPad(
                (soft_ball(),), Electronics(seed, SensorModel(**{fault: 0.01 * percent}))
            )
        except InputError as error:
            # The pad is rejected before any motion: `0 of 256 tactels work`.
            return Trial(passed=False, refused=True, note=str(error).split(":")[0])
        return hold_contact(pad, servo_phases("track"))

    return attempt


SENSOR_SWEEPS = (
    _threshold,
    _fault_sweep("dead", "tactels that read nothing"),
    _fault_sweep("saturated", "tactels that read full scale"),
)
"""Sweeps over sensor faults."""
