"""Execute one motion of the arm until it ends, and set the speeds of its tasks."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Literal, Protocol

import numpy as np

from eyehand.control.tasks import AxisAlignment, Interval, LookAt, Orientation, Pose, Task

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Sequence

    from numpy.typing import NDArray

    from eyehand.control import ControlStep, RobotModel

    from .cell import Cell
    from .hands import AnyCommand
    from .joint_travel import HeldJoint
    from .robot import RobotReading

MotionEnd = Literal["reached", "stuck", "late", "stopped", "fault"]
"""End of a motion.

- reached: the goal is reached.
- stuck: the controller finds no way to continue, or something holds a joint back.
- late: the time limit is over.
- stopped: the stop condition is met.
- fault: the robot stopped itself.
"""

ROTATION_TASKS = (AxisAlignment, LookAt, Orientation)
"""Tasks whose error is an angle."""
INFEASIBLE_SECONDS = 0.3
"""Time for which a motion may violate its margins, s. Shorter violations end by themselves."""
RAMP_SECONDS = 0.05
"""Time in which the acceleration of a motion rises to its limit, s."""
TURN_SPEED = 3.5
"""Angular speed of the hand, rad/s."""
GAIN = 12.0
"""Gain of the final, slow part of a motion, 1/s. A higher gain demands more of the arm's servos."""
BRAKE_SECONDS = 0.5
"""Time limit of braking at the end of a motion, s."""
NEAR_ENOUGH = "near enough"
"""Reason of a stop near the goal of a motion that need not reach it."""
RETURN_PAUSE, RETURN_SPEED = 0.2, 0.3
"""Time for which the arm rests after a joint was held back, s, and the speed at which that joint
then moves back, rad/s. Late arms have come to rest by then."""
POSITION_SLACK = 0.006
"""Position error that is acceptable where the arm cannot come closer, m."""
ANGLE_SLACK = 0.09
"""Acceptable angular error there, rad (5°). At the edge of its workspace the arm tilts the hand."""


class Controller(Protocol):
    """A controller of joint velocities, such as an approach controller."""

    def step(self, q: NDArray[np.float64]) -> ControlStep:
        """Compute one control cycle at joint angles q (n,), rad."""
        ...

    def stop(self, q: NDArray[np.float64]) -> ControlStep:
        """Compute one cycle of braking within the limits; the status ``stopped`` ends it."""
        ...

    def resume(
        self, velocity: NDArray[np.float64], acceleration: NDArray[np.float64] | None = None
    ) -> None:
        """Continue from a velocity (n,), rad/s, and an acceleration (n,), rad/s²."""
        ...


@dataclass(frozen=True)
class MotionResult:
    """Result of a motion; true in a condition when the goal was reached."""

    end: MotionEnd
    """Kind of the end of the motion."""
    reason: str
    """Why the goal was not reached; empty otherwise."""

    def __bool__(self) -> bool:
        return self.end == "reached"


def execute(
    cell: Cell,
    controller: Controller,
    seconds: float,
    *,
    command: Callable[[RobotReading], AnyCommand | None] | None = None,
    stop: Callable[[RobotReading], str] | None = None,
    ramp_seconds: float = RAMP_SECONDS,
    guarded: bool = False,
    gentle: bool = False,
) -> MotionResult:
    """Move until the controller reaches its goal or the motion ends early, then stop the arm.

    Parameters
    ----------
    cell
        The robot.
    controller
        Controller with the robot's period.
    seconds
        Time limit, s of robot time.
    command
        Function that computes the command of the hand in each cycle.
    stop
        Function that returns the reason to stop, or an empty string to continue.
    ramp_seconds
        Time in which the acceleration rises to its limit, s.
    guarded
        End as stuck as soon as something holds a joint back. A motion in free space ends only if
        the other joints follow: it is fast, and messages of a network that bunch look the same.
    gentle
        Brake within the limits when the stop condition is met. Otherwise the arm stops at once, as
        at a contact.
    """
    end = cell.reading.time + seconds
    infeasible = 0.0
    cell.begin_motion(free=not guarded)
    still = np.zeros(len(cell.robot.joints))
    hard = None if gentle else stop
    start = _SmoothStart(controller, cell.robot.period, ramp_seconds, still)
    with cell.stopped_at_error():
        while True:
            reading = cell.reading
            if reading.fault:
                return MotionResult("fault", reading.fault)
            if cell.touch_fault:
                cell.step(still)
                return MotionResult("stopped", cell.touch_fault)
            stop_reason = stop(reading) if stop else ""
            if stop_reason:
                if gentle or stop_reason == NEAR_ENOUGH:
                    stop_reason = _brake(cell, controller, start, command, hard) or stop_reason
                cell.step(still)
                return MotionResult("stopped", stop_reason)
            cycle = controller.step(cell.expected_q())
            infeasible = infeasible + cell.robot.period if cycle.status == "infeasible" else 0.0
            result = None
            if cycle.status == "reached":
                result = MotionResult("reached", "")
            elif cycle.status == "stuck" or infeasible > INFEASIBLE_SECONDS:
                result = MotionResult("stuck", cycle.reason)
            elif cell.held is not None and (guarded or cell.held.alone):
                result = MotionResult("stuck", cell.held.reason)
            elif reading.time >= end:
                errors = ", ".join(f"{error:.3g}" for error in cycle.errors)
                late = f"not reached after {seconds:g} s: errors {errors} (m or rad)"
                result = MotionResult("late", late)
            if result is not None:
                held = None if result or guarded else cell.held
                stop_reason = _brake(cell, controller, start, command, hard)
                cell.step(still)
                if stop_reason:
                    return MotionResult("stopped", stop_reason)
                if held is not None and _stands(cell, held, command):
                    return MotionResult("fault", cell.reading.fault)
                return result
            cell.step(start.follow(cycle.velocity), command(reading) if command else None)


