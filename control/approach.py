"""The approach controller: from tasks, obstacles and joint positions to joint velocities."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal

import numpy as np

from eyehand.errors import InputError

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

Status = Literal["moving", "reached", "stuck", "infeasible"]
"""``stuck``: safe, but without progress; ``infeasible``: not all safety bounds can be kept."""
Phase = Literal["approach", "retreat", "path"]
"""A stuck motion retreats before it tries again, or follows a path that a search found."""

AT_RETREAT_GOAL = 0.1
"""Norm of the joint differences at which a retreat has arrived, rad: it need not be exact."""
MIN_PROGRESS = 0.01
"""Decrease of an error that counts as progress, m or rad: larger gives up creeping sooner."""
PROGRESS_SHARE = 0.1
"""Share of the smallest error so far whose decrease counts as progress too, near the goal."""
HELD_SHARE = 0.5
"""A task that misses less than this share of its rate could move without obstacles near. Repulsion
then stops it, not a lack of joints."""
RETREAT_PATIENCE = 0.3
"""A retreat ends after this time without progress, s."""
RETREAT_SPEED = 1.5
"""Upper limit of the norm of the joint velocities of a retreat, rad/s."""
RETREAT_HAND_SPEED = DEFAULT_LINEAR_SPEED
"""Speed limit of the controlled frame in a retreat, m/s."""
RETREAT_SECONDS = 20.0
"""Time limit of a retreat, s; the motion then tries again from there."""


@dataclass(frozen=True)
class ControlStep:
    """The result of one control cycle."""

    velocity: NDArray[np.float64]
    """Joint velocities to command, (n,), rad/s (m/s of sliding joints)."""
    status: Status
    """Status of the motion."""
    reason: str
    """Why it is stuck or infeasible, by name; empty otherwise."""
    phase: Phase
    """Whether it drives the tasks, retreats, or follows a path."""
    errors: tuple[float, ...]
    """By task: norm of what is left, m or rad."""
    clearance: float
    """Minimum distance of all pairs nearer than the cut-off, m; inf when none is."""
    beta: tuple[float, ...]
    """By task: weight of avoidance (eq. 8)."""
    blocking: tuple[str, ...]
    """Active constraints of the safety level, strongest first."""

    def __bool__(self) -> bool:
        return self.status in ("moving", "reached")


class ApproachController:
    """Drive a robot to a stack of tasks among obstacles, with one call per control cycle.

    Parameters
    ----------
    world
        The robot and what it must not touch.
    tasks
        Highest priority first.
    options
        See :class:`ControlOptions`.

    Raises
    ------
    InputError
        If there is no task, one has no method `at`, or the repulsion would oscillate at this
        control period.
    """

    def __init__(
        self, world: CollisionWorld, tasks: Sequence[Task], options: ControlOptions | None = None
    ) -> None:
        self.world = world
        self.robot = world.robot
        self._tasks = _checked(tasks)
        self._counted = counted(self._tasks)
        self._options = options or ControlOptions()
        require_stable(self.options, _lever(self.robot.at(self.robot.home)))
        self._cycles: dict[int, ControlCycle] = {}
        self.restart()

    @property
    def tasks(self) -> tuple[Task, ...]:
        """The tasks, highest priority first; for other tasks make another controller (50 µs)."""
        return self._tasks

    @property
    def options(self) -> ControlOptions:
        """The options; for other options make another controller."""
        return self._options

    def restart(self) -> None:
        """Reset the progress of the motion: after a jump of the robot, or new obstacles."""
        self._phase: Phase = "approach"
        self._retreats = 0
        self._begin()

    def step(self, q: NDArray[np.float64]) -> ControlStep:
        """Return the joint velocities for joint positions q (n,), and advance time by one period.

        Raises
        ------
        InputError
            If q has another shape, or is not finite.
        """
        motion = self._motion(q)
        velocity = motion.velocity
        phase, errors, blocking = self._phase, motion.errors, motion.blocking
        if phase == "retreat":
            left, *rest = errors
            errors = tuple(rest)
            velocity = self._unhurried(q, motion)
            self._judge_retreat(left, motion.feasible)
        status, reason = "moving", ""
        if not motion.feasible:
            status = "infeasible"
            reason = f"cannot keep the margin: {', '.join(blocking[:3]) or 'no reason'}"
        elif phase == "approach":
            status, reason = self._judge(q, motion)
        return ControlStep(
            velocity, status, reason, phase, errors, motion.clearance, motion.beta, blocking
        )

    def _begin(self) -> None:
        self._best: tuple[float, ...] = ()
        self._stalled = 0.0
        self._clock = 0.0

    def _motion(self, q: NDArray[np.float64]) -> CycleResult:
        """Return the motion to the tasks, or to a retreat configuration with the tasks watched."""
        place = self._retreats if self._phase == "retreat" else 0
        cycle = self._cycles.get(place)
        if cycle is None:
            tasks, watched = self.tasks, ()
            if place:
                configurations = retreat_configurations(self.robot)
                configuration = configurations[(place - 1) % len(configurations)]
                tasks, watched = (
                    (Posture(configuration, speed=RETREAT_SPEED),),
                    self.tasks,
                )
            cycle = ControlCycle(self.world, tasks, self.options, watched)
            self._cycles[place] = cycle
        return cycle.at(q)

    def _unhurried(self, q: NDArray[np.float64], motion: CycleResult) -> NDArray[np.float64]:
        """Return the velocity (n,) of a retreat, rad/s, with the frame within its speed limit.

        A slower motion keeps all bounds that standing still keeps. Inside the margin standing still
        does not keep them, so the velocity is not limited there.
        """
        hand = float(np.linalg.norm(self.robot.at(q).jacobian[:3] @ motion.velocity))
        if motion.clearance < self.options.margin or hand <= RETREAT_HAND_SPEED:
            return motion.velocity
        return motion.velocity * (RETREAT_HAND_SPEED / hand)

    def _judge(self, q: NDArray[np.float64], motion: CycleResult) -> tuple[Status, str]:
        errors = tuple([motion.errors[place] for place in self._counted])
        if max(errors) <= self.options.tolerance:
            self.restart()
            return "reached", ""
        if self._stalled_for(errors) < self.options.patience:
            return "moving", ""
        # With the first task met and nothing near, the tasks conflict, and a retreat is no use.
        torn = errors[0] <= self.options.tolerance and not motion.blocking
        if self._retreats < self.options.retreats and not torn:
            self._phase = "retreat"
            self._retreats += 1
            self._begin()
            return "moving", ""
        return "stuck", self._what_blocks(q, errors, motion)

    def _judge_retreat(self, left: float, feasible: bool) -> None:
        self._clock += self.options.dt
        arrived = left < AT_RETREAT_GOAL or self._stalled_for((left,)) > RETREAT_PATIENCE
        if arrived or self._clock > RETREAT_SECONDS or not feasible:
            self._phase = "approach"
            self._begin()

    def _stalled_for(self, errors: tuple[float, ...]) -> float:
        """Return the time without progress, s: no error fell enough below its smallest so far.

        Where one error falls, the smallest values of the tasks below it start anew, because those
        errors may grow for it. Each error can fall only so often, so every motion ends.
        """
        options = self.options
        if not self._best:
            self._best, self._stalled = errors, 0.0
            return 0.0
        for place, (error, best) in enumerate(zip(errors, self._best, strict=True)):
            enough = min(MIN_PROGRESS, PROGRESS_SHARE * best)
            if best > options.tolerance and error < best - enough:
                self._best = (*self._best[:place], *errors[place:])
                self._stalled = 0.0
                return 0.0
        self._stalled += options.dt
        return self._stalled

    def _what_blocks(
        self, q: NDArray[np.float64], errors: tuple[float, ...], motion: CycleResult
    ) -> str:
        options = self.options
        unmet = [
            f"{self.tasks[place].name} {error:.3g} off"
            for place, error in zip(self._counted, errors, strict=True)
            if error > options.tolerance
        ]
        if motion.blocking:
            return f"{', '.join(unmet)}: held by {', '.join(motion.blocking[:3])}"
        if len(self.tasks) > 1 and errors[0] <= options.tolerance:
            return f"{', '.join(unmet)}: the tasks above leave no way"
        if motion.clearance < options.influence and _could_go(
            self.robot.at(q), self.tasks, options
        ):
            return f"{', '.join(unmet)}: repulsion and goal are in balance"
        return f"{', '.join(unmet)}: out of reach from here"


def counted(tasks: Sequence[Task]) -> tuple[int, ...]:
    """Return the indices of the tasks that decide whether a motion is reached or stuck.

    Tasks with a true attribute ``endless`` do not count, unless all tasks are endless.
    """
    ending = [place for place, task in enumerate(tasks) if not getattr(task, "endless", False)]
    return tuple(ending or range(len(tasks)))


def retreat_configurations(robot: RobotModel) -> tuple[NDArray[np.float64], ...]:
    """Return the postures (n,) to try again from: home, and its mirror image in the joint ranges.

    The mirror image bends elbow and wrist the other way, which a path around an obstacle often
    needs. A joint without a range is mirrored about zero.
    """
    ranged = np.isfinite(robot.lower) & np.isfinite(robot.upper)
    span = np.add(robot.lower, robot.upper, out=np.zeros(robot.n), where=ranged)
    mirrored = span - robot.home
    return robot.home, mirrored


def _lever(state: RobotState) -> float:
    """Return the largest motion of the frame per unit of joint motion, m."""
    return float(np.linalg.norm(state.jacobian[:3], 2))


def _could_go(state: RobotState, tasks: tuple[Task, ...], options: ControlOptions) -> bool:
    """Return whether the first task that is not met would move without obstacles."""
    task_rows = [task.at(state) for task in tasks]
    missing = solve_stack(task_rows, speed=state.speed).missing
    for rows, rest in zip(task_rows, missing, strict=True):
        if rows.unmet > options.tolerance:
            return rest < HELD_SHARE * float(np.linalg.norm(rows.rate))
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
