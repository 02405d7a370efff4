"""Sweeps of objects that are misplaced, out of reach, moved, removed, or held for long."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from scipy.spatial.transform import RigidTransform

from eyehand.grasping import Phase, PickOptions
from eyehand.perception import DepthFrame, Scene, SceneObject

from ...bench.sweep import Sweep, Trial
from .shape_sweeps import MM, PLACED
from .stress_objects import can_on_table
from .stress_trial import StressCell, stress_cell

BASE = np.array([0.0, -0.58])
"""Position of the robot base, (2,), m."""
FAR_CORNER = np.array([-0.57, 0.37])
"""The farthest table corner that is clear of the tray, (2,), m."""
HELD_MASS = 0.4
"""Mass of the object that is held for long, kg."""
MAX_CREEP_MM = 1.0
"""Maximum motion of that object in the hand, mm."""
PHASES: tuple[Phase, ...] = ("pre-grasp", "approach", "close", "grip", "lift", "check", "place")
"""Phases that a disturbance can hit, numbered from 1. Every pick goes through all of them."""
PHASE_RANGE = "from pre-grasp (1) to place (7)"
"""The range of these phases for people."""


def event_sweeps() -> tuple[Sweep[PickOptions], ...]:
    """Return the sweeps over pose errors, reach, moved or removed objects, and long holding."""
    numbers = tuple(float(k + 1) for k in range(len(PHASES)))
    in_reach = f"{PLACED}, or refused before the arm moves"
    return (
        Sweep("pose-error", "error of the estimated position", "mm",
              (0.0, 3.0, 6.0, 10.0, 15.0, 20.0, 25.0, 30.0), 15.0, _pose_error, PLACED),
        Sweep("reach", "distance of a far object from the robot base", "mm",
              (500.0, 600.0, 700.0, 775.0, 850.0, 925.0, 1000.0, 1090.0), 925.0, _far, in_reach),
        Sweep("near-base", "distance of a near object from the robot base", "mm",
              (500.0, 425.0, 350.0, 300.0, 250.0, 200.0), 300.0, _far, in_reach),
        Sweep("moved", "displacement of the object after perception", "mm",
              (0.0, 5.0, 10.0, 20.0, 30.0, 40.0, 60.0, 80.0), 10.0, _moved,
              "in the tray at the end, after another capture if needed"),
        Sweep("vanished", f"phase in which the object is removed, {PHASE_RANGE}", "",
              numbers, numbers[-1], _vanished,
              "a named outcome other than placed, then the object is missed"),
        Sweep("hold", f"holding time of {HELD_MASS:g} kg at friction 0.6", "s",
              (1.0, 20.0, 60.0, 120.0), 60.0, _held,
              f"moves less than {MAX_CREEP_MM:g} mm in the hand, then {PLACED}", repeats=1),
    )  # fmt: skip


def displaced_scene(scene: Scene, offset: np.ndarray) -> Scene:
    """Return a scene whose objects are all displaced by a vector (3,), m."""
    shift = RigidTransform.from_translation(offset)

    def moved(item: SceneObject) -> SceneObject:
        solid = item.fit.superquadric
        if solid is None:
            return replace(item, points=item.points + offset)
        solids = [replace(one, pose=shift * one.pose) for one in item.fit.parts or (solid,)]
        fit = replace(item.fit, superquadric=solids[0], parts=tuple(solids))
        return replace(item, points=item.points + offset, fit=fit)

    return replace(scene, objects=tuple(map(moved, scene.objects)))


def disturbed(stress: StressCell, number: float) -> StressCell:
    """Set the phase in which a cell is disturbed, by its number."""
    stress.disturbed_phase = PHASES[round(number) - 1]
    return stress


def _horizontal_direction(seed: int) -> np.ndarray:
    """Draw a horizontal unit vector, (3,)."""
    angle = np.random.default_rng([seed, 22]).uniform(-np.pi, np.pi)
    return np.array([np.cos(angle), np.sin(angle), 0.0])


def _pose_error(error_mm: float, seed: int, options: PickOptions) -> Trial:
    stress = stress_cell([can_on_table(seed)], seed, options)
    perceive, offset = stress.cell.perceive, MM * error_mm * _horizontal_direction(seed)

    def wrong(frame: DepthFrame) -> Scene:
        return displaced_scene(perceive(frame), offset)

    stress.cell.perceive = wrong
    return stress.clear().trial()


def _far(distance_mm: float, seed: int, options: PickOptions) -> Trial:
    away = FAR_CORNER - BASE
    # Vary the distance a little with the seed.
    spread = np.random.default_rng([seed, 23]).uniform(-0.02, 0.02)
    position = BASE + (MM * distance_mm + spread) * away / np.linalg.norm(away)
    position = np.clip(position, [-0.58, -0.38], [0.2, 0.38])
    outcome = stress_cell([can_on_table(seed, position=position)], seed, options).clear()
    return outcome.trial(outcome.refused or not outcome.left)


def _moved(distance_mm: float, seed: int, options: PickOptions) -> Trial:
    stress = stress_cell([can_on_table(seed)], seed, options)
    offset = MM * distance_mm * _horizontal_direction(seed)
    start = stress.robot.object_pose("can").translation
    stress.after_selection = lambda: stress.move_object("can", start + offset)
    return stress.clear().trial()


def _vanished(number: float, seed: int, options: PickOptions) -> Trial:
    stress = disturbed(stress_cell([can_on_table(seed)], seed, options), number)
    stress.disturb = lambda: stress.remove_object("can")
    outcome = stress.clear()
    named = bool(outcome.picks) and outcome.picks[0].outcome not in ("placed", "fault")
    right = named and "not seen again" in outcome.report.stop_reason
    outcomes = ", ".join(row.outcome for row in outcome.picks) or "no pick"
    return outcome.trial(right, f"{outcomes}; {outcome.report.stop_reason}")


def _held(seconds: float, seed: int, options: PickOptions) -> Trial:
    options = replace(options, check_seconds=seconds)
    stress = stress_cell([can_on_table(seed, HELD_MASS)], seed, options, friction=0.6)
    outcome = stress.clear()
    creep = stress.creep
    if creep is None:
        return outcome.trial(False, f"never held; {outcome.failure}")
    still = 1e3 * creep <= MAX_CREEP_MM and not outcome.left
    return outcome.trial(still, f"moved {1e3 * creep:.2f} mm in the hand; {outcome.failure}")
