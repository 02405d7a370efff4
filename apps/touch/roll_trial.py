"""Roll a pad flat onto a tilted face with an arm, before and after the face rotates."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import RigidTransform, Rotation

from eyehand.data_synth.pad import PlacedObject, pad_scene, tilted_face
from eyehand.errors import DeviceError
from eyehand.tactile import PRESETS, ServoGoal, TactileServo, TouchPhases

from .arm_rig import ArmRig, RigOptions, SensorName, home_pose
from .commissioning import commissioned
from .servo_run import ServoRun, run_servo

TILT = np.radians(6.0)
"""Angle between pad and face at the landing, rad."""
FLAT = np.radians(1.0)
"""Maximum tilt of a pad that counts as flat, rad."""
DISPLACED, DISPLACING = 1.2, 0.4
"""Start time of the face's rotation after the landing, and its duration, s."""
SECONDS = 2.6
"""Duration of a trial after the landing, s."""
GAP = 0.004
"""Initial distance from the pad to the face's centre, m. The upper edge is 3 mm closer."""
PRESSURE = 1000.0
"""Contact pressure that the servo keeps, Pa."""


@dataclass(frozen=True)
class RollTrial:
    """One trial: landing, rolling flat, and rolling flat again after the face rotates."""

    run: ServoRun
    """Record from the landing onwards."""
    tilt: NDArray[np.float64]
    """True angle (M,) between pad and face, rad, positive in the initial tilt direction."""
    across: NDArray[np.float64]
    """Centre of pressure (M,) along the face's tilt direction, m."""


def roll_once(seed: int, sensor: SensorName = "good") -> RollTrial:
    """Land on a face tilted by 6° and roll flat, then follow the face to the opposite tilt.

    Parameters
    ----------
    seed
        Random seed of the electronics, the noise and the tilt direction of the face, >= 0.
    sensor
        Sensor model.

    Returns
    -------
    RollTrial
        Its run has an outcome, and is shorter, if the servo ended early.

    Raises
    ------
    DeviceError
        If the face was not touched.
    """
    direction = float(np.random.default_rng(seed).uniform(-np.pi, np.pi))
    lean = np.array([np.cos(direction), np.sin(direction), 0.0])
    axis = np.array([-lean[1], lean[0], 0.0])
    place = home_pose().translation - [0.0, 0.0, GAP]
    face = PlacedObject(
        tilted_face(TILT, direction), RigidTransform.from_translation(place), "mocap"
    )
    rig = ArmRig(pad_scene((face,)), seed=seed, options=RigOptions(sensor=sensor))

    def turned(time: float) -> float:
        return -2 * TILT * float(np.clip((time - DISPLACED) / DISPLACING, 0.0, 1.0))

    def move(time: float) -> None:
        turn = Rotation.from_rotvec(turned(time) * axis)
        rig.simulation.data.mocap_quat[0] = turn.as_quat(scalar_first=True)

    servo = TactileServo(ServoGoal(pressure=PRESSURE), PRESETS["roll"], commissioned(sensor))
    run = run_servo(rig, TouchPhases(servo), SECONDS, move=move)
    if not len(run.time):
        raise DeviceError(f"the face was not touched (seed {seed}): {run.outcome}")
    # The pad's z-axis is opposite to the face's normal when the pad lies flat.
    leaning = TILT + np.array([turned(float(time)) for time in run.time])
    normal = np.cos(leaning)[:, None] * [0.0, 0.0, 1.0] + np.sin(leaning)[:, None] * lean
    size = np.arctan2(
        np.linalg.norm(np.cross(normal, -run.normal), axis=1), -(normal * run.normal).sum(axis=1)
    )
    sign = np.sign(np.cross(-run.normal, normal) @ axis)
    # The pad faces down, so its x-axis is the world's -x at home.
    across = run.centre @ (home_pose().rotation.inv().apply(lean))[:2]
    return RollTrial(run, size * sign, across)


def roll_row(trials: Sequence[RollTrial]) -> dict[str, Any]:
    """Summarise the trials: times until the tilt stays below 1°, residual tilt, lost contacts."""
    first = [_flat_after(trial, 0.0, DISPLACED) for trial in trials]
    again = [_flat_after(trial, DISPLACED + DISPLACING, SECONDS) for trial in trials]
    residual = [np.abs(trial.tilt[trial.run.time > SECONDS - 0.2]).max() for trial in trials]
    rest = [trial.run.time < DISPLACED for trial in trials]
    settled = [
        np.abs(trial.tilt[early & (trial.run.time > DISPLACED - 0.2)]).max()
        for trial, early in zip(trials, rest, strict=True)
    ]
    return {
        "name": "roll",
        "time_to_flat_s": float(np.mean(first)),
        "slowest_to_flat_s": float(max(first)),
        "time_to_flat_again_s": float(np.mean(again)),
        "slowest_to_flat_again_s": float(max(again)),
        "settled_tilt_deg": float(np.degrees(max(settled))),
        "settled_tilt_again_deg": float(np.degrees(max(residual))),
        "least_force_n": float(min(trial.run.force.min() for trial in trials)),
        "contact_losses": sum(_loses_contact(trial.run) for trial in trials),
        "paper_time_to_flat_s": 4.0,
    }


def _loses_contact(run: ServoRun) -> bool:
    """Return whether pad and face separated after the landing, or the servo lost the contact."""
    apart = run.force <= 0.0
    # A first touch of a few mN is below the noise. The servo starts after it.
    undetected = np.logical_or.accumulate(run.serving) & (run.area <= 0.0)
    return bool((apart | undetected).any())


def _flat_after(trial: RollTrial, start: float, end: float) -> float:
    """Return the time after `start` from which the tilt stays below 1° until `end`, s, or inf."""
    selected = (trial.run.time >= start) & (trial.run.time < end)
    time, tilt = trial.run.time[selected], np.abs(trial.tilt[selected])
    steep = np.flatnonzero(tilt >= FLAT)
    if not len(steep):
        return 0.0
    return float(time[steep[-1] + 1] - start) if steep[-1] + 1 < len(time) else float("inf")
