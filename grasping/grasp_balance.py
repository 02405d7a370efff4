"""Improve a grasp after contact: slide the palm until weight and contact forces turn nothing.

The palm moves as the controllers of grasp quality of Platt, Fagg and Grupen (Null-space grasp
control, 2010) move contacts: down the gradient of the residual torque. The residual about the
opposing axis is the weight times the distance of the centre of mass along the row of fingers. The
residual about the palm's direction is that of a face that is turned against this row. Both need
one row each. Manipulability and the middle of the joint ranges come below them.

The fingers keep equal forces by their tendons. Two fingers share a tendon in some hands, so that
tensions cannot move the resultant of a symmetric row. The palm can.
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from scipy.spatial.transform import RigidTransform, Rotation

from eyehand.control import ApproachController
from eyehand.control.tasks import (
    JointCentring,
    Manipulability,
    Orientation,
    PointOnPlane,
    Position,
    Task,
)

from .hands.closing import Closing
from .hands.hand_model import HandModel
from .hands.hand_state import finger_forces, finger_reading, grip_width
from .held_grip import MIN_WEIGHT
from .motion import execute, with_speed
from .tray_plan import UP

if TYPE_CHECKING:
    from .cell import Cell
    from .pick_state import PickState
    from .robot import RobotReading

WEIGHING_SPEED = 0.04
"""Speed of raising the object to feel it, m/s."""
MAX_SHIFT, MAX_TURN = 0.015, float(np.radians(10.0))
"""Limits of the motion of the palm: along the row of fingers, m, and about its direction, rad."""
MIN_SHIFT, MIN_TURN = 0.002, float(np.radians(1.5))
"""Errors below which the palm stays."""
LIGHT_TENSION = 14.0
"""Tension of each finger while the pads slide along the object, N. It presses with 0.4 N, because
the springs take 8 N of it."""
LIGHT_THUMB_TENSION = 18.0
"""Tension of the thumb meanwhile, N. It presses with 1 N against the fingers."""
EASE_SECONDS, GRIP_SECONDS, MOTION_SECONDS = 0.12, 0.25, 0.8
"""Times of easing the grip, of gripping again, and the limit of one motion between them, s."""
ROUNDS = 3
"""Maximum number of motions. Each one measures the turn again, which the first contact shows too
small."""
SLIDE_SPEED, SLIDE_TURN_SPEED = 0.05, 0.6
"""Speeds of the palm while the pads slide, m/s and rad/s."""
MAX_SLIDE_FORCE = 5.0
"""Force of a finger at which the motion ends, N."""
TOLERANCE = 0.001
"""Error at which a motion of the palm ends, m or rad."""
PROBE_HEIGHT, PROBE_SECONDS = 0.006, 0.12
"""Height to which the object is raised to feel its centre of mass, m, and time for it, s."""
MIN_DOWN = 0.9
"""Minimum cosine between palm and down."""
CONTACT_FORCE = 0.05
"""Force of a finger in contact, N."""
MIN_MANIPULABILITY = 0.03
"""Manipulability that the arm keeps where the grasp leaves it free."""


class BalanceError(NamedTuple):
    """The residual of a grasp that a motion of the palm removes."""

    shift: float
    """Distance of the centre of mass from the opposing axis along the row of fingers, m."""
    turn: float
    """Angle of the touched face to the row of fingers about the palm's direction, rad."""


def balance_error(reading: RobotReading, hand: HandModel, centre: float | None) -> BalanceError:
    """Return the residual of the contacts.

    Parameters
    ----------
    reading
        State of the robot, with an object between fingers and thumb.
    hand
        The hand.
    centre
        Estimated coordinate of the centre of mass along the row of fingers, m, in the palm's frame;
        None if it is unknown.
    """
    felt = finger_reading(reading.hand)
    forces = finger_forces(felt, hand)[:-1]
    touching = forces > CONTACT_FORCE
    rows = hand.row_offsets
    if not touching.any():
        return BalanceError(0.0, 0.0)
    middle = float(forces[touching] @ rows[touching] / forces[touching].sum())
    shift = 0.0 if centre is None else centre - middle
    if touching.sum() < 2 or not hand.joints:
        return BalanceError(shift, 0.0)
    # The fingertips move as those of fingers with two links of equal length.
    link = 0.5 * hand.reach(grip_width(felt, hand))
    places = []
    for finger in hand.fingers[:-1]:
        joints = [k for k, name in enumerate(hand.joints) if name.startswith(finger)]
        bend = felt.angles[joints]
        places.append(link * (np.sin(bend[0]) + np.sin(bend.sum())))
    slope = np.polyfit(rows[touching], np.array(places)[touching], 1)[0]
    return BalanceError(shift, -float(np.arctan(slope)))


