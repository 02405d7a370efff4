"""Shake the hand, to test a grip or to remove what hangs on the open hand."""

from __future__ import annotations

import numpy as np

from .cell import Cell
from .held_grip import mean_wrench
from .pick_state import PickState

FREQUENCY = 3.0
"""Approximate frequency of the motion, Hz. Each axis takes a whole number of periods."""
PEAK_ACCELERATION = 4.0
"""Maximum acceleration of the palm, m/s². At 3 Hz the amplitude is 11 mm."""
DAMPING = 0.05
"""Damping of the pseudo-inverse, which reduces the motion near singular configurations."""
HANGING_FORCE = 0.1
"""Force on a pad of the open hand, and load of the wrist, above which something hangs on it, N (10
g)."""
SHAKE_OFF_SECONDS = 1.0
"""Time for which the open hand is shaken, s: one period along each axis."""


def shake(cell: Cell, state: PickState, seconds: float) -> None:
    """Oscillate the palm along each world axis in turn, a third of the time each.

    Each oscillation begins and ends at rest.

    Parameters
    ----------
    cell
        The robot.
    state
        The pick; its closing controller stays active.
    seconds
        Duration, s of robot time. It ends early if every motion must end.
    """
    model = state.model(cell)
    start = cell.reading.time
    third = seconds / 3.0
    rate = 2.0 * np.pi * max(round(FREQUENCY * third), 1) / third
    with cell.stopped_at_error():
        while (elapsed := cell.reading.time - start) < seconds and not cell.halted:
            axis = min(int(elapsed / third), 2)
            twist = np.zeros(6)
            twist[axis] = PEAK_ACCELERATION / rate * np.sin(rate * (elapsed - axis * third))
            robot = model.at(cell.reading.q)
            jacobian = robot.jacobian
            damped = jacobian @ jacobian.T + DAMPING**2 * np.eye(6)
            velocity = jacobian.T @ np.linalg.solve(damped, twist)
            excess = float(np.max(np.abs(velocity) / robot.speed, initial=1.0))
            cell.step(velocity / excess, state.grip_command(cell, cell.reading))


def shake_off(cell: Cell, state: PickState) -> str:
    """Shake an object off the open hand; return the names of pads that still feel a force.

    Parameters
    ----------
    cell
        The robot, its hand open and free.
    state
        The pick; its closing controller is removed.
    """
    state.closing = None
    if _loaded_pads(cell, state):
        shake(cell, state, SHAKE_OFF_SECONDS)
    return _loaded_pads(cell, state)


def _loaded_pads(cell: Cell, state: PickState) -> str:
    """Return the names of the pads that something hangs on, if the wrist feels it too.

    Foam reads a part of an earlier load for seconds. The wrist does not.
    """
    pads = ", ".join(cell.hand.contacts(cell.reading.hand, HANGING_FORCE))
    if not pads or state.tare is None:
        return pads
    wrench = mean_wrench(cell)
    if wrench is not None and np.linalg.norm((wrench - state.tare)[:3]) < HANGING_FORCE:
        return ""
    return ", ".join(cell.hand.contacts(cell.reading.hand, HANGING_FORCE))
