"""Run one reach to its end and evaluate it with a collision model that no method can access."""

from __future__ import annotations

import time
from collections import deque
from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Literal, Protocol

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from eyehand.data_synth import ReachingArm
from eyehand.data_synth.scenes import PLACES, ArmClearance, Place, ReachingScene
from eyehand.errors import InputError

from .arm_choice import reaching_robot

REACHED_M = 1e-3
"""Distance from the goal at which it is reached, m. A hand's fingers compensate for it."""
REACHED_RAD = 0.01
"""Angle from a goal with an orientation at which it is reached, rad."""
STANDSTILL_S = 2.0
"""Time without motion after which the arm counts as stuck, s."""
STANDSTILL_RAD = 1e-4
"""Range within which every joint stays while the arm does not move, rad."""


Goal = Literal["position", "axis", "pose"]
"""What must be reached: the position of the tool; its axis too; or its whole pose."""
GOALS: tuple[Goal, ...] = ("position", "axis", "pose")
"""Names of all goals."""


@dataclass(frozen=True)
class ReachOptions:
    """Cycle time and time limit of a reach.

    Raises
    ------
    InputError
        If `dt` is not positive, or longer than the time limit.
    """

    dt: float = 0.005
    """Cycle time, s. The joints keep their speed between two commands."""
    time_limit: float = 60.0
    """Simulated time after which a reach is given up, s."""
    goal: Goal = "position"
    """What must be reached: the position of the tool; its axis too; or its whole pose."""
    place: Place = "boxes"
    """Surroundings of the goal."""
    arm: ReachingArm = field(default_factory=ReachingArm)
    """The arm."""

    def __post_init__(self) -> None:
        for name, value, known in (("goal", self.goal, GOALS), ("place", self.place, PLACES)):
            if value not in known:
                raise InputError(f"the {name} must be one of {', '.join(known)}, got {value!r}")
        if not 0 < self.dt <= self.time_limit < np.inf:
            raise InputError(
                "dt must be > 0 s and at most the time limit, "
                f"got dt {self.dt}, time limit {self.time_limit}"
            )


@dataclass(frozen=True)
class ReachOutcome:
    """The result of a reach.

    A reach is a success if the tool came within 1 mm of the goal in time, and if no shape of the
    arm touched a box or another shape of the arm in any cycle.
    """

    success: bool
    """Whether the goal was reached without contact."""
    contacts: int
    """Number of cycles that ended with a distance below 0."""
    min_clearance: float
    """Minimum distance over all cycles, start included, m; at most 1."""
    seconds: float
    """Simulated time until the end, s."""
    final_error: float
    """Distance of the tool from the goal at the end, m."""
    cycle_times_us: NDArray[np.float64]
    """Time of each cycle of the method (cycles,), µs, without the evaluation."""
    peak_acceleration: float
    """Maximum joint acceleration as a share of its limit, start and stop included."""
    peak_jerk: float
    """Maximum joint jerk as a share of its limit, start and stop included."""
    status: str
    """`reached`; `stuck` if the arm did not move; `late` if the time was up; or the status with
    which the method itself gave up."""


class ReachMethod(Protocol):
    """A method that controls a reach."""

    def __call__(self, q: NDArray[np.float64]) -> tuple[NDArray[np.float64], str]:
        """Take the joint angles (n,), rad, and return joint speeds (n,), rad/s, and a status.

        The status is empty while the method continues. Otherwise the run ends with this status. A
        method with a function `stop` of q brakes with it at the end. The others command zero.
        """
        ...


