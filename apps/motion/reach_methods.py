"""Who reaches: the control basis with more and more of its parts, and the baseline."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from eyehand.control import (
    ApproachController,
    Box,
    CollisionWorld,
    ControlOptions,
    Obstacle,
    PlannedApproach,
    PlannerOptions,
    RobotModel,
)
from eyehand.control.tasks import Position
from eyehand.data_synth import LBR_ARM, TOOL_SITE
from eyehand.errors import InputError

from .controlled_reach import ControlledReach

if TYPE_CHECKING:
    from collections.abc import Sequence

    from eyehand.control import CollisionOptions
    from eyehand.data_synth.scenes import ReachingObstacle, ReachingScene

DEFAULT = "default"
"""The controller as users get it."""
PLANNED = "default + planner"
BASELINE = "mink"


@dataclass(frozen=True)
class ReachMethodSettings:
    """One of the control basis' rows."""

    what: str
    """In words."""
    options: ControlOptions
    """Of the controller."""
    planner: PlannerOptions | None = None
    """Of the search for a way when the controller is stuck; None: there is none."""


OWN_METHODS: dict[str, ReachMethodSettings] = {
    "null space only": ReachMethodSettings(
        "straight to the goal; what the goal leaves free avoids",
        ControlOptions(beta=0.0, safety=False, retreats=0),
    ),
    "beta 1": ReachMethodSettings(
        "avoidance bends the way to the goal at full weight",
        ControlOptions(beta=1.0, safety=False, retreats=0),
    ),
    "dynamic beta": ReachMethodSettings(
        "avoidance bends the way no more than the goal still pulls",
        ControlOptions(safety=False, retreats=0),
    ),
    DEFAULT: ReachMethodSettings(
        "dynamic beta, with the safety level above it, and retreats", ControlOptions()
    ),
    PLANNED: ReachMethodSettings(
        "the default, which looks for a way when it is stuck", ControlOptions(), PlannerOptions()
    ),
}
"""The control basis' rows, from its barest form to its fullest."""
METHODS: tuple[str, ...] = (*OWN_METHODS, BASELINE)
"""All rows."""


def own_method(name: str, scene: ReachingScene) -> ControlledReach:
    """Make one of the control basis' rows ready for a scene.

    Raises
    ------
    InputError
        If there is no such row.
    """
    if name not in OWN_METHODS:
        raise InputError(f"unknown method {name!r}; choose from: {', '.join(METHODS)}")
    settings = OWN_METHODS[name]
    world, task = reaching_world(scene.obstacles), Position(scene.goal)
    if settings.planner is None:
        return ControlledReach(ApproachController(world, (task,), settings.options))
    return ControlledReach(PlannedApproach(world, (task,), settings.options, settings.planner))


def reaching_world(
    obstacles: Sequence[ReachingObstacle],
    options: CollisionOptions | None = None,
) -> CollisionWorld:
    """Put the 7-joint arm among a scene's boxes."""
    robot = RobotModel.load(LBR_ARM, TOOL_SITE)
    boxes = [Obstacle(one.name, Box(np.array(one.size)), one.T_world_shape) for one in obstacles]
    return CollisionWorld(robot, boxes, options=options)
