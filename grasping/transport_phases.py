"""Phases from a held object to an object in the tray: lift, check, place."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from eyehand.control.tasks import AxisAlignment, Orientation, Position

from .motion import MotionResult, execute
from .pick_state import LIFT_SECONDS, LIFT_SPEED, PhaseFailure, PickState
from .shaking import shake, shake_off

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from .cell import Cell
    from .motion import Controller
    from .robot import RobotReading

UP = np.array([0.0, 0.0, 1.0])
MIN_WIDTH_SHARE = 0.3
"""Minimum distance of the fingertips that hold an object, as a share of the object's smallest
extent. Off the middle of a round object the held chord is shorter, and the distance is known to a
few mm only."""
MIN_LIFT_SHARE = 0.5
"""Minimum share of the lift height at which an arm that cannot rise further continues."""
TRAY_CLEARANCE = 0.03
"""Height at which the object passes over the tray's walls, m."""
PLACE_SECONDS = 8.0
"""Time limit of the motion to the tray, s."""


def lift(cell: Cell, state: PickState) -> PhaseFailure | None:
    """Lift the object vertically without turning the hand."""
    palm = cell.palm_pose()
    goal = palm.translation + cell.options.lift_height * UP
    tasks = (Position(goal), Orientation(palm.rotation))
    controller = state.move_off(cell, tasks, LIFT_SPEED)
    result = _carry(cell, state, controller, LIFT_SECONDS)
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
    reason = _lost(cell, cell.reading) or _tips_touch(cell, state)
    return PhaseFailure("slipped", f"{reason} after the lift") if reason else None


def place(cell: Cell, state: PickState) -> PhaseFailure | None:
    """Carry the object to its slot in the tray, keep it upright, and release it."""
    options, tray = cell.options, cell.tray
    palm = cell.palm_pose()
    goal = tray.slot_position(state.slot)
    fit = state.grasp.target.fit
    solid = fit.superquadric
    # The centre of the object is moved over the slot. In a side grasp it is far from the palm.
    centre, above_floor, height = palm.translation, 0.0, 0.0
    if solid is not None:
        centre = solid.centre
        parts = fit.parts or (solid,)
        below_origin = max(float(part.support(-UP)) for part in parts)
        above_floor = float(centre @ UP) + below_origin
        height = max(float(part.support(UP)) for part in parts) + below_origin
    centre_in_palm = state.T_palm_world_at_grasp.apply(centre)
    layer = tray.layer(state.slot)
    below = cell.layer_tops[layer - 1] if 0 < layer <= len(cell.layer_tops) else 0.0
    low = goal + (below + above_floor + options.drop_height) * UP
    over = max(cell.tray_height + TRAY_CLEARANCE - below - options.drop_height, 0.0)
    high = low + over * UP
    # The object stays upright; its rotation about the vertical is free. A sphere has no upright
    # axis, so the palm faces down.
    sphere = solid is not None and solid.kind == "sphere"
    axis = -UP if sphere else palm.rotation.inv().apply(UP)
    upright = AxisAlignment(axis, UP)
    tasks = (Position(high, centre_in_palm), upright)
    # A stuck arm over the tray is near enough. Otherwise the planner searches a path.
    result = MotionResult("stuck", "")
    for controller in (
        state.direct_carry(cell, tasks),
        state.transit(cell, tasks, "held"),
    ):
        result = _carry(cell, state, controller, PLACE_SECONDS)
        short = result.end in ("stuck", "late")
        if short and tray.contains(cell.palm_pose().apply(centre_in_palm)):
            result = MotionResult("reached", "")
        if not short or result:
            break
    if result.end == "stopped":
        return PhaseFailure("lost", f"{result.reason} on the way to the tray")
    if not result:
        _put_back(cell, state, centre_in_palm, upright, centre)
        return PhaseFailure("place_failed", f"on the way to the tray: {result.reason}")
    state.lowering = True
    # However this motion ends, the object is over its slot or already on what lies there.
    _carry(cell, state, state.lower(cell, (Position(low, centre_in_palm), upright)), LIFT_SECONDS)
    cell.layer_tops += [0.0] * (layer + 1 - len(cell.layer_tops))
    cell.layer_tops[layer] = max(cell.layer_tops[layer], below + height)
    palm = cell.palm_pose().translation
    tips = cell.hand.reach(state.plan.opening)
    clear = tray.centre[2] + cell.tray_height + tips + TRAY_CLEARANCE
    state.release(cell, np.array([palm[0], palm[1], max(clear, palm[2])]))
    pads = shake_off(cell, state)
    return PhaseFailure("place_failed", f"something hangs on {pads}") if pads else None


def _carry(cell: Cell, state: PickState, controller: Controller, seconds: float) -> MotionResult:
    """Move with the held object until the motion ends or the object is lost."""
    return execute(
        cell,
        controller,
        cell.options.time_limit(seconds),
        command=lambda reading: state.grip_command(cell, reading),
        stop=lambda reading: _lost(cell, reading),
    )


def _put_back(
    cell: Cell,
    state: PickState,
    centre_in_palm: NDArray[np.float64],
    upright: AxisAlignment,
    centre: NDArray[np.float64],
) -> None:
    """Lower an object that cannot be carried to the tray to its former height."""
    here = cell.palm_pose().apply(centre_in_palm)
    goal = np.array([here[0], here[1], centre[2] + cell.options.drop_height])
    tasks = (Position(goal, centre_in_palm), upright)
    _carry(cell, state, state.lower(cell, tasks), LIFT_SECONDS)


def _tips_touch(cell: Cell, state: PickState) -> str:
    """Return the reason why the fingertips press on each other; empty if they hold the object.

    A power grasp encloses the object. The distance of its fingertips is then no criterion.
    """
    solid = state.grasp.target.fit.superquadric
    if solid is None or state.prototype == "power":
        return ""
    width = cell.hand.width(cell.reading.hand)
    thinnest = 2.0 * float(solid.semi_axes.min())
    if width >= MIN_WIDTH_SHARE * thinnest:
        return ""
    return f"the fingertips are {1e3 * width:.0f} mm apart on an object of {1e3 * thinnest:.0f} mm"


def _lost(cell: Cell, reading: RobotReading) -> str:
    return "" if cell.hand.holds(reading.hand) else "the object left the hand"
