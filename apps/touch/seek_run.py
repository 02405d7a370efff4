"""A pad on an arm seeks the ridges, edges and corners of an object that nobody described."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
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

from .arm_rig import CYCLE, ArmRig, home_pose
from .seek_shapes import SHAPES, SeekShape

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

PRESSURE = 1000.0
"""Mean over the imprint that is kept, Pa."""
GAP = 0.004
"""From the pad at home to the object's top, m."""
OFFSET = 0.01
"""The object stands up to this far from under the pad, along x and along y, m."""
SPEED, QUICK_SPEED = 0.03, 0.06
"""Over the surface, m/s."""
JUMP = 0.12
"""Way that the centre of pressure may jump, m: at edges the imprint halves."""
HOLD_GAIN = 4.0
"""Pull of the pad back to how it was turned when it landed, 1/s: on the way a long reach tilts it
by some 0.2°, which shifts the felt edges."""
SECONDS = 90.0
"""Longest time for one object, s."""
BACK_OFF_SECONDS = 3.0
"""Longest time to come off it again, s."""
NEAR = 0.005
"""A corner or end with a found one as near as this is found, m: the pad's pitch."""
SHARP = ("corner", "inner_corner", "end")
"""Kinds of spot that are a place; the others are anywhere along a line."""


@dataclass(frozen=True)
class FoundPoint:
    """Something that the guide noticed, in the object's frame."""

    kind: str
    """As :class:`eyehand.tactile.ContourPoint` names it."""
    place: NDArray[np.float64]
    """(2,), where it was felt to be, m."""
    truth: NDArray[np.float64]
    """(2,), the nearest true corner or end, or point of the line, m."""
    image: NDArray[np.float64]
    """(rows, columns), what was felt, Pa."""

    @property
    def error(self) -> float:
        """Distance of both, m."""
        return float(np.linalg.norm(self.place - self.truth))


@dataclass(frozen=True)
class SeekRun:
    """One object; M cycles."""

    shape: SeekShape
    """The true object."""
    turn: float
    """Angle by which the object lay turned in the cell, rad."""
    pad_axes: NDArray[np.float64]
    """(2, 2), directions of the pad's x and y in the cell, seen from above, as columns."""
    path: NDArray[np.float64]
    """(M, 2), the pad's middle in the object's frame, by the arm's joints, m."""
    forces: NDArray[np.float64]
    """(M,), true force, N."""
    spots: tuple[FoundPoint, ...]
    """In the order in which they were found."""
    outcome: str
    """"closed" or "done", or the name of what went wrong."""
    seconds: float
    """Simulated time, s."""


def run_seek(name: str, seed: int, *, quick: bool = False) -> SeekRun:
    """Land on an object, and let the guide find what it can.

    Parameters
    ----------
    name
        Of :data:`SHAPES`.
    seed
        Of the object's place and direction, the first heading, the pad and its noise.
    quick
        Twice as fast over the surface, and less exact.
    """
    shape = SHAPES[name]()
    rng = np.random.default_rng((seed, list(SHAPES).index(name)))
    turn, heading = rng.uniform(-np.pi, np.pi, 2)
    rotation = Rotation.from_euler("z", turn)
    home = home_pose().translation
    place = home - [*rng.uniform(-OFFSET, OFFSET, 2), GAP] - rotation.apply([*shape.middle, 0.0])
    T_world_object = RigidTransform.from_components(place, rotation)
    rig = ArmRig(pad_scene((PlacedObject(shape.thing, T_world_object),)), seed=seed)
    from_world = T_world_object.inv()
    phases = TouchPhases(
        TactileServo(ServoGoal(pressure=PRESSURE), PRESETS["press"]), PhaseOptions(jump=JUMP)
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
        step = phases.step(hand.features, CYCLE, external=outer, measured=hand.twist)
        outcome = step.outcome or outcome
        moment = rig.step(step.twist)[-1][0]
        if phases.phase == "task":
            path.append(from_world.apply(hand.pose.translation)[:2])
            forces.append(moment.force)
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
    """Give a run's figures; places are corners and ends, lines the edge or ridge first noticed."""
    places = [spot for spot in run.spots if spot.kind in SHARP]
    true = run.shape.corners
    met = [any(np.linalg.norm(spot.place - corner) < NEAR for spot in places) for corner in true]
    wrong = len(places) if not len(true) else sum(spot.error >= NEAR for spot in places)
    errors = 1e3 * np.array([spot.error for spot in places])
    lines = [1e3 * spot.error for spot in run.spots if spot.kind not in SHARP]
    steps = np.linalg.norm(np.diff(run.path, axis=0), axis=1)
    return {
        "name": run.shape.name,
        "spots_found": int(sum(met)),
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
    """Give one row per spot that was found, in the object's frame."""
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
