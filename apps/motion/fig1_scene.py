"""The scene of the paper's Fig. 1: a planar arm whose straight way grazes a pole, to a wall."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np
from scipy.spatial.transform import RigidTransform, Rotation

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

if TYPE_CHECKING:
    from numpy.typing import NDArray

BETAS: tuple[Relaxation, ...] = (0.0, 0.5, 1.0, 2.0, 5.0, "dynamic")
"""Weights of avoidance that are compared: none, fixed ones, and that of eq. 10."""
TIME_LIMIT = 15.0
"""Simulated time after which a run ends, s, should it not have come to rest before."""
START = np.array([1.2, 1.15, 0.6, -0.55])
"""Posture to begin with, rad: the hand points away from the base, so that it comes nearest to the
obstacles, not the elbow."""
WAY = 0.80
"""Length of the straight way, m, along x."""
POLE_RADIUS = 0.09
"""m."""
POLE_AT = (0.36, 0.117)
"""Axis of the pole past the start, along and across the way, m: the straight way leaves 12 mm."""
WALL_HALF = (0.05, 0.12)
"""Half the wall's sides, m."""
WALL_AT = (0.91, 0.02)
"""Middle of the wall past the start, m: at the goal 45 mm are left, well inside its influence."""
HALF_HEIGHT = 0.1
"""Half the obstacles' height, m: more than the arm's, so that all happens in the plane."""
OPTIONS = ControlOptions(influence=0.12, eta=2.0, safety=False, retreats=0)
"""Of all runs: an influence that a picture can show, and a push weak enough that fixed weights
from 0.5 to 5 differ. No safety level and no second try, as the figure is about eq. 8-10 alone."""


@dataclass(frozen=True, eq=False)
class Fig1Scene:
    """Robot, obstacles and way."""

    world: CollisionWorld
    """Robot and obstacles."""
    start: NDArray[np.float64]
    """Posture to begin with (4,), rad."""
    first: NDArray[np.float64]
    """Where the hand is then (3,), m."""
    goal: NDArray[np.float64]
    """Where it shall be (3,), m."""

    @property
    def reach_task(self) -> Position:
        """The only task: two rows in the plane, which leave two joints free."""
        return Position(self.goal, name="hand")

    def share(self, hand: NDArray[np.float64]) -> NDArray[np.float64]:
        """Share of the straight way that hand positions (N, 3) have gone, (N,)."""
        return (hand - self.first) @ (self.goal - self.first) / WAY**2


def fig1_scene() -> Fig1Scene:
    """Build the scene."""
    robot = RobotModel.load(PLANAR_ARM, TOOL_SITE, home=START)
    first = robot.at(START).position
    pole = Obstacle("pole", Cylinder(POLE_RADIUS, HALF_HEIGHT), _beside(first, POLE_AT))
    wall = Obstacle("wall", Box(np.array([*WALL_HALF, HALF_HEIGHT])), _beside(first, WALL_AT))
    world = CollisionWorld(robot, [pole, wall])
    return Fig1Scene(world, START.copy(), first, first + np.array([WAY, 0.0, 0.0]))


def fig1_options(beta: Relaxation, *, safety: bool = False) -> ControlOptions:
    """Options of one run: nothing differs but β, and whether the safety level is on."""
    return replace(OPTIONS, beta=beta, safety=safety)


def _beside(first: NDArray[np.float64], offset: tuple[float, float]) -> RigidTransform:
    return RigidTransform.from_components(first + np.array([*offset, 0.0]), Rotation.identity())
