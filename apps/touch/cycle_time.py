"""Measure the computing time of a servo cycle and of a simulated image."""

from __future__ import annotations

import time
from collections.abc import Callable

import numpy as np
from scipy.spatial.transform import RigidTransform

from eyehand.data_synth.pad import PlacedObject, pad_scene, toy_box
from eyehand.tactile import ServoGoal, TactileServo, TouchPhases

from .arm_rig import CYCLE, ArmRig, home_pose
from .servo_run import run_servo

CYCLES = 2000
"""Number of calls that are timed one by one. The result is their median."""
SETTLE = 0.5
"""Servo time before the measurement, s. Kernels are compiled and a contact exists after it."""


def cycle_times(seed: int) -> dict[str, float]:
    """Measure the computing time of one cycle on a toy box.

    Returns
    -------
    dict
        `servo_cycle_us`: time of calibration, features and servo. `image_us`: time of the
        simulated image and its electronics. Both are medians in µs, called from Python.
    """
    place = home_pose().apply([0.002, 0.001, 0.001])
    placed = PlacedObject(toy_box(), RigidTransform.from_translation(place))
    rig = ArmRig(pad_scene((placed,)), seed=seed)
    servo = TactileServo(ServoGoal(pressure=1000.0))
    run_servo(rig, TouchPhases(servo), SETTLE)
    pad, reader, twist = rig.simulation.pads[0], rig.hand.reader, rig.hand.twist
    rng = np.random.default_rng(seed)
    raws = [pad.read(rng) for _ in range(32)]
    turn = iter(range(CYCLES + 1))

    def cycle() -> None:
        servo.step(reader.read(raws[next(turn) % len(raws)]), CYCLE, None, twist)

    def image() -> None:
        pad.contact()
        pad.read(rng)

    return {"servo_cycle_us": _median_us(cycle), "image_us": _median_us(image)}


def _median_us(call: Callable[[], None]) -> float:
    times = np.empty(CYCLES)
    for k in range(CYCLES):
        start = time.perf_counter_ns()
        call()
        times[k] = time.perf_counter_ns() - start
    return round(1e-3 * float(np.median(times)), 2)
