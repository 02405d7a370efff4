"""From an object held to an object put away: lift, check, place."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from eyehand.control.tasks import AxisAlignment, Orientation, Position

from .grasp_phases import hold
from .hand_state import held, width
from .motion import Arrival, go
from .pick_state import Ended, Job
from .shaking import shake, shake_off

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from .cell import Cell
    from .robot import HandCommand, RobotReading

UP = Z = np.array([0.0, 0.0, 1.0])
LEAST_CHORD = 0.3
"""Of its thinnest extent, what the hand holds of an object at the least: off the middle of a round
one the chord is shorter, and the gap is known to some mm."""


def lift(cell: Cell, job: Job) -> Ended | None:
    """Raise the object straight up, the hand's orientation kept."""
    options = cell.options
    palm = cell.palm()
    goal = palm.translation + options.lift_height * UP
    tasks = (Position(goal), Orientation(palm.rotation))
    controller = job.off(cell, tasks, options.lift_speed)
    arrival = go(
        cell,
        controller,
        options.lift_seconds,
        command=lambda reading: _grip(job, cell, reading),
        stop=lambda reading: _gone(cell, reading),
    )
    if arrival:
        return None
    if arrival.end == "stopped":
        return Ended("slipped", f"{arrival.reason} while lifting")
    return Ended("stuck", f"lifting: {arrival.reason}")


def check(cell: Cell, job: Job) -> Ended | None:
    """Watch whether the object stays in the lifted hand."""
    hold(cell, job, cell.options.check_seconds)
    if cell.options.shake_seconds > 0.0:
        shake(cell, job, cell.options.shake_seconds)
    why = _gone(cell, cell.reading) or _too_narrow(cell, job)
    return Ended("slipped", f"{why} after the lift") if why else None


def place(cell: Cell, job: Job) -> Ended | None:
    """Carry the object over its place in the tray, as upright as it was, and let it go."""
    options, tray = cell.options, cell.tray
    palm = cell.palm()
    goal = tray.place(job.slot)
    solid = job.choice.target.fit.superquadric
    # The object's middle is led over its place, which from the side is far before the palm.
    middle, above_floor, height = palm.translation, 0.0, 0.0
    if solid is not None:
        middle = solid.centre
        above_floor = float(middle @ UP) + float(solid.support(-UP))
        height = float(solid.support(UP) + solid.support(-UP))
    carried = job.T_palm_grasped.apply(middle)
    layer = tray.layer(job.slot)
    below = cell.tops[layer - 1] if 0 < layer <= len(cell.tops) else 0.0
    low = goal + (below + above_floor + options.drop_height) * UP
    over = max(cell.tray_height + options.over_tray - below - options.drop_height, 0.0)
    high = low + over * UP
    # Which way is up stays so, the turn about it is free. A ball has no up: the palm faces down.
    ball = solid is not None and solid.kind == "sphere"
    axis = -Z if ball else palm.rotation.inv().apply(UP)
    upright = AxisAlignment(axis, UP)
    tasks = (Position(high, carried), upright)
    # Where the arm comes no nearer, over the tray is near enough; only else a way is searched.
    arrival = Arrival("stuck", "")
    for controller in (job.straight(cell, tasks), job.far(cell, tasks, "held")):
        arrival = go(
            cell,
            controller,
            options.place_seconds,
            command=lambda reading: _grip(job, cell, reading),
            stop=lambda reading: _gone(cell, reading),
        )
        there = cell.palm().apply(carried)
        if arrival.end == "stuck" and tray.holds(there):
            arrival = Arrival("reached", "")
        if arrival.end != "stuck":
            break
    if arrival.end == "stopped":
        return Ended("lost", f"{arrival.reason} on the way to the tray")
    if not arrival:
        _set_down(cell, job, carried, upright, middle)
        return Ended("place_failed", f"on the way to the tray: {arrival.reason}")
    job.lowering = True
    # However this ends, the object is over its place, or already down on what lies there.
    go(
        cell,
        job.down(cell, (Position(low, carried), upright)),
        options.lift_seconds,
        command=lambda reading: _grip(job, cell, reading),
        stop=lambda reading: _gone(cell, reading),
    )
    cell.tops += [0.0] * (layer + 1 - len(cell.tops))
    cell.tops[layer] = max(cell.tops[layer], below + height)
    palm = cell.palm().translation
    tips = cell.robot.hand.reach(job.plan.opening)
    clear = tray.centre[2] + cell.tray_height + tips + options.over_tray
    job.let_go(cell, np.array([palm[0], palm[1], max(clear, palm[2])]))
    felt = shake_off(cell, job)
    return Ended("place_failed", f"something hangs on {felt}") if felt else None


def _set_down(
    cell: Cell,
    job: Job,
    carried: NDArray[np.float64],
    upright: AxisAlignment,
    middle: NDArray[np.float64],
) -> None:
    """Lower what cannot be carried away to the height where it stood, so that it does not fall."""
    here = cell.palm().apply(carried)
    goal = np.array([here[0], here[1], middle[2] + cell.options.drop_height])
    go(
        cell,
        job.down(cell, (Position(goal, carried), upright)),
        cell.options.lift_seconds,
        command=lambda reading: _grip(job, cell, reading),
        stop=lambda reading: _gone(cell, reading),
    )


def _grip(job: Job, cell: Cell, reading: RobotReading) -> HandCommand | None:
    return job.closing.step(reading.hand, cell.robot.period) if job.closing else None


def _too_narrow(cell: Cell, job: Job) -> str:
    """Tell fingertips that press on each other by how near they are; a wrapping hand has no gap."""
    solid = job.choice.target.fit.superquadric
    if solid is None or job.prototype == "power":
        return ""
    gap, thinnest = width(cell.reading.hand, cell.robot.hand), 2.0 * float(solid.semi_axes.min())
    if gap >= LEAST_CHORD * thinnest:
        return ""
    return f"the fingertips stand {1e3 * gap:.0f} mm apart around {1e3 * thinnest:.0f} mm"


def _gone(cell: Cell, reading: RobotReading) -> str:
    return "" if held(reading.hand, cell.robot.hand) else "the object left the hand"
