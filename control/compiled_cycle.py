"""The control cycle as one compiled call, for stacks of built-in tasks."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from .cycle_kernels import control_cycle
from .mujoco_binding import mujoco
from .packed_aims import pack_tasks
from .packed_options import pack_options
from .proximity_tables import kernel_arguments
from .safety import ACTIVE, held_joint, near_pair

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from .collision_world import CollisionWorld
    from .options import ControlOptions
    from .proximity_tables import ProximityTables
    from .task import Task


class CycleResult(NamedTuple):
    """What tasks, avoidance and safety come to in one posture."""

    velocity: NDArray[np.float64]
    """(n,), rad/s (m/s of sliding joints)."""
    errors: tuple[float, ...]
    """By task: norm of the error that counts; those of the stack, then those that are watched."""
    beta: tuple[float, ...]
    """By task of the stack: weight of avoidance."""
    clearance: float
    """Smallest distance of all pairs nearer than the cut-off, m; inf when none is."""
    blocking: tuple[str, ...]
    """What the safety level holds back for, strongest first."""
    feasible: bool
    """False when what must be kept cannot be."""


class CompiledCycle:
    """A stack of tasks on a robot among obstacles, packed for the kernel.

    Obstacles may come, move and go; tasks and options stay. It gives the figures of the plain
    cycle to rounding, except where rounding decides: at a singular value that is lost, at a bound
    that is just not passed.

    Parameters
    ----------
    world
        The robot and what it must not touch.
    tasks
        The stack, highest priority first.
    options
        See :class:`ControlOptions`.
    watched
        Tasks of which only the errors are wanted.
    """

    def __init__(
        self,
        world: CollisionWorld,
        tasks: Sequence[Task],
        options: ControlOptions,
        watched: Sequence[Task] = (),
    ) -> None:
        self.world = world
        self.tasks = tuple(tasks)
        self.watched = tuple(watched)
        self.options = options
        self._robot = robot = world.robot
        rows = pack_tasks((*tasks, *watched), robot.n)
        self.fits = (
            rows is not None
            and options.compiled
            and options.mode == "strict"
            and world.compiled
            and robot.compiled
        )
        """Whether the kernel can compute this cycle at all."""
        if rows is None or not self.fits:
            return
        self._count, self._driven = len(rows), len(tasks)
        limits = np.column_stack([robot.lower, robot.upper, robot.speed])
        self._report = np.zeros(1 + 2 * len(rows) + 2 * robot.n)
        spans = robot.lower.tolist(), robot.upper.tolist()
        self._joints = list(zip(robot.joint_names, *spans, strict=True))
        self._own = (self._report, rows, len(tasks), pack_options(options), limits)
        self._bind(world.tables)

    def at(self, q: NDArray[np.float64]) -> CycleResult | None:
        """The motion at joint positions (n,); None where the plain cycle has to say what is wrong.

        Raises
        ------
        InputError
            If q is not n finite numbers.
        """
        if not self.fits:
            return None
        q = self._robot.checked(q)
        tables = self.world.tables
        if tables is not self._tables:
            self._bind(tables)
        velocity = np.empty(len(q))
        active = control_cycle(q, velocity, *self._arguments)
        if active < 0:
            return None
        told, count = self._report.tolist(), self._count
        beta = told[1 + count : 1 + count + self._driven]
        blocking = self._names(q, told[1 + 2 * count :], active) if active else ()
        return CycleResult(
            velocity, tuple(told[1 : 1 + count]), tuple(beta), told[0], blocking, True
        )

    def _bind(self, tables: ProximityTables) -> None:
        """Take the buffers of a world's present model."""
        robot, data = self._robot, tables.data
        self._tables = tables
        site = mujoco.mj_name2id(tables.model, mujoco.mjtObj.mjOBJ_SITE, robot.frame)
        if site >= 0:
            frame = data.site_xpos[site], data.site_xmat[site]
        else:
            frame = data.xpos[robot.frame_body], data.xmat[robot.frame_body]
        moves = np.ascontiguousarray(robot.moves[robot.frame_body])
        self._arguments = (*self._own, *frame, moves, *kernel_arguments(tables))

    def _names(self, q: NDArray[np.float64], told: list[float], active: int) -> tuple[str, ...]:
        n = len(q)
        held = [(told[n + k], int(told[k])) for k in range(active)]
        if active > 1:
            held.sort(reverse=True)
        names = []
        for strength, which in held:
            if strength < ACTIVE:
                break
            if which >= n:
                names.append(near_pair(self._tables.names[which - n]))
            else:
                name, lower, upper = self._joints[which]
                names.append(held_joint(name, float(q[which]), lower, upper))
        return tuple(names)
