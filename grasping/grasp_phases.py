"""From the rest posture to an object held: pre-grasp, approach, contact, close, grip."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from eyehand.control.tasks import Position

from .closing import Closing, preshape_command
from .control_tasks import control_tasks
from .fingertips import bumped_tips
from .motion import bumped, distance_left, go
from .pick_state import Ended, Job

if TYPE_CHECKING:
    from .cell import Cell
    from .robot import HandCommand, HandReading, RobotReading

SLIPPED_OUT = "the object left the closing hand"
"""Reason of a close that may be tried again."""
NEARLY_THERE = 0.012
"""A touch so near the goal is the grasp's own contact, m: the fingers close from there."""


def pre_grasp(cell: Cell, job: Job) -> Ended | None:
    """Bring the open hand before the object, with as few rows as its symmetry allows."""
    hand, options = cell.robot.hand, cell.options
    tasks = control_tasks(job.plan, hand, job.back(cell))
    shape = preshape_command(hand, job.plan.opening, job.prototype)
    _off_the_tray(cell, job, shape)
    since = np.inf

    def stop(reading: RobotReading) -> str:
        # At a joint's limit an error just over the tolerance may stay for ever.
        nonlocal since
        since = min(since, reading.time) if job.there(cell, tasks, reading.q) else np.inf
        near = reading.time - since > options.near_seconds
        return bumped(cell, reading) or ("near enough" if near else "")

    arrival = go(
        cell,
        job.far(cell, tasks, "there"),
        options.pre_grasp_seconds,
        command=lambda _: shape,
        stop=stop,
    )
    if arrival or job.there(cell, tasks, cell.reading.q):
        return None
    return Ended("stuck", f"before the grasp: {arrival.reason}")


def _off_the_tray(cell: Cell, job: Job, shape: HandCommand) -> None:
    """Go level until the hand is beside the tray: straight to the object, it dips behind a wall."""
    palm, tray = cell.palm().translation, cell.tray
    if tray.distance(palm) > 0.0:
        return
    there = job.choice.target.points.mean(axis=0)
    level = Position(np.array([there[0], there[1], palm[2]]))
    beside = 0.5 * max(cell.robot.hand.spread(job.plan.opening), cell.robot.hand.row)
    go(
        cell,
        job.far(cell, (level,), "there"),
        cell.options.pre_grasp_seconds,
        command=lambda _: shape,
        stop=lambda r: (
            bumped(cell, r) or ("beside" if tray.distance(cell.palm().translation) > beside else "")
        ),
    )


def approach(cell: Cell, job: Job) -> Ended | None:
    """Go straight to the grasp; where a finger meets the object too early, come again beside it."""
    hand, options = cell.robot.hand, cell.options
    for tried in range(options.contact_retries + 1):
        tasks = control_tasks(job.plan, hand, 0.0)
        controller = job.near(cell, tasks, options.approach_speed)
        arrival = go(cell, controller, options.approach_seconds, stop=lambda r: _touch(cell, r))
        left = distance_left(tasks, controller.step(cell.reading.q).errors)
        if arrival or (arrival.end == "stopped" and left < NEARLY_THERE):
            return None
        if arrival.end != "stopped":
            if job.there(cell, tasks, cell.reading.q):
                return None
            return Ended("stuck", f"at the grasp: {arrival.reason}")
        reading = cell.reading.hand
        # Felt on the fingers' inner faces, it is between them already.
        if not bumped_tips(reading, hand, options.touch_force):
            return None
        side = _side(cell, reading)
        if tried == options.contact_retries:
            return Ended("no_contact", f"{arrival.reason} was touched {left * 1e3:.0f} mm early")
        job.offset = job.offset + options.shift * side * cell.palm().rotation.as_matrix()[:, 0]
        back = job.near(cell, control_tasks(job.plan, hand, job.back(cell)), options.approach_speed)
        if not go(cell, back, options.approach_seconds):
            return Ended("stuck", f"backing off after {arrival.reason} was touched")
    return None


