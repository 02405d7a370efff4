"""The control cycle of one stack of tasks, in one compiled call if possible."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import partial
from typing import cast

import numpy as np
from numpy.typing import NDArray

from .collision_world import CollisionWorld
from .cycle_kernels import control_cycle
from .motion_steps import CycleResult, motion_in_steps
from .mujoco_binding import mujoco
from .options import ControlOptions
from .packed_options import pack_options
from .proximity_tables import ProximityTables, kernel_arguments
from .safety import blocking_names
from .tasks.kernel_task import FIELDS
from .tasks.posture import Posture
from .tasks.registry import pack_tasks
from .tasks.task import Task


class ControlCycle:
    """A stack of tasks on a robot among obstacles, prepared for the kernel.

    Tasks and options are fixed. Obstacles may be added, moved and removed. A stack with a task that
    has no kernel is computed step by step, about ten times slower.

    Parameters
    ----------
    world
        The robot and its obstacles.
    tasks
        The stack, highest priority first.
    options
        See :class:`ControlOptions`.
    watched
        Tasks of which only the errors are computed.
    frame_speed
        Speed limit of the controlled frame in the nominal motion, m/s.
    instant
        Whether joints may change their velocity at once, without limits of acceleration and jerk.
    """

    def __init__(
        self,
        world: CollisionWorld,
        tasks: Sequence[Task],
        options: ControlOptions,
        watched: Sequence[Task] = (),
        *,
        frame_speed: float = np.inf,
        instant: bool = False,
    ) -> None:
        self.world = world
        self.tasks = tuple(tasks)
        self.watched = tuple(watched)
        self.options = options
        self.frame_speed = frame_speed
        self.instant = instant
        self._robot = robot = world.robot
        self._goal: NDArray[np.float64] | None = None
        self._arguments: tuple = ()
        packed = pack_tasks((*tasks, *watched), robot.n)
        if packed is None:
            return
        self._packed = packed
        self._count, self._driven = len(packed), len(tasks)
        limits = robot.limits(instant=instant)
        self._report = np.zeros(1 + 2 * len(packed) + 2 * robot.n)
        ranges = robot.lower.tolist(), robot.upper.tolist()
        self._joints = list(zip(robot.joint_names, *ranges, strict=True))
        options_row = pack_options(options, frame_speed)
        self._fixed_arguments = (self._report, packed, len(tasks), options_row, limits)
        self._bind(world.tables)

    def head_for(self, goal: NDArray[np.float64]) -> None:
        """Change the goal (n,) of the first task, which must be a :class:`Posture`.

        It takes a tenth of the time of a new cycle, so it is fast enough for every control cycle.
        """
        self._goal = goal
        if self._arguments:
            self._packed[0, FIELDS : FIELDS + len(goal)] = goal

    def at(self, q: NDArray[np.float64], motion: NDArray[np.float64]) -> CycleResult:
        """Return the motion at joint positions q (n,).

        ``motion`` (2, n) is the velocity of the last command, and its acceleration.

        Raises
        ------
        InputError
            If q is not n finite numbers, or a task is not finite.
        """
        q = self._robot.checked(q)
        result = self.compiled(q, motion)
        return self.in_steps(q, motion) if result is None else result

    def in_steps(self, q: NDArray[np.float64], motion: NDArray[np.float64]) -> CycleResult:
        """Return the motion at joint positions q (n,), computed step by step."""
        last = None if self.instant else motion
        tasks = self.tasks
        if self._goal is not None:
            tasks = (replace(cast("Posture", tasks[0]), goal=self._goal), *tasks[1:])
        return motion_in_steps(
            self.world, q, tasks, self.options, self.watched, last, self.frame_speed
        )

    def compiled(self, q: NDArray[np.float64], motion: NDArray[np.float64]) -> CycleResult | None:
        """Return the motion at q (n,), float64, or None if the kernel has no result."""
        if not self._arguments:
            return None
        tables = self.world.tables
        if tables is not self._tables:
            self._bind(tables)
        command = np.empty((2, len(q)))
        active = control_cycle(q, motion, command, *self._arguments)
        if active < 0:
            return None
        report, count = self._report.tolist(), self._count
        errors = tuple(report[1 : 1 + count])
        beta = tuple(report[1 + count : 1 + count + self._driven])
        name_blocking = tuple
        if active:
            bounds = report[1 + 2 * count :]
            name_blocking = partial(_named, bounds, active, q, self._joints, tables.labels)
        return CycleResult(command, errors, beta, report[0], name_blocking, True)

    def _bind(self, tables: ProximityTables) -> None:
        """Use the buffers of the world's current model."""
        robot, data = self._robot, tables.data
        self._tables = tables
        site = mujoco.mj_name2id(tables.model, mujoco.mjtObj.mjOBJ_SITE, robot.frame)
        if site >= 0:
            frame = data.site_xpos[site], data.site_xmat[site]
        else:
            frame = data.xpos[robot.frame_body], data.xmat[robot.frame_body]
        moves = np.ascontiguousarray(robot.moves[robot.frame_body])
        self._arguments = (*self._fixed_arguments, *frame, moves, *kernel_arguments(tables))


def _named(
    bounds: list[float],
    active: int,
    q: NDArray[np.float64],
    joints: Sequence[tuple[str, float, float]],
    pairs: Sequence[str],
) -> tuple[str, ...]:
    """Return the names of the active bounds in a report of the kernel, strongest first.

    ``bounds`` (2 n) are the indices and the multipliers of the bounds.
    """
    n = len(q)
    multipliers = zip(bounds[n : n + active], map(int, bounds[:active]), strict=True)
    return blocking_names(list(multipliers), q, joints, pairs)
