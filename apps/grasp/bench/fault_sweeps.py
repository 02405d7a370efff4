"""Robots that fail: what is not a number, and physics that breaks down, phase by phase."""

from __future__ import annotations

from contextlib import contextmanager
from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np

from eyehand.data_synth import import_mujoco

from ...bench.sweep import Sweep, Trial
from .event_sweeps import PHASES, PHASES_TOLD, can, disturbed
from .stress_trial import Bench, bench_of

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

    from numpy.typing import NDArray

    from eyehand.data_synth.cell import SimRobot
    from eyehand.grasping import HandCommand, PickOptions, RobotReading

NAN = float("nan")
SHOVE_N = 1e13
"""On the object, N: its acceleration is past what MuJoCo takes for true."""
STILL_RAD = 1e-9
"""How far a robot that has stopped may move."""
AFTER = 25
"""Control periods for which it is watched."""


class SpoiledRobot:
    """A robot whose commands turn into what is no number, from a moment on.

    Parameters
    ----------
    robot
        The sound one behind it.
    """

    def __init__(self, robot: SimRobot) -> None:
        self._robot = robot
        self.spoils = ""
        """``arm`` or ``hand``; empty while all is well."""

    def __getattr__(self, name: str) -> Any:
        return getattr(self._robot, name)

    def step(
        self, velocity: NDArray[np.float64], command: HandCommand | None = None
    ) -> RobotReading:
        """Pass a command on, spoiled or not."""
        if self.spoils == "arm":
            velocity = np.where(np.arange(len(velocity)) == 0, NAN, velocity)
        if self.spoils == "hand" and command is not None:
            command = replace(command, values=np.full_like(command.values, NAN))
        return self._robot.step(velocity, command)


def fault_sweeps() -> tuple[Sweep[PickOptions], ...]:
    """Sweeps over what fails and when."""
    numbers = tuple(float(k + 1) for k in range(len(PHASES)))
    kinds: tuple[tuple[str, str, Callable[[Bench], None], str], ...] = (
        ("nan-arm", "arm command that is no number", partial(_spoil, what="arm"), "not finite"),
        ("nan-hand", "hand command that is no number", partial(_spoil, what="hand"), "not finite"),
        ("bad-physics", "physics that breaks down", _shove, "the simulation failed"),
    )
    return tuple(
        Sweep(
            name=name,
            axis=f"{told}, {PHASES_TOLD}",
            unit="",
            values=numbers,
            holds_to=numbers[-1],
            attempt=partial(_failing, happens=happens, says=says),
            right=f"stops at once, stands still, and says: {says}",
            repeats=1,
        )
        for name, told, happens, says in kinds
    )


def _failing(
    number: float, seed: int, options: PickOptions, *, happens: Callable[[Bench], None], says: str
) -> Trial:
    bench = disturbed(bench_of([can(seed)], seed, options), number)
    bench.cell.robot = SpoiledRobot(bench.robot)  # pyright: ignore[reportAttributeAccessIssue] - passes all else on
    bench.disturb = lambda: happens(bench)
    with _quietly():
        ended = bench.clear()
    if bench.disturb is not None:
        return ended.judged(False, f"the pick never came to {bench.phase}; {ended.says}")
    named = [row for row in ended.picks if row.outcome == "fault" and says in row.reason]
    stopped = says in ended.report.stop_reason
    before = bench.robot.read().q
    for _ in range(AFTER):
        bench.robot.step(np.full(len(before), 0.1))
    moved = float(np.abs(bench.robot.read().q - before).max())
    still = moved <= STILL_RAD
    right = len(named) == 1 and len(ended.picks) == 1 and stopped and still
    outcomes = ", ".join(row.outcome for row in ended.picks)
    said = f"{outcomes}; {ended.report.stop_reason}" if still else f"moved on by {moved:.2g} rad"
    return ended.judged(right, said)


@contextmanager
def _quietly() -> Iterator[None]:
    """Keep MuJoCo's own warnings off the terminal and out of its log file: they are provoked."""
    mujoco = import_mujoco()
    before = mujoco.get_mju_user_warning()
    mujoco.set_mju_user_warning(lambda _: None)
    try:
        yield
    finally:
        mujoco.set_mju_user_warning(before)


def _spoil(bench: Bench, *, what: str) -> None:
    robot = bench.cell.robot
    assert isinstance(robot, SpoiledRobot)
    robot.spoils = what


def _shove(bench: Bench) -> None:
    """Push the object so hard that the physics breaks down."""
    data, model = bench.robot.data, bench.robot.model
    data.xfrc_applied[model.body("can").id, :3] = SHOVE_N
