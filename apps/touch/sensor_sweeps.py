"""Stress sweeps over imperfections and faults of the sensor."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from eyehand.data_synth.pad import SensorModel, pen, soft_ball, toy_box
from eyehand.errors import InputError
from eyehand.tactile import FeatureOptions

from ..bench import Sweep, Trial, as_sweep
from .stress_trial import CALM_CONTACT, hold_contact, servo_phases
from .stress_world import START_HEIGHT, CarriedPad, Electronics

FAULTS = (0.0, 2.0, 5.0, 10.0, 15.0, 20.0, 24.0, 26.0, 30.0, 50.0, 75.0, 95.0, 100.0)
"""Percentages of faulty tactels. The phase machine rejects a pad from 25 % on. A pad without any
working tactel cannot be calibrated."""


@as_sweep(
    "threshold", "contact threshold above the rest reading, in standard deviations of the noise",
    "", (6.0, 4.0, 3.0, 2.5, 2.0, 1.5, 1.0, 0.5), holds_to=4.0,
    right=f"{CALM_CONTACT} on a pen",
)  # fmt: skip
def _threshold(sigmas: float, seed: int, sensor: SensorModel) -> Trial:
    pad = CarriedPad((pen(),), Electronics(seed, sensor), features=FeatureOptions(sigmas=sigmas))
    return hold_contact(pad, servo_phases("track", sensor))


def _fault_sweep(fault: str, axis: str) -> Sweep[SensorModel]:
    @as_sweep(fault, axis, "%", FAULTS, holds_to=5.0, right=f"{CALM_CONTACT} on a soft ball")
    def attempt(percent: float, seed: int, sensor: SensorModel) -> Trial:
        try:
            faulty = replace(sensor, **{fault: 0.01 * percent})
            pad = CarriedPad((soft_ball(),), Electronics(seed, faulty))
        except InputError as error:
            # The pad is rejected before any motion: `0 of 256 tactels work`.
            return Trial(passed=False, refused=True, note=str(error).split(":")[0])
        return hold_contact(pad, servo_phases("track", sensor))

    return attempt


IMPERFECTIONS = {
    "wait": ("time from a reading to its arrival", "ms", 1e-3, (0, 8, 16, 24, 32, 48, 64), 8),
    "lag": ("time constant of the readings", "ms", 1e-3, (0, 10, 25, 50, 100, 200), 10),
    "gain_spread": ("deviation of the tactels' gains since calibration", "%", 0.01,
                    (0, 10, 20, 40, 60, 80), 10),
    "hysteresis": ("share of the load that remains after unloading", "%", 0.01,
                   (0, 5, 10, 20, 40, 60), 10),
    "creep": ("rise of the readings under a constant load", "%", 0.01, (0, 5, 15, 30, 60), 5),
    "drift": ("drift of the readings at rest", "counts/min", 1.0, (0, 3, 6, 12, 30, 60), 6),
    "shear": ("share of the foam's thickness over which friction turns the layer", "%", 0.01,
              (0, 25, 50, 100), 100),
}  # fmt: skip
"""Field of `SensorModel` → axis, unit, factor to SI, values, and the value up to which contacts
must hold."""
SENSOR_SECONDS = 6.0
"""Time limit of these contacts, s. With a slow sensor they settle, or end, within it."""
OFFSET = 0.008
"""Distance of the box from the middle of the pad, m."""
DEAD_ROWS = (0.0, 1.0, 2.0, 3.0, 4.0, 6.0, 8.0)
"""Numbers of dead rows of 16. A loose flat cable makes them. The pad is rejected from 5 rows on."""


def _imperfection_sweep(name: str) -> Sweep[SensorModel]:
    axis, unit, factor, values, bound = IMPERFECTIONS[name]

    @as_sweep(name.replace("_", "-"), axis, unit, values, holds_to=bound,
              right=f"{CALM_CONTACT} on a pen")  # fmt: skip
    def attempt(value: float, seed: int, sensor: SensorModel) -> Trial:
        worse = replace(sensor, **{name: factor * value})
        pad = CarriedPad((pen(),), Electronics(seed, worse))
        return hold_contact(pad, servo_phases("track", worse), SENSOR_SECONDS)

    return attempt


@as_sweep(
    "backlash", "free play of the carrier along the pad's normal", "mm",
    (0.0, 0.01, 0.03, 0.1, 0.3), holds_to=0.03, right=f"{CALM_CONTACT} on a pen",
)  # fmt: skip
def _backlash(play: float, seed: int, sensor: SensorModel) -> Trial:
    pad = CarriedPad((pen(),), Electronics(seed, sensor), play=1e-3 * play)
    return hold_contact(pad, servo_phases("track", sensor))


@as_sweep(
    "friction", "static friction of a plate that the pad slides on, with shear", "",
    (0.0, 0.3, 0.6, 1.0, 1.5), holds_to=1.0, right=f"{CALM_CONTACT} on a box off the centre",
)  # fmt: skip
def _friction(friction: float, seed: int, sensor: SensorModel) -> Trial:
    sheared = replace(sensor, shear=1.0)
    place = (OFFSET, 0.0, START_HEIGHT)
    pad = CarriedPad((toy_box(),), Electronics(seed, sheared), place=place, friction=friction)
    return hold_contact(pad, servo_phases("track", sheared))


@as_sweep(
    "dead-rows", "dead rows of 16", "", DEAD_ROWS, holds_to=1.0,
    right=f"{CALM_CONTACT} on a soft ball",
)  # fmt: skip
def _dead_rows(rows: float, seed: int, sensor: SensorModel) -> Trial:
    first = np.random.default_rng(seed).permutation(16)[: int(rows)]
    dead = tuple((16 * first[:, None] + np.arange(16)).ravel().tolist())
    pad = CarriedPad((soft_ball(),), Electronics(seed, sensor, dead))
    return hold_contact(pad, servo_phases("track", sensor))


SENSOR_SWEEPS = (
    _threshold,
    *(_imperfection_sweep(name) for name in IMPERFECTIONS),
    _backlash,
    _friction,
    _dead_rows,
    _fault_sweep("dead", "tactels that read nothing"),
    _fault_sweep("saturated", "tactels that read full scale"),
)
"""Sweeps over the sensor."""
