"""One motion of the arm, until it is there, is stuck, or something stops it."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Literal, Protocol

import numpy as np

from eyehand.control.tasks import AxisAlignment, Interval, LookAt, Orientation, Pose

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Sequence

    from numpy.typing import NDArray

    from eyehand.control import ControlStep, RobotModel
    from eyehand.control.tasks import Task

    from .cell import Cell
    from .robot import HandCommand, RobotReading

MotionEnd = Literal["reached", "stuck", "late", "stopped", "fault"]
"""stuck: no way on; late: out of time; stopped: by what was watched for; fault: of the robot."""

ROTATION_TASKS = (AxisAlignment, LookAt, Orientation)
INFEASIBLE_SECONDS = 0.3
"""A motion that cannot keep its margins for so long has no way on: shorter is a passing squeeze."""


class Controller(Protocol):
    """What gives joint velocities: an approach controller, with or without a search."""

    def step(self, q: NDArray[np.float64]) -> ControlStep:
        """Give the cycle for joint angles q, (n,)."""
        ...


@dataclass(frozen=True)
class Arrival:
    """How a motion ended; true in a condition when it is there."""

    end: MotionEnd
    """How."""
    reason: str
    """Why, where it is not there."""

    def __bool__(self) -> bool:
        return self.end == "reached"


def go(
    cell: Cell,
    controller: Controller,
    seconds: float,
    *,
    command: Callable[[RobotReading], HandCommand | None] | None = None,
    stop: Callable[[RobotReading], str] | None = None,
) -> Arrival:
    """Move until the controller has reached its tasks, and stand still, however it ends.

    Parameters
    ----------
    cell
        The robot.
    controller
        Its period is the robot's.
    seconds
        Longest time, s of the robot's clock.
    command
        What the hand does meanwhile.
    stop
        Why to stop now; empty to go on.
    """
    start = cell.reading.time
    end = start + seconds
    infeasible = 0.0
    still = np.zeros(len(cell.robot.joints))
    while True:
        reading = cell.reading
        if reading.fault:
            return Arrival("fault", reading.fault)
        why = stop(reading) if stop else ""
        if why:
            cell.step(still)
            return Arrival("stopped", why)
        cycle = controller.step(reading.q)
        infeasible = infeasible + cell.robot.period if cycle.status == "infeasible" else 0.0
        if cycle.status == "reached":
            cell.step(still)
            return Arrival("reached", "")
        if cycle.status == "stuck" or infeasible > INFEASIBLE_SECONDS:
            cell.step(still)
            return Arrival("stuck", cycle.reason)
        if reading.time >= end:
            cell.step(still)
            left = ", ".join(f"{error:.3g}" for error in cycle.errors)
            return Arrival("late", f"not there after {seconds:g} s: {left} m or rad left")
        # Standing still is safe, and so is all between it and a safe velocity.
        begun = (reading.time - start + cell.robot.period) / cell.options.ramp_seconds
        cell.step(min(begun, 1.0) * cycle.velocity, command(reading) if command else None)


def bumped(cell: Cell, reading: RobotReading) -> str:
    """Name the pads that met something harder than what is brushed aside; empty when none did."""
    hand = reading.hand.forces > cell.options.bump_force
    pads = ", ".join(np.array(cell.robot.hand.pads)[hand].tolist())
    return f"{pads} met what was not seen" if pads else ""


def distance_left(tasks: Sequence[Task], errors: Sequence[float]) -> float:
    """Largest error of the tasks that are lengths, m; turns do not count."""
    return max(
        (
            error
            for task, error in zip(tasks, errors, strict=True)
            if not isinstance(task.task if isinstance(task, Interval) else task, ROTATION_TASKS)
        ),
        default=0.0,
    )


def paced(tasks: Iterable[Task], speed: float, turn_speed: float, gain: float) -> tuple[Task, ...]:
    """Give the tasks with other speeds, m/s and rad/s, and another gain, 1/s."""
    return tuple(_paced(task, speed, turn_speed, gain) for task in tasks)


def near_enough(
    robot: RobotModel,
    tasks: Iterable[Task],
    q: NDArray[np.float64],
    slack: float,
    turn_slack: float,
) -> bool:
    """Return whether every task is met within a distance, m, or an angle, rad, at q (n,).

    At the edge of reach the hand's own compliance takes up a few degrees.
    """
    state = robot.at(q)
    return all(
        task.at(state).unmet <= (turn_slack if isinstance(task, ROTATION_TASKS) else slack)
        for task in tasks
    )


def _paced(task: Task, speed: float, turn_speed: float, gain: float) -> Task:
    if isinstance(task, Interval):
        return replace(task, task=_paced(task.task, speed, turn_speed, gain))
    if isinstance(task, Pose):
        return replace(task, speed=speed, turn_speed=turn_speed, gain=gain)
    faster = turn_speed if isinstance(task, ROTATION_TASKS) else speed
    return replace(task, speed=faster, gain=gain)  # pyright: ignore[reportArgumentType] - all tasks are dataclasses with a speed
