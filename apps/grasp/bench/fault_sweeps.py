"""Sweeps of failing robots: NaN commands and unstable physics in each phase of a pick."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from eyehand.data_synth import import_mujoco
from eyehand.data_synth.cell import SimRobot
from eyehand.grasping import HandCommand, PickOptions, RobotReading

from ...bench.sweep import Sweep, Trial
from .event_sweeps import PHASE_RANGE, PHASES, disturbed
from .stress_objects import can_on_table
from .stress_trial import StressCell, stress_cell

NAN = float("nan")
UNSTABLE_FORCE_N = 1e13
"""Force on the object, N. MuJoCo rejects the resulting acceleration."""
MAX_MOTION_RAD = 1e-9
"""Maximum joint motion of a stopped robot, rad."""
CYCLES_AFTER_STOP = 25
"""Number of control cycles in which the stopped robot must ignore a motion command."""


class FaultyCommandRobot:
    """A robot with NaN in the first joint velocity or in all hand values, if `faulty_part` is set.

    Parameters
    ----------
    robot
        The robot that receives the commands.
    """

    def __init__(self, robot: SimRobot) -> None:
        self._robot = robot
        self.faulty_part = ""
        """``arm`` or ``hand``; empty without a fault."""

    def __getattr__(self, name: str) -> Any:
        return getattr(self._robot, name)

    def step(
        self, velocity: NDArray[np.float64], command: HandCommand | None = None
    ) -> RobotReading:
        """Forward a command, with NaN if its part is faulty."""
        if self.faulty_part == "arm":
            velocity = np.where(np.arange(len(velocity)) == 0, NAN, velocity)
        if self.faulty_part == "hand" and command is not None:
            command = replace(command, values=np.full_like(command.values, NAN))
        return self._robot.step(velocity, command)


def fault_sweeps() -> tuple[Sweep[PickOptions], ...]:
    """Return the sweeps over the faults and the phases in which they start."""
    numbers = tuple(float(k + 1) for k in range(len(PHASES)))
    nan_arm, nan_hand = (partial(_make_commands_nan, part=part) for part in ("arm", "hand"))
    return tuple(
        Sweep(name, f"{axis}, {PHASE_RANGE}", "", numbers, numbers[-1],
              partial(_run_fault, fault=fault, message=message),
              f"stops at once, stands still, and reports: {message}", repeats=1)
        for name, axis, fault, message in (
            ("nan-arm", "phase of a NaN arm command", nan_arm, "not finite"),
            ("nan-hand", "phase of a NaN hand command", nan_hand, "not finite"),
            ("bad-physics", "phase of unstable physics", _make_unstable, "the simulation failed"),
        )
    )  # fmt: skip


def _run_fault(
    number: float,
    seed: int,
    options: PickOptions,
    *,
    fault: Callable[[StressCell], None],
    message: str,
) -> Trial:
    """Run a pick with a fault in one phase, and check that the robot stops."""
    stress = disturbed(stress_cell([can_on_table(seed)], seed, options), number)
    stress.cell.robot = FaultyCommandRobot(stress.robot)  # pyright: ignore[reportAttributeAccessIssue] - passes all else on
    stress.disturb = lambda: fault(stress)
    with _mujoco_warnings_off():
        outcome = stress.clear()
    # `disturb` becomes None when it runs.
    if stress.disturb is not None:
        return outcome.trial(
            False, f"the pick never reached {stress.disturbed_phase}; {outcome.failure}"
        )
    reported = [row for row in outcome.picks if row.outcome == "fault" and message in row.reason]
    stopped = message in outcome.report.stop_reason
    before = stress.robot.read().q
    # A stopped robot must ignore valid commands too, so they bypass the faulty robot.
    for _ in range(CYCLES_AFTER_STOP):
        stress.robot.step(np.full(len(before), 0.1))
    moved = float(np.abs(stress.robot.read().q - before).max())
    still = moved <= MAX_MOTION_RAD
    right = len(reported) == 1 and len(outcome.picks) == 1 and stopped and still
    outcomes = ", ".join(row.outcome for row in outcome.picks)
    note = f"{outcomes}; {outcome.report.stop_reason}" if still else f"moved on by {moved:.2g} rad"
    return outcome.trial(right, note)


@contextmanager
def _mujoco_warnings_off() -> Iterator[None]:
    """Suppress the MuJoCo warnings that the faults provoke."""
    mujoco = import_mujoco()
    before = mujoco.get_mju_user_warning()
    mujoco.set_mju_user_warning(lambda _: None)
    try:
        yield
    finally:
        mujoco.set_mju_user_warning(before)


def _make_commands_nan(stress: StressCell, *, part: str) -> None:
    """Turn the commands of the arm or the hand into NaN from now on."""
    robot = stress.cell.robot
    assert isinstance(robot, FaultyCommandRobot)
    robot.faulty_part = part


def _make_unstable(stress: StressCell) -> None:
    """Push the object so hard that the simulation becomes unstable."""
    data, model = stress.robot.data, stress.robot.model
    data.xfrc_applied[model.body("can").id, :3] = UNSTABLE_FORCE_N
