"""Objects that are not where they were seen, not within reach, gone, or held for long."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
from scipy.spatial.transform import RigidTransform

from ...bench.sweep import Sweep, Trial
from .shape_sweeps import MM, PLACED
from .stress_objects import standing
from .stress_trial import Bench, bench_of

if TYPE_CHECKING:
    from eyehand.data_synth.scenes import TabletopObject
    from eyehand.grasping import Phase, PickOptions
    from eyehand.perception import DepthFrame, Scene

BASE = np.array([0.0, -0.58])
"""Where the robot stands, (2,), m."""
FAR_CORNER = np.array([-0.57, 0.37])
"""The farthest corner of the table that is free of the tray, (2,), m."""
HELD_MASS = 0.4
"""Of what is held for a minute, kg."""
CREEP_MM = 1.0
"""Most that it may move in the hand meanwhile."""
PHASES: tuple[Phase, ...] = ("pre-grasp", "approach", "close", "grip", "lift", "check", "place")
"""Phases in which something happens, by number from 1: those in which time passes whatever the
grasp."""
PHASES_TOLD = "from pre-grasp (1) to place (7)"
"""The same for people."""


def event_sweeps() -> tuple[Sweep[PickOptions], ...]:
    """Sweeps over what happens to the object."""
    numbers = tuple(float(k + 1) for k in range(len(PHASES)))
    return (
        Sweep(
            name="pose-error",
            axis="object seen beside its place",
            unit="mm",
            values=(0.0, 3.0, 6.0, 10.0, 15.0, 20.0, 25.0, 30.0),
            holds_to=15.0,
            attempt=_beside_truth,
            right=PLACED,
        ),
        Sweep(
            name="reach",
            axis="object farther and farther from the robot's base",
            unit="mm",
            values=(500.0, 600.0, 700.0, 775.0, 850.0, 925.0, 1000.0, 1090.0),
            holds_to=925.0,
            attempt=_far,
            right=f"{PLACED}, or refused before the arm moves",
        ),
        Sweep(
            name="near-base",
            axis="object nearer and nearer to the robot's base",
            unit="mm",
            values=(500.0, 425.0, 350.0, 300.0, 250.0, 200.0),
            holds_to=300.0,
            attempt=_far,
            right=f"{PLACED}, or refused before the arm moves",
        ),
        Sweep(
            name="moved",
            axis="object moved after the look",
            unit="mm",
            values=(0.0, 5.0, 10.0, 20.0, 30.0, 40.0, 60.0, 80.0),
            holds_to=10.0,
            attempt=_moved,
            right="in the tray at the end, after another look if need be",
        ),
        Sweep(
            name="vanished",
            axis=f"object vanishes, {PHASES_TOLD}",
            unit="",
            values=numbers,
            holds_to=numbers[-1],
            attempt=_vanished,
            right="a named outcome other than placed, then the table is clear",
        ),
        Sweep(
            name="hold",
            axis=f"{HELD_MASS:g} kg held up at friction 0.6",
            unit="s",
            values=(1.0, 20.0, 60.0, 120.0),
            holds_to=60.0,
            attempt=_held,
            right=f"moves less than {CREEP_MM:g} mm in the hand, then {PLACED}",
            repeats=1,
        ),
    )


def can(seed: int, mass: float = 0.2, place: np.ndarray | None = None) -> TabletopObject:
    """Give what every hand should hold: a can of 60 mm."""
    return standing("cylinder", (0.06, 0.06, 0.11), seed, mass=mass, place=place, name="can")


def displaced(scene: Scene, by: np.ndarray) -> Scene:
    """Give a scene whose objects are all seen beside their places, by (3,), m."""
    shift = RigidTransform.from_translation(by)

    def moved(one):
        solid = one.fit.superquadric
        if solid is None:
            return replace(one, points=one.points + by)
        solid = replace(solid, pose=shift * solid.pose)
        return replace(one, points=one.points + by, fit=replace(one.fit, superquadric=solid))

    return replace(scene, objects=tuple(moved(one) for one in scene.objects))


def disturbed(bench: Bench, number: float) -> Bench:
    """Name the phase in which a bench is disturbed, by its number."""
    bench.phase = PHASES[round(number) - 1]
    return bench


def _level(seed: int) -> np.ndarray:
    """Draw a horizontal direction, (3,)."""
    angle = np.random.default_rng([seed, 22]).uniform(-np.pi, np.pi)
    return np.array([np.cos(angle), np.sin(angle), 0.0])


def _beside_truth(error_mm: float, seed: int, options: PickOptions) -> Trial:
    bench = bench_of([can(seed)], seed, options)
    perceive, by = bench.cell.perceive, MM * error_mm * _level(seed)

    def wrong(frame: DepthFrame) -> Scene:
        return displaced(perceive(frame), by)

    bench.cell.perceive = wrong
    return bench.clear().judged()


def _far(distance_mm: float, seed: int, options: PickOptions) -> Trial:
    away = FAR_CORNER - BASE
    # From beside it, the way to what is near does not lead along the corner.
    spread = np.random.default_rng([seed, 23]).uniform(-0.02, 0.02)
    place = BASE + (MM * distance_mm + spread) * away / np.linalg.norm(away)
    place = np.clip(place, [-0.58, -0.38], [0.2, 0.38])
    ended = bench_of([can(seed, place=place)], seed, options).clear()
    return ended.judged(ended.refused or not ended.left)


def _moved(distance_mm: float, seed: int, options: PickOptions) -> Trial:
    bench = bench_of([can(seed)], seed, options)
    by = MM * distance_mm * _level(seed)
    bench.after_look = lambda: bench.put("can", bench.robot.object_pose("can").translation + by)
    return bench.clear().judged()


def _vanished(number: float, seed: int, options: PickOptions) -> Trial:
    bench = disturbed(bench_of([can(seed)], seed, options), number)
    bench.disturb = lambda: bench.vanish("can")
    ended = bench.clear()
    named = bool(ended.picks) and ended.picks[0].outcome not in ("placed", "fault")
    right = named and ended.report.stop_reason == "clear"
    outcomes = ", ".join(row.outcome for row in ended.picks) or "no pick"
    return ended.judged(right, f"{outcomes}; {ended.report.stop_reason}")


def _held(seconds: float, seed: int, options: PickOptions) -> Trial:
    long = replace(options, check_seconds=seconds)
    bench = bench_of([can(seed, HELD_MASS)], seed, long, friction=0.6)
    ended = bench.clear()
    creep = bench.creep
    if creep is None:
        return ended.judged(False, f"never held; {ended.says}")
    still = 1e3 * creep <= CREEP_MM and not ended.left
    return ended.judged(still, f"moved {1e3 * creep:.2f} mm in the hand; {ended.says}")
