"""`eyehand experiment seek`: ridges, edges and corners of unknown objects, found by touch alone."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from cyclopts import Parameter
from rich import box
from rich.table import Table

from eyehand.errors import InputError

from ..bench.chart_style import write_chart
from ..console import print_json, say, show, tracked
from ..output_files import make_folder
from .seek_picture import seek_picture
from .seek_run import run_seek, seek_row, spot_rows
from .seek_shapes import SHAPES

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

QUICK_SHAPES = ("box", "ridge", "prism")
"""Objects of a first look."""


def experiment_seek(
    *,
    only: Annotated[list[str] | None, Parameter(consume_multiple=True, negative="")] = None,
    seed: int = 0,
    quick: bool = False,
    out: Path = Path("out/experiment_seek"),
    json: bool = False,
) -> int:
    """Find ridges, edges and corners of objects that nobody described.

    The pad lands on an object that lies anyhow, wanders until an edge comes under it, follows the
    edge, and turns at the corners until it is round; a ridge it follows to both ends. Only the
    pressure is servoed; where to go is computed from what the pad feels. The chapter names this
    as future work. Writes seek.png, and seek.csv with every spot that was found.

    Parameters
    ----------
    only
        Objects: box, ridge, prism, bend, disc; all when not given.
    seed
        Places, directions, first headings and noise follow from it.
    quick
        Box, ridge and prism at twice the speed: a first look.
    out
        Output folder.
    json
        Print one JSON object on stdout; the table goes to stderr.
    """
    names = list(dict.fromkeys(only or (QUICK_SHAPES if quick else SHAPES)))
    unknown = [name for name in names if name not in SHAPES]
    if unknown:
        raise InputError(f"--only must name some of {', '.join(SHAPES)}, got {unknown[0]}")
    if seed < 0:
        raise InputError(f"--seed must be >= 0, got {seed}")
    make_folder(out)
    runs = [run_seek(name, seed, quick=quick) for name in tracked(names, "objects", len(names))]
    rows = [seek_row(run) for run in runs]
    path = out / "seek.png"
    write_chart(seek_picture(runs, seed), path, spot_rows(runs))
    show(_table(rows), json_wanted=json)
    say(f"wrote {path} and {path.with_suffix('.csv')}")
    if json:
        print_json("experiment_seek", seed, rows, out=str(out))
    return 0


def _table(rows: Sequence[Mapping[str, Any]]) -> Table:
    table = Table(
        box=box.SIMPLE,
        title="corners and ends found by touch; the chapter only hopes for such a guide",
        title_justify="left",
        caption="found: true corners, or a ridge's ends, with a found one within 5 mm; "
        "false: found ones without a true one; edge: how far the first noticed edge is off; "
        "round: back where following began; done: both ends of a ridge",
    )
    headings = ("", "found", "false", "off by, median", "at most", "edge", "path", "time", "ended")
    for heading in headings:
        table.add_column(heading, justify="left" if heading in ("", "ended") else "right")
    for row in rows:
        table.add_row(
            row["name"],
            f"{row['spots_found']} of {row['spots_true']}",
            str(row["spots_wrong"]),
            _mm(row["place_median_mm"], 2),
            _mm(row["place_max_mm"], 2),
            _mm(row["line_max_mm"], 2),
            _mm(row["path_mm"], 0),
            f"{row['time_s']:.0f} s",
            row["outcome"],
        )
    return table


def _mm(value: float | None, digits: int) -> str:
    return "-" if value is None else f"{value:.{digits}f} mm"
