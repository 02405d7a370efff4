"""Compare the measured and the true position of a thin probe between two tactels."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.spatial.transform import RigidTransform

from eyehand.data_synth.pad import IMAGE_RATE, PlacedObject, pad_scene, probe
from eyehand.errors import DeviceError
from eyehand.tactile import SelectionMatrix, ServoGoal, TactileServo, TouchPhases

from .arm_rig import ArmRig, RigOptions, SensorName, home_pose
from .commissioning import commissioned
from .servo_run import run_servo

PATH_LENGTH = 0.005
"""Length of the path, m. It joins the centres of two adjacent tactels."""
SPEED = 0.0025
"""Speed of the pad relative to the probe, m/s: 10 µm during the images of one cycle."""
SETTLE = 0.8
"""Time from the landing to the start of the path, s."""
PRESSURE = 1000.0
"""Contact pressure that the servo keeps, Pa."""
GAP = 0.0015
"""Initial distance between pad and probe, m."""


@dataclass(frozen=True)
class ProbePath:
    """M readings along the path."""

    real: np.ndarray
    """True position of the probe (M, 2) in the pad frame, m, from the arm's joints."""
    estimated: np.ndarray
    """Centre of pressure (M, 2) in the pad frame, m."""
    force: np.ndarray
    """True normal force (M,), N."""

    @property
    def error(self) -> np.ndarray:
        """Distance (M,) between estimated and true position, m."""
        return np.linalg.norm(self.estimated - self.real, axis=1)


def follow_probe(seed: int, sensor: SensorName = "good") -> ProbePath:
    """Slide the pad over a fixed upright probe, 2 mm in diameter, with an arm.

    The servo controls the pressure only. An external motion slides the pad along x, so that the
    probe moves from the centre of one tactel to the centre of the next. The position across the
    path is random within one tactel.

    Parameters
    ----------
    seed
        Random seed of the pad's electronics, its noise and the position across the path, >= 0.
    sensor
        Sensor model.

    Raises
    ------
    DeviceError
        If the contact was lost.
    """
    home = home_pose()
    across = np.random.default_rng(seed).uniform(-0.5, 0.5) * PATH_LENGTH
    start = home.apply(np.array([-0.5 * PATH_LENGTH, across, GAP]))
    placed = PlacedObject(probe(), RigidTransform.from_translation(start))
    options = RigOptions(image_rate=IMAGE_RATE, sensor=sensor)
    rig = ArmRig(pad_scene((placed,)), seed=seed, options=options)
    goal, press = ServoGoal(pressure=PRESSURE), SelectionMatrix(press=True)
    servo = TactileServo(goal, press, commissioned(sensor))
    run = run_servo(
        rig,
        TouchPhases(servo),
        SETTLE + PATH_LENGTH / SPEED,
        lambda elapsed: np.array([-SPEED if elapsed >= SETTLE else 0.0, 0, 0, 0, 0, 0]),
    )
    if run.outcome is not None or not len(run.time):
        raise DeviceError(f"the contact with the probe was lost (seed {seed}): {run.outcome}")
    moving = run.time > SETTLE
    # The pad does not rotate, so the axes of the home pose remain the pad's axes.
    real = home.rotation.inv().apply(start - run.position[moving])[:, :2]
    return ProbePath(real, run.centre[moving], run.force[moving])
