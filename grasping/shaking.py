"""Shake the hand, along each axis in turn: a test of its grip, or to be rid of what hangs on it."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from .cell import Cell
    from .pick_state import Job

FREQUENCY = 3.0
"""Hz."""
AMPLITUDE = 0.012
"""m: with the frequency, 4 m/s² at the turning points."""
DAMPING = 0.05
"""Of the inverse near singular postures: the shake gets smaller there."""
HANGS = 0.1
"""Force on a pad of the open hand in the air from which something hangs on it, N: 10 g."""
OFF_SECONDS = 1.0
"""How long the hand is shaken then, s: one swing along each axis."""


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


def shake_off(cell: Cell, job: Job) -> str:
    """Be rid of what still hangs on the open hand; names the pads that feel it even then.

    Parameters
    ----------
    cell
        The robot, its hand open and off all else.
    job
        The pick, whose fingers stay open.
    """
    job.closing = None
    if _hanging(cell):
        shake(cell, job, OFF_SECONDS)
    return _hanging(cell)


def _hanging(cell: Cell) -> str:
    pads = zip(cell.robot.hand.pads, cell.reading.hand.forces, strict=True)
    return ", ".join(pad for pad, force in pads if force > HANGS)
