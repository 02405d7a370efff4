"""The runs of Fig. 1: the same motion with each weight of avoidance, and the results."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import RigidTransform

from eyehand.control import (
    ApproachController,
    Box,
    CollisionWorld,
    ControlOptions,
    Cylinder,
    Obstacle,
    Relaxation,
    RobotModel,
)
from eyehand.control.tasks import Position
from eyehand.data_synth import PLANAR_ARM, TOOL_SITE

MIDCOURSE = (0.2, 0.8)
"""Progress along the straight path, from 0 to 1, that counts as mid-course. No path can change the
clearance at the start and at the goal."""
REST = 1e-5
"""Joint speed below which the arm is at rest, rad/s. The hand is then within micrometres of its
final position."""
DEFAULT = "default"
"""Name of the run with the safety level on."""
REACHED_MM = 0.1
"""Final error below which a run reaches its goal, mm."""
CLEARANCE_RATIO = 3.0
"""Required ratio of mid-course clearances, of a dynamic β to β = 0."""


@dataclass(frozen=True, eq=False)
class Fig1Run:
    """One run of the scene."""

    name: str
    """Name of the run: ``beta 0``, ..., ``dynamic``, ``default``."""
    postures: NDArray[np.float64]
    """Joint angles by cycle (N, 4), rad."""
    hand: NDArray[np.float64]
    """Positions of the hand by cycle (N, 3), m."""
    clearance: NDArray[np.float64]
    """Minimum distance of all pairs by cycle (N,), m."""
    progress: NDArray[np.float64]
    """Progress along the straight path by cycle (N,), 0 to 1."""
    error: float
    """Distance of the hand from the goal at the end, m."""
    status: str
    """Final status of the controller."""

    @property
    def closest(self) -> float:
        """Minimum distance of all pairs in the whole run, m."""
        return float(self.clearance.min())

    @property
    def midcourse(self) -> float:
        """Minimum distance of all pairs in mid-course, m."""
        low, high = MIDCOURSE
        return float(self.clearance[(self.progress > low) & (self.progress < high)].min())


def run_fig1() -> list[Fig1Run]:
    """Run the scene with every β, and once more with the safety level on."""
    scene = fig1_scene()
    runs = [run_once(scene, beta_name(beta), beta) for beta in BETAS]
    return [*runs, run_once(scene, DEFAULT, "dynamic", safety=True)]


def run_once(scene: Fig1Scene, name: str, beta: Relaxation, *, safety: bool = False) -> Fig1Run:
    """Run the scene once until the arm is at rest. The joints execute every command exactly."""
    options = fig1_options(beta, safety=safety)
    # The chapter's figure has no limits of acceleration.
    controller = ApproachController(scene.world, [scene.reach_task], options, instant=True)
    q, status = scene.start, "moving"
    postures, hand, clearance = [], [], []
    for _ in range(round(TIME_LIMIT / options.dt)):
        cycle = controller.step(q)
        postures.append(q)
        hand.append(scene.world.robot.at(q).position)
        clearance.append(cycle.clearance)
        status = cycle.status
        if np.abs(cycle.velocity).max() < REST:
            break
        q = q + options.dt * cycle.velocity
    positions = np.array(hand)
    error = float(np.linalg.norm(positions[-1] - scene.goal))
    return Fig1Run(
        name,
        np.array(postures),
        positions,
        np.array(clearance),
        scene.progress(positions),
        error,
        status,
    )


def beta_name(beta: Relaxation) -> str:
    """Return the name of a run: ``beta 0.5``, or ``dynamic``."""
    return beta if isinstance(beta, str) else f"beta {beta:g}"


def fig1_rows(runs: Sequence[Fig1Run]) -> list[dict[str, Any]]:
    """Return one row per run, for CSV and JSON."""
    return [
        {
            "name": run.name,
            "closest_mm": round(1e3 * run.closest, 2),
            "midcourse_clearance_mm": round(1e3 * run.midcourse, 2),
            "final_error_mm": round(1e3 * run.error, 4),
            "status": run.status,
        }
        for run in runs
    ]


def fig1_faults(runs: Sequence[Fig1Run]) -> list[str]:
    """Return the differences from the chapter's statements, one line each."""
    by_name = {run.name: run for run in runs}
    straight, dynamic = by_name["beta 0"], by_name["dynamic"]
    faults = [
        f"{run.name} ends {1e3 * run.error:.3g} mm from its goal, must be below {REACHED_MM} mm"
        for run in (straight, dynamic, by_name[DEFAULT])
        if 1e3 * run.error >= REACHED_MM
    ]
    wanted = CLEARANCE_RATIO * straight.midcourse
    if dynamic.midcourse < wanted:
        faults.append(
            f"dynamic leaves {1e3 * dynamic.midcourse:.3g} mm of clearance, must be at least "
            f"{1e3 * wanted:.3g} mm"
        )
    for name in ("beta 1", "beta 2", "beta 5"):
        run = by_name[name]
        if run.midcourse < wanted:
            faults.append(f"{name} has only {1e3 * run.midcourse:.3g} mm of clearance")
        if 1e3 * run.error < REACHED_MM:
            faults.append(f"{name} reaches its goal, but a fixed weight must not")
    return faults


