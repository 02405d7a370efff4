"""Search the ridges, edges and corners of an unknown object with a pad on an arm."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import RigidTransform, Rotation

from eyehand.data_synth.pad import PlacedObject, pad_scene
from eyehand.tactile import (
    PRESETS,
    ContourFollower,
    ContourOptions,
    PhaseOptions,
    ServoGoal,
    TactileServo,
    TouchPhases,
)

from .arm_rig import CYCLE, ArmRig, RigOptions, SensorName, home_pose
from .commissioning import commissioned
from .seek_shapes import SHAPES, SeekShape

PRESSURE = 1000.0
"""Goal of the mean pressure over the imprint, Pa."""
GAP = 0.004
"""Distance from the pad at home to the object's top, m."""
OFFSET = 0.01
"""Maximum offset of the object from the pad along x and along y, m."""
SPEED, QUICK_SPEED = 0.03, 0.06
"""Speeds over the surface, m/s."""
JUMP = 0.12
"""Maximum jump of the centre of pressure, m. At edges the imprint loses half of its area."""
HOLD_GAIN = 4.0
"""Gain towards the pad's orientation at the landing, 1/s. Without it, a stretched arm tilts the pad
by about 0.2°, and the measured edges shift."""
SECONDS = 90.0
"""Time limit for one object, s."""
BACK_OFF_SECONDS = 3.0
"""Time limit of the retreat, s."""
NEAR = 0.005
"""Maximum distance between a true corner or end and its detection, m: the pad's pitch."""
SHARP = ("corner", "inner_corner", "end")
"""Kinds of points with a unique position. The other kinds lie anywhere along a line."""


@dataclass(frozen=True)
class FoundPoint:
    """A point that the contour follower detected, in the object frame."""

    kind: str
    """Kind of the point, as in :class:`eyehand.tactile.ContourPoint`."""
    place: NDArray[np.float64]
    """Measured position (2,), m."""
    truth: NDArray[np.float64]
    """Closest true corner, end or point of the line (2,), m."""
    image: NDArray[np.float64]
    """Pressures (rows, columns) of the tactile image, Pa."""

    @property
    def error(self) -> float:
        """Distance between measured and true position, m."""
        return float(np.linalg.norm(self.place - self.truth))


@dataclass(frozen=True)
class SeekRun:
    """The record of one object over M cycles."""

    shape: SeekShape
    """The true object."""
    turn: float
    """Rotation of the object about the world's z-axis, rad."""
    pad_axes: NDArray[np.float64]
    """Horizontal directions of the pad's x and y in the world (2, 2), as columns."""
    path: NDArray[np.float64]
    """Path (M, 2) of the pad's centre in the object frame, m, from the arm's joints."""
    forces: NDArray[np.float64]
    """True forces (M,), N."""
    spots: tuple[FoundPoint, ...]
    """Detected points in the order of their detection."""
    outcome: str
    """"closed", "done" or the name of the failure."""
    seconds: float
    """Simulated time, s."""