def contact(cell: Cell, job: Job) -> Ended | None:
    """Go on until the palm feels the object, where the whole hand is to hold it."""
    grip = replace(cell.options.grip, load=job.plan.mass[-1])
    job.closing = Closing(cell.robot.hand, job.prototype, job.plan.opening, grip)
    if job.prototype != "power":
        return None
    options = cell.options
    palm = cell.palm()
    ahead = palm.translation + options.palm_search * palm.rotation.as_matrix()[:, 2]
    controller = job.near(cell, (Position(ahead),), options.palm_speed)
    seconds = options.palm_search / options.palm_speed + options.ramp_seconds
    go(cell, controller, seconds, stop=lambda r: _touch(cell, r))
    return None


def close(cell: Cell, job: Job) -> Ended | None:
    """Close the hand until it holds; where it loses what it touched, back off and come again."""
    for tried in range(cell.options.regrasps + 1):
        ended, side = _close(cell, job)
        if ended is None or ended.reason != SLIPPED_OUT or tried == cell.options.regrasps:
            return ended
        job.offset = job.offset + (
            cell.options.shift * side * cell.palm().rotation.as_matrix()[:, 0]
        )
        shape = preshape_command(cell.robot.hand, job.plan.opening, job.prototype)
        tasks = control_tasks(job.plan, cell.robot.hand, job.back(cell))
        back = job.near(cell, tasks, cell.options.approach_speed)
        if not go(cell, back, cell.options.approach_seconds, command=lambda _, to=shape: to):
            return ended
        again = approach(cell, job) or contact(cell, job)
        if again is not None:
            return again
    return None


def _close(cell: Cell, job: Job) -> tuple[Ended | None, float]:
    """Close once; gives also the side on which something was felt last, as `_side` does."""
    closing = job.closing
    if closing is None:
        return Ended("no_contact", "nothing to close on"), 0.0
    end = cell.reading.time + cell.options.close_seconds
    still = np.zeros(len(cell.robot.joints))
    side = 0.0
    touched = False
    while cell.reading.time < end and not cell.reading.fault:
        cell.step(still, closing.step(cell.reading.hand, cell.robot.period))
        touched = touched or closing.touched
        if _touch(cell, cell.reading):
            side = _side(cell, cell.reading.hand)
        if closing.state in ("holding", "empty"):
            break
    if closing.state == "holding":
        return None, side
    why = SLIPPED_OUT if touched else "the hand closed on nothing"
    return Ended("empty_close", why), side


def grip(cell: Cell, job: Job) -> Ended | None:
    """Let the grip settle."""
    hold(cell, job, cell.options.grip_seconds)
    job.T_palm_grasped = cell.palm().inv()
    return None


def hold(cell: Cell, job: Job, seconds: float) -> None:
    """Stand still with the fingers at work."""
    end = cell.reading.time + seconds
    still = np.zeros(len(cell.robot.joints))
    while cell.reading.time < end and not cell.reading.fault:
        closing = job.closing
        command = closing.step(cell.reading.hand, cell.robot.period) if closing else None
        cell.step(still, command)


def _touch(cell: Cell, reading: RobotReading) -> str:
    """Name the pads that feel something; empty when none does."""
    felt = reading.hand.forces > cell.options.touch_force
    return ", ".join(np.array(cell.robot.hand.pads)[felt].tolist())


def _side(cell: Cell, reading: HandReading) -> float:
    """Tell which way along the closing axis to go: 1 where the thumb met it, -1 for fingers."""
    felt = np.array(cell.robot.hand.pads)[reading.forces > cell.options.touch_force].tolist()
    *fingers, thumb = cell.robot.hand.fingers
    on_thumb = any(pad.startswith(thumb) for pad in felt)
    return float(on_thumb) - float(any(pad.startswith(tuple(fingers)) for pad in felt))
