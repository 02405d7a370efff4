"""The approach controller: from tasks, obstacles and joint positions to joint velocities."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal

import numpy as np

from eyehand.errors import InputError

from .array_checks import checked_array
from .braking_kernels import brake_command
from .cycle import ControlCycle
from .options import ControlOptions
from .repulsion import require_stable
from .stack import solve_stack
from .tasks.posture import Posture
from .tasks.task import DEFAULT_LINEAR_SPEED

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from .collision_world import CollisionWorld
    from .motion_steps import CycleResult
    from .robot_model import RobotModel
    from .robot_state import RobotState
    from .tasks.task import Task

Status = Literal["moving", "reached", "stuck", "infeasible", "stopped"]
"""Status of a motion. ``stuck``: safe, but without progress. ``infeasible``: not all safety bounds
can be satisfied. ``stopped``: at standstill after :meth:`ApproachController.stop`."""
Phase = Literal["approach", "retreat", "path", "stop"]
"""Phase of a motion. A stuck motion retreats before it tries again, or follows a planned path."""

ARRIVAL_SHARE = 0.15
"""Maximum share of its speed limit at which a joint has arrived. Near a singularity the hand can be
at its goal while the joints still turn fast, and a caller that ends there would stop them hard."""
AT_RETREAT_GOAL = 0.1
"""Maximum norm of the joint differences at which a retreat ends, rad. It need not be exact."""
MIN_PROGRESS = 0.01
"""Minimum decrease of an error that counts as progress, m or rad. With a larger value, a slow
motion counts as stuck earlier."""
RELATIVE_PROGRESS = 0.1
"""A decrease by this fraction of the smallest error so far counts as progress too. It is the
smaller one near the goal."""
MAX_MISSING_RATE = 0.5
"""Maximum fraction of the rate of a task that the stack may miss without obstacles. If it misses
less, repulsion blocks the task, and not a lack of joints."""
RETREAT_PATIENCE = 0.3
"""A retreat ends after this time without progress, s."""
RETREAT_SPEED = 1.5
"""Upper limit of the norm of the joint velocities of a retreat, rad/s."""
RETREAT_HAND_SPEED = DEFAULT_LINEAR_SPEED
"""Speed limit of the controlled frame in a retreat, m/s."""
RETREAT_SECONDS = 20.0
"""Time limit of a retreat, s. The motion then tries again from where it is."""


@dataclass(frozen=True)
class ControlStep:
    """The result of one control cycle."""

    velocity: NDArray[np.float64]
    """Joint velocities to command, (n,), rad/s (m/s of sliding joints)."""
    status: Status
    """Status of the motion."""
    reason: str
    """Why the motion is stuck or infeasible; empty otherwise."""
    phase: Phase
    """Whether the motion drives the tasks, retreats, or follows a path."""
    errors: tuple[float, ...]
    """Norm of the error of each task, m or rad."""
    clearance: float
    """Minimum distance of all pairs nearer than the cut-off, m; inf if there are none."""
    beta: tuple[float, ...]
    """Weight of avoidance in each task (eq. 8)."""
    blocking: tuple[str, ...]
    """Names of the active constraints of the safety level, strongest first."""

    def __bool__(self) -> bool:
        return self.status in ("moving", "reached", "stopped")


class ApproachController:
    """Drive a robot to a stack of tasks among obstacles, with one call per control cycle.

    The commands keep the limits of speed, acceleration and jerk of the robot. The arm can always
    brake within them before a joint limit or an obstacle (:mod:`braking_kernels`). The controller
    starts at standstill, and remembers its last command.

    Parameters
    ----------
    world
        The robot and its obstacles.
    tasks
        Highest priority first.
    options
        See :class:`ControlOptions`.
    instant
        Whether joints may change their velocity at once, as in a simulation of poses only.

    Raises
    ------
    InputError
        If there is no task, a task has no method `at`, or the repulsion would oscillate at this
        control period.
    """

    def __init__(
        self,
        world: CollisionWorld,
        tasks: Sequence[Task],
        options: ControlOptions | None = None,
        *,
        instant: bool = False,
    ) -> None:
        self.world = world
        self.robot = world.robot
        self._tasks = _checked(tasks)
        self._counted = counted(self._tasks)
        self._options = options or ControlOptions()
        require_stable(self.options, _lever(self.robot.at(self.robot.home)))
        self._instant = instant
        self._cycles: dict[int, ControlCycle] = {}
        self._last = np.zeros((2, self.robot.n))
        self.restart()

    @property
    def tasks(self) -> tuple[Task, ...]:
        """The tasks, highest priority first. For other tasks, create another controller (50 µs)."""
        return self._tasks

    @property
    def options(self) -> ControlOptions:
        """The options. For other options, create another controller."""
        return self._options

    def restart(self) -> None:
        """Reset the progress of the motion, for example after new obstacles were added."""
        self._phase: Phase = "approach"
        self._retreats = 0
        self._begin()

    @property
    def velocity(self) -> NDArray[np.float64]:
        """Velocity (n,) of the last command, rad/s, from which the next one continues."""
        return self._last[0].copy()

    @property
    def acceleration(self) -> NDArray[np.float64]:
        """Acceleration (n,) of the last command, rad/s²."""
        return self._last[1].copy()

    @property
    def last_command(self) -> NDArray[np.float64]:
        """Velocity and acceleration (2, n) of the last command, for a :class:`ControlCycle`."""
        return self._last

    def resume(
        self, velocity: NDArray[np.float64], acceleration: NDArray[np.float64] | None = None
    ) -> None:
        """Continue from the velocity (n,), rad/s, and acceleration (n,), of another controller.

        Raises
        ------
        InputError
            If they are not n finite numbers.
        """
        last = np.zeros((2, self.robot.n))
        last[0] = checked_array("velocity", velocity, (self.robot.n,))
        if acceleration is not None:
            last[1] = checked_array("acceleration", acceleration, (self.robot.n,))
        self._last = last

    def step(self, q: NDArray[np.float64]) -> ControlStep:
        """Return the joint velocities for joint positions q (n,), and advance time by one period.

        The robot is assumed to hold the velocity for one period.

        Raises
        ------
        InputError
            If q has another shape, or is not finite.
        """
        motion = self._motion(q)
        velocity = motion.velocity
        phase, errors, blocking = self._phase, motion.errors, motion.blocking
        self.commit(velocity)
        if phase == "retreat":
            left, *rest = errors
            errors = tuple(rest)
            self._update_retreat(left, motion.feasible)
        status, reason = "moving", ""
        if not motion.feasible:
            status = "infeasible"
            reason = f"cannot keep the margin: {', '.join(blocking[:3]) or 'no reason'}"
        elif phase == "approach":
            status, reason = self._judge(q, motion)
        return ControlStep(
            velocity, status, reason, phase, errors, motion.clearance, motion.beta, blocking
        )

    def stop(self, q: NDArray[np.float64]) -> ControlStep:
        """Return joint velocities (n,) that brake within the limits, and advance one period.

        Call it in every cycle until the status is ``stopped``. The next :meth:`step` continues the
        motion. If no obstacle moves, the arm stands still before it comes nearer than the margin.

        Raises
        ------
        InputError
            If q has another shape, or is not finite.
        """
        state = self.robot.at(q)
        proximity = self.world.proximity(state.q)
        velocity = brake_command(self._last, self.robot.limits(), self.options.dt)
        self.commit(velocity)
        return ControlStep(
            velocity,
            "moving" if np.any(velocity) else "stopped",
            "",
            "stop",
            tuple(task.at(state).unmet for task in self.tasks),
            float(proximity.distance.min(initial=float("inf"))),
            (0.0,) * len(self.tasks),
            (),
        )

    def _begin(self) -> None:
        self._best: tuple[float, ...] = ()
        self._stalled = 0.0
        self._clock = 0.0

    def _motion(self, q: NDArray[np.float64]) -> CycleResult:
        """Return the motion to the tasks or, in a retreat, to a retreat configuration."""
        # Cycle 0 drives the tasks, cycle k the k-th retreat.
        number = self._retreats if self._phase == "retreat" else 0
        cycle = self._cycles.get(number)
        if cycle is None:
            if number:
                configurations = retreat_configurations(self.robot)
                configuration = configurations[(number - 1) % len(configurations)]
                tasks, watched = (Posture(configuration, speed=RETREAT_SPEED),), self.tasks
                frame_speed = RETREAT_HAND_SPEED
            else:
                tasks, watched, frame_speed = self.tasks, (), np.inf
            cycle = ControlCycle(
                self.world,
                tasks,
                self.options,
                watched,
                frame_speed=frame_speed,
                instant=self._instant,
            )
            self._cycles[number] = cycle
        return cycle.at(q, self._last)

    def commit(self, velocity: NDArray[np.float64]) -> None:
        """Remember a velocity (n,) as the command of this cycle."""
        last = self._last
        self._last = np.array([velocity, (velocity - last[0]) / self.options.dt])

    def _judge(self, q: NDArray[np.float64], motion: CycleResult) -> tuple[Status, str]:
        errors = tuple([motion.errors[index] for index in self._counted])
        if max(errors) <= self.options.tolerance:
            if np.any(np.abs(motion.velocity) > ARRIVAL_SHARE * self.robot.speed):
                return "moving", ""
            self.restart()
            return "reached", ""
        if self._time_without_progress(errors) < self.options.patience:
            return "moving", ""
        # If the first task is reached and no constraint is active, the tasks conflict. Then a
        # retreat does not help.
        conflict = errors[0] <= self.options.tolerance and not motion.blocking
        if self._retreats < self.options.retreats and not conflict:
            self._phase = "retreat"
            self._retreats += 1
            self._begin()
            return "moving", ""
        return "stuck", self._what_blocks(q, errors, motion)

    def _update_retreat(self, left: float, feasible: bool) -> None:
        self._clock += self.options.dt
        arrived = left < AT_RETREAT_GOAL or self._time_without_progress((left,)) > RETREAT_PATIENCE
        if arrived or self._clock > RETREAT_SECONDS or not feasible:
            self._phase = "approach"
            self._begin()

    def _time_without_progress(self, errors: tuple[float, ...]) -> float:
        """Return the time without progress, s: no error fell enough below its minimum so far.

        When an error falls, the minima of the tasks below it are reset, because their errors may
        have to grow. Each error can fall only a limited number of times, so every motion ends.
        """
        options = self.options
        if not self._best:
            self._best, self._stalled = errors, 0.0
            return 0.0
        for index, (error, best) in enumerate(zip(errors, self._best, strict=True)):
            enough = min(MIN_PROGRESS, RELATIVE_PROGRESS * best)
            if best > options.tolerance and error < best - enough:
                self._best = (*self._best[:index], *errors[index:])
                self._stalled = 0.0
                return 0.0
        self._stalled += options.dt
        return self._stalled

    def _what_blocks(
        self, q: NDArray[np.float64], errors: tuple[float, ...], motion: CycleResult
    ) -> str:
        options = self.options
        unmet = [
            f"{self.tasks[index].name} {error:.3g} off"
            for index, error in zip(self._counted, errors, strict=True)
            if error > options.tolerance
        ]
        if motion.blocking:
            return f"{', '.join(unmet)}: blocked by {', '.join(motion.blocking[:3])}"
        if len(self.tasks) > 1 and errors[0] <= options.tolerance:
            return f"{', '.join(unmet)}: the tasks above leave no joint motion free"
        if motion.clearance < options.influence and _moves_without_obstacles(
            self.robot.at(q), self.tasks, options
        ):
            return f"{', '.join(unmet)}: repulsion balances the motion to the goal"
        return f"{', '.join(unmet)}: out of reach from here"


def counted(tasks: Sequence[Task]) -> tuple[int, ...]:
    """Return the indices of the tasks that decide whether a motion is reached or stuck.

    Tasks with a true attribute ``endless`` do not count, unless all tasks are endless.
    """
    ending = [index for index, task in enumerate(tasks) if not getattr(task, "endless", False)]
    return tuple(ending or range(len(tasks)))


def retreat_configurations(robot: RobotModel) -> tuple[NDArray[np.float64], ...]:
    """Return the configurations (n,) to try again from: home and its mirror image.

    The mirror image bends elbow and wrist the other way, which is often necessary to pass an
    obstacle. A joint is mirrored about the middle of its range, or about zero if it has no range.
    """
    ranged = np.isfinite(robot.lower) & np.isfinite(robot.upper)
    span = np.add(robot.lower, robot.upper, out=np.zeros(robot.n), where=ranged)
    return robot.home, span - robot.home


def _lever(state: RobotState) -> float:
    """Return the maximum motion of the frame per unit of joint motion, m."""
    return float(np.linalg.norm(state.jacobian[:3], 2))


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


def _checked(tasks: Sequence[Task]) -> tuple[Task, ...]:
    if not isinstance(tasks, Iterable):
        raise InputError(f"the controller needs a list of tasks, got {tasks!r}")
    given = tuple(tasks)
    for task in given:
        if not callable(getattr(task, "at", None)):
            raise InputError(f"a task must have a method `at`, as Position has; got {task!r}")
    if not given:
        raise InputError("the controller needs at least one task")
    return given
