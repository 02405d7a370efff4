"""`eyehand experiment edge`: the pad keeps an object's edge in line (section 4.3)."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

from rich import box
from rich.table import Table

from ..console import tracked
from ..output_files import make_folder
from .edge_picture import edge_picture
from .edge_run import edge_row, mean_row, run_edge
from .trials import tell_trials, trial_count

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

TRIALS, QUICK_TRIALS = 10, 2
"""Edges, each at another angle."""


def experiment_edge(
    *,
    trials: int | None = None,
    seed: int = 0,
    quick: bool = False,
    out: Path = Path("out/experiment_edge"),
    json: bool = False,
) -> int:
    """Turn the pad with an object's edge.

    The arm lands the pad on an edge that lies up to 60° off its y-axis; with pressing and turning
    alone, the pad comes into line, and keeps in line while the edge is turned to and fro by 40°.
    The chapter shows this in its video only. Writes edge.png and edge.csv.

    Parameters
    ----------
    trials
        How many edges, >= 1; default: 10.
    seed
        Trial k follows from seed + k.
    quick
        2 trials: a first look.
    out
        Output folder.
    json
        Print one JSON object on stdout; the table goes to stderr.
    """
    count = trial_count(trials, QUICK_TRIALS if quick else TRIALS, seed)
    make_folder(out)
    runs = [run_edge(seed + k) for k in tracked(range(count), "edges", count)]
    rows = [edge_row(run) for run in runs]
    rows.append(mean_row(rows))
    tell_trials(
        "experiment edge",
        rows,
        _table(rows),
        edge_picture(runs, seed),
        seed=seed,
        trials=count,
        out=out,
        json=json,
    )
    return 0


def _table(rows: Sequence[Mapping[str, Any]]) -> Table:
    table = Table(
        box=box.SIMPLE,
        title="an edge's direction kept by turning; the chapter shows it in its video only",
        title_justify="left",
        caption="response: to a tenth of the angle at touch; at rest: mean and deviation of the "
        "error; turned: rms error while the edge turns to and fro, and by how much the pad is late",
    )
    for heading in ("", "at touch", "response", "at rest", "turned", "late", "force"):
        table.add_column(heading, justify="left" if not heading else "right")
    for row in rows:
        table.add_row(
            row["name"],
            f"{row['start_deg']:.1f}°",
            f"{row['response_time_s']:.2f} s",
            f"{row['steady_state_error_deg']:.3f} ± {row['standard_deviation_deg']:.3f}°",
            f"{row['turning_rms_deg']:.2f}°",
            f"{row['delay_ms']:.0f} ms",
            f"{row['force_mean_n']:.3f} ± {row['force_std_n']:.3f} N",
        )
    return table