def balance(cell: Cell, state: PickState) -> None:
    """Slide the lightly closed hand along the resting object, and grip it again.

    `PickOptions.balance` names the source of the centre of mass. Nothing happens without fingers
    and thumb, in a power grasp, or if the palm does not face down.
    """
    closing, hand, source = state.closing, cell.robot.hand, cell.options.balance
    if source == "off" or not (isinstance(closing, Closing) and isinstance(hand, HandModel)):
        return
    if state.prototype == "power" or closing.state != "holding":
        return
    # Otherwise the weight turns the object about another axis than that of the fingers.
    if -cell.palm_pose().rotation.as_matrix()[2, 2] < MIN_DOWN:
        return
    centre = _felt_centre(cell, state) if source == "felt" else _seen_centre(cell, state)
    tension = closing.tension
    closing.ease(LIGHT_TENSION, LIGHT_THUMB_TENSION)
    cell.wait(EASE_SECONDS, lambda reading: state.grip_command(cell, reading))
    _slide(cell, state, closing, hand, centre)
    closing.end_ease()
    steps = round(GRIP_SECONDS / cell.robot.period)
    for share in np.linspace(0.0, 1.0, steps):
        closing.pull_with(float(LIGHT_TENSION + share * (tension - LIGHT_TENSION)))
        cell.wait(cell.robot.period, lambda reading: state.grip_command(cell, reading))


def _slide(
    cell: Cell, state: PickState, closing: Closing, hand: HandModel, centre: float | None
) -> None:
    """Move the palm until the residual is small or at its limits."""
    start = cell.palm_pose()

    def moved() -> float:
        return float(start.inv().apply(cell.palm_pose().translation)[1])

    def error() -> BalanceError:
        left = None if centre is None else centre - moved()
        return balance_error(cell.reading, hand, left)

    def stop(reading: RobotReading) -> str:
        if float(finger_forces(finger_reading(reading.hand), hand).max()) > MAX_SLIDE_FORCE:
            return "a finger pressed too hard"
        return "" if closing.state == "holding" else "the contact was lost"

    found = error()
    shift, turned = float(np.clip(found.shift, -MAX_SHIFT, MAX_SHIFT)), 0.0
    for _ in range(ROUNDS):
        turn = float(np.clip(turned + found.turn, -MAX_TURN, MAX_TURN))
        if abs(turn - turned) < MIN_TURN and abs(shift - moved()) < MIN_SHIFT:
            break
        turned = turn
        result = execute(
            cell,
            _slide_controller(cell, state, start, shift, turned),
            MOTION_SECONDS,
            command=lambda reading: state.grip_command(cell, reading),
            stop=stop,
        )
        cell.wait(EASE_SECONDS, lambda reading: state.grip_command(cell, reading))
        found = error()
        if result.end == "stopped":
            return


def _seen_centre(cell: Cell, state: PickState) -> float | None:
    """Return the coordinate of the solid's centre along the row of fingers, m, palm frame."""
    solid = state.grasp.target.fit.superquadric
    if solid is None:
        return None
    return float(cell.palm_pose().inv().apply(solid.centre + state.offset)[1])


def _felt_centre(cell: Cell, state: PickState) -> float | None:
    """Raise the object by millimetres, measure where it pulls, and lower it again.

    Returns
    -------
    float or None
        Coordinate of the centre of mass along the row of fingers, m, in the frame of the palm,
        which faces down. None without a sense of the load.
    """
    start = cell.palm_pose()
    state.follow_load(cell)
    held = state.held
    if held is None:
        return None
    _move_up(cell, state, start, PROBE_HEIGHT)
    cell.wait(PROBE_SECONDS, lambda reading: state.grip_command(cell, reading))
    force, torque = held.load[2], held.load[3]
    _move_up(cell, state, start, 0.0)
    state.held = None
    return float(torque / force) if force > MIN_WEIGHT else None


def _move_up(cell: Cell, state: PickState, start: RigidTransform, height: float) -> None:
    tasks = (Position(start.translation + height * UP), Orientation(start.rotation))
    execute(
        cell,
        _controller(cell, state, with_speed(tasks, WEIGHING_SPEED, SLIDE_TURN_SPEED)),
        MOTION_SECONDS,
        command=lambda reading: state.grip_command(cell, reading),
    )


def balance_tasks(start: RigidTransform, shift: float, turn: float) -> tuple[Task, ...]:
    """Return the tasks of the sliding palm, the highest priority first.

    Parameters
    ----------
    start
        Pose of the palm at the first contact, T_world_palm.
    shift, turn
        Motion along the row of fingers, m, and about the palm's direction, rad.
    """
    closing, row, palm = start.rotation.as_matrix().T
    place = start.translation
    return (
        PointOnPlane(row, float(row @ place) + shift, name="centre of mass"),
        Orientation(start.rotation * Rotation.from_rotvec([0.0, 0.0, turn]), name="face"),
        PointOnPlane(palm, float(palm @ place), name="depth"),
        PointOnPlane(closing, float(closing @ place), name="thumb"),
        Manipulability(MIN_MANIPULABILITY),
        JointCentring(),
    )


def _slide_controller(
    cell: Cell, state: PickState, start: RigidTransform, shift: float, turn: float
) -> ApproachController:
    """Return the controller of :func:`balance_tasks`, with the limits of a motion near objects."""
    tasks = with_speed(balance_tasks(start, shift, turn), SLIDE_SPEED, SLIDE_TURN_SPEED)
    return _controller(cell, state, tasks)


def _controller(cell: Cell, state: PickState, tasks: tuple[Task, ...]) -> ApproachController:
    options = replace(state.near_options(cell), tolerance=TOLERANCE)
    return ApproachController(state.world(cell, "ignored"), tasks, options)
