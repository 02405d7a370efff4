"""Phases from a held object to an object in the tray: lift, check, place."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import RigidTransform

from eyehand.control.tasks import AxisAlignment, Orientation, Position, Task
from eyehand.perception import SuperquadricFit

from .cell import Cell
from .motion import NEAR_ENOUGH, Controller, MotionResult, execute
from .pick_state import (
    LIFT_SECONDS,
    LIFT_SPEED,
    RETREAT_TOLERANCE,
    PhaseFailure,
    PickState,
)
from .plan import GraspPlan
from .put_down import TRAY_CLEARANCE, PutDown, clear_poses, object_centre, put_down_poses
from .robot import RobotReading
from .shaking import shake, shake_off
from .tray_plan import UP, added_items
from .weighing import weigh

MIN_WIDTH_SHARE = 0.3
"""Minimum distance of the fingertips that hold an object, as a share of the object's smallest
extent. Off the middle of a round object the held chord is shorter, and the distance is known to a
few mm only."""
RAMP_SECONDS = 0.075
"""Time in which the acceleration of a motion with a held object rises to its limit, s. Shorter
ramps jerk it."""
MIN_LIFT_SHARE = 0.5
"""Minimum share of the lift height at which an arm that cannot rise further continues."""
WALL_MARGIN = 0.03
"""Distance inside the walls at which the centre of an object counts as over the tray, m."""
MAX_PUSH = 15.0
"""Force of tray or content from below at which a lowered object is down, N. An object may be longer
than its solid. The arm pressed one down with 87 N on a finger until a joint was stopped."""
MAX_REST = 0.05
"""Height above its goal at which an object is not released, m. Walls stop fingers that hold a low
object up to 40 mm above."""
PLACE_SECONDS = 15.0
"""Time limit of the motion to the tray, s. A way around its content, found where the direct motion
is stuck, takes up to 12 s."""


def lift(cell: Cell, state: PickState) -> PhaseFailure | None:
    """Lift the object vertically without turning the hand."""
    failure = weigh(cell, state)
    if failure is not None:
        return failure
    palm = state.T_palm_world_at_grasp.inv()
    goal = palm.translation + cell.options.lift_height * UP
    tasks = (Position(goal), Orientation(palm.rotation))
    result = _carry(cell, state, state.move_off(cell, tasks, LIFT_SPEED), LIFT_SECONDS)
    if result:
        return None
    # An arm at a joint limit may stop early. Half of the way clears table and neighbours.
    risen = float((cell.palm_pose().translation - palm.translation) @ UP)
    if result.end in ("stuck", "late") and risen > MIN_LIFT_SHARE * cell.options.lift_height:
        return None
    if result.end == "stopped":
        return PhaseFailure("slipped", f"{result.reason} while lifting")
    return PhaseFailure("stuck", f"lifting: {result.reason}")


def check(cell: Cell, state: PickState) -> PhaseFailure | None:
    """Check that the object stays in the lifted hand."""
    cell.wait(cell.options.check_seconds, lambda reading: state.grip_command(cell, reading))
    if cell.options.shake_seconds > 0.0:
        shake(cell, state, cell.options.shake_seconds)
    width = cell.hand.width(cell.reading.hand)
    reason = state.lost(cell) or gripped_too_thin(width, state.plan, state.grasp.target.fit)
    return PhaseFailure("slipped", f"{reason} after the lift") if reason else None


def place(cell: Cell, state: PickState) -> PhaseFailure | None:
    """Carry the object to a place in the tray, lower it, and release it.

    A tall object that is held from the side is laid down. Other objects stay upright, and so does
    a tall one if the arm cannot lay it down.
    """
    palm = cell.palm_pose()
    if state.held is not None:
        state.held.carrying = True
    poses = put_down_poses(cell, state)
    result = MotionResult("stuck", "")
    goal = poses[-1]
    for goal in poses:
        result = _carry_over_tray(cell, state, goal)
        if result or result.end not in ("stuck", "late"):
            break
    if result.end == "stopped":
        return PhaseFailure("lost", f"{result.reason} on the way to the tray")
    if not result:
        _put_back(cell, state, goal.centre_in_palm, palm)
        return PhaseFailure("place_failed", f"on the way to the tray: {result.reason}")
    thin = gripped_too_thin(cell.hand.width(cell.reading.hand), state.plan, state.grasp.target.fit)
    if thin:
        return PhaseFailure("lost", f"{thin} over the tray")
    state.lowering = True
    down = _lower(cell, state, goal)
    if down is None:
        state.lowering = False
        _put_back(cell, state, goal.centre_in_palm, palm)
        return PhaseFailure("place_failed", "the hand reaches no free place in the tray")
    cell.tray_content += added_items(
        down.size, cell.palm_pose().apply(down.centre_in_palm), down.place.below
    )
    palm = cell.palm_pose().translation
    tips = cell.hand.reach(state.plan.opening)
    clear = cell.tray.centre[2] + cell.tray_height + tips + TRAY_CLEARANCE
    held = state.release(cell, np.array([palm[0], palm[1], max(clear, palm[2])]))
    if held is not None:
        return held
    pads = shake_off(cell, state)
    return PhaseFailure("place_failed", f"something hangs on {pads}") if pads else None


def _lower(cell: Cell, state: PickState, goal: PutDown) -> PutDown | None:
    """Lower the object that is over its place; return the pose, or None without a free one."""
    for pose in clear_poses(cell, state, goal):
        tasks = pose.tasks(pose.high)
        if pose is not goal:
            controller = state.direct_carry(cell, tasks)
            result = _carry(cell, state, controller, LIFT_SECONDS, tasks, RETREAT_TOLERANCE)
            if result.end in ("stuck", "late"):
                continue
        tasks = pose.tasks(pose.low)
        controller = state.lower(cell, tasks)
        result = _carry(cell, state, controller, LIFT_SECONDS, tasks, RETREAT_TOLERANCE)
        here = cell.palm_pose().apply(pose.centre_in_palm)
        if result.end not in ("stuck", "late") or here[2] < pose.low[2] + MAX_REST:
            return pose
        palm = cell.palm_pose()
        up = palm.translation + (pose.high[2] - here[2]) * UP
        tasks = (Position(up), Orientation(palm.rotation))
        _carry(cell, state, state.move_off(cell, tasks, LIFT_SPEED), LIFT_SECONDS)
    return None


def _carry_over_tray(cell: Cell, state: PickState, goal: PutDown) -> MotionResult:
    """Carry the object over its place: directly, else raised first, else along a planned path."""
    tasks = goal.tasks(goal.high)
    # Lowering removes the rest. An object further beside its place would press on the content.
    slack = max(goal.place.gap, RETREAT_TOLERANCE)
    result = MotionResult("stuck", "")
    for way in ("direct", "raised", "planned"):
        if way == "raised":
            _raise(cell, state, goal)
        controller = state.direct_carry(cell, tasks)
        if way == "planned":
            controller = state.transit(cell, tasks, "held")
        result = _carry(cell, state, controller, PLACE_SECONDS, tasks, slack)
        short = result.end in ("stuck", "late")
        # A stuck arm over the tray is near enough, unless the object is over a wall.
        over = cell.tray.contains(cell.palm_pose().apply(goal.centre_in_palm), WALL_MARGIN)
        if short and over:
            return MotionResult("reached", "")
        if not short:
            break
    return result


def _raise(cell: Cell, state: PickState, goal: PutDown) -> None:
    """Raise the held object to the height at which it passes over tray and content."""
    here = cell.palm_pose().apply(goal.centre_in_palm)
    tasks = goal.tasks(np.array([*here[:2], goal.high[2]]))
    _carry(cell, state, state.direct_carry(cell, tasks), LIFT_SECONDS)


def _carry(
    cell: Cell,
    state: PickState,
    controller: Controller,
    seconds: float,
    tasks: Sequence[Task] = (),
    slack: float = 0.0,
) -> MotionResult:
    """Move with the held object until the motion ends or the object is lost.

    With ``tasks``, the motion also counts as reached when their errors are below ``slack``, m. A
    lowered object is also down when what is under it pushes back.
    """

    def stop(reading: RobotReading) -> str:
        near = tasks and state.near_goal(cell, tasks, reading.q, slack)
        put_down = state.lowering and state.held is not None and state.held.pushed > MAX_PUSH
        return state.lost(cell) or (NEAR_ENOUGH if near or put_down else "")

    result = execute(
        cell,
        controller,
        cell.options.time_limit(seconds),
        command=lambda reading: state.grip_command(cell, reading),
        stop=stop,
        ramp_seconds=RAMP_SECONDS,
        guarded=state.lowering,
        gentle=True,
    )
    return MotionResult("reached", "") if result.reason == NEAR_ENOUGH else result


def _put_back(
    cell: Cell, state: PickState, centre_in_palm: NDArray[np.float64], palm: RigidTransform
) -> None:
    """Lower an object that is not put into the tray to its former height beside the tray.

    It was lifted to the pose ``palm`` of the hand.
    """
    upright = AxisAlignment(palm.rotation.inv().apply(UP), UP)
    centre = object_centre(state)
    here = cell.palm_pose().apply(centre_in_palm)
    if cell.tray.contains(here):
        here = palm.apply(centre_in_palm)
        tasks = (Position(here, centre_in_palm), upright)
        _carry(cell, state, state.transit(cell, tasks, "held"), PLACE_SECONDS)
    goal = np.array([here[0], here[1], centre[2] + cell.options.drop_height])
    tasks = (Position(goal, centre_in_palm), upright)
    _carry(cell, state, state.lower(cell, tasks), LIFT_SECONDS)


def gripped_too_thin(width: float, plan: GraspPlan, fit: SuperquadricFit) -> str:
    """Return the reason why fingertips at a distance in m hold no object; empty if they do.

    A power grasp encloses the object. The distance of its fingertips is then no criterion. Jaws at
    a rim hold a wall, which is thinner than the solid.
    """
    solid, expected = fit.superquadric, plan.gripped_width
    if solid is None or plan.prototype == "power":
        return ""
    if expected is None:
        expected = 2.0 * float(solid.semi_axes.min())
    if width >= MIN_WIDTH_SHARE * expected:
        return ""
    gap = 1e3 * max(width, 0.0)
    return f"the fingertips are {gap:.0f} mm apart on an object of {1e3 * expected:.0f} mm"
