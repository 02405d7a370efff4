"""`eyehand experiment features`: ways to a contact's direction and place, accuracy against time."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

from rich import box
from rich.table import Table

from eyehand.errors import InputError
from eyehand.tactile import TactileArray

from ..bench.chart_style import Provenance, write_chart
from ..bench.machine import machine_line
from ..console import print_json, say, show
from ..output_files import make_folder
from .calibration_comparison import calibration_rows
from .feature_chart import feature_chart
from .feature_comparison import centre_rows, lines_and_probes, orientation_rows, reading_rows

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

IMPRINTS, QUICK_IMPRINTS = 300, 20
"""Lines, and as many probes."""


def experiment_features(
    *,
    imprints: int | None = None,
    seed: int = 0,
    quick: bool = False,
    out: Path = Path("out/experiment_features"),
    json: bool = False,
) -> int:
    """Chart how well and how fast a contact's direction and place are found.

    Lines (short ones, and ones that cross the pad) and probes of 2 mm are pressed at random places
    into a simulated pad with noise. Directions by second moments and by the Hough transform,
    places by centres of pressure and of touched tactels, and through the simulated read-out,
    calibrated by the full curve and by the linear range. Writes features.png and features.csv.

    Parameters
    ----------
    imprints
        How many lines, and as many probes, >= 2; default: 300.
    seed
        Imprint k follows from seed + k.
    quick
        20 imprints: a first look.
    out
        Output folder.
    json
        Print one JSON object on stdout; the table goes to stderr.
    """
    if imprints is not None and imprints < 2:
        raise InputError(f"--imprints must be >= 2, got {imprints}")
    if seed < 0:
        raise InputError(f"--seed must be >= 0, got {seed}")
    count = imprints or (QUICK_IMPRINTS if quick else IMPRINTS)
    make_folder(out)
    array = TactileArray.flat()
    lines, probes = lines_and_probes(array, count, seed)
    rows = [
        *orientation_rows(array, lines),
        *centre_rows(probes),
        *calibration_rows(array, count, seed),
        *reading_rows(array, lines),
    ]
    made = Provenance(
        "lines (half of them crossing the pad) and 2 mm probes, 16 × 16 tactels, noise 5 Pa",
        seed,
        count,
        "imprint",
    )
    path = out / "features.png"
    write_chart(feature_chart(rows, made), path, rows)
    show(_table(rows), json_wanted=json)
    say(f"wrote {path} and {path.with_suffix('.csv')}")
    if json:
        print_json(
            "experiment_features", seed, rows, imprints=count, machine=machine_line(), out=str(out)
        )
    return 0


def _table(rows: Sequence[Mapping[str, Any]]) -> Table:
    table = Table(
        box=box.SIMPLE,
        caption="errors: median, 95th percentile, root mean square; time: median of a call from "
        "Python, from the region on; a reading goes from raw counts to all features; "
        "calibrations: a probe's place through squashed characteristics, noise and 12 bits",
    )
    for heading in ("", "time", "median", "p95", "rms"):
        table.add_column(heading, justify="left" if not heading else "right")
    for row in rows:
        unit = {"orientation": "deg", "centre": "mm", "calibration": "mm"}.get(row["feature"])
        sign = {"deg": "°", "mm": " mm"}.get(unit or "", "")
        errors = [
            f"{row[f'error_{what}_{unit}']:.3f}{sign}" if unit else ""
            for what in ("p50", "p95", "rms")
        ]
        time = f"{row['time_p50_us']:.1f} µs" if "time_p50_us" in row else ""
        table.add_row(row["name"], time, *errors)
    return table
