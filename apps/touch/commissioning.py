"""Commission a pad on an arm: press a plate once, and set the servo for what the press shows."""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import RigidTransform

from eyehand.data_synth.pad import SENSORS, Foam, PlacedObject, pad_scene, toy_box
from eyehand.tactile import ServoOptions, Timing, identify_timing

from .arm_rig import CYCLE, ArmRig, RigOptions, SensorName, home_pose

SEED = 20000
"""Seed of the pad that is commissioned: no experiment uses it."""
GAP = 0.002
"""Initial distance from the pad to the plate, m."""
APPROACH, PRESS = 0.02, 500.0
"""Speed towards the plate, m/s, and the pressure at which it ends, Pa."""
SHAKE_SECONDS = 1.2
"""Duration of the shaking in contact, s."""
SHAKE = ((0.010, 3.0), (0.012, 8.0))
"""Amplitudes, m/s, and frequencies, 1/s, of the shaking along the normal."""


@lru_cache
def press_timing(sensor: SensorName) -> Timing:
    """Press a plate with a pad of a sensor model, and identify delay and lag."""
    placed = PlacedObject(
        toy_box(), RigidTransform.from_translation(home_pose().apply([0.0, 0.0, GAP]))
    )
    rig = ArmRig(pad_scene((placed,)), seed=SEED, options=RigOptions(sensor=sensor))

    def step(twist: NDArray[np.float64]) -> float:
        rig.step(twist)
        return rig.hand.features.pressure

    return shaken_press(step)


def shaken_press(step: Callable[[NDArray[np.float64]], float]) -> Timing:
    """Press an object and shake the pad along its normal, and identify delay and lag.

    Parameters
    ----------
    step
        Command a twist (6,) for one cycle, and return the pressure that is then read, Pa.
    """
    commands, pressures = [], [0.0]
    shaken = 0.0
    while shaken < SHAKE_SECONDS and len(commands) * CYCLE < SHAKE_SECONDS + 2.0:
        speed = APPROACH
        if shaken > 0.0 or pressures[-1] > PRESS:
            speed = sum(a * np.sin(2 * np.pi * f * shaken) for a, f in SHAKE)
            shaken += CYCLE
        commands.append(speed)
        pressures.append(step(np.array([0.0, 0.0, speed, 0.0, 0.0, 0.0])))
    return identify_timing(np.array(commands), np.array(pressures[1:]), CYCLE)


def commissioned(sensor: SensorName) -> ServoOptions:
    """Return the options of a servo for a sensor model, with the timing that a press shows.

    The thickness of the foam is known from its data sheet.
    """
    timing = press_timing(sensor)
    lever = Foam().thickness if SENSORS[sensor].shear > 0 else 0.0
    return ServoOptions(latency=timing.latency, arm_lag=timing.lag, shear_lever=lever)
