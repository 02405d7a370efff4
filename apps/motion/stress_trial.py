"""Simulate one motion of a stress test, and check the limits that hold in every cycle."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from eyehand.control import (
    ApproachController,
    CollisionWorld,
    ControlOptions,
    ControlStep,
    Obstacle,
    RobotModel,
)
from eyehand.control.tasks import Task
from eyehand.data_synth import LBR_ARM, TOOL_SITE

from ..bench import Trial

MARGIN_TOLERANCE_M = 5e-4
"""Allowed violation of a distance margin, m: the error of linearisation within a cycle."""
SPEED_TOLERANCE = 1e-6
"""Allowed relative violation of a joint speed: rounding errors."""
ACCELERATION_TOLERANCE = 1e-6
"""Allowed relative violation of a joint acceleration: rounding errors."""
SETTLED_STEP = 2e-3
"""Joint step per cycle below which a motion is settled, rad."""
TAIL_S = 1.0
"""Duration at the end of a motion that must be settled, s."""


@dataclass(frozen=True, eq=False)
class SimulatedMotion:
    """The record of a simulated motion."""

    postures: NDArray[np.float64]
    """Joint angles by cycle (N + 1, n), start first, rad."""
    velocities: NDArray[np.float64]
    """Commanded joint speeds by cycle (N, n), rad/s."""
    clearance: NDArray[np.float64]
    """Minimum distance before each cycle (N,), m; inf if nothing is near."""
    cycles: tuple[ControlStep, ...]
    """Results of the controller by cycle (N)."""
    dt: float
    """Cycle time, s."""
    limits: NDArray[np.float64]
    """Joint speed limits (n,), rad/s."""
    acceleration_limits: NDArray[np.float64]
    """Joint acceleration limits (n,), rad/s²."""

    @property
    def last(self) -> ControlStep:
        """The last cycle."""
        return self.cycles[-1]

    @property
    def closest(self) -> float:
        """Minimum distance of all pairs, m; inf if nothing came near."""
        return float(self.clearance.min())

    @property
    def peak_speed(self) -> float:
        """Maximum joint speed as a share of its limit."""
        return float(np.max(np.abs(self.velocities) / self.limits))

    @property
    def peak_acceleration(self) -> float:
        """Maximum change of a joint's speed over time, between cycles, rad/s²."""
        return float(np.abs(np.diff(self.velocities, axis=0)).max(initial=0.0)) / self.dt

    @property
    def acceleration_share(self) -> float:
        """Maximum joint acceleration as a share of its limit, from standstill on."""
        steps = np.diff(self.velocities, axis=0, prepend=0.0)
        return float(np.max(np.abs(steps) / self.acceleration_limits)) / self.dt

    @property
    def end_step(self) -> float:
        """Maximum joint step of a cycle in the last second, rad; of the last cycle after arrival.

        A motion ends as soon as it arrives, perhaps within a second of its fastest part.
        """
        count = 1 if self.last.status == "reached" else round(TAIL_S / self.dt)
        tail = self.velocities[-count:]
        return float(np.abs(tail).max()) * self.dt


@dataclass(frozen=True)
class MotionFigures:
    """Measured values of a trial, for the table behind the chart."""

    closest_mm: float | None = None
    """Minimum distance; None if nothing was near."""
    peak_speed_pct: float | None = None
    """Maximum joint speed, in % of its limit."""
    end_step_rad: float | None = None
    """Maximum joint step per cycle in the last second, rad; in the last cycle after arrival."""
    amplitude_mm: float | None = None
    """Peak-to-peak amplitude of an oscillation, mm."""
    peak_acceleration: float | None = None
    """Maximum change of a joint's speed between cycles, rad/s²."""


def lbr_world(obstacles: Iterable[Obstacle] = ()) -> CollisionWorld:
    """Return the collision world of the 7-joint arm and obstacles."""
    return CollisionWorld(RobotModel.load(LBR_ARM, TOOL_SITE), obstacles)


