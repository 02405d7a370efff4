"""Commission a pad on an arm: a press of a plate shows its timing, another one its gains."""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import RigidTransform

from eyehand.data_synth.pad import (
    SENSORS,
    Foam,
    Part,
    PlacedObject,
    TouchObject,
    pad_scene,
    toy_box,
)
from eyehand.tactile import ServoOptions, Timing, flat_press_gains, identify_timing

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

PLATE = TouchObject("plate", (Part("box", (0.08, 0.08, 0.01), (0.0, 0.0, -0.01)),))
"""Flat plate that covers the pad of 80 x 80 mm."""
PLATE_APPROACH, PLATE_PRESSURE = 0.01, 800.0
"""Speed towards the plate, m/s, and the pressure at which the pad stops, Pa: 5 N on the pad."""
PLATE_SECONDS = 3.0
"""Maximum duration of the approach, s: ten times the way over the gap."""
STOP_CYCLES, HELD_IMAGES = 10, 50
"""Cycles until the arm stands, and number of averaged images."""


@lru_cache
def press_timing(sensor: SensorName) -> Timing:
    """Press a plate with a pad of a sensor model, and identify delay and lag."""
    rig = _rig_over(toy_box(), SEED, sensor)

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


@lru_cache
def pressed_gains(sensor: SensorName, seed: int) -> NDArray[np.float64] | None:
    """Press a flat plate with the pad of a seed, and measure its gains (N,); None for `ideal`.

    The pad that works later has rested since: the foam's memory of this press has faded.
    """
    if sensor == "ideal":
        return None
    rig = _rig_over(PLATE, seed, sensor)
    while rig.hand.features.pressure < PLATE_PRESSURE and rig.time < PLATE_SECONDS:
        rig.step(np.array([0.0, 0.0, PLATE_APPROACH, 0.0, 0.0, 0.0]))
    images = []
    for _ in range(STOP_CYCLES + HELD_IMAGES):
        rig.step(np.zeros(6))
        images.append(rig.hand.reader.image.pressures)
    return flat_press_gains(rig.hand.reader.image.array, np.array(images[STOP_CYCLES:]))


def _rig_over(pressed: TouchObject, seed: int, sensor: SensorName) -> ArmRig:
    """Return the rig with the pad of a seed above an object."""
    T_world_object = RigidTransform.from_translation(home_pose().apply([0.0, 0.0, GAP]))
    scene = pad_scene((PlacedObject(pressed, T_world_object),))
    return ArmRig(scene, seed=seed, options=RigOptions(sensor=sensor))
