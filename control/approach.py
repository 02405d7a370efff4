"""The approach controller: from tasks, obstacles and joint positions to joint velocities."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from eyehand.errors import InputError

from .array_checks import checked_array
from .braking_kernels import brake_command
from .collision_world import CollisionWorld
from .control_step import ControlStep, Phase, Status, control_step
from .cycle import ControlCycle
from .motion_steps import CycleResult
from .options import ControlOptions
from .posture_checks import jump_reason, posture_fault
from .progress import Progress, why_stuck
from .repulsion import require_stable
from .retreat import (
    AT_RETREAT_GOAL,
    RETREAT_HAND_SPEED,
    RETREAT_PATIENCE,
    RETREAT_SECONDS,
    RETREAT_SPEED,
    retreat_configurations,
)
from .robot_state import RobotState
from .tasks.posture import Posture
from .tasks.task import Task

TOO_NEAR = 1e-3
"""Violation of the margin that is reported, m. Smaller ones are errors of linearisation."""
ARRIVAL_SHARE = 0.15
"""Maximum share of its speed limit at which a joint has arrived. Near a singularity the hand can be
at its goal while the joints still turn fast, and a caller that ends there would stop them hard."""


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
        self._limits = self.robot.limits()
        # The posture before the first cycle.
        self._unknown = np.full(self.robot.n, np.nan)
        self._progress = Progress(self.options.tolerance, self.options.dt)
        # Largest clearance so far, at most the margin.
        self._least = -np.inf
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
        self._posture = self._unknown
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

        The robot is assumed to hold the velocity for one period. The status is ``infeasible`` if a
        joint jumped farther since the last call than its speed limit allows.

        Raises
        ------
        InputError
            If q has another shape, is not finite, or is far outside the joint limits.
        """
        q = self.robot.numbers(q)
        fault = posture_fault(q, self._posture, self._limits, self._options.dt)
        if fault:
            # Positions that are not finite are a fault as well, with a message of their own.
            self.robot.checked(q)
            reason = jump_reason(fault, q, self._posture, self.robot, self._options.dt)
            self._posture = q
            return replace(self.stop(q), status="infeasible", reason=reason)
        self._posture = q
        if not self._instant:
            self.world.advance(self._options.dt)
        motion = self._motion(q)
        self._last = motion.command
        phase, errors = self._phase, motion.errors
        if phase == "retreat":
            left, *rest = errors
            errors = tuple(rest)
            self._update_retreat(left, motion.feasible)
        status, reason = "moving", ""
        if not motion.feasible:
            status = "infeasible"
            reason = f"cannot keep the margin: {', '.join(motion.blocking[:3]) or 'no reason'}"
        elif phase == "approach":
            status, reason = self._judge(q, motion)
        if motion.clearance >= self._options.margin:
            self._least = self._options.margin
        elif self._options.safety:
            status, reason = self._violation(q, motion.clearance) or (status, reason)
        return control_step(motion, status, reason, phase, errors)

    def _violation(self, q: NDArray[np.float64], clearance: float) -> tuple[Status, str] | None:
        """Return status and reason if an obstacle came nearer than the margin.

        A motion that starts inside the margin is not a violation, unless it goes deeper.
        """
        self._least = max(self._least, clearance)
        if clearance >= self._least - TOO_NEAR:
            return None
        proximity = self.world.proximity(q)
        first, second = proximity.names[int(np.argmin(proximity.distance))]
        if clearance < 0.0:
            return "contact", f"{first} and {second} overlap by {-1e3 * clearance:.1f} mm"
        return "too_near", f"{first} is {1e3 * clearance:.1f} mm from {second}"

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
        self.world.advance(self._options.dt)
        self._posture = state.q
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
        self._progress.restart()
        self._clock = 0.0

    def warm_up(self) -> None:
        """Load all compiled code, so that no later cycle has to; this takes up to a second."""
        q, still = self.robot.home, np.zeros((2, self.robot.n))
        for number in range(1 + self._options.retreats):
            cycle = self._cycle(number)
            cycle.at(q, still)
            cycle.in_steps(q, still)
        posture_fault(q, q, self._limits, self._options.dt)
        brake_command(still, self._limits, self._options.dt)

    def _motion(self, q: NDArray[np.float64]) -> CycleResult:
        """Return the motion to the tasks or, in a retreat, to a retreat configuration."""
        number = self._retreats if self._phase == "retreat" else 0
        cycle = self._cycles.get(number) or self._cycle(number)
        motion = cycle.compiled(q, self._last)
        return cycle.in_steps(q, self._last) if motion is None else motion

    def _cycle(self, number: int) -> ControlCycle:
        """Return the cycle that drives the tasks (number 0), or the cycle of a retreat."""
        if number in self._cycles:
            return self._cycles[number]
        tasks, watched, frame_speed = self.tasks, (), np.inf
        if number:
            configurations = retreat_configurations(self.robot)
            configuration = configurations[(number - 1) % len(configurations)]
            tasks, watched = (Posture(configuration, speed=RETREAT_SPEED),), self.tasks
            frame_speed = RETREAT_HAND_SPEED
        self._cycles[number] = cycle = ControlCycle(
            self.world,
            tasks,
            self.options,
            watched,
            frame_speed=frame_speed,
            instant=self._instant,
        )
        return cycle

    def commit(self, velocity: NDArray[np.float64]) -> None:
        """Remember a velocity (n,) as the command of this cycle."""
        last = self._last
        self._last = np.array([velocity, (velocity - last[0]) / self.options.dt])

    def _judge(self, q: NDArray[np.float64], motion: CycleResult) -> tuple[Status, str]:
        errors, options = motion.errors, self._options
        if len(errors) > len(self._counted):
            errors = tuple([errors[index] for index in self._counted])
        if max(errors) <= options.tolerance:
            if np.any(np.abs(motion.velocity) > ARRIVAL_SHARE * self.robot.speed):
                return "moving", ""
            self.restart()
            return "reached", ""
        if self._progress.time_without(errors) < options.patience:
            return "moving", ""
        # If the first task is reached and no constraint is active, the tasks conflict. Then a
        # retreat does not help.
        conflict = errors[0] <= options.tolerance and not motion.blocking
        if self._retreats < options.retreats and not conflict:
            self._phase = "retreat"
            self._retreats += 1
            self._begin()
            return "moving", ""
        return "stuck", why_stuck(self.robot.at(q), self.tasks, self._counted, options, motion)

    def _update_retreat(self, left: float, feasible: bool) -> None:
        self._clock += self.options.dt
        arrived = left < AT_RETREAT_GOAL or self._progress.time_without((left,)) > RETREAT_PATIENCE
        if arrived or self._clock > RETREAT_SECONDS or not feasible:
            self._phase = "approach"
            self._begin()


def counted(tasks: Sequence[Task]) -> tuple[int, ...]:
    """Return the indices of the tasks that decide whether a motion is reached or stuck.

    Tasks with a true attribute ``endless`` do not count, unless all tasks are endless.
    """
    ending = [index for index, task in enumerate(tasks) if not getattr(task, "endless", False)]
    return tuple(ending or range(len(tasks)))


def _lever(state: RobotState) -> float:
    """Return the maximum motion of the frame per unit of joint motion, m."""
    return float(np.linalg.norm(state.jacobian[:3], 2))


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