BETAS: tuple[Relaxation, ...] = (0.0, 0.5, 1.0, 2.0, 5.0, "dynamic")
"""Compared weights of avoidance: none, fixed, and the dynamic weight of eq. 10."""
TIME_LIMIT = 15.0
"""Simulated time after which a run ends if the arm is not at rest, s."""
START = np.array([1.2, 1.15, 0.6, -0.55])
"""Start posture, rad. The hand points away from the base, so that the hand is closest to the
obstacles, not the elbow."""
PATH_LENGTH = 0.80
"""Length of the straight path along x, m."""
POLE_RADIUS = 0.09
"""Radius of the pole, m."""
POLE_OFFSET = (0.36, 0.117)
"""Offset of the pole's axis from the start, along and across the path, m. The straight path passes
it at 12 mm."""
WALL_HALF = (0.05, 0.12)
"""Half side lengths of the wall, m."""
WALL_OFFSET = (0.91, 0.02)
"""Offset of the wall's centre from the start, m. The goal is 45 mm from the wall, well inside its
influence distance."""
HALF_HEIGHT = 0.1
"""Half height of the obstacles, m. They are taller than the arm, so that all motion is planar."""
OPTIONS = ControlOptions(influence=0.12, eta=2.0, safety=False, retreats=0)
"""Options of all runs. The influence distance is large enough to see in the picture. The repulsion
is weak enough that fixed weights from 0.5 to 5 differ. The safety level and retreats are off,
because the figure shows eq. 8-10 only."""

GAIN = 3.0
"""Gain of the hand's position, 1/s. The balance of goal and avoidance, and so the final error of a
fixed weight, depends on it."""


@dataclass(frozen=True, eq=False)
class Fig1Scene:
    """Robot, obstacles, start and goal."""

    world: CollisionWorld
    """Robot and obstacles."""
    start: NDArray[np.float64]
    """Start posture (4,), rad."""
    hand_start: NDArray[np.float64]
    """Position of the hand at the start (3,), m."""
    goal: NDArray[np.float64]
    """Goal of the hand (3,), m."""

    @property
    def reach_task(self) -> Position:
        """The only task: two rows in the plane, with two joints left free."""
        return Position(self.goal, gain=GAIN, name="hand")

    def progress(self, hand: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the progress (N,) of hand positions (N, 3) along the straight path, 0 to 1."""
        return (hand - self.hand_start) @ (self.goal - self.hand_start) / PATH_LENGTH**2


def fig1_scene() -> Fig1Scene:
    """Build the scene."""
    robot = RobotModel.load(PLANAR_ARM, TOOL_SITE, home=START)
    hand = robot.at(START).position
    obstacles = [
        Obstacle(name, shape, RigidTransform.from_translation(hand + np.array([*offset, 0.0])))
        for name, shape, offset in (
            ("pole", Cylinder(POLE_RADIUS, HALF_HEIGHT), POLE_OFFSET),
            ("wall", Box(np.array([*WALL_HALF, HALF_HEIGHT])), WALL_OFFSET),
        )
    ]
    goal = hand + np.array([PATH_LENGTH, 0.0, 0.0])
    return Fig1Scene(CollisionWorld(robot, obstacles), START.copy(), hand, goal)


def fig1_options(beta: Relaxation, *, safety: bool = False) -> ControlOptions:
    """Return the options of one run. Only β and the safety level differ between runs."""
    return replace(OPTIONS, beta=beta, safety=safety)
