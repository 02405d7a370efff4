"""Searches for the way of a motion, at standstill: before it starts, and where it was stuck."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from .approach import counted
from .collision_world import CollisionWorld
from .joint_path import JointPath, resample_path
from .joint_planner import find_path
from .options import ControlOptions, PlannerOptions
from .planner import plan, predict
from .tasks.axis_alignment import AxisAlignment
from .tasks.look_at import LookAt
from .tasks.orientation import Orientation
from .tasks.task import DEFAULT_LINEAR_SPEED, Task

DETOUR = 1.3
"""A motion without planning is accepted if it takes at most this factor times the time on a
straight line. Then a search would rarely find a faster one."""
SETTLING = 0.6
"""Time that the tasks need after a path, s."""
OUT_OF_REACH = {False: 0.02, True: 0.15}
"""Error of a task, m, or of an angle, rad, above which a goal counts as unreachable if no
configuration comes nearer. Nearer goals are approached as far as possible."""
LEGS = 8
"""Number of roll-outs of a search before the motion: to the goal and by way of home. More rarely
help as long as the arm is not stuck elsewhere."""


@dataclass(frozen=True, eq=False)
class SearchResult:
    """The result of a search: go on along a path, directly, or not at all."""

    path: JointPath | None = None
    """Result of the search; None if there was none."""
    track: NDArray[np.float64] | None = None
    """The path with one configuration per cycle (M, n); None for the direct motion."""
    unreachable: str = ""
    """Why no configuration reaches the tasks; empty if one does."""


def search_first(
    world: CollisionWorld,
    tasks: Sequence[Task],
    q: NDArray[np.float64],
    options: ControlOptions,
    planner: PlannerOptions,
) -> SearchResult:
    """Choose between the direct motion, a path, and no motion, at the start q (n,)."""
    state = world.robot.at(q)
    ending = [tasks[k] for k in counted(tasks)]
    lengths = [task.at(state).unmet for task in ending if not is_angle(task)]
    straight = max(lengths, default=0.0) / DEFAULT_LINEAR_SPEED + SETTLING
    reached, seconds = predict(world, tasks, q, options, planner)
    if reached and seconds <= DETOUR * straight:
        return SearchResult()
    found = find_path(world, tasks, q, options, planner.seed)
    if found is None:
        return SearchResult()
    state = world.robot.at(found.nearest)
    left = [(task, task.at(state).unmet) for task in ending]
    if not reached and any(error > OUT_OF_REACH[is_angle(task)] for task, error in left):
        named = ", ".join(f"{task.name} {error:.3g}" for task, error in left)
        at = np.round(state.position, 4).tolist()
        reason = f"unreachable: at the nearest configuration {named} off, at {at} m"
        return SearchResult(unreachable=reason)
    path = found.as_joint_path()
    if not path and not reached:
        path = plan(
            world, tasks, q, options, replace(planner, rollouts=min(LEGS, planner.rollouts))
        )
    faster = path and not (reached and seconds < found.seconds + SETTLING)
    return SearchResult(path, _track(path, world, options) if faster else None)


def search_again(
    world: CollisionWorld,
    tasks: Sequence[Task],
    q: NDArray[np.float64],
    options: ControlOptions,
    planner: PlannerOptions,
) -> SearchResult:
    """Plan a path from q (n,), where the motion was stuck."""
    path = None
    if planner.rollouts:
        found = find_path(world, tasks, q, options, planner.seed)
        path = None if found is None else found.as_joint_path()
    if not path:
        path = plan(world, tasks, q, options, planner)
    return SearchResult(path, _track(path, world, options) if path else None)


def is_angle(task: Task) -> bool:
    """Return whether the error of a task is an angle."""
    return isinstance(getattr(task, "task", task), (AxisAlignment, LookAt, Orientation))


def _track(path: JointPath, world: CollisionWorld, options: ControlOptions) -> NDArray[np.float64]:
    return resample_path(path.configurations, world.robot, options.dt)
