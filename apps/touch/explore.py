"""`eyehand experiment explore`: the shape of an unknown object, felt by two arms (Fig. 11)."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

from rich import box
from rich.table import Table

from eyehand.errors import InputError
from eyehand.perception.io import write_cloud

from ..bench.chart_style import write_chart
from ..console import print_json, say, show
from ..output_files import make_folder
from .explore_picture import explore_picture
from .explore_run import MOST_TILT_DEG, run_explore
from .explore_truth import explore_rows

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

WANTED_MM = 0.3
"""Rms error that the cloud should stay below, mm."""


def experiment_explore(
    *,
    seed: int = 0,
    quick: bool = False,
    out: Path = Path("out/experiment_explore"),
    json: bool = False,
) -> int:
    """Scan an unknown object with two pads on two arms, and make a cloud of what they feel.

    Each pad runs over its half in lanes, along one direction and then across, and rolls and
    presses by touch; the other arm waits meanwhile. The cloud is held to the true surface. The
    chapter shows a picture (its Fig. 11). One row of the table is of the same images with the
    foam's spread left in them. Writes explore.png, explore.csv and explore.ply.

    Parameters
    ----------
    seed
        Of the object, the pads' electronics and noise. Objects are a dome with a ridge and a
        block, a smooth pebble, and a barrel with rims, by turns; from 3 on, varied.
    quick
        Two lanes in each direction, faster: a first look.
    out
        Output folder.
    json
        Print one JSON object on stdout; the table goes to stderr.
    """
    if seed < 0:
        raise InputError(f"--seed must be >= 0, got {seed}")
    make_folder(out)
    run = run_explore(seed, quick)
    rows = explore_rows(run)
    path = out / "explore.png"
    rms = rows[-1]["surface_rms_mm"] if rows else 0.0
    write_chart(explore_picture(run, rms, seed), path, rows)
    write_cloud(out / "explore.ply", run.points)
    show(_table(rows), json_wanted=json)
    force = f"{run.forces.mean():.2f} ± {run.forces.std():.2f} N"
    say(f"pads: {', '.join(run.outcomes)}; {run.seconds:.0f} s of scanning at {force}")
    say(f"tilted up to {run.tilt_deg:.0f}°, rims down to {run.rim_mm:.0f} mm below the top")
    say(f"wrote {path}, {path.with_suffix('.csv')} and {path.with_suffix('.ply')}")
    if json:
        print_json(
            "experiment_explore",
            seed,
            rows,
            wanted_rms_mm=WANTED_MM,
            outcomes=list(run.outcomes),
            force_mean_n=float(run.forces.mean()),
            force_std_n=float(run.forces.std()),
            most_tilt_deg=run.tilt_deg,
            rim_below_top_mm=run.rim_mm,
            out=str(out),
        )
    return 0


def _table(rows: Sequence[Mapping[str, Any]]) -> Table:
    table = Table(
        box=box.SIMPLE,
        title=f"an object's surface felt; rms wanted: {WANTED_MM:g} mm, the chapter shows Fig. 11",
        title_justify="left",
        caption="off the surface, inside it negative; ridges: the points on ridges, edges and "
        "corners; blurred: with the foam's spread left in; covered: of the surface that a flat pad "
        f"reaches at up to {MOST_TILT_DEG:g}° of tilt, the share with a felt point within 5 mm",
    )
    for heading in ("", "points", "rms", "median", "p95", "ridges rms", "median", "covered"):
        table.add_column(heading, justify="left" if not heading else "right")
    for row in rows:
        table.add_row(
            row["name"],
            str(row["points"]),
            f"{row['surface_rms_mm']:.3f} mm",
            f"{row['surface_median_mm']:+.3f} mm",
            f"{row['surface_p95_mm']:.3f} mm",
            f"{row['ridges_rms_mm']:.3f} mm",
            f"{row['ridges_median_mm']:+.3f} mm",
            f"{row['covered_pct']:.1f} %",
        )
    return table