def run_reach(
    scene: ReachingScene, method: ReachMethod, options: ReachOptions | None = None
) -> ReachOutcome:
    """Run a method from the start of a scene until it reaches the goal, gives up or is late.

    The arm executes every command exactly: its angles change by speed times cycle time. Clearance
    and error are computed from the joint angles alone, by a model that no method uses.

    Parameters
    ----------
    scene
        Start, goal and obstacles.
    method
        Returns the joint speeds of each cycle.
    options
        Cycle time and time limit.

    Returns
    -------
    ReachOutcome
        The result.

    Raises
    ------
    InputError
        If the method does not return one finite speed per joint.
    """
    options = options or ReachOptions()
    checker = ArmClearance(scene.obstacles, scene.arm)
    q = scene.start.copy()
    min_clearance, contacts = checker.at(q), 0
    times: list[float] = []
    recent = deque([q], maxlen=round(STANDSTILL_S / options.dt) + 1)
    status = ""
    speeds = [np.zeros(len(q))]
    while not status:
        start = time.perf_counter_ns()
        speed, status = method(q)
        times.append((time.perf_counter_ns() - start) * 1e-3)
        speeds.append(_checked_speed(speed, len(q)))
        q = q + options.dt * speeds[-1]
        recent.append(q)
        clearance = checker.at(q)
        min_clearance = min(min_clearance, clearance)
        contacts += clearance < 0
        if _is_reached(checker, q, scene, options.goal):
            status = "reached"
        status = status or _end_status(recent, len(times), options)
    error = float(np.linalg.norm(checker.tool(q) - scene.goal))
    seconds = len(times) * options.dt
    for speed in _stop(method, q, speeds[-1], options.dt):
        speeds.append(speed)
        q = q + options.dt * speed
        clearance = checker.at(q)
        min_clearance = min(min_clearance, clearance)
        contacts += clearance < 0
    peaks = _peaks(speeds, options.dt, scene.arm)
    return ReachOutcome(
        success=status == "reached" and contacts == 0,
        contacts=contacts,
        min_clearance=min_clearance,
        seconds=seconds,
        final_error=error,
        cycle_times_us=np.array(times),
        peak_acceleration=peaks[0],
        peak_jerk=peaks[1],
        status=status,
    )


def _is_reached(
    checker: ArmClearance, q: NDArray[np.float64], scene: ReachingScene, goal: Goal
) -> bool:
    if np.linalg.norm(checker.tool(q) - scene.goal) >= REACHED_M:
        return False
    if goal == "position":
        return True
    axes = checker.tool_axes(q)
    if goal == "axis":
        across = float(np.linalg.norm(np.cross(axes[:, 2], scene.goal_axes[:, 2])))
        return across < REACHED_RAD and float(axes[:, 2] @ scene.goal_axes[:, 2]) > 0.0
    return Rotation.from_matrix(axes.T @ scene.goal_axes).magnitude() < REACHED_RAD


def _stop(
    method: ReachMethod, q: NDArray[np.float64], speed: NDArray[np.float64], dt: float
) -> Iterator[NDArray[np.float64]]:
    """Yield the joint speeds (n,) of each cycle until the arm stands still."""
    stop = getattr(method, "stop", None)
    if stop is None:
        yield np.zeros(len(q))
        return
    for _ in range(round(STANDSTILL_S / dt)):
        speed = _checked_speed(stop(q), len(q))
        yield speed
        if not np.any(speed):
            return
        q = q + dt * speed


def _peaks(speeds: list[NDArray[np.float64]], dt: float, arm: ReachingArm) -> tuple[float, float]:
    """Return peak acceleration and jerk as shares of the limits, from standstill to standstill."""
    still = np.zeros_like(speeds[0])
    accelerations = np.diff([still, *speeds, still], axis=0) / dt
    jerks = np.diff(accelerations, axis=0) / dt
    robot = reaching_robot(arm)
    return (
        float(np.max(np.abs(accelerations) / robot.acceleration)),
        float(np.max(np.abs(jerks) / robot.jerk)),
    )


def _end_status(recent: deque[NDArray[np.float64]], cycles: int, options: ReachOptions) -> str:
    if cycles * options.dt >= options.time_limit:
        return "late"
    if (
        len(recent) == recent.maxlen
        and np.abs(recent[-1] - recent[0]).max() < STANDSTILL_RAD
        and np.ptp(np.array(recent), axis=0).max() < STANDSTILL_RAD
    ):
        return "stuck"
    return ""


def _checked_speed(speed: NDArray[np.float64], joints: int) -> NDArray[np.float64]:
    speed = np.asarray(speed, dtype=np.float64)
    if speed.shape != (joints,) or not np.isfinite(speed).all():
        raise InputError(f"a method must return {joints} finite joint speeds, got {speed}")
    return speed
