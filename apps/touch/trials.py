"""Trials of a touch command: how many are wanted, and how their outcome is told."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from eyehand.errors import InputError

from ..bench.chart_style import write_chart
from ..console import print_json, say, show

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence
    from pathlib import Path

    from matplotlib.figure import Figure
    from rich.table import Table


def trial_count(trials: int | None, usual: int, seed: int) -> int:
    """Give the number of trials: the one asked for, or the usual one.

    Raises
    ------
    InputError
        If fewer than one is asked for, or the seed is negative.
    """
    if trials is not None and trials < 1:
        raise InputError(f"--trials must be >= 1, got {trials}")
    if seed < 0:
        raise InputError(f"--seed must be >= 0, got {seed}")
    return trials or usual


def tell_trials(
    command: str,
    rows: Sequence[Mapping[str, Any]],
    table: Table,
    picture: Figure,
    points: Sequence[Mapping[str, Any]] | None = None,
    *,
    seed: int,
    trials: int,
    out: Path,
    json: bool,
) -> None:
    """Write the picture with its points, show the table, and print the rows where JSON is wanted.

    Parameters
    ----------
    command
        As in "experiment edge".
    rows
        Of the JSON object.
    points
        Rows of the CSV beside the picture; the same when left out.
    out
        Folder; the files are named by the command's last word.
    """
    path = out / f"{command.split()[-1]}.png"
    write_chart(picture, path, rows if points is None else points)
    show(table, json_wanted=json)
    say(f"wrote {path} and {path.with_suffix('.csv')}")
    if json:
        print_json(command.replace(" ", "_"), seed, rows, trials=trials, out=str(out))
