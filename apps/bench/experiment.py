"""The driver of all `eyehand experiment` commands: measure, then write and print the results.

A command keeps its options and its help. Its `Experiment` says how to measure, and
:func:`run_experiment` does what all experiments share.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from rich import box
from rich.table import Table

from eyehand.errors import InputError

from ..console import print_json, say, show, tracked
from ..run_folder import claim_folder
from .chart_style import Provenance, write_chart

if TYPE_CHECKING:
    from matplotlib.figure import Figure

Rows = Sequence[Mapping[str, Any]]
"""Rows of results: metric name with its unit → value."""


class TrialPlan(NamedTuple):
    """The trials, seed and length of an experiment."""

    trials: int
    """Number of trials; 1 if the experiment has no such option."""
    seed: int
    """Seed of the first trial."""
    quick: bool
    """Whether a short first look is enough."""
    unit: str
    """What one trial is called, in the singular."""

    def seeds(self) -> Iterator[int]:
        """Iterate over the seeds of all trials with a progress bar."""
        seeds = range(self.seed, self.seed + self.trials)
        yield from tracked(seeds, f"{self.unit}s", self.trials)

    def provenance(self, data: str) -> Provenance:
        """Return the footer of a picture whose figures were measured on `data`."""
        return Provenance(data, self.seed, self.trials, self.unit)


@dataclass(frozen=True)
class ExperimentResult:
    """The result of an experiment, ready to be written and printed."""

    rows: Rows
    """Rows of the JSON object."""
    table: Table
    """The table for the terminal, see :func:`result_table`."""
    picture: Figure
    """The chart."""
    points: Rows | None = None
    """Rows of the CSV file beside the chart; None writes `rows`."""
    files: Mapping[str, Callable[[Path], object]] = field(default_factory=dict)
    """Further files: name → function that writes the file to a path."""
    notes: Sequence[str] = ()
    """Lines that are printed below the table."""
    broken_bounds: Sequence[str] | None = None
    """Expectations that were not met, one line each; None if the experiment checks none."""
    more: Mapping[str, Any] = field(default_factory=dict)
    """Further members of the JSON object."""


@dataclass(frozen=True)
class Experiment:
    """One figure, table or section of the chapter."""

    name: str
    """Last word of the command. It also names the files."""
    measure: Callable[[TrialPlan], ExperimentResult]
    """Run all trials and return the result."""
    unit: str = "trial"
    """What one trial is called, in the singular."""
    trials: int | None = None
    """Usual number of trials; None if the user cannot choose it."""
    quick_trials: int = 1
    """Number of trials of a short first look."""
    min_trials: int = 1
    """Minimum number of trials that makes sense."""
    option: str = "trials"
    """Name of the option, and of the JSON member, that holds the number of trials."""
    file_stem: str = ""
    """Name of the picture and its CSV file without their endings; `name` if empty."""


def run_experiment(
    experiment: Experiment,
    *,
    trials: int | None = None,
    seed: int | None,
    quick: bool = False,
    out: Path | None,
    json: bool,
) -> int:
    """Run an experiment, write its files, print its table, and return the exit code.

    Parameters
    ----------
    experiment
        What to measure.
    trials
        Number of trials, or None for the usual number.
    seed
        Seed of the first trial. None means that the experiment has no randomness.
    quick
        Run the small number of trials of a first look, unless `trials` is given.
    out
        Output folder. It is created. None means ``out/experiment_NAME``.
    json
        Print one JSON object on stdout. The table then goes to stderr.

    Returns
    -------
    int
        1 if an expectation was not met, otherwise 0.

    Raises
    ------
    InputError
        If there are too few trials, the seed is negative, or the folder cannot be written to.
    """
    if trials is not None and trials < experiment.min_trials:
        option = experiment.option
        raise InputError(f"--{option} must be >= {experiment.min_trials}, got {trials}")
    if seed is not None and seed < 0:
        raise InputError(f"--seed must be >= 0, got {seed}")
    count = trials or (experiment.quick_trials if quick else experiment.trials) or 1
    out = out or Path("out") / f"experiment_{experiment.name}"
    claim_folder(out)
    result = experiment.measure(TrialPlan(count, seed or 0, quick, experiment.unit))
    picture = out / f"{experiment.file_stem or experiment.name}.png"
    write_chart(result.picture, picture, result.rows if result.points is None else result.points)
    for name, write in result.files.items():
        write(out / name)
    show(result.table, json_wanted=json)
    broken = list(result.broken_bounds or ())
    written = [picture, picture.with_suffix(".csv"), *(out / name for name in result.files)]
    for line in (
        *result.notes,
        f"wrote {', '.join(map(str, written))}",
        *(f"broken bound: {bound}" for bound in broken),
    ):
        say(line)
    if json:
        more: dict[str, Any] = {} if experiment.trials is None else {experiment.option: count}
        if result.broken_bounds is not None:
            more["broken_bounds"] = broken
        print_json(
            f"experiment_{experiment.name}", seed, result.rows, **more, **result.more, out=str(out)
        )
    return 1 if broken else 0


def result_table(
    rows: Rows,
    columns: Sequence[tuple[str, str]],
    *,
    title: str | None = None,
    caption: str | None = None,
    left: Sequence[str] = (),
) -> Table:
    """Return a table for the terminal.

    Parameters
    ----------
    rows
        One mapping per line of the table.
    columns
        Heading and cell of each column. A cell is a format string that refers to the row's keys,
        such as ``"{path_rms_mm:.3f} mm"``. It stays empty if the row lacks a key or holds None.
    title, caption
        Text above and below the table.
    left
        Headings of further columns aligned to the left, besides the first one.
    """
    table = Table(box=box.SIMPLE, title=title, title_justify="left", caption=caption)
    for number, (heading, _) in enumerate(columns):
        table.add_column(heading, justify="left" if not number or heading in left else "right")
    for row in rows:
        known = {key: value for key, value in row.items() if value is not None}
        table.add_row(*(_cell(cell, known) for _, cell in columns))
    return table


def markdown_table(rows: Rows, columns: Sequence[tuple[str, str]]) -> str:
    """Return a table for a document, with the rows and columns of :func:`result_table`."""
    lines = [[heading for heading, _ in columns], ["---" for _ in columns]]
    for row in rows:
        known = {key: value for key, value in row.items() if value is not None}
        lines.append([_cell(cell, known) for _, cell in columns])
    return "".join(f"| {' | '.join(line)} |\n" for line in lines)


def _cell(text: str, row: Mapping[str, Any]) -> str:
    try:
        return text.format_map(row)
    except KeyError:
        return ""
