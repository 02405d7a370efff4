"""What every `eyehand stress` command does: check, run the sweeps, tell where they break."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from rich import box
from rich.table import Table

from eyehand.apps.console import print_json, say, show, tracked
from eyehand.errors import InputError

from .sweep import SweepResult, format_value, iterate_steps
from .sweep_chart import point_rows, sweep_rows, write_stress_chart

if TYPE_CHECKING:
    from collections.abc import Sequence
    from pathlib import Path

    from .sweep import Sweep, Tested
    from .sweep_chart import ReportSpec

CHART_FILES = ("stress.png", "stress.csv")
"""What every stress command writes: its chart, and the figures in it."""


def stress_seeds(seeds: int | None, seed: int, usual: int) -> range:
    """Seeds to try at each value: `seeds` of them, or the usual number, from `seed` on.

    Raises
    ------
    InputError
        If there are none, or the first is negative.
    """
    count = usual if seeds is None else seeds
    if count < 1:
        raise InputError(f"--seeds must be >= 1, got {count}")
    if seed < 0:
        raise InputError(f"--seed must be a whole number >= 0, got {seed}")
    return range(seed, seed + count)


def run_sweeps(
    sweeps: Sequence[Sweep[Tested]], seeds: range, method: Tested, *, quick: bool
) -> list[SweepResult]:
    """Run sweeps with a progress bar; `quick` tries their easiest, bound and hardest value."""
    wanted = [sweep.shortened() if quick else sweep for sweep in sweeps]
    return [
        SweepResult(sweep, tuple(iterate_steps(sweep, seeds, method)))
        for sweep in tracked(wanted, "sweeps")
    ]


def tell_stress(
    results: Sequence[SweepResult],
    telling: ReportSpec,
    seeds: range,
    *,
    out: Path,
    json: bool,
    quick: bool,
    files: Sequence[str] = (),
    faults: Sequence[str] = (),
    **more: Any,
) -> int:
    """Chart and print where the sweeps break, name each broken bound, and give the exit code.

    Parameters
    ----------
    results
        The sweeps.
    telling
        The words of the stage.
    seeds
        What was tried at each value.
    out
        Output folder.
    json
        Whether one JSON object goes to stdout, the table then to stderr.
    quick
        Whether the sweeps were shortened.
    files
        What else was written, by name in `out`.
    faults
        Broken expectations beside those of the sweeps, one line each.
    more
        Further members of the JSON object.
    """
    written = [*files]
    if results:
        write_stress_chart(out / CHART_FILES[0], results, telling, len(seeds), seeds.start)
        written = [*CHART_FILES, *files]
        show(_table(results, telling), json_wanted=json)
    say(f"{', '.join(written)} in {out}")
    broken = [*(fault for result in results for fault in result.faults), *faults]
    for fault in broken:
        say(f"broken bound: {fault}")
    if json:
        print_json(
            f"stress_{telling.stage}",
            seeds.start,
            sweep_rows(results),
            seeds=len(seeds),
            quick=quick,
            broken_bounds=broken,
            points=point_rows(results, telling),
            out=str(out),
            **more,
        )
    return 1 if broken else 0


def _table(results: Sequence[SweepResult], telling: ReportSpec) -> Table:
    title = telling.title
    table = Table(
        title=f"{title[:1].lower()}{title[1:]} (fewer than 90 % of trials right)",
        title_justify="left",
        box=box.SIMPLE_HEAD,
    )
    figures = ("breaks at", telling.time)
    for column in ("sweep", "what gets harder", "holds to", *figures, "what is wrong"):
        table.add_column(column, justify="right" if column in figures else "left")
    for result in results:
        sweep, broken = result.sweep, result.breaks_at
        seconds = result.steps[0].seconds
        table.add_row(
            sweep.name,
            sweep.axis,
            "" if sweep.holds_to is None else format_value(sweep.holds_to, sweep.unit),
            "never" if broken is None else format_value(broken, sweep.unit),
            "" if seconds is None else f"{1e3 * seconds:.0f}",
            result.shown.worst.note,
            style="bold red" if result.faults else None,
        )
    return table
