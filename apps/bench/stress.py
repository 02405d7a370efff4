"""The driver of all `eyehand stress` commands: run sweeps, chart and print where they break.

A stage declares one :class:`StressStage`; its command calls :func:`run_stress`.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, Generic

from cyclopts import Parameter
from rich import box
from rich.table import Table

from eyehand.apps.console import print_json, say, show, tracked
from eyehand.apps.run_folder import claim_folder
from eyehand.errors import InputError

from .sweep import Sweep, SweepResult, Tested, format_value, run_sweep, select_sweeps
from .sweep_chart import ReportSpec, point_rows, sweep_rows, write_stress_chart

CHART_FILES = ("stress.png", "stress.csv")
"""Files that every stress command writes: the chart and its figures."""


@Parameter(name="*")
@dataclass(frozen=True, kw_only=True)
class StressArguments:
    """The options that all stress commands share."""

    only: list[str] | None = None
    """Names of the sweeps to run; default: all."""
    seeds: int | None = None
    """Trials at each value; default: segmentation 5, fit 20, motion 10, touch 8,
    grasp 2, and fewer with --quick."""
    seed: int = 0
    """The first seed. All randomness follows from the seeds."""
    quick: bool = False
    """Run each sweep at its easiest value, its bound and its hardest value only."""
    out: Path | None = None
    """Output folder; default: out/stress_STAGE."""
    json: bool = False
    """Print one JSON object on stdout; tables go to stderr."""


@dataclass(frozen=True)
class OtherMethod(Generic[Tested]):
    """A further method that runs the same sweeps: a column of the table, a curve of the chart."""

    name: str
    """Name of the column and the curve."""
    method: Tested
    """The method under test."""
    holds_to: Mapping[str, float]
    """Name of a sweep → value up to which the method must not break. Nothing is required of it in
    the other sweeps."""


@dataclass(frozen=True)
class StressStage(Generic[Tested]):
    """The parts of the stress command of one stage."""

    name: str
    """Name of the stage, the second word of the command."""
    sweeps: Sequence[Sweep[Tested]]
    """All sweeps, in reading order."""
    method: Tested
    """The method under test."""
    report: ReportSpec
    """Words and curves of the chart."""
    seeds: int
    """Trials per value when no number is given."""
    quick_seeds: int
    """Trials per value of a quick run when no number is given."""
    prepare: Callable[[], object] | None = None
    """Called once before the first trial, for instance to compile kernels."""
    write_files: Callable[[Path, Sequence[SweepResult]], Sequence[str]] | None = None
    """Write further files into the output folder and return their names."""
    method_name: str = ""
    """Name of the method, if there are others."""
    others: Sequence[OtherMethod[Tested]] = ()
    """Further methods."""
    members: Mapping[str, Any] = field(default_factory=dict)
    """Further members of the JSON object."""
    schema_version: int = 1
    """Version of the schema of the JSON object."""


def run_stress(stage: StressStage[Any], arguments: StressArguments) -> int:
    """Run the sweeps of a stage, write its chart, and print where it breaks.

    Returns
    -------
    int
        Exit code: 1 when a bound is violated, otherwise 0.

    Raises
    ------
    InputError
        If a name is unknown, or a number of seeds or the first seed is invalid.
    """
    seeds = _seed_range(stage, arguments)
    sweeps = select_sweeps(stage.sweeps, arguments.only or ())
    out = arguments.out or Path(f"out/stress_{stage.name}")
    claim_folder(out)
    if stage.prepare is not None:
        stage.prepare()
    results = [
        run_methods(stage, sweep, seeds, arguments.quick) for sweep in tracked(sweeps, "sweeps")
    ]
    files = stage.write_files(out, results) if stage.write_files else ()
    write_stress_chart(out / CHART_FILES[0], results, stage.report, len(seeds), seeds.start)
    show(_table(results, stage.report), json_wanted=arguments.json)
    say(f"{', '.join([*CHART_FILES, *files])} in {out}")
    faults = [fault for result in results for fault in result.faults]
    for fault in faults:
        say(f"broken bound: {fault}")
    if arguments.json:
        print_json(
            f"stress_{stage.name}",
            seeds.start,
            sweep_rows(results),
            seeds=len(seeds),
            quick=arguments.quick,
            broken_bounds=faults,
            points=point_rows(results, stage.report),
            out=str(out),
            schema_version=stage.schema_version,
            **stage.members,
        )
    return 1 if faults else 0


def run_methods(
    stage: StressStage[Any], sweep: Sweep[Any], seeds: Sequence[int], quick: bool
) -> SweepResult:
    """Run a sweep with all methods of a stage; `quick` shortens it."""
    bounds = [other.holds_to.get(sweep.name) for other in stage.others]
    used = sweep.shortened(*bounds) if quick else sweep
    others = tuple(
        run_sweep(replace(used, holds_to=bound), seeds, other.method, other.name)
        for other, bound in zip(stage.others, bounds, strict=True)
    )
    return replace(run_sweep(used, seeds, stage.method, stage.method_name), others=others)


def _seed_range(stage: StressStage[Any], arguments: StressArguments) -> range:
    count = arguments.seeds
    if count is None:
        count = stage.quick_seeds if arguments.quick else stage.seeds
    if count < 1:
        raise InputError(f"--seeds must be >= 1, got {count}")
    if arguments.seed < 0:
        raise InputError(f"--seed must be a whole number >= 0, got {arguments.seed}")
    return range(arguments.seed, arguments.seed + count)


def _table(results: Sequence[SweepResult], report: ReportSpec) -> Table:
    title = report.title
    table = Table(
        title=f"{title[:1].lower()}{title[1:]} (fewer than 90 % of trials right)",
        title_justify="left",
        box=box.SIMPLE_HEAD,
    )
    others = [f"{other.method} breaks at" for other in results[0].others]
    first = f"{results[0].method} breaks at".strip()
    numeric = (first, *others, report.time_column)
    for column in ("sweep", "what gets harder", "holds to", *numeric, "what is wrong"):
        table.add_column(column, justify="right" if column in numeric else "left")
    for result in results:
        sweep = result.sweep
        seconds = result.steps[0].median_seconds
        table.add_row(
            sweep.name,
            sweep.axis,
            "" if sweep.holds_to is None else format_value(sweep.holds_to, sweep.unit),
            *(_break(one) for one in (result, *result.others)),
            "" if seconds is None else f"{1e3 * seconds:.0f}",
            result.shown.worst.note,
            style="bold red" if result.faults else None,
        )
    return table


def _break(result: SweepResult) -> str:
    value = result.breaks_at
    return "never" if value is None else format_value(value, result.sweep.unit)