@dataclass
class _SmoothStart:
    """Commands whose acceleration rises gradually at the start of a motion.

    The controller accelerates at once. A velocity between the last one and a safe one is safe. The
    controller continues from the velocity that was commanded, so that it brakes in time.
    """

    controller: Controller
    period: float
    """Control period, s."""
    seconds: float
    """Time in which the acceleration rises to its limit, s."""
    velocity: NDArray[np.float64]
    """Last velocity, (n,), rad/s."""
    acceleration: NDArray[np.float64] | None = None
    """Last acceleration, (n,), rad/s²."""
    elapsed: float = 0.0
    """Time since the start, s."""

    def follow(self, wanted: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the next velocity (n,) towards that of the controller, rad/s."""
        self.elapsed += self.period
        change = min(self.elapsed / self.seconds, 1.0) * (wanted - self.velocity)
        self.velocity, self.acceleration = self.velocity + change, change / self.period
        if self.elapsed < self.seconds:
            self.controller.resume(self.velocity, self.acceleration)
        return self.velocity


def _brake(
    cell: Cell,
    controller: Controller,
    start: _SmoothStart,
    command: Callable[[RobotReading], AnyCommand | None] | None,
    stop: Callable[[RobotReading], str] | None,
) -> str:
    """Brake within the limits; return the reason to stop at once, such as a contact, or "".

    A command that drops to zero at once saturates the motors of light wrists.
    """
    end = cell.reading.time + BRAKE_SECONDS
    # The controller may have computed a step that was not commanded.
    controller.resume(start.velocity, start.acceleration)
    while cell.reading.time < end and not cell.halted:
        reason = stop(cell.reading) if stop else ""
        if reason not in ("", NEAR_ENOUGH):
            return reason
        velocity = start.follow(controller.stop(cell.expected_q()).velocity)
        if not velocity.any():
            break
        cell.step(velocity, command(cell.reading) if command else None)
    return ""


def _stands(
    cell: Cell,
    held: HeldJoint,
    command: Callable[[RobotReading], AnyCommand | None] | None,
) -> bool:
    """Move a joint that was held back a little back; return whether it stands, with a fault.

    A joint that an obstacle holds back is free on the side from which it came.
    """
    cell.wait(RETURN_PAUSE, command)
    velocity, change = np.zeros(len(cell.robot.joints)), cell.acceleration * cell.robot.period
    cell.begin_motion(free=False, returning=held)
    while not cell.halted:
        goal = np.zeros_like(velocity)
        if cell.returning is not None:
            goal[held.joint] = -cell.returning.side * RETURN_SPEED
        velocity = velocity + np.clip(goal - velocity, -change, change)
        cell.step(velocity, command(cell.reading) if command else None)
        if cell.returning is None and not velocity.any():
            break
    return bool(cell.reading.fault)


def unexpected_contact(cell: Cell, reading: RobotReading) -> str:
    """Return the reason to stop a motion in free space; empty without a hard contact."""
    pads = ", ".join(cell.hand.contacts(reading.hand, cell.options.max_contact_force))
    return f"{pads} touched something that was not perceived" if pads else ""


def remaining_distance(tasks: Sequence[Task], errors: Sequence[float]) -> float:
    """Return the maximum error of the tasks that control a length, m."""
    return max(
        (
            error
            for task, error in zip(tasks, errors, strict=True)
            if not isinstance(task.task if isinstance(task, Interval) else task, ROTATION_TASKS)
        ),
        default=0.0,
    )


def with_speed(
    tasks: Iterable[Task], speed: float, turn_speed: float, gain: float = GAIN
) -> tuple[Task, ...]:
    """Return tasks with a maximum speed, m/s, an angular speed, rad/s, and a gain, 1/s."""
    return tuple(_with_speed(task, speed, turn_speed, gain) for task in tasks)


def within_slack(
    robot: RobotModel, tasks: Iterable[Task], q: NDArray[np.float64], slack: float = POSITION_SLACK
) -> bool:
    """Return whether all errors at joint angles q (n,) are small enough to continue.

    The compliance of the hand compensates angles up to `ANGLE_SLACK` and lengths up to ``slack``,
    m.
    """
    state = robot.at(q)
    return all(
        task.at(state).unmet <= (ANGLE_SLACK if isinstance(task, ROTATION_TASKS) else slack)
        for task in tasks
    )


def _with_speed(task: Task, speed: float, turn_speed: float, gain: float) -> Task:
    if isinstance(task, Interval):
        return replace(task, task=_with_speed(task.task, speed, turn_speed, gain))
    if isinstance(task, Pose):
        return replace(task, speed=speed, turn_speed=turn_speed, gain=gain)
    own_speed = turn_speed if isinstance(task, ROTATION_TASKS) else speed
    return replace(task, speed=own_speed, gain=gain)  # pyright: ignore[reportArgumentType] - all tasks are dataclasses with a speed
