"""A demo from an empty tray to a cleared table, watched and remembered."""

from __future__ import annotations

import time
from typing import TYPE_CHECKING, Protocol, TypeAlias

from eyehand.grasping import ClearOptions, GraspOptions, clear_table

from .bench.trial import GraspTrial, Scorer
from .demo_record import DemoRecord, Recorder

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from eyehand.data_synth.cell import SimRobot
    from eyehand.grasping import Cell, CycleInfo, PickReport, SelectedGrasp


FAILURES = 6
"""Failed picks in a row after which a demo ends: each object has its two tries, and a robot that
can do nothing here is not watched forever."""


class Onlooker(Protocol):
    """Who sees the demo while it runs: a film, a live page."""

    def on_cycle(self, cycle: CycleInfo) -> None:
        """See the robot after a control period."""
        ...

    def on_pick(self, choice: SelectedGrasp, report: PickReport | None) -> None:
        """Hear of a pick: before it, with None, and after it."""
        ...


Joins: TypeAlias = "Callable[[Cell, SimRobot, Recorder], Onlooker]"
"""Makes an onlooker of a cell that stands."""


def run_demo(
    source: str,
    trial: GraspTrial,
    built: tuple[Cell, SimRobot],
    onlookers: Sequence[Joins] = (),
    options: ClearOptions | None = None,
) -> DemoRecord:
    """Clear the table; the result's processor time is without that of the onlookers.

    Parameters
    ----------
    source
        What stands on it, in words.
    trial
        Seed, purpose, friction and robot.
    built
        The cell and its robot, as :func:`~.trial.cell_of` makes them of the trial.
    onlookers
        Each joins the cell before the first look.
    options
        When to end.
    """
    began, watching = time.process_time(), 0.0
    select = GraspOptions(purpose=trial.purpose)
    cell, robot = built
    recorder = Recorder(cell)
    joined = time.process_time()
    seeing: list[Onlooker] = [recorder, *(make(cell, robot, recorder) for make in onlookers)]
    watching += time.process_time() - joined

    def on_cycle(cycle: CycleInfo) -> None:
        nonlocal watching
        started = time.process_time()
        for one in seeing:
            one.on_cycle(cycle)
        watching += time.process_time() - started

    cell.on_cycle = on_cycle
    scorer = Scorer(cell, robot)

    def on_pick(choice: SelectedGrasp, report: PickReport | None) -> None:
        nonlocal watching
        scorer.on_pick(choice, report)
        started = time.process_time()
        for one in seeing:
            one.on_pick(choice, report)
        watching += time.process_time() - started

    report = clear_table(cell, select, options or ClearOptions(failures=FAILURES), on_pick)
    # The robot's own time: a film takes many times as much, and a robot needs none.
    result = scorer.result(trial, report, time.process_time() - began - watching)
    return DemoRecord(
        source=source,
        looks=recorder.looks(result.picks),
        report=report,
        result=result,
        fingers=cell.robot.hand.fingers,
    )
