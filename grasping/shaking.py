"""Shake what the hand holds: a test of the grip, along each axis in turn."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from .cell import Cell
    from .job import Job

FREQUENCY = 3.0
"""Hz."""
AMPLITUDE = 0.012
"""m: with the frequency, 4 m/s² at the turning points."""
DAMPING = 0.05
"""Of the inverse near singular postures: the shake gets smaller there."""


def shake(cell: Cell, job: Job, seconds: float) -> None:
    """Move the palm to and fro, a third of the time along each world axis.

    Parameters
    ----------
    cell
        The robot with an object in its hand.
    job
        The pick, whose fingers stay at work.
    seconds
        How long, s of the robot's clock; ends early when the robot has a fault.
    """
    model = job.model(cell)
    start = cell.reading.time
    pace = 2.0 * np.pi * FREQUENCY
    while (passed := cell.reading.time - start) < seconds and not cell.reading.fault:
        along = min(int(3.0 * passed / seconds), 2)
        twist = np.zeros(6)
        twist[along] = AMPLITUDE * pace * np.cos(pace * (passed - along * seconds / 3.0))
        state = model.at(cell.reading.q)
        jacobian = state.jacobian
        lever = jacobian @ jacobian.T + DAMPING**2 * np.eye(6)
        velocity = jacobian.T @ np.linalg.solve(lever, twist)
        fastest = float(np.max(np.abs(velocity) / state.speed, initial=1.0))
        command = job.closing.step(cell.reading.hand, cell.robot.period) if job.closing else None
        cell.step(velocity / fastest, command)
