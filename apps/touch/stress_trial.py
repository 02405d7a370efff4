"""Run, record and evaluate one contact of a stress sweep."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from eyehand.data_synth.pad import SensorModel, toy_box
from eyehand.tactile import PRESETS, ServoOptions, TactileServo, Timing, TouchPhases

from ..bench import Trial
from .commissioning import SEED, shaken_press
from .stress_world import CYCLE, CarriedPad, Electronics

CALM_CONTACT = "pressure reached, calm, and never above 1.2 times its goal"
"""What a trial requires if its sweep requires nothing else."""
SECONDS = 3.0
"""Default time limit of a trial, s."""
LAST_SECONDS = 0.5
"""Time at the end of a trial over which the final figures are computed, s."""
NEAR = 0.1
"""Maximum error of the mean pressure that counts as reached, as a fraction of the goal."""
MAX_PEAK = 1.2
"""Maximum averaged pressure after landing, as a share of the goal, of a contact that is held."""
CALM = 0.08
"""Maximum standard deviation of the pressure that counts as calm, as a fraction of the goal."""
MAX_FORCE = 60.0
"""Force limit of all trials, N: twice the force that ends a task, as the carrier stops late."""
RETREAT_SECONDS = 2.0
"""Extra time to back off if a trial ends late, s. The longest retreat takes 1 s."""
REVERSAL_SECONDS = 0.06
"""Time the carrier needs to reverse after the outcome was reported, s: four times its lag."""
GROWTH = 1.0
"""Maximum ratio of the peak force after that time to the peak force before."""
MAX_RETRACTED_FORCE = 0.05
"""Maximum force on a pad that has backed off, N."""


@dataclass(frozen=True)
class ContactFigures:
    """The measured figures of one contact."""

    outcome: str | None
    """Reason for the end of the contact, or None if the contact lasted."""
    ended: bool
    """Whether the pad has backed off and stands still."""
    peak_force: float
    """Maximum true force, N."""
    growth: float
    """Ratio of the peak force after the carrier could reverse to the peak force before. 0 without
    an outcome."""
    last_force: float
    """Maximum true force at the end of the trial, N."""
    peak_pressure: float
    """Maximum pressure of the servo's average, Pa."""
    pressure: float
    """Mean measured pressure at the end, Pa. 0 without contact."""
    swing: float
    """Standard deviation of the measured pressure at the end, Pa."""
    tilt: float
    """Tilt of the pad at the end, rad."""
    turned: float
    """Maximum rotation of the heading from the start, rad."""
    heading: float
    """Heading of the pad at the end, rad."""
    losses: int
    """Number of lost contacts."""


def run_contact(
    pad: CarriedPad,
    phases: TouchPhases,
    seconds: float = SECONDS,
    lifts: Callable[[float], Sequence[float]] | None = None,
) -> ContactFigures:
    """Run a pad through approach and contact until the time limit or the end of its retreat.

    Parameters
    ----------
    pad
        Pad above the objects.
    phases
        Phase machine with its servo.
    seconds
        Time limit of the contact, s. A retreat may take longer.
    lifts
        Motion of the objects, as in :meth:`CarriedPad.step`.
    """
    forces, pressures, averages, end_cycle = [], [], [], None
    turned, losses = 0.0, 0
    for cycle in range(round((seconds + RETREAT_SECONDS) / CYCLE)):
        if end_cycle is None and cycle >= round(seconds / CYCLE):
            break
        step = phases.step(pad.features, CYCLE, fault=pad.fault)
        if step.outcome and end_cycle is None:
            end_cycle = cycle
        touching = bool(pad.features)
        pad.step(step.twist, lifts)
        losses += touching and not pad.features and end_cycle is None
        forces.append(pad.force)
        pressures.append(pad.features.pressure if pad.features else 0.0)
        averages.append(phases.servo.filtered[0])
        turned = max(turned, abs(pad.heading))
        if step.phase == "ended":
            break
    last = round(LAST_SECONDS / CYCLE)
    reversal = len(forces) if end_cycle is None else end_cycle + round(REVERSAL_SECONDS / CYCLE)
    before, after = max(forces[:reversal]), max(forces[reversal:], default=0.0)
    ended = phases.phase == "ended"
    return ContactFigures(
        outcome=phases.outcome,
        ended=ended,
        peak_force=max(forces),
        growth=after / before if before > MAX_RETRACTED_FORCE else 0.0,
        last_force=forces[-1] if ended else max(forces[-last:]),
        peak_pressure=max(averages),
        pressure=float(np.mean(pressures[-last:])),
        swing=float(np.std(pressures[-last:])),
        tilt=pad.tilt,
        turned=turned,
        heading=pad.heading,
        losses=losses,
    )


