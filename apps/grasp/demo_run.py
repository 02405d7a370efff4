"""Run a demo: clear the table, record it, and pass every cycle to the observers."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from typing import Protocol, TypeAlias

from eyehand.data_synth.cell import SimRobot
from eyehand.grasping import (
    Cell,
    ClearOptions,
    CycleInfo,
    GraspOptions,
    PickReport,
    SelectedGrasp,
    clear_table,
)

from .bench.trial import GraspTrial, Scorer
from .demo_record import DemoRecord, Recorder

FAILURES = 6
"""Default number of successive failed picks that ends a demo: about two per object."""


class Observer(Protocol):
    """The callbacks of a film or a live page that follows the demo."""

    def on_cycle(self, cycle: CycleInfo) -> None:
        """Handle a control cycle."""
        ...

    def on_pick(self, choice: SelectedGrasp, report: PickReport | None) -> None:
        """Handle a pick: before it, with None, and after it, with its report."""
        ...


MakeObserver: TypeAlias = "Callable[[Cell, SimRobot, Recorder], Observer]"
"""Make an observer of a built cell."""


def run_demo(
    source: str,
    trial: GraspTrial,
    built: tuple[Cell, SimRobot],
    observers: Sequence[MakeObserver] = (),
    options: ClearOptions | None = None,
) -> DemoRecord:
    """Clear the table, print a line per pick, and record it.

    The processor time of the result excludes the observers.

    Parameters
    ----------
    source
        Description of the scene for people.
    trial
        Seed, purpose, friction and robot.
    built
        The cell and its robot, as returned by :func:`~.trial.trial_cell`.
    observers
        Functions that make the observers. They are called before the first capture.
    options
        When to stop.
    """
    began = time.process_time()
    observer_seconds = 0.0

    @contextmanager
    def observing() -> Iterator[None]:
        nonlocal observer_seconds
        started = time.process_time()
        yield
        observer_seconds += time.process_time() - started

    cell, robot = built
    recorder = Recorder(cell)
    with observing():
        following: list[Observer] = [recorder, *(make(cell, robot, recorder) for make in observers)]

    def on_cycle(cycle: CycleInfo) -> None:
        with observing():
            for observer in following:
                observer.on_cycle(cycle)

    def on_pick(choice: SelectedGrasp, report: PickReport | None) -> None:
        scorer.on_pick(choice, report)
        if report is not None:
            reports.append(report)
        with observing():
            for observer in following:
                observer.on_pick(choice, report)

    reports: list[PickReport] = []
    cell.on_cycle = on_cycle
    scorer = Scorer(cell, robot)
    select = GraspOptions(purpose=trial.purpose)
    report = clear_table(cell, select, options or ClearOptions(failures=FAILURES), on_pick)
    # A film takes many times the processor time of the robot, so it is counted separately.
    result = scorer.result(trial, report, time.process_time() - began - observer_seconds)
    return DemoRecord(
        source=source,
        captures=recorder.captures(result.picks),
        report=report,
        result=result,
        fingers=cell.hand.fingers,
    )