def simulate(
    world: CollisionWorld,
    tasks: Sequence[Task],
    options: ControlOptions,
    seconds: float,
    *,
    stop_when_reached: bool = True,
    stop_when_stuck: bool = False,
    before: Callable[[int], None] | None = None,
    alternate: tuple[ControlOptions, int] | None = None,
) -> SimulatedMotion:
    """Run a controller from the home posture of an arm that executes every command exactly.

    Parameters
    ----------
    world
        Robot and obstacles.
    tasks
        Tasks, highest priority first.
    options
        Options of the controller.
    seconds
        Longest simulated time, s.
    stop_when_reached
        Whether the motion ends when the goal is reached.
    stop_when_stuck
        Whether the motion ends when the controller has been stuck for 1.5 times TAIL_S.
    before
        Called with the cycle number before each cycle, for example to move obstacles.
    alternate
        Options of a second controller, and the number of cycles after which the two controllers
        take turns.
    """
    controllers = [ApproachController(world, tasks, options)]
    other, turn = alternate or (None, 1)
    if other is not None:
        controllers.append(ApproachController(world, tasks, other))
    q = world.robot.home.copy()
    postures, velocities, clearance, cycles = [q], [], [], []
    stuck = 0
    for number in range(round(seconds / options.dt)):
        if before is not None:
            before(number)
        active = controllers[number // turn % len(controllers)]
        cycle = active.step(q)
        for waiting in controllers:
            if waiting is not active:
                waiting.resume(active.velocity, active.acceleration)
        q = q + options.dt * cycle.velocity
        postures.append(q)
        velocities.append(cycle.velocity)
        clearance.append(cycle.clearance)
        cycles.append(cycle)
        stuck = stuck + 1 if cycle.status == "stuck" else 0
        if cycle.status == "reached" and stop_when_reached:
            break
        if stop_when_stuck and stuck * options.dt > 1.5 * TAIL_S:
            break
        if not np.all(np.isfinite(q)):
            break
    return SimulatedMotion(
        np.array(postures),
        np.array(velocities),
        np.array(clearance),
        tuple(cycles),
        options.dt,
        world.robot.speed,
        world.robot.acceleration,
    )


def find_fault(motion: SimulatedMotion, options: ControlOptions, *, margin: bool = True) -> str:
    """Return how a motion violates a limit that every motion must keep; empty if it does not.

    With `margin`, no distance may fall below the safety margin. This requires a start outside the
    margin and obstacles that do not move.
    """
    if not np.all(np.isfinite(motion.postures)):
        return "joint angles are not finite"
    if motion.peak_speed > 1.0 + SPEED_TOLERANCE:
        return f"a joint moves at {100 * motion.peak_speed:.1f} % of its speed limit"
    if motion.acceleration_share > 1.0 + ACCELERATION_TOLERANCE:
        return f"a joint accelerates at {100 * motion.acceleration_share:.1f} % of its limit"
    if margin and options.safety and motion.closest < options.margin - MARGIN_TOLERANCE_M:
        return f"the smallest distance is {1e3 * motion.closest:.2f} mm"
    if motion.last.status in ("stuck", "infeasible") and not motion.last.reason:
        return f"{motion.last.status} without a reason"
    return ""


def motion_trial(
    motion: SimulatedMotion,
    options: ControlOptions,
    *,
    passed: bool,
    note: str = "",
    margin: bool = True,
    **figures: float,
) -> Trial:
    """Return a motion as a trial. It is unclean if the motion violates a limit."""
    fault = find_fault(motion, options, margin=margin)
    measured = MotionFigures(
        closest_mm=1e3 * motion.closest if np.isfinite(motion.closest) else None,
        peak_speed_pct=100 * motion.peak_speed,
        end_step_rad=motion.end_step,
        **figures,
    )
    status = f"{motion.last.status}: {motion.last.reason}".rstrip(": ")
    ok = passed and not fault
    return Trial(
        ok,
        "" if ok else fault or note or status,
        clean=not fault,
        refused=motion.last.status == "infeasible",
        picture=measured,
    )


def direction(azimuth: float, elevation: float) -> NDArray[np.float64]:
    """Return the unit vector (3,) of two angles, rad."""
    level = np.cos(elevation)
    return np.array([np.cos(azimuth) * level, np.sin(azimuth) * level, np.sin(elevation)])
