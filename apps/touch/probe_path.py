"""A thin probe led from one tactel to the next: where it is felt against where it is."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.spatial.transform import RigidTransform

from eyehand.data_synth.pad import IMAGE_RATE, PlacedObject, pad_scene, probe
from eyehand.errors import DeviceError
from eyehand.tactile import SelectionMatrix, ServoGoal, TactileServo, TouchPhases

from .arm_rig import ArmRig, RigOptions, home_pose
from .servo_run import run_servo

WAY = 0.005
"""From one tactel's middle to the next, m."""
SPEED = 0.0025
"""Of the pad along the probe, m/s: in a cycle's images it then moves by 10 µm."""
SETTLE = 0.8
"""From the landing until the way begins, s."""
PRESSURE = 1000.0
"""That the servo keeps meanwhile, Pa."""
GAP = 0.0015
"""Between pad and probe at the start, m."""


@dataclass(frozen=True)
class ProbePath:
    """M readings along the way."""

    real: np.ndarray
    """(M, 2), by the arm's joints, m, in the pad's frame."""
    estimated: np.ndarray
    """(M, 2), centre of pressure, m."""
    force: np.ndarray
    """(M,), true normal force, N."""

    @property
    def error(self) -> np.ndarray:
        """(M,), distance of estimate and truth, m."""
        return np.linalg.norm(self.estimated - self.real, axis=1)


def follow_probe(seed: int) -> ProbePath:
    """Lead the pad over a fixed upright probe, 2 mm in diameter, with an arm.

    The servo keeps the pressure and nothing else; an outer motion slides the pad along x, so that
    the probe goes from a tactel's middle to the next one's. Across the way it is anywhere within
    a tactel.

    Parameters
    ----------
    seed
        Of the pad's electronics and noise and of the place across, >= 0.

    Raises
    ------
    DeviceError
        If the contact was lost, which it should not be.
    """
    home = home_pose()
    across = np.random.default_rng(seed).uniform(-0.5, 0.5) * WAY
    start = home.apply(np.array([-0.5 * WAY, across, GAP]))
    thing = PlacedObject(probe(), RigidTransform.from_translation(start))
    rig = ArmRig(pad_scene((thing,)), seed=seed, options=RigOptions(image_rate=IMAGE_RATE))
    servo = TactileServo(ServoGoal(pressure=PRESSURE), SelectionMatrix(press=True))
    run = run_servo(
        rig,
        TouchPhases(servo),
        SETTLE + WAY / SPEED,
        lambda since: np.array([-SPEED if since >= SETTLE else 0.0, 0, 0, 0, 0, 0]),
    )
    if run.outcome is not None or not len(run.time):
        raise DeviceError(f"the probe was lost on the way (seed {seed}): {run.outcome}")
    moving = run.time > SETTLE
    # The pad does not turn: the home pose's axes are the pad's all along.
    real = home.rotation.inv().apply(start - run.position[moving])[:, :2]
    return ProbePath(real, run.centre[moving], run.force[moving])
