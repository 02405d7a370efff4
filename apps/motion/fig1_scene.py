"""The scene of Fig. 1: a planar arm, a pole close to its straight path, and a wall at its goal."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import RigidTransform

from eyehand.control import (
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
