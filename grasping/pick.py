"""Pick one object, phase by phase."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from .cell import Cell
from .grasp_phases import approach, close, contact, grip, pre_grasp
from .hands.hand_control import HeldState
from .motion import unexpected_contact
from .pick_state import PhaseFailure, PickState, SelectedGrasp
from .report import Phase, PickReport
from .transport_phases import check, lift, place

LATE_JAWS = 1.5
"""Time to wait after jaws did not follow a command, s."""


def pick_object(cell: Cell, grasp: SelectedGrasp) -> PickReport:
    """Grasp an object, lift it, and put it into the tray.

    After a failed phase the hand opens and moves off the object, unless the robot has a fault.

    Parameters
    ----------
    cell
        The robot at rest with an empty hand.
    grasp
        The object and its grasp.
    """
    state = PickState(grasp)
    solid = grasp.target.fit.superquadric
    cell.begin()
    cell.plan = grasp.plan
    failure: PhaseFailure | None = None
    held, phase = HeldState(0), ""
    for phase, run in PHASES:
        start = cell.enter(phase)
        failure = run(cell, state)
        if cell.reading.fault:
            failure = PhaseFailure("fault", cell.reading.fault)
        elif cell.touch_fault:
            failure = PhaseFailure("touch_lost", cell.touch_fault)
        cell.leave(start, failure.reason if failure else "done")
        if failure is not None:
            break
        if phase == "check":
            held = cell.hand.held(cell.reading.hand)
    if failure is not None and failure.outcome == "touch_lost":
        cell.ignore_touch()
    stalled = failure is not None and failure.outcome == "hand_stalled"
    # Jaws that keep the object over the tray have been waited for. A hand that is still on its way
    # touches nothing, and a motion off ignores obstacles.
    free = phase == "pre-grasp" and not unexpected_contact(cell, cell.reading)
    done = free or (stalled and phase == "place")
    if failure is not None and failure.outcome != "fault" and not done:
        if stalled:
            # Late jaws may still follow earlier commands.
            cell.wait(LATE_JAWS, cell.hand.opened())
        failure = state.release(cell) or failure
    cell.plan = None
    return PickReport(
        label=grasp.target.label,
        kind=solid.kind if solid else "none",
        plan=grasp.plan,
        outcome=failure.outcome if failure else "placed",
        reason=failure.reason if failure else "",
        phases=tuple(cell.records),
        perceive_ms=grasp.perceive_ms,
        plan_ms=grasp.plan_ms,
        times=np.array(cell.times),
        forces=np.array(cell.forces).reshape(len(cell.times), len(cell.hand.fingers) + 1),
        contact_pads=held.pads,
        finger_curl=held.curl,
        tips=held.tips,
    )


PHASES: tuple[tuple[Phase, Callable[[Cell, PickState], PhaseFailure | None]], ...] = (
    ("pre-grasp", pre_grasp),
    ("approach", approach),
    ("contact", contact),
    ("close", close),
    ("grip", grip),
    ("lift", lift),
    ("check", check),
    ("place", place),
)
"""Phases of a pick and their functions, in execution order."""
