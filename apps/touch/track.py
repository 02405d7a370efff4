"""`eyehand experiment track`: place and pressure of a contact held (Table 1, Fig. 8)."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

from rich import box
from rich.table import Table

from eyehand.errors import InputError

from ..bench.chart_style import Provenance, write_chart
from ..bench.csv_table import write_csv
from ..bench.machine import machine_line
from ..console import print_json, say, show, tracked
from ..output_files import make_folder
from .cycle_time import cycle_times
from .track_picture import track_picture, track_points
from .track_trial import OBJECTS, track_once, track_rows

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

TRIALS, QUICK_TRIALS = 20, 1
"""Of each object; the chapter has 20."""
SECONDS, QUICK_SECONDS = 20.0, 2.0
"""From convergence on; the chapter has 20."""
LANDING = 0.7
"""Left for converging, s."""


def experiment_track(
    *,
    trials: int | None = None,
    seed: int = 0,
    quick: bool = False,
    out: Path = Path("out/experiment_track"),
    json: bool = False,
) -> int:
    """Hold a contact's place and pressure on a pen, a toy box and a soft ball.

    An arm lands its pad beside the middle, and the servo, with one setting for all, brings the
    contact to the middle and its pressure to 1 kPa. Prints Table 1 beside the chapter's. Writes
    track.png, after Fig. 8, with track.csv, and table.csv.

    Parameters
    ----------
    trials
        Of each object, >= 1; default: 20, which take some 10 minutes.
    seed
        Trial k has electronics, noise and the object's place from seed + k.
    quick
        1 trial of 2 s instead of 20 s: a first look.
    out
        Output folder.
    json
        Print one JSON object on stdout; the table goes to stderr.
    """
    if trials is not None and trials < 1:
        raise InputError(f"--trials must be >= 1, got {trials}")
    if seed < 0:
        raise InputError(f"--seed must be >= 0, got {seed}")
    count = trials or (QUICK_TRIALS if quick else TRIALS)
    seconds = QUICK_SECONDS if quick else SECONDS
    make_folder(out)
    cases = [(name, seed + k) for name in OBJECTS for k in range(count)]
    done = [
        track_once(name, number, LANDING + seconds)
        for name, number in tracked(cases, "trials", len(cases))
    ]
    rows = track_rows(done, seconds)
    times = cycle_times(seed)
    path = out / "track.png"
    made = Provenance(
        "pen, toy box, soft ball; 16 × 16 tactels, 250 cycles a second", seed, count, "trial"
    )
    write_chart(track_picture(done, rows, made), path, track_points(done))
    write_csv(out / "table.csv", rows)
    show(_table(rows, times), json_wanted=json)
    say(f"wrote {path}, {path.with_suffix('.csv')} and {out / 'table.csv'}")
    if json:
        print_json(
            "experiment_track",
            seed,
            rows,
            trials=count,
            seconds=seconds,
            machine=machine_line(),
            out=str(out),
            **times,
        )
    return 0


def _table(rows: Sequence[Mapping[str, Any]], times: Mapping[str, float]) -> Table:
    table = Table(
        box=box.SIMPLE,
        caption="in brackets: the paper's Table 1; objects: shares of the goal, 1 kPa; X, Y: "
        f"tactels\ncalibration, features and servo: {times['servo_cycle_us']:.1f} µs "
        f"(paper: 4000); simulated image: {times['image_us']:.0f} µs",
    )
    for heading in ("", "steady-state error", "standard deviation", "response time", "slowest"):
        table.add_column(heading, justify="left" if not heading else "right")
    for row in rows:
        table.add_row(
            row["name"],
            f"{row['steady_state_error']:.5f} ({row['paper_steady_state_error']:.4f})",
            f"{row['standard_deviation']:.4f} ({row['paper_standard_deviation']:.3f})",
            f"{row['response_time_s']:.2f} s ({row['paper_response_time_s']:.1f})",
            f"{row['slowest_response_s']:.2f} s",
        )
    return table
