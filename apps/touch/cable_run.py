"""Follow a cable along a table with a pad, and compare the path with the cable (section 4.4)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import KDTree
from scipy.spatial.transform import RigidTransform

from eyehand.data_synth.pad import Part, PlacedObject, TouchObject, pad_scene
from eyehand.errors import DeviceError
from eyehand.tactile import (
    PRESETS,
    CableFollower,
    CableOptions,
    ServoGoal,
    TactileServo,
    TouchPhases,
)

from .arm_rig import CYCLE, ArmRig, RigOptions, SensorName, home_pose
from .cable_shapes import CABLE_RADIUS, SPACING, CableShape, cable_shape
from .commissioning import commissioned, pressed_gains
from .start_posture import facing_down, start_posture

FORCE = 2.0
"""Force on the cable, N."""
GAP = 0.002
"""Distance from the pad to the cable at the start, m."""
CABLE_AHEAD = 0.03
"""Offset of the cable's middle from the arm's home along x, m."""
DROP = 0.01
"""Height of the pad at home above the cable's top, m."""
LANDING_LENGTH = 0.05
"""Length from the cable's end to the landing point, m. The whole imprint is on the cable."""
OFFSET, ANGLE_DEG = 0.004, 8.0
"""Maximum offset, m, and angle, degrees, from the cable's middle line at the landing."""
SETTLING = 0.3
"""Time after touch before the path counts, s. In the chapter, it settles first, too."""
EXTRA_TIME = 2.0
"""Time for landing and bends, in addition to length over speed, s."""


@dataclass(frozen=True)
class CableRun:
    """One cable followed at one speed, with M cycles of the path that counts."""

    seed: int
    """Seed of the cable."""
    shape: CableShape
    """The true cable."""
    speed: float
    """Speed along the cable, m/s."""
    path: NDArray[np.float64]
    """(M, 2), centre of the pad in the cable's frame, from the arm's joints, m."""
    errors: NDArray[np.float64]
    """(M,), distance from the cable's middle line, positive to the left, m."""
    length: NDArray[np.float64]
    """(M,), length along the cable from its end, m."""
    forces: NDArray[np.float64]
    """(M,), true force, N."""
    outcome: str
    """"end of the cable", or the reason of a failure."""

    @property
    def rms(self) -> float:
        """Root mean square of the error, m."""
        return float(np.sqrt(np.mean(self.errors**2)))


def run_cable(seed: int, speed: float, sensor: SensorName = "good") -> CableRun:
    """Press a flat plate for the gains of the pad, land it on a cable and follow it to its end.

    Parameters
    ----------
    seed
        Seed of the cable, the landing and the pad.
    speed
        Speed along the cable, m/s.
    sensor
        Sensor model.
    """
    shape = cable_shape(seed)
    rng = np.random.default_rng((seed, 1))
    home = home_pose().translation
    origin = home + np.array([CABLE_AHEAD, 0.0, -DROP])
    rig = _rig_over_cable(shape, origin, rng, (seed, sensor))
    options = commissioned(sensor)
    phases = TouchPhases(TactileServo(ServoGoal(force=FORCE), PRESETS["press"], options))
    phases.phase = "hold"
    lead = options.arm_lag + options.latency * CYCLE
    follower = CableFollower(CableOptions(speed=speed, lead=lead))
    time_limit = EXTRA_TIME + len(shape.line) * SPACING / speed
    log: list[tuple[float, float, float, float]] = []
    outcome = "time over"
    while rig.time < time_limit:
        hand = rig.hand
        guide = np.zeros(6)
        if phases.phase == "task" and hand.features:
            guide = follower.step(hand.reader.image, hand.features.orientation)
            if follower.at_end:
                outcome = "end of the cable"
                break
        phases.servo.side_force = hand.side_force
        step = phases.step(hand.features, CYCLE, external=guide, measured=hand.twist)
        if step.outcome:
            outcome = step.outcome
            break
        force = rig.step(step.twist)[-1][0].force
        x, y = (rig.hand.pose.translation - origin)[:2]
        log.append((rig.time, x, y, force))
    return _compare(seed, shape, speed, np.array(log), outcome)


