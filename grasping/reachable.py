"""Check whether the arm can reach a grasp, by simulating the approach controller."""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from eyehand.control import ApproachController, CollisionWorld, ControlOptions
from eyehand.control.tasks import Task

PERIOD = 0.04
"""Period of the simulation, s. Longer is faster, but follows obstacles less accurately."""
MAX_SECONDS = 4.0
"""Maximum simulated time of one motion, s."""
PATIENCE = 0.4
"""Simulated time without progress after which a motion ends, s."""
MIN_TOLERANCE = 2e-3
"""Minimum goal tolerance, m or rad. Smaller tolerances spend time on the slow end of a motion."""


@dataclass(frozen=True)
class Reachability:
    """Result of a reachability check; true in a condition when every goal was reached."""

    reached: bool
    """Whether the last goal was reached."""
    leg: int
    """Index of the last simulated motion."""
    reason: str
    """Why a goal was not reached; empty otherwise."""
    q: NDArray[np.float64]
    """Joint angles at the end, (n,), rad."""
    seconds: float
    """Simulated time, s."""
    computed: float
    """Computing time, s."""

    def __bool__(self) -> bool:
        return self.reached


def is_reachable(
    world: CollisionWorld,
    legs: Sequence[Sequence[Task]],
    q: NDArray[np.float64],
    control: ControlOptions | None = None,
) -> Reachability:
    """Simulate the approach controller through a sequence of motions.

    Parameters
    ----------
    world
        The robot and its obstacles.
    legs
        Tasks of each motion, such as those of the pre-grasp and those of the grasp.
    q
        Joint angles at the start, (n,), rad.
    control
        Options of the real motion; the simulation runs without retreats.

    Raises
    ------
    InputError
        If q does not fit the robot, or a motion has no task.
    """
    control = control or ControlOptions()
    began = time.perf_counter()
    # A longer period needs a proportionally softer repulsion to stay stable.
    simulated = replace(
        control,
        dt=PERIOD,
        patience=PATIENCE,
        tolerance=max(MIN_TOLERANCE, control.tolerance),
        retreats=0,
        eta=min(control.eta, control.eta * control.dt / PERIOD),
    )
    q = world.robot.checked(q)
    moved = 0.0
    for leg, tasks in enumerate(legs):
        controller = ApproachController(world, tasks, simulated)
        reason = f"not there after {MAX_SECONDS:g} s"
        for _ in range(round(MAX_SECONDS / PERIOD)):
            cycle = controller.step(q)
            if cycle.status not in ("moving", "too_near"):
                reason = cycle.reason
                break
            q = q + PERIOD * cycle.velocity
            moved += PERIOD
        if reason:
            return Reachability(False, leg, reason, q, moved, time.perf_counter() - began)
    return Reachability(True, len(legs) - 1, "", q, moved, time.perf_counter() - began)
