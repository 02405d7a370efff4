"""A quick look ahead: whether the arm gets to a grasp at all, before it is tried."""

from __future__ import annotations

import time
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from eyehand.control import ApproachController, ControlOptions

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from eyehand.control import CollisionWorld
    from eyehand.control.tasks import Task


@dataclass(frozen=True)
class LookAheadOptions:
    """Options of :func:`is_reachable`."""

    dt: float = 0.04
    """Period of the look-ahead, s: longer is faster, and follows obstacles less well."""
    seconds: float = 4.0
    """Longest motion of one leg, s: longer lets slow ways count."""
    patience: float = 0.4
    """A leg ends when it has got no nearer for so long, s."""
    tolerance: float = 2e-3
    """Error at which a leg counts as done, m or rad: the last creep is not worth its time."""


@dataclass(frozen=True)
class Reachability:
    """How a look-ahead ended; true in a condition when every leg was done."""

    reached: bool
    """Whether the last leg's tasks were reached."""
    leg: int
    """Last leg that was begun, from 0."""
    reason: str
    """Why it was not done; empty otherwise."""
    q: NDArray[np.float64]
    """Joint angles at the end, (n,), rad."""
    seconds: float
    """Duration of the motion, s."""
    computed: float
    """Time the look-ahead took, s."""

    def __bool__(self) -> bool:
        return self.reached


def is_reachable(
    world: CollisionWorld,
    legs: Sequence[Sequence[Task]],
    q: NDArray[np.float64],
    control: ControlOptions | None = None,
    options: LookAheadOptions | None = None,
) -> Reachability:
    """Roll the approach controller from joint angles q (n,) through legs of tasks, one by one.

    Parameters
    ----------
    world
        The robot and what it must not touch.
    legs
        Tasks to reach in turn: those of the pre-grasp, then those of the grasp.
    q
        Where the arm is, (n,), rad.
    control
        Options of the motion looked ahead to; retreats are left out.
    options
        What it may cost.

    Raises
    ------
    InputError
        If q does not fit the robot, or a leg has no task.
    """
    options = options or LookAheadOptions()
    control = control or ControlOptions()
    began = time.perf_counter()
    # A longer period needs a softer repulsion, as much softer as it is longer.
    ahead = replace(
        control,
        dt=options.dt,
        patience=options.patience,
        tolerance=max(options.tolerance, control.tolerance),
        retreats=0,
        eta=min(control.eta, control.eta * control.dt / options.dt),
    )
    q = world.robot.checked(q)
    moved = 0.0
    for leg, tasks in enumerate(legs):
        controller = ApproachController(world, tasks, ahead)
        reason = "no time left"
        for _ in range(round(options.seconds / options.dt)):
            cycle = controller.step(q)
            if cycle.status != "moving":
                reason = cycle.reason
                break
            q = q + options.dt * cycle.velocity
            moved += options.dt
        if reason:
            return Reachability(False, leg, reason, q, moved, time.perf_counter() - began)
    return Reachability(True, len(legs) - 1, "", q, moved, time.perf_counter() - began)
