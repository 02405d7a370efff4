"""One simulated motion under stress: run to its end, with what must hold in every cycle."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from eyehand.control import ApproachController, CollisionWorld, ControlOptions, RobotModel
from eyehand.data_synth import LBR_ARM, TOOL_SITE

from ..bench import Trial

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Sequence

    from numpy.typing import ArrayLike, NDArray

    from eyehand.control import ControlStep, Obstacle
    from eyehand.control.tasks import Task


SLACK_M = 5e-4
"""By how much a distance may fall below its margin: what linearising over a cycle costs."""
SPEED_SLACK = 1e-6
"""By how much a joint may pass its speed, as a share: rounding."""
SETTLED_STEP = 2e-3
"""Largest joint step of a cycle, rad, that counts as settled."""
TAIL_S = 1.0
"""How much of the end of a motion must be settled, s."""


@dataclass(frozen=True, eq=False)
class Motion:
    """What came of a simulated motion."""

    postures: NDArray[np.float64]
    """Joint angles by cycle (N + 1, n), the start first, rad."""
    velocities: NDArray[np.float64]
    """Commanded by cycle (N, n), rad/s."""
    clearance: NDArray[np.float64]
    """Least distance before each cycle (N,), m; inf when nothing is near."""
    cycles: tuple[ControlStep, ...]
    """What the controller said, by cycle (N)."""
    dt: float
    """Length of a cycle, s."""
    limits: NDArray[np.float64]
    """Joint speed limits (n,), rad/s."""

    @property
    def last(self) -> ControlStep:
        """The last cycle."""
        return self.cycles[-1]

    @property
    def closest(self) -> float:
        """Least distance of all pairs, m; inf when nothing came near."""
        return float(self.clearance.min())

    @property
    def peak_speed(self) -> float:
        """Largest joint speed as a share of its limit."""
        return float(np.max(np.abs(self.velocities) / self.limits))

    @property
    def peak_acceleration(self) -> float:
        """Largest change of a joint's speed over time, between cycles, rad/s²."""
        return float(np.abs(np.diff(self.velocities, axis=0)).max(initial=0.0)) / self.dt

    @property
    def end_step(self) -> float:
        """Largest joint step of a cycle in the last second, rad."""
        tail = self.velocities[-round(TAIL_S / self.dt) :]
        return float(np.abs(tail).max()) * self.dt


@dataclass(frozen=True)
class MotionFigures:
    """What a trial measured, for the table behind the chart."""

    closest_mm: float | None = None
    """Least distance; None when nothing was near."""
    peak_speed_pct: float | None = None
    """Largest joint speed, of its limit."""
    end_step_rad: float | None = None
    """Largest joint step in the last second."""
    amplitude_mm: float | None = None
    """Of an oscillation, peak to peak."""
    peak_acceleration: float | None = None
    """Largest change of a joint's speed between cycles, rad/s²."""
    jump_pct: float | None = None
    """Change of the avoidance's gradient, as a share of it."""


def lbr_world(obstacles: Iterable[Obstacle] = (), *, home: ArrayLike | None = None):
    """The 7-joint arm among obstacles."""
    return CollisionWorld(RobotModel.load(LBR_ARM, TOOL_SITE, home=home), obstacles)


def simulate(
    world: CollisionWorld,
    tasks: Sequence[Task],
    options: ControlOptions,
    seconds: float,
    *,
    start: NDArray[np.float64] | None = None,
    stop_when_reached: bool = True,
    stop_when_stuck: bool = False,
    before: Callable[[int], None] | None = None,
    in_turns: tuple[ControlOptions, int] | None = None,
) -> Motion:
    """Run a controller on an arm that does exactly as it is told.

    Parameters
    ----------
    world
        Robot and obstacles.
    tasks
        Highest priority first.
    options
        Of the controller.
    seconds
        Longest simulated time.
    start
        Posture to begin with (n,); the home posture when None.
    stop_when_reached
        Whether that ends the motion.
    stop_when_stuck
        Whether it ends when it has been stuck for longer than its tail.
    before
        Called before each cycle with its number: moves obstacles.
    in_turns
        Options of a second controller, and for how many cycles each of the two has its turn.
    """
    controllers = [ApproachController(world, tasks, options)]
    other, turn = in_turns or (None, 1)
    if other is not None:
        controllers.append(ApproachController(world, tasks, other))
    q = world.robot.home.copy() if start is None else np.array(start, dtype=np.float64)
    postures, velocities, clearance, cycles = [q], [], [], []
    stuck = 0
    for number in range(round(seconds / options.dt)):
        if before is not None:
            before(number)
        cycle = controllers[number // turn % len(controllers)].step(q)
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
    return Motion(
        np.array(postures),
        np.array(velocities),
        np.array(clearance),
        tuple(cycles),
        options.dt,
        world.robot.speed,
    )


def fault_of(motion: Motion, options: ControlOptions, *, margin: bool = True) -> str:
    """What no motion may do, whatever is asked of it; empty when it did not.

    With `margin`, the start kept the margin and no obstacle moves: then nothing may come nearer.
    """
    if not np.all(np.isfinite(motion.postures)):
        return "joint angles that are not finite"
    if motion.peak_speed > 1.0 + SPEED_SLACK:
        return f"a joint at {100 * motion.peak_speed:.1f} % of its speed"
    if margin and options.safety and motion.closest < options.margin - SLACK_M:
        return f"came as near as {1e3 * motion.closest:.2f} mm"
    if motion.last.status in ("stuck", "infeasible") and not motion.last.reason:
        return f"{motion.last.status} without a reason"
    return ""


def judged(
    motion: Motion,
    options: ControlOptions,
    *,
    passed: bool,
    note: str = "",
    margin: bool = True,
    **figures: float,
) -> Trial:
    """A motion as a trial: unclean when it did what no motion may do."""
    fault = fault_of(motion, options, margin=margin)
    measured = MotionFigures(
        closest_mm=1e3 * motion.closest if np.isfinite(motion.closest) else None,
        peak_speed_pct=100 * motion.peak_speed,
        end_step_rad=motion.end_step,
        **figures,
    )
    said = f"{motion.last.status}: {motion.last.reason}".rstrip(": ")
    right = passed and not fault
    return Trial(
        right,
        "" if right else fault or note or said,
        clean=not fault,
        refused=motion.last.status == "infeasible",
        picture=measured,
    )
