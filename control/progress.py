"""Whether the errors of a motion still fall, and why they do not, in words."""

from __future__ import annotations

import numpy as np

from .motion_steps import CycleResult
from .options import ControlOptions
from .robot_state import RobotState
from .stack import solve_stack
from .tasks.task import Task

MIN_PROGRESS = 0.01
"""Minimum decrease of an error that counts as progress, m or rad. With a larger value, a slow
motion counts as stuck earlier."""
RELATIVE_PROGRESS = 0.1
"""A decrease by this fraction of the smallest error so far counts as progress too. It is the
smaller one near the goal."""

MAX_MISSING_RATE = 0.5
"""Maximum fraction of the rate of a task that the stack may miss without obstacles. If it misses
less, repulsion blocks the task, and not a lack of joints."""


class Progress:
    """The smallest errors of a motion so far, and the time since one of them fell."""

    def __init__(self, tolerance: float, dt: float) -> None:
        self._tolerance, self._dt = tolerance, dt
        self.restart()

    def restart(self) -> None:
        """Forget all errors."""
        self._best: tuple[float, ...] = ()
        self._stalled = 0.0

    def time_without(self, errors: tuple[float, ...]) -> float:
        """Return the time without progress, s: no error fell enough below its minimum so far.

        Call it once per cycle. When an error falls, the minima of the tasks below it are reset,
        because their errors may have to grow. Each error can fall only a limited number of times,
        so every motion ends.
        """
        if not self._best:
            self._best, self._stalled = errors, 0.0
            return 0.0
        for index, (error, best) in enumerate(zip(errors, self._best, strict=True)):
            if best > self._tolerance and (
                error < best - MIN_PROGRESS or error < best - RELATIVE_PROGRESS * best
            ):
                self._best = (*self._best[:index], *errors[index:])
                self._stalled = 0.0
                return 0.0
        self._stalled += self._dt
        return self._stalled


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
