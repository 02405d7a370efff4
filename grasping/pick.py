"""Pick one object: phase by phase, each with a time-out and a named outcome."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from .fingertips import fingertip_contacts
from .grasp_phases import approach, close, contact, grip, pre_grasp
from .hand_state import curl
from .pick_state import Ended, Job
from .report import PickReport
from .transport_phases import check, lift, place

if TYPE_CHECKING:
    from collections.abc import Callable

    from eyehand.tactile import ContactFeatures

    from .cell import Cell
    from .pick_state import Choice
    from .report import Phase

TOUCHED = 0.1
"""Force from which a pad counts as in contact while an object is held, N."""


def pick(cell: Cell, choice: Choice, slot: int = 0) -> PickReport:
    """Grasp the object, lift it, and put it into the tray.

    Parameters
    ----------
    cell
        The robot at rest, its hand free.
    choice
        What to pick and how.
    slot
        Number of the place in the tray.

    Returns
    -------
    PickReport
        Whatever happens: the hand is open and off the object, or the robot has a fault.
    """
    job = Job(choice, slot)
    solid = choice.target.fit.superquadric
    cell.begin()
    cell.plan = choice.plan
    ended: Ended | None = None
    wrapped = (0, 0.0)
    tips: tuple[ContactFeatures, ...] = ()
    for phase, run in PHASES:
        start = cell.enter(phase)
        ended = run(cell, job)
        if cell.reading.fault:
            ended = Ended("fault", cell.reading.fault)
        cell.leave(start, ended.reason if ended else "done")
        if phase == "check" and ended is None:
            wrapped = _wrapped(cell)
            tips = fingertip_contacts(cell.reading.hand)
        if ended is not None:
            break
    if ended is not None and ended.outcome != "fault":
        job.let_go(cell)
    cell.plan = None
    return PickReport(
        label=choice.target.label,
        kind=solid.kind if solid else "none",
        plan=choice.plan,
        outcome=ended.outcome if ended else "placed",
        reason=ended.reason if ended else "",
        phases=tuple(cell.records),
        perceive_ms=choice.perceive_ms,
        plan_ms=choice.plan_ms,
        times=np.array(cell.times),
        forces=np.array(cell.forces).reshape(len(cell.times), len(cell.robot.hand.fingers) + 1),
        wrapped=wrapped,
        tips=tips,
    )


PHASES: tuple[tuple[Phase, Callable[[Cell, Job], Ended | None]], ...] = (
    ("pre-grasp", pre_grasp),
    ("approach", approach),
    ("contact", contact),
    ("close", close),
    ("grip", grip),
    ("lift", lift),
    ("check", check),
    ("place", place),
)
"""What is done, in order."""


def _wrapped(cell: Cell) -> tuple[int, float]:
    reading = cell.reading.hand
    return int((reading.forces > TOUCHED).sum()), curl(reading, cell.robot.hand)
