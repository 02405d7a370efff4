"""One contact under stress: led by the phase machine, recorded, and judged."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from ..bench import Trial
from .stress_world import CYCLE

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from eyehand.tactile import TouchPhases

    from .stress_world import CarriedPad

SECONDS = 3.0
"""Longest trial from the start, s, where a sweep says nothing else."""
LAST_SECONDS = 0.5
"""At the end of a trial, whose figures tell where it came to, s."""
NEAR = 0.1
"""Error of the mean pressure that counts as reached, as a share of the goal."""
CALM = 0.08
"""Standard deviation of the pressure that counts as calm, likewise."""
MAX_FORCE = 60.0
"""Force that must never be met, N: twice what ends a task, for the way the carrier still goes."""
AWAY_SECONDS = 2.0
"""Time to back off in after the trial's, s, where an end was named late in it: the longest way away
takes 1 s."""
STOP_SECONDS = 0.06
"""Time in which the carrier can turn back after an end was named, s: four times its lag."""
GROWTH = 1.0
"""Largest force after that time, over that of the worst cycle before."""
FEELABLE = 0.05
"""Force that a backed-off pad may still feel, N."""


@dataclass(frozen=True)
class ContactFigures:
    """What came of one contact."""

    outcome: str | None
    """Name of its end; None where it lasted."""
    ended: bool
    """Whether the pad has backed off and rests."""
    peak_force: float
    """Largest true force, N."""
    growth: float
    """Largest force once the carrier could turn back after an end was named, over the largest
    before; 0 where none was named."""
    last_force: float
    """Largest true force at the end of the trial, N."""
    peak_pressure: float
    """Largest felt pressure, Pa."""
    pressure: float
    """Mean felt pressure at the end, Pa; 0 without contact."""
    swing: float
    """Its standard deviation there, Pa."""
    tilt: float
    """Of the pad at the end, rad."""
    turned: float
    """Way that the heading has gone from the start, rad, largest."""
    heading: float
    """Of the pad at the end, rad."""
    losses: int
    """How often a contact was lost."""


def lead(
    pad: CarriedPad,
    phases: TouchPhases,
    seconds: float = SECONDS,
    lifts: Callable[[float], Sequence[float]] | None = None,
) -> ContactFigures:
    """Lead a pad to its contact and on, or until it has backed off.

    Parameters
    ----------
    pad
        Over objects.
    phases
        With the servo.
    seconds
        Longest time until an end is named; backing off may take it over this.
    lifts
        See :meth:`CarriedPad.step`.
    """
    forces, pressures, named = [], [], None
    turned, losses = 0.0, 0
    for cycle in range(round((seconds + AWAY_SECONDS) / CYCLE)):
        if named is None and cycle >= round(seconds / CYCLE):
            break
        step = phases.step(pad.features, CYCLE, trusted=pad.trusted)
        if step.outcome and named is None:
            named = cycle
        touching = bool(pad.features)
        pad.step(step.twist, lifts)
        losses += touching and not pad.features and named is None
        forces.append(pad.force)
        pressures.append(pad.features.pressure if pad.features else 0.0)
        turned = max(turned, abs(pad.heading))
        if step.phase == "ended":
            break
    last = round(LAST_SECONDS / CYCLE)
    turn = len(forces) if named is None else named + round(STOP_SECONDS / CYCLE)
    before, after = max(forces[:turn]), max(forces[turn:], default=0.0)
    ended = phases.phase == "ended"
    return ContactFigures(
        outcome=phases.outcome,
        ended=ended,
        peak_force=max(forces),
        growth=after / before if before > FEELABLE else 0.0,
        last_force=forces[-1] if ended else max(forces[-last:]),
        peak_pressure=max(pressures),
        pressure=float(np.mean(pressures[-last:])),
        swing=float(np.std(pressures[-last:])),
        tilt=pad.tilt,
        turned=turned,
        heading=pad.heading,
        losses=losses,
    )


def judged(figures: ContactFigures, goal: float, wrong: str = "") -> Trial:
    """Tell whether a contact was held as it should, and whether it stayed harmless.

    Parameters
    ----------
    figures
        Of the contact.
    goal
        Pressure, Pa.
    wrong
        What else the sweep found wrong; empty where nothing.

    Returns
    -------
    Trial
        Passed where the contact lasted at its pressure and nothing else was wrong; refused where
        it ended with a name. Unclean where force grew, or a named end left the pad in contact.
    """
    harm = _harm(figures)
    note = ""
    if figures.outcome:
        note = figures.outcome.replace("_", " ")
    elif abs(figures.pressure / goal - 1.0) > NEAR:
        note = f"unnamed: {figures.pressure:.0f} Pa instead of {goal:.0f}"
    elif figures.swing > CALM * goal:
        note = f"unnamed: swings by {figures.swing:.0f} Pa"
    elif wrong:
        note = f"unnamed: {wrong}"
    return Trial(
        passed=not (note or harm),
        note=harm or note,
        clean=not harm,
        refused=figures.outcome is not None,
        picture=figures,
    )


def _harm(figures: ContactFigures) -> str:
    if not np.isfinite(figures.peak_force) or figures.peak_force > MAX_FORCE:
        return f"force of {figures.peak_force:.0f} N"
    if figures.growth > GROWTH:
        return f"force grew {figures.growth:.1f} times after {figures.outcome}"
    if figures.outcome and not (figures.ended and figures.last_force <= FEELABLE):
        return f"{figures.outcome}, but not backed off: {figures.last_force:.2f} N"
    return ""
