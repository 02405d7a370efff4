"""Why a motion is stuck, in words."""

from __future__ import annotations

import numpy as np

from .motion_steps import CycleResult
from .options import ControlOptions
from .robot_state import RobotState
from .stack import solve_stack
from .tasks.task import Task

MAX_MISSING_RATE = 0.5
"""Maximum fraction of the rate of a task that the stack may miss without obstacles. If it misses
less, repulsion blocks the task, and not a lack of joints."""


def why_stuck(
    state: RobotState,
    tasks: tuple[Task, ...],
    counted: tuple[int, ...],
    options: ControlOptions,
    motion: CycleResult,
) -> str:
    """Return why the tasks with the indices ``counted`` make no progress in a state."""
    errors = [motion.errors[index] for index in counted]
    unmet = [
        f"{tasks[index].name} {error:.3g} off"
        for index, error in zip(counted, errors, strict=True)
        if error > options.tolerance
    ]
    if motion.blocking:
        return f"{', '.join(unmet)}: blocked by {', '.join(motion.blocking[:3])}"
    if len(tasks) > 1 and errors[0] <= options.tolerance:
        return f"{', '.join(unmet)}: the tasks above leave no joint motion free"
    if motion.clearance < options.influence and _moves_without_obstacles(state, tasks, options):
        return f"{', '.join(unmet)}: repulsion balances the motion to the goal"
    return f"{', '.join(unmet)}: out of reach from here"


def _moves_without_obstacles(
    state: RobotState, tasks: tuple[Task, ...], options: ControlOptions
) -> bool:
    """Return whether the first task that is not reached would move without obstacles."""
    task_rows = [task.at(state) for task in tasks]
    missing = solve_stack(task_rows, speed=state.speed).missing
    for rows, rest in zip(task_rows, missing, strict=True):
        if rows.unmet > options.tolerance:
            return rest < MAX_MISSING_RATE * float(np.linalg.norm(rows.rate))
    return False