def run_seek(name: str, seed: int, *, quick: bool = False, sensor: SensorName = "good") -> SeekRun:
    """Land on an object and detect its ridges, edges and corners with the contour follower.

    Parameters
    ----------
    name
        Key of :data:`SHAPES`.
    seed
        Random seed of the object's pose, the initial heading, the pad and its noise.
    quick
        Whether to move twice as fast. The result is less accurate.
    """
    shape = SHAPES[name]()
    rng = np.random.default_rng((seed, list(SHAPES).index(name)))
    turn, heading = rng.uniform(-np.pi, np.pi, 2)
    rotation = Rotation.from_euler("z", turn)
    home = home_pose().translation
    place = home - [*rng.uniform(-OFFSET, OFFSET, 2), GAP] - rotation.apply([*shape.middle, 0.0])
    T_world_object = RigidTransform.from_components(place, rotation)
    scene = pad_scene((PlacedObject(shape.touch_object, T_world_object),))
    rig = ArmRig(scene, seed=seed, options=RigOptions(sensor=sensor))
    from_world = T_world_object.inv()
    phases = TouchPhases(
        TactileServo(ServoGoal(pressure=PRESSURE), PRESETS["press"], commissioned(sensor)),
        PhaseOptions(jump=JUMP),
    )
    phases.phase = "hold"
    follower = ContourFollower(
        ContourOptions(heading=heading, speed=QUICK_SPEED if quick else SPEED, seconds=SECONDS)
    )
    upright = rig.hand.pose.rotation
    path, forces, spots = [], [], []
    outcome: str | None = None
    while outcome is None:
        hand, outer = rig.hand, None
        if phases.phase == "task":
            found = follower.step(hand.features, hand.reader.image, CYCLE, hand.twist)
            outer, outcome = found.twist, found.outcome
            outer[3:] = HOLD_GAIN * (hand.pose.rotation.inv() * upright).as_rotvec()
            if found.point is not None:
                felt = from_world.apply(hand.pose.apply(found.point.position))[:2]
                true = shape.nearest(felt, corner=found.point.kind in SHARP)
                image = hand.reader.image
                pressures = image.pressures.reshape(image.array.grid or (1, -1)).copy()
                spots.append(FoundPoint(found.point.kind, felt, true, pressures))
        phases.servo.side_force = hand.side_force
        step = phases.step(hand.features, CYCLE, external=outer, measured=hand.twist)
        outcome = step.outcome or outcome
        reading = rig.step(step.twist)[-1][0]
        if phases.phase == "task":
            path.append(from_world.apply(hand.pose.translation)[:2])
            forces.append(reading.force)
    seconds = rig.time
    phases.finish()
    while phases.phase != "ended" and rig.time < seconds + BACK_OFF_SECONDS:
        rig.step(phases.step(rig.hand.features, CYCLE, measured=rig.hand.twist).twist)
    return SeekRun(
        shape,
        turn,
        upright.as_matrix()[:2, :2],
        np.array(path).reshape(-1, 2),
        np.array(forces),
        tuple(spots),
        outcome,
        seconds,
    )


def seek_row(run: SeekRun) -> dict[str, Any]:
    """Compute the figures of a run.

    The "place" figures cover corners and ends. The "line" figure covers detected edges and ridges.
    """
    places = [spot for spot in run.spots if spot.kind in SHARP]
    true = run.shape.corners
    found = [any(np.linalg.norm(spot.place - corner) < NEAR for spot in places) for corner in true]
    wrong = len(places) if not len(true) else sum(spot.error >= NEAR for spot in places)
    errors = 1e3 * np.array([spot.error for spot in places])
    lines = [1e3 * spot.error for spot in run.spots if spot.kind not in SHARP]
    steps = np.linalg.norm(np.diff(run.path, axis=0), axis=1)
    return {
        "name": run.shape.name,
        "spots_found": int(sum(found)),
        "spots_true": len(true),
        "spots_wrong": int(wrong),
        "place_median_mm": float(np.median(errors)) if len(errors) else None,
        "place_max_mm": float(errors.max()) if len(errors) else None,
        "line_max_mm": max(lines) if lines else None,
        "path_mm": 1e3 * float(steps.sum()),
        "time_s": run.seconds,
        "force_mean_n": float(run.forces.mean()) if len(run.forces) else None,
        "force_max_n": float(run.forces.max()) if len(run.forces) else None,
        "outcome": run.outcome,
    }


def spot_rows(runs: Sequence[SeekRun]) -> list[dict[str, Any]]:
    """Return one row per detected point, in the object frame."""
    return [
        {
            "object": run.shape.name,
            "kind": spot.kind,
            "x_mm": round(1e3 * float(spot.place[0]), 3),
            "y_mm": round(1e3 * float(spot.place[1]), 3),
            "true_x_mm": round(1e3 * float(spot.truth[0]), 3),
            "true_y_mm": round(1e3 * float(spot.truth[1]), 3),
            "error_mm": round(1e3 * spot.error, 3),
        }
        for run in runs
        for spot in run.spots
    ]
