"""`eyehand experiment cable`: a cable of unknown shape is followed (section 4.4, Fig. 10)."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

from rich import box
from rich.table import Table

from eyehand.errors import InputError

from ..bench.chart_style import write_chart
from ..console import print_json, say, show, tracked
from ..output_files import make_folder
from .cable_picture import cable_picture
from .cable_run import cable_row, run_cable, speed_row

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

CABLES, QUICK_CABLES = 5, 1
"""Shapes."""
SPEEDS = (0.05, 0.2)
"""m/s: a calm one, and one four times as fast."""
WANTED_MM = {0.05: 0.5, 0.2: 1.3}
"""Rms error that each speed should stay below, mm."""


def experiment_cable(
    *,
    trials: int | None = None,
    seed: int = 0,
    quick: bool = False,
    out: Path = Path("out/experiment_cable"),
    json: bool = False,
) -> int:
    """Follow cables of unknown shape along a table, slowly and fast.

    The pad lands beside the middle of the cable and askew, presses with 2 N, and follows to the
    cable's end. Its path by the arm's forward kinematics is held to the cable's true middle, as
    the chapter's Fig. 10 does by eye. Writes cable.png, which shows the first cable, and cable.csv.

    Parameters
    ----------
    trials
        How many cables, >= 1; default: 5.
    seed
        Cable k follows from seed + k.
    quick
        1 cable: a first look.
    out
        Output folder.
    json
        Print one JSON object on stdout; the table goes to stderr.
    """
    if trials is not None and trials < 1:
        raise InputError(f"--trials must be >= 1, got {trials}")
    if seed < 0:
        raise InputError(f"--seed must be >= 0, got {seed}")
    count = trials or (QUICK_CABLES if quick else CABLES)
    make_folder(out)
    tasks = [(seed + k, speed) for speed in SPEEDS for k in range(count)]
    runs = [run_cable(k, speed) for k, speed in tracked(tasks, "cables", len(tasks))]
    rows = [cable_row(run) for run in runs]
    for speed in SPEEDS:
        own = [run for run in runs if run.speed == speed]
        rows.append({**speed_row(own), "wanted_rms_mm": WANTED_MM[speed]})
    path = out / "cable.png"
    write_chart(cable_picture(runs[::count], seed, count), path, rows)
    show(_table(rows), json_wanted=json)
    say(f"wrote {path} and {path.with_suffix('.csv')}")
    if json:
        print_json("experiment_cable", seed, rows, trials=count, out=str(out))
    return 0


def _table(rows: Sequence[Mapping[str, Any]]) -> Table:
    table = Table(
        box=box.SIMPLE,
        title="a cable's path felt by following it; the chapter shows a photograph (Fig. 10)",
        title_justify="left",
        caption="error: the pad's middle against the cable's, across it, from 0.3 s after touch to "
        "the cable's end; followed: share of the cable ahead of the landing",
    )
    for heading in ("", "speed", "rms", "largest", "wanted", "followed", "force", "end"):
        table.add_column(heading, justify="left" if not heading else "right")
    for row in rows:
        wanted = row.get("wanted_rms_mm")
        table.add_row(
            row["name"],
            f"{row['speed_mm_s']:.0f} mm/s",
            f"{row['path_rms_mm']:.3f} mm",
            f"{row['path_max_mm']:.3f} mm",
            f"{wanted:g} mm" if wanted else "",
            f"{row['followed_pct']:.1f} %",
            f"{row['force_mean_n']:.2f} ± {row['force_std_n']:.2f} N",
            row["outcome"],
        )
    return table
