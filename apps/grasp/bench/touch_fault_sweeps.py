"""Sweeps of a hand whose sense of touch fails in a phase of a pick."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import partial
from typing import Any, get_args

import numpy as np
from numpy.typing import NDArray

from eyehand.data_synth.cell import SimRobot
from eyehand.grasping import HandCommand, HandReading, PickOptions, PickOutcome, RobotReading

from ...bench.sweep import Sweep, Trial
from .event_sweeps import PHASE_RANGE, PHASES, disturbed
from .stress_objects import can_on_table
from .stress_trial import stress_cell

MAX_LEFT_FORCE = 0.1
"""Maximum true force on a pad of a hand that has let go, N."""
AFTER_S = 0.2
"""Time after the pick at which it is measured, s."""


class NumbRobot:
    """A robot whose touch passes through `alter`, if that is set.

    Parameters
    ----------
    robot
        The robot that feels.
    """

    def __init__(self, robot: SimRobot) -> None:
        self._robot = robot
        self.alter: Callable[[HandReading], HandReading] | None = None

    def __getattr__(self, name: str) -> Any:
        return getattr(self._robot, name)

    def read(self) -> RobotReading:
        """Return the altered state."""
        return self._altered(self._robot.read())

    def step(
        self, velocity: NDArray[np.float64], command: HandCommand | None = None
    ) -> RobotReading:
        """Move for a control period, and return the altered state."""
        return self._altered(self._robot.step(velocity, command))

    def _altered(self, reading: RobotReading) -> RobotReading:
        if self.alter is None or not isinstance(reading.hand, HandReading):
            return reading
        return replace(reading, hand=self.alter(reading.hand))


def touch_fault_sweeps() -> tuple[Sweep[PickOptions], ...]:
    """Return the sweeps over the faults of touch and the phases in which they start."""
    numbers = tuple(float(k + 1) for k in range(len(PHASES)))
    right = "a named outcome other than placed, and the hand has let go"
    return tuple(
        Sweep(name, f"phase in which {axis}, {PHASE_RANGE}", "", numbers, numbers[-1],
              partial(_run, fault=fault), right, repeats=1)
        for name, axis, fault in (
            ("touch-repeats", "touch repeats its last reading", _repeat),
            ("touch-tactels", "the driver reports lost tactels", _lose_tactels),
            ("touch-forces", "a pad's force is missing", _lose_force),
        )
    )  # fmt: skip


def _run(
    number: float,
    seed: int,
    options: PickOptions,
    *,
    fault: Callable[[HandReading], Callable[[HandReading], HandReading]],
) -> Trial:
    """Run a pick in which touch fails, and check how it ends."""
    stress = disturbed(stress_cell([can_on_table(seed)], seed, options), number)
    robot = NumbRobot(stress.robot)
    stress.cell.robot = robot  # pyright: ignore[reportAttributeAccessIssue] - passes all else on

    def fail() -> None:
        reading = stress.robot.read().hand
        assert isinstance(reading, HandReading), "the default hand has fingers"
        robot.alter = fault(reading)

    stress.disturb = fail
    outcome = stress.clear()
    if stress.disturb is not None:
        return outcome.trial(
            False, f"the pick never reached {stress.disturbed_phase}; {outcome.failure}"
        )
    for _ in range(round(AFTER_S / stress.robot.period)):
        stress.robot.step(np.zeros(len(stress.robot.joints)))
    after = stress.robot.read().hand
    assert isinstance(after, HandReading), "the default hand has fingers"
    left = float(after.forces.max())
    outcomes = [row.outcome for row in outcome.picks]
    named = bool(outcomes) and outcomes[0] in set(get_args(PickOutcome)) - {"placed", "fault"}
    note = f"{', '.join(outcomes)}; {outcome.report.stop_reason}; {left:.1f} N left on a pad"
    return outcome.trial(named and left <= MAX_LEFT_FORCE, note)


def _repeat(last: HandReading) -> Callable[[HandReading], HandReading]:
    return lambda reading: replace(reading, forces=last.forces, tips=last.tips)


def _lose_tactels(last: HandReading) -> Callable[[HandReading], HandReading]:
    return lambda reading: replace(reading, touch_fault="tactels_lost")


def _lose_force(last: HandReading) -> Callable[[HandReading], HandReading]:
    def alter(reading: HandReading) -> HandReading:
        missing = np.arange(len(reading.forces)) == 0
        return replace(reading, forces=np.where(missing, np.nan, reading.forces))

    return alter