def servo_phases(preset: str, sensor: SensorModel, **options: Any) -> TouchPhases:
    """Return a phase machine with a preset selection, commissioned for a sensor.

    Parameters
    ----------
    preset
        Name of the selection.
    sensor
        The servo has the timing that a press of this sensor shows.
    options
        Further options of the servo; a given timing replaces that of the press.
    """
    timing = _timing(sensor)
    servo = ServoOptions(**({"latency": timing.latency, "arm_lag": timing.lag} | options))
    return TouchPhases(TactileServo(selection=PRESETS[preset], options=servo))


@lru_cache
def _timing(sensor: SensorModel) -> Timing:
    pad = CarriedPad((toy_box(),), Electronics(SEED, sensor))

    def step(twist: NDArray[np.float64]) -> float:
        pad.step(twist)
        return pad.features.pressure

    return shaken_press(step)


def hold_contact(
    pad: CarriedPad,
    phases: TouchPhases,
    seconds: float = SECONDS,
    lifts: Callable[[float], Sequence[float]] | None = None,
    find_error: Callable[[ContactFigures], str] = lambda figures: "",
    max_peak: float = MAX_PEAK,
) -> Trial:
    """Run one contact (:func:`run_contact`) and evaluate it (:func:`evaluate_contact`).

    `find_error` returns the error that only this sweep can detect, or an empty string. A contact
    above `max_peak` times its goal ends as `overshoot`.
    """
    phases.options = replace(phases.options, peak_limit=max_peak)
    figures = run_contact(pad, phases, seconds, lifts)
    return evaluate_contact(figures, phases.servo.goal.pressure, find_error(figures), max_peak)


def evaluate_contact(
    figures: ContactFigures, goal: float, wrong: str = "", max_peak: float = MAX_PEAK
) -> Trial:
    """Evaluate whether a contact was kept and stayed safe.

    Parameters
    ----------
    figures
        Figures of the contact.
    goal
        Goal pressure, Pa.
    wrong
        Error that the sweep itself detected, or an empty string.
    max_peak
        Maximum averaged pressure, as a multiple of the goal.

    Returns
    -------
    Trial
        Passed if the contact lasted at its pressure and no error was detected. Refused if the
        contact ended with an outcome. Unclean if the force exceeded `MAX_FORCE` or grew after the
        outcome, or the pad did not back off.
    """
    harm = _safety_violation(figures)
    note = ""
    if figures.outcome:
        note = figures.outcome.replace("_", " ")
    elif abs(figures.pressure / goal - 1.0) > NEAR:
        note = f"no outcome, but {figures.pressure:.0f} Pa instead of {goal:.0f} Pa"
    elif figures.peak_pressure > max_peak * goal:
        note = f"no outcome, but a peak of {figures.peak_pressure / goal:.2f} times the goal"
    elif figures.swing > CALM * goal:
        note = f"no outcome, but the pressure varies by {figures.swing:.0f} Pa (standard deviation)"
    elif wrong:
        note = f"no outcome, but {wrong}"
    return Trial(
        passed=not (note or harm),
        note=harm or note,
        clean=not harm,
        refused=figures.outcome is not None,
        picture=figures,
    )


def _safety_violation(figures: ContactFigures) -> str:
    if not np.isfinite(figures.peak_force) or figures.peak_force > MAX_FORCE:
        return f"force of {figures.peak_force:.0f} N"
    if figures.growth > GROWTH:
        return f"force grew by a factor of {figures.growth:.1f} after {figures.outcome}"
    if figures.outcome and not (figures.ended and figures.last_force <= MAX_RETRACTED_FORCE):
        return f"{figures.outcome}, but not backed off: {figures.last_force:.2f} N"
    return ""
