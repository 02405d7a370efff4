"""Weigh a grasped object just above its support, and grasp deeper if it slides out."""

from __future__ import annotations

from typing import TYPE_CHECKING

from eyehand.control.tasks import Orientation, Position

from .grasp_phases import grasp_deeper
from .held_grip import MIN_WEIGHT, STEADY_SECONDS
from .motion import execute
from .pick_state import LIFT_SECONDS, PhaseFailure
from .tray_plan import UP

if TYPE_CHECKING:
    from .cell import Cell
    from .pick_state import PickState

WEIGHING_HEIGHT, MIN_WEIGHING_HEIGHT = 0.015, 0.004
"""Maximum and minimum height to which an object is raised to be weighed, m. What slides in the hand
then falls no further."""
WEIGHING_SPEED = 0.04
"""Speed of this motion, m/s."""
MAX_WEIGHING_PUSH = 1.0
"""Force from below in the raised hand that shows an object pressed out of the fingers, N. Of 73
picks, the 67 successful ones had at most 0.2 N, and the 6 others 1.3 to 8.8 N."""
PRESSED_DOWN = "the rising hand presses the object down"
"""Reason to grasp deeper, and of a failure if this does not help."""
CHECK_SIGN = "if every pick ends so, check the sign of RobotReading.wrench"
WEIGHED = "the load is constant"
"""Reason to end this motion."""
PULL_SECONDS = 1.2
"""Time limit of easing the grip, s."""


def weigh(cell: Cell, state: PickState) -> PhaseFailure | None:
    """Raise the object by millimetres, and adapt the grip to its weight and friction.

    If the fingers press it down instead, they grasp once more, and deeper.
    """
    failure = _weigh_once(cell, state)
    if failure is None and _presses_down(state):
        failure = grasp_deeper(cell, state) or _weigh_once(cell, state)
    if failure is None and _presses_down(state):
        return PhaseFailure("slipped", f"{PRESSED_DOWN}; {CHECK_SIGN}")
    return failure


def _weigh_once(cell: Cell, state: PickState) -> PhaseFailure | None:
    """Raise the object by millimetres, measure its weight, and ease the grip until it slides."""
    held = state.held
    if held is None:
        return None
    palm = state.T_palm_world_at_grasp.inv()

    def taken_over() -> str:
        risen = float((cell.palm_pose().translation - palm.translation) @ UP)
        if risen > MIN_WEIGHING_HEIGHT and _presses_down(state):
            return PRESSED_DOWN
        return WEIGHED if risen > MIN_WEIGHING_HEIGHT and held.steady else ""

    tasks = (Position(palm.translation + WEIGHING_HEIGHT * UP), Orientation(palm.rotation))
    result = execute(
        cell,
        state.move_off(cell, tasks, WEIGHING_SPEED),
        cell.options.time_limit(LIFT_SECONDS),
        command=lambda reading: state.grip_command(cell, reading),
        stop=lambda _: state.lost(cell) or taken_over(),
        gentle=True,
    )
    if result.reason == PRESSED_DOWN:
        return None
    if result.end == "stopped" and result.reason != WEIGHED:
        return PhaseFailure("slipped", f"{result.reason} while lifting")
    cell.wait(STEADY_SECONDS, lambda reading: state.grip_command(cell, reading))
    held.weigh()
    pressed = held.pressed(cell.hand.forces(cell.reading.hand))
    if state.prototype == "power" or held.weight < MIN_WEIGHT:
        held.follow(pressed)
        return None
    held.start_pull(pressed)
    end = cell.reading.time + PULL_SECONDS
    while held.pulling and cell.reading.time < end and not cell.halted:
        cell.wait(cell.robot.period, lambda reading: state.grip_command(cell, reading))
    if held.pulling:
        held.follow(pressed)
    return None


def _presses_down(state: PickState) -> bool:
    """Return whether the fingers press the object on what is under it, though the hand has risen.

    They hold it above its widest part, and it slides out of them.
    """
    return state.held is not None and state.held.pushed > MAX_WEIGHING_PUSH