def _rig_over_cable(
    shape: CableShape,
    origin: NDArray[np.float64],
    rng: np.random.Generator,
    pad: tuple[int, SensorName],
) -> ArmRig:
    """Return the rig with the pad, drawn by seed and sensor model, above the landing point."""
    seed, sensor = pad
    options = RigOptions(sensor=sensor, gains=pressed_gains(sensor, seed))
    first = round(LANDING_LENGTH / SPACING)
    along = shape.direction(first)
    offset = rng.uniform(-OFFSET, OFFSET) * np.array([-np.sin(along), np.cos(along)])
    place = origin + np.array([*(shape.line[first] + offset), GAP])
    angle = np.radians(rng.uniform(-ANGLE_DEG, ANGLE_DEG))
    table = TouchObject("table", (Part("box", (0.15, 0.3, 0.01), (0.0, 0.0, -0.01)),))
    T_world_cable = RigidTransform.from_translation(origin)
    T_world_table = RigidTransform.from_translation(origin - [0.0, 0.0, 2 * CABLE_RADIUS])
    objects = (
        PlacedObject(shape.touch_object(), T_world_cable),
        PlacedObject(table, T_world_table),
    )
    scene = pad_scene(objects)
    at_home = ArmRig(scene, seed=seed)
    joints = start_posture(at_home.hand.robot, facing_down(place, along + angle))
    return ArmRig(scene, seed=seed, options=options, joints=joints)


def _compare(
    seed: int, shape: CableShape, speed: float, log: NDArray[np.float64], outcome: str
) -> CableRun:
    """Return the record from the end of settling to the end of the cable."""
    touching = log[:, 3] > 0.0
    begin = log[np.argmax(touching), 0] + SETTLING
    path = log[:, 1:3]
    nearest = np.asarray(KDTree(shape.line).query(path)[1])
    # Beyond the end of the cable, there is no error to measure.
    counts = (log[:, 0] >= begin) & (nearest < len(shape.line) - 1)
    path, nearest, forces = path[counts], nearest[counts], log[counts, 3]
    heading = np.array([shape.direction(k) for k in nearest])
    offsets = path - shape.line[nearest]
    errors = -np.sin(heading) * offsets[:, 0] + np.cos(heading) * offsets[:, 1]
    length = SPACING * nearest.astype(np.float64)
    return CableRun(seed, shape, speed, path, errors, length, forces, outcome)


def cable_row(run: CableRun) -> dict[str, Any]:
    """Return the results of a run; one that ended before `SETTLING` has no figures."""
    row = {"name": f"cable {run.seed}", "speed_mm_s": 1e3 * run.speed, "outcome": run.outcome}
    if not len(run.errors):
        return row
    ahead = SPACING * (len(run.shape.line) - 1) - LANDING_LENGTH
    return row | {
        "path_rms_mm": 1e3 * run.rms,
        "path_max_mm": 1e3 * float(np.abs(run.errors).max()),
        "followed_pct": 100 * (float(run.length.max()) - LANDING_LENGTH) / ahead,
        "force_mean_n": float(run.forces.mean()),
        "force_std_n": float(run.forces.std()),
    }


def speed_row(runs: Sequence[CableRun]) -> dict[str, Any]:
    """Return the results of all cables at one speed: over all points, and of the worst cable.

    Raises
    ------
    DeviceError
        If no run has readings.
    """
    count, reached = len(runs), sum(run.outcome == "end of the cable" for run in runs)
    runs = [run for run in runs if len(run.errors)]
    if not runs:
        raise DeviceError(f"all {count} cables were lost within {SETTLING} s")
    rows = [cable_row(run) for run in runs]
    errors = np.concatenate([run.errors for run in runs])
    return {
        "name": "all cables",
        "speed_mm_s": rows[0]["speed_mm_s"],
        "path_rms_mm": 1e3 * float(np.sqrt(np.mean(errors**2))),
        "path_max_mm": 1e3 * float(np.abs(errors).max()),
        "followed_pct": min(row["followed_pct"] for row in rows),
        "force_mean_n": float(np.mean([row["force_mean_n"] for row in rows])),
        "force_std_n": float(np.max([row["force_std_n"] for row in rows])),
        "outcome": f"{reached} of {count} to the end",
    }
