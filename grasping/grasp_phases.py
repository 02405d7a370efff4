"""Phases from the rest posture to a held object: pre-grasp, approach, contact, close, grip."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from eyehand.control.tasks import AxisAlignment, Interval, Orientation, Position, Task

from .cell import Cell
from .control_tasks import control_tasks
from .grasp_balance import balance
from .hands import AnyCommand, JawCommand, ParallelHand
from .held_grip import mean_wrench
from .motion import NEAR_ENOUGH, RAMP_SECONDS, execute, remaining_distance, unexpected_contact
from .pick_state import OPEN_SECONDS as LET_GO_SECONDS
from .pick_state import PhaseFailure, PickState
from .robot import RobotReading

SLIPPED_OUT = "the object left the closing hand"
"""Reason of a failed close that is tried again."""
CONTACT_DISTANCE = 0.012
"""Distance from the grasp below which a touch is the contact of the grasp itself, m."""
TOUCH_FORCE = 0.6
"""Force on a pad that counts as touch while the arm moves, N."""
APPROACH_SPEED = 0.3
"""Speed of the straight approach to the grasp, m/s."""
PALM_SEARCH, PALM_SPEED = 0.012, 0.03
"""A power grasp moves on by this distance, m, at this speed, m/s, to touch the object with the
palm."""
OFFSET_STEP = 0.008
"""Sideways correction of the grasp after an early touch, m."""
DEEPER_STEP = 0.01
"""Distance by which the hand grasps deeper after it pressed the object down, m."""
MAX_RETRIES = 2
"""Maximum number of new approaches after an early touch."""
MAX_REGRASPS = 1
"""Maximum number of new grasps after the object left the closing hand."""
PRE_GRASP_SECONDS = 9.0
"""Time limit of the motion to the pre-grasp, s. A motion around obstacles takes 3 to 6 s."""
PRE_GRASP_SLACK = 0.01
"""Error of the pre-grasp at which the approach begins, m. The approach controls the same tasks, so
it removes the error before the fingers reach the object."""
BOUND_SLACK = 0.001
"""The same error of a bound, m. The bound of the approach angle is so flat that 10 mm are 20°."""
OPEN_SECONDS = 3.0
"""Time for which the arm waits above the object for slow jaws to open, s."""
OUTSIDE = "a fingertip touches something beside its gripping face"
"""Reason to end the motion of an open hand further over the object."""
NARROW = 0.01
"""Distance by which the jaws may be too narrow for the approach, m."""
APPROACH_SECONDS = 3.0
"""Time limit of the approach, s."""
CLOSE_SECONDS = 3.0
"""Time limit of closing the hand, s."""
SLOW_SECONDS = 15.0
"""Time limit of closing jaws that still move, s. Slow grippers close at 5 mm/s."""
PROGRESS, PROGRESS_SECONDS = 0.001, 1.0
"""Jaws still move if their width falls by this distance, m, in this time, s."""
GRIP_SECONDS = 0.15
"""Time for which the grip settles before the lift, s."""


def pre_grasp(cell: Cell, state: PickState) -> PhaseFailure | None:
    """Move the pre-shaped hand to the pre-grasp, with as few task rows as symmetry allows."""
    tasks = control_tasks(state.plan, cell.robot.hand, state.retreat(cell))
    shape = cell.hand.preshape(state.plan.opening, state.prototype)
    _leave_tray(cell, state, tasks, shape)
    bounds = [task for task in tasks if isinstance(task, Interval)]

    def stop(reading: RobotReading) -> str:
        near = state.near_goal(cell, bounds, reading.q, BOUND_SLACK) and state.near_goal(
            cell, tasks, reading.q, PRE_GRASP_SLACK
        )
        return unexpected_contact(cell, reading) or (NEAR_ENOUGH if near else "")

    result = execute(
        cell,
        state.transit(cell, tasks, "obstacle"),
        cell.options.time_limit(PRE_GRASP_SECONDS),
        command=lambda _: shape,
        stop=stop,
    )
    # The step that stops the arm may move it out of the slack again.
    near_enough = result.reason == NEAR_ENOUGH or state.near_goal(cell, tasks, cell.reading.q)
    if not result and not near_enough:
        return PhaseFailure("stuck", f"before the grasp: {result.reason}")
    if narrow := _wait_for_opening(cell, shape):
        return PhaseFailure("hand_stalled", narrow)
    state.tare = _tare(cell)
    return None


def _wait_for_opening(cell: Cell, shape: AnyCommand) -> str:
    """Wait until two jaws are open; return what is wrong if they do not open."""
    if not isinstance(shape, JawCommand):
        return ""

    def narrow() -> bool:
        return cell.hand.width(cell.reading.hand) < shape.width - NARROW

    end = cell.reading.time + OPEN_SECONDS
    while narrow() and cell.reading.time < end and not cell.halted:
        cell.step(np.zeros(len(cell.robot.joints)), shape)
    if not narrow():
        return ""
    return (
        f"the hand opened to {1e3 * cell.hand.width(cell.reading.hand):.0f} of "
        f"{1e3 * shape.width:.0f} mm; check the stroke in its description, and that `width` is the "
        "distance between the pads, 0 when closed"
    )


def _tare(cell: Cell) -> NDArray[np.float64] | None:
    """Return the mean measurement of the wrist with the empty hand, (6,); None without one.

    A gripper with two jaws does not follow the load, and needs none.
    """
    jaws = isinstance(cell.robot.hand, ParallelHand)
    return mean_wrench(cell) if cell.options.follow_load and not jaws else None


def _leave_tray(
    cell: Cell, state: PickState, pre_grasp_tasks: Sequence[Task], shape: AnyCommand
) -> None:
    """Move the hand horizontally until it is beside the tray.

    A direct motion to the object would lower the hand behind a wall of the tray. For a grasp from
    the top the hand already turns on the way.
    """
    palm, tray = cell.palm_pose().translation, cell.tray
    if tray.distance(palm) > 0.0:
        return
    target = state.grasp.target.points.mean(axis=0)
    tasks: list[Task] = [Position(np.array([target[0], target[1], palm[2]]))]
    if state.plan.approach == "top":
        tasks += [one for one in pre_grasp_tasks if isinstance(one, AxisAlignment | Orientation)]
    half_hand = cell.hand.half_width(state.plan.opening)

    def stop(reading: RobotReading) -> str:
        beside = tray.distance(cell.palm_pose().translation) > half_hand
        return unexpected_contact(cell, reading) or (NEAR_ENOUGH if beside else "")

    execute(
        cell,
        state.transit(cell, tasks, "obstacle"),
        cell.options.time_limit(PRE_GRASP_SECONDS),
        command=lambda _: shape,
        stop=stop,
    )


def approach(cell: Cell, state: PickState) -> PhaseFailure | None:
    """Move straight to the grasp; after an early touch, back off and approach beside it."""
    hand, options = cell.robot.hand, cell.options
    seconds = options.time_limit(APPROACH_SECONDS)
    for retry in range(MAX_RETRIES + 1):
        tasks = control_tasks(state.plan, hand, 0.0)
        controller = state.near(cell, tasks, APPROACH_SPEED)
        result = execute(
            cell, controller, seconds, stop=lambda r: _touched_pads(cell, r), guarded=True
        )
        distance = remaining_distance(tasks, controller.step(cell.reading.q).errors)
        if result or (result.end == "stopped" and distance < CONTACT_DISTANCE):
            return None
        if result.end != "stopped":
            if state.near_goal(cell, tasks, cell.reading.q):
                return None
            return PhaseFailure("stuck", f"at the grasp: {result.reason}")
        reading = cell.reading.hand
        # A touch on the inner faces of fingers beside the object means that it is between them.
        beside = distance < state.tip_overlap(cell)
        if beside and not cell.hand.touches_outside(reading, TOUCH_FORCE):
            return None
        if retry == MAX_RETRIES:
            reason = f"{result.reason} touched something {distance * 1e3:.0f} mm before the grasp"
            return PhaseFailure("no_contact", reason)
        if not _touched_pads(cell, cell.reading):
            # What the fingers brushed has moved aside.
            continue
        _shift(cell, state, cell.hand.touched_side(reading, TOUCH_FORCE))
        if not _back_off(cell, state):
            return PhaseFailure("stuck", f"backing off after a touch of {result.reason}")
    return None


def contact(cell: Cell, state: PickState) -> PhaseFailure | None:
    """Prepare the closing; for a power grasp, move on until the palm touches the object."""
    load = None if state.grasp.firm else state.plan.mass[-1]
    grip = replace(cell.options.grip, load=load, lever=state.plan.lever)
    state.closing = cell.hand.closing(state.prototype, state.plan.opening, grip)
    if state.prototype != "power":
        return None
    palm = cell.palm_pose()
    goal = palm.translation + PALM_SEARCH * palm.rotation.as_matrix()[:, 2]
    controller = state.near(cell, (Position(goal),), PALM_SPEED)
    seconds = PALM_SEARCH / (cell.options.speed * PALM_SPEED) + RAMP_SECONDS
    execute(cell, controller, seconds, stop=lambda r: _touched_pads(cell, r))
    return None


def close(cell: Cell, state: PickState) -> PhaseFailure | None:
    """Close the hand until it holds; if the object slips out, back off and grasp again."""
    for regrasp in range(MAX_REGRASPS + 1):
        failure, side = _close_once(cell, state)
        if failure is None or failure.reason != SLIPPED_OUT or regrasp == MAX_REGRASPS:
            return failure
        _shift(cell, state, side)
        shape = cell.hand.preshape(state.plan.opening, state.prototype)
        if not _back_off(cell, state, shape):
            return failure
        again = approach(cell, state) or contact(cell, state)
        if again is not None:
            return again
    return None


def _close_once(cell: Cell, state: PickState) -> tuple[PhaseFailure | None, float]:
    """Close the hand; return the failure, if any, and the side of the last touch."""
    closing = state.closing
    if closing is None:
        return PhaseFailure("no_contact", "the contact phase was not executed"), 0.0
    jaws = isinstance(cell.robot.hand, ParallelHand)
    end = cell.reading.time + CLOSE_SECONDS
    latest = cell.reading.time + (SLOW_SECONDS if jaws else CLOSE_SECONDS)
    still = np.zeros(len(cell.robot.joints))
    side, width = 0.0, np.inf
    touched = False
    while cell.reading.time < min(end, latest) and not cell.halted:
        cell.step(still, closing.step(cell.reading.hand, cell.robot.period))
        touched = touched or closing.touched
        if cell.hand.width(cell.reading.hand) < width - PROGRESS:
            width = cell.hand.width(cell.reading.hand)
            end = max(end, cell.reading.time + PROGRESS_SECONDS)
        if _touched_pads(cell, cell.reading):
            side = cell.hand.touched_side(cell.reading.hand, TOUCH_FORCE)
        if closing.state in ("holding", "empty", "stalled"):
            break
    if closing.state == "holding":
        return None, side
    if closing.state == "stalled" or (jaws and closing.state == "closing"):
        slow = cell.reading.time >= latest
        what = f"still closes after {SLOW_SECONDS:g} s," if slow else "stopped"
        effort = getattr(cell.reading.hand, "effort", None)
        force = "" if effort is None else f" and {effort:.1f} N"
        at = f"{1e3 * cell.hand.width(cell.reading.hand):.0f} mm{force}"
        return PhaseFailure("hand_stalled", f"the hand {what} at {at}"), side
    reason = SLIPPED_OUT if touched else "the hand closed without an object"
    return PhaseFailure("empty_close", reason), side


def grip(cell: Cell, state: PickState) -> PhaseFailure | None:
    """Improve the grasp, if the options say so, and wait until the grip force is constant."""
    balance(cell, state)
    cell.wait(GRIP_SECONDS, lambda reading: state.grip_command(cell, reading))
    state.gripped = cell.hand.width(cell.reading.hand)
    state.T_palm_world_at_grasp = cell.palm_pose().inv()
    state.follow_load(cell)
    return None


def grasp_deeper(cell: Cell, state: PickState) -> PhaseFailure | None:
    """Open the hand, move it further over the object, and grasp again.

    Fingers above the widest part of an object press it out of the hand. A part that the camera did
    not see may be the widest one.
    """
    state.held = state.closing = None
    shape = cell.hand.preshape(state.plan.opening, state.prototype)
    cell.wait(LET_GO_SECONDS, shape)
    state.offset = state.offset + DEEPER_STEP * cell.palm_pose().rotation.as_matrix()[:, 2]
    execute(
        cell,
        state.near(cell, control_tasks(state.plan, cell.robot.hand, 0.0), PALM_SPEED),
        cell.options.time_limit(APPROACH_SECONDS),
        stop=lambda r: OUTSIDE if cell.hand.touches_outside(r.hand, TOUCH_FORCE) else "",
        guarded=True,
    )
    return contact(cell, state) or close(cell, state) or grip(cell, state)


def _shift(cell: Cell, state: PickState, side: float) -> None:
    """Shift the grasp along the closing axis, towards the side that was touched."""
    closing_axis = cell.palm_pose().rotation.as_matrix()[:, 0]
    state.offset = state.offset + OFFSET_STEP * side * closing_axis


def _back_off(cell: Cell, state: PickState, shape: AnyCommand | None = None) -> bool:
    """Move back to the pre-grasp; return whether it was reached."""
    tasks = control_tasks(state.plan, cell.robot.hand, state.retreat(cell))
    controller = state.near(cell, tasks, APPROACH_SPEED)
    seconds = cell.options.time_limit(APPROACH_SECONDS)
    return bool(execute(cell, controller, seconds, command=lambda _: shape))


def _touched_pads(cell: Cell, reading: RobotReading) -> str:
    """Return the names of the pads in contact; empty without contact."""
    return ", ".join(cell.hand.contacts(reading.hand, TOUCH_FORCE))
