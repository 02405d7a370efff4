"""`eyehand experiment fig1`: the paper's Fig. 1, run and drawn."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from rich import box
from rich.table import Table

from eyehand.apps.console import print_json, say, show

from ..output_files import make_folder
from .fig1_picture import write_fig1
from .fig1_run import DEFAULT, fig1_faults, fig1_rows, run_fig1
from .fig1_scene import fig1_scene

if TYPE_CHECKING:
    from collections.abc import Sequence

    from .fig1_run import Fig1Run

PICTURE = "experiment_fig1.png"
"""In the output folder; the figures are in the CSV beside it."""


def experiment_fig1(*, out: Path = Path("out/experiment_fig1"), json: bool = False) -> int:
    """Draw how the weight of avoidance bends a hand's way: none, fixed weights, a dynamic one.

    A planar arm of 4 joints moves its hand past a pole to a goal beside a wall. Without avoidance
    in task space the way is straight and grazes the pole; with a fixed weight it keeps its
    distance and misses the goal; with the dynamic weight it does both. One scene and one set of
    options for all, only the weight differs; a last row has the safety level on. Ends with exit
    code 1 when that does not come out, and says what. Writes experiment_fig1.png with
    experiment_fig1.csv.

    Parameters
    ----------
    out
        Output folder.
    json
        Print one JSON object on stdout; the table goes to stderr.
    """
    make_folder(out)
    runs = run_fig1()
    write_fig1(out / PICTURE, fig1_scene(), runs)
    show(_table(runs), json_wanted=json)
    say(f"{PICTURE}, experiment_fig1.csv in {out}")
    faults = fig1_faults(runs)
    for fault in faults:
        say(f"broken bound: {fault}")
    if json:
        print_json("experiment_fig1", None, fig1_rows(runs), broken_bounds=faults, out=str(out))
    return 1 if faults else 0


def _table(runs: Sequence[Fig1Run]) -> Table:
    table = Table(
        title="one way past a pole to a goal beside a wall",
        title_justify="left",
        box=box.SIMPLE_HEAD,
    )
    table.add_column("avoidance")
    for column in ("mid-course, mm", "closest, mm", "error at the end, mm"):
        table.add_column(column, justify="right")
    table.add_column("status")
    for run, row in zip(runs, fig1_rows(runs), strict=True):
        table.add_row(
            "dynamic, safety level on" if run.name == DEFAULT else run.name,
            f"{row['midcourse_clearance_mm']:.1f}",
            f"{row['closest_mm']:.1f}",
            f"{row['final_error_mm']:.3f}",
            run.status,
        )
    return table
