"""A pad on an arm follows a cable along a table, and where it went (section 4.4)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from scipy.spatial import KDTree
from scipy.spatial.transform import RigidTransform

from eyehand.data_synth.pad import CABLE_RADIUS, Part, PlacedObject, TouchObject, pad_scene
from eyehand.tactile import (
    PRESETS,
    CableFollower,
    CableOptions,
    ServoGoal,
    TactileServo,
    TouchPhases,
)

from .arm_rig import CYCLE, ArmRig, home_pose
from .cable_shapes import SPACING, CableShape, cable_shape
from .start_posture import looking_down, start_posture

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

FORCE = 2.0
"""With which the pad presses on the cable, N."""
GAP = 0.002
"""From the pad to the cable at the start, m."""
CABLE_AHEAD = 0.03
"""The middle of the cable's extent is this far beyond the arm's home along x, m."""
DROP = 0.01
"""The cable's top is this far below the pad at home, m."""
LANDING_WAY = 0.05
"""From the cable's end to where the pad lands, m: the whole imprint is on the cable."""
OFFSET, ASKEW_DEG = 0.004, 8.0
"""The pad lands up to this far beside the cable's middle, m, and askew by up to this, degrees."""
SETTLING = 0.3
"""After touch, before the path counts, s: in the chapter, too, it swings in first."""
PATIENCE = 2.0
"""Time allowed for landing and bends, beside the way over the speed, s."""


@dataclass(frozen=True)
class CableRun:
    """One cable followed at one speed; M cycles of the path that counts."""

    seed: int
    """What the cable follows from."""
    shape: CableShape
    """The true cable."""
    speed: float
    """m/s."""
    path: NDArray[np.float64]
    """(M, 2), the pad's middle in the cable's frame, by the arm's joints, m."""
    errors: NDArray[np.float64]
    """(M,), m: distance from the cable's middle, positive to the left of the way."""
    way: NDArray[np.float64]
    """(M,), where that is along the cable, m from its end."""
    forces: NDArray[np.float64]
    """(M,), true force, N."""
    outcome: str
    """"end of the cable", or the name of what went wrong."""

    @property
    def rms(self) -> float:
        """Root mean square of the error, m."""
        return float(np.sqrt(np.mean(self.errors**2)))


def run_cable(seed: int, speed: float) -> CableRun:
    """Land a pad on a cable, and follow it to its end.

    Parameters
    ----------
    seed
        Of the cable, the landing, and the pad.
    speed
        Along the cable, m/s.
    """
    shape = cable_shape(seed)
    rng = np.random.default_rng((seed, 1))
    home = home_pose().translation
    origin = home + np.array([CABLE_AHEAD, 0.0, -DROP])
    rig = _landing(shape, origin, rng, seed)
    phases = TouchPhases(TactileServo(ServoGoal(force=FORCE), PRESETS["press"]))
    phases.phase = "hold"
    follower = CableFollower(CableOptions(speed=speed))
    patience = PATIENCE + len(shape.line) * SPACING / speed
    log: list[tuple[float, float, float, float]] = []
    outcome = "time over"
    while rig.time < patience:
        hand = rig.hand
        guide = np.zeros(6)
        if phases.phase == "task" and hand.features:
            guide = follower.step(hand.reader.image, hand.features.orientation)
            if follower.at_end:
                outcome = "end of the cable"
                break
        step = phases.step(hand.features, CYCLE, external=guide, measured=hand.twist)
        if step.outcome:
            outcome = step.outcome
            break
        force = rig.step(step.twist)[-1][0].force
        x, y = (rig.hand.pose.translation - origin)[:2]
        log.append((rig.time, x, y, force))
    return _held_to_truth(seed, shape, speed, np.array(log), outcome)


def _landing(
    shape: CableShape, origin: NDArray[np.float64], rng: np.random.Generator, seed: int
) -> ArmRig:
    """Give the cell with the pad over the cable."""
    first = round(LANDING_WAY / SPACING)
    along = shape.direction(first)
    aside = rng.uniform(-OFFSET, OFFSET) * np.array([-np.sin(along), np.cos(along)])
    place = origin + np.array([*(shape.line[first] + aside), GAP])
    askew = np.radians(rng.uniform(-ASKEW_DEG, ASKEW_DEG))
    table = TouchObject("table", (Part("box", (0.15, 0.3, 0.01), (0.0, 0.0, -0.01)),))
    scene = pad_scene(
        (
            PlacedObject(shape.thing(), RigidTransform.from_translation(origin)),
            PlacedObject(
                table,
                RigidTransform.from_translation(origin - [0.0, 0.0, 2 * CABLE_RADIUS]),
            ),
        )
    )
    at_home = ArmRig(scene, seed=seed)
    joints = start_posture(at_home.hand.robot, looking_down(place, along + askew))
    return ArmRig(scene, seed=seed, joints=joints)


def _held_to_truth(
    seed: int,
    shape: CableShape,
    speed: float,
    log: NDArray[np.float64],
    outcome: str,
) -> CableRun:
    """Measure from when the pad has come into line to where the cable ends."""
    touching = log[:, 3] > 0.0
    begin = log[np.argmax(touching), 0] + SETTLING
    path = log[:, 1:3]
    nearest = np.asarray(KDTree(shape.line).query(path)[1])
    # Beyond the end there is no cable to be beside of.
    counts = (log[:, 0] >= begin) & (nearest < len(shape.line) - 1)
    path, nearest, forces = path[counts], nearest[counts], log[counts, 3]
    heading = np.array([shape.direction(k) for k in nearest])
    off = path - shape.line[nearest]
    errors = -np.sin(heading) * off[:, 0] + np.cos(heading) * off[:, 1]
    way = SPACING * nearest.astype(np.float64)
    return CableRun(seed, shape, speed, path, errors, way, forces, outcome)


def cable_row(run: CableRun) -> dict[str, Any]:
    """Give a run's figures."""
    ahead = SPACING * (len(run.shape.line) - 1) - LANDING_WAY
    return {
        "name": f"cable {run.seed}",
        "speed_mm_s": 1e3 * run.speed,
        "path_rms_mm": 1e3 * run.rms,
        "path_max_mm": 1e3 * float(np.abs(run.errors).max()),
        "followed_pct": 100 * (float(run.way.max()) - LANDING_WAY) / ahead,
        "force_mean_n": float(run.forces.mean()),
        "force_std_n": float(run.forces.std()),
        "outcome": run.outcome,
    }


def speed_row(runs: Sequence[CableRun]) -> dict[str, Any]:
    """Give the figures of all cables at one speed: over all points, and the worst."""
    rows = [cable_row(run) for run in runs]
    errors = np.concatenate([run.errors for run in runs])
    reached = sum(run.outcome == "end of the cable" for run in runs)
    return {
        "name": "all cables",
        "speed_mm_s": rows[0]["speed_mm_s"],
        "path_rms_mm": 1e3 * float(np.sqrt(np.mean(errors**2))),
        "path_max_mm": 1e3 * float(np.abs(errors).max()),
        "followed_pct": min(row["followed_pct"] for row in rows),
        "force_mean_n": float(np.mean([row["force_mean_n"] for row in rows])),
        "force_std_n": float(np.max([row["force_std_n"] for row in rows])),
        "outcome": f"{reached} of {len(runs)} to the end",
    }
