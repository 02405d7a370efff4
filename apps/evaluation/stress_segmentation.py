"""`eyehand stress segmentation`: make it harder until it breaks, and chart where."""

from __future__ import annotations

import functools
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from cyclopts import Parameter
from rich import box
from rich.table import Table

from eyehand.apps.console import print_json, say, show, tracked
from eyehand.apps.description import ready_kernels
from eyehand.apps.description_files import make_folder
from eyehand.data_synth.staged_scene import render_staged
from eyehand.errors import InputError
from eyehand.perception import DepthFrame, SegmentationOptions, segment

from .segmentation_pictures import ScoredFrame, write_sheet
from .segmentation_score import score_segmentation
from .segmentation_stress_cases import segmentation_sweeps
from .stress_chart import point_rows, sweep_rows, write_stress_chart
from .stress_sweep import SweepResult, iterate_steps, value_text

if TYPE_CHECKING:
    from collections.abc import Sequence

SEEDS, QUICK_SEEDS = 5, 2
"""Scenes a value when no number is asked for."""
LEAST_SHOWN_PX = 64
"""Smaller images are not shown: they are about answers, not about pictures."""
MOST_SHOWN = 50
"""Objects past which a picture shows nothing but lines."""
CHART_FILE, SHEET_FILE = "stress.png", "breaking.png"


def stress_segmentation(
    *,
    only: Annotated[list[str] | None, Parameter(consume_multiple=True, negative="")] = None,
    seeds: int | None = None,
    seed: int = 0,
    quick: bool = False,
    out: Path = Path("out/stress_segmentation"),
    json: bool = False,
    options: Annotated[
        SegmentationOptions | None, Parameter(name="*", group="Segmentation options")
    ] = None,
) -> int:
    """Make staged scenes harder step by step until the segmentation breaks, and chart where.

    Each sweep has a bound that must hold, and every answer, right or wrong, must be a clean one.
    Ends with exit code 1 when a bound is broken, and says which. Writes stress.png with
    stress.csv, and breaking.png: each sweep's frame where it breaks, truth beside answer.

    Parameters
    ----------
    only
        Sweeps to run; all when not given.
    seeds
        Scenes tried at each value; default 5, or 2 with --quick.
    seed
        The first seed; scenes and noise follow from it alone.
    quick
        Try each sweep at its easiest value, its bound and its hardest value only.
    out
        Output folder.
    json
        Print one JSON object on stdout; the table goes to stderr.
    options
        Thresholds to run with; each is a dial of its own.
    """
    count = seeds if seeds is not None else QUICK_SEEDS if quick else SEEDS
    if count < 1:
        raise InputError(f"--seeds must be >= 1, got {count}")
    if seed < 0:
        raise InputError(f"--seed must be a whole number >= 0, got {seed}")
    sweeps = segmentation_sweeps(only or ())
    if quick:
        sweeps = tuple(sweep.shortened() for sweep in sweeps)
    make_folder(out)
    ready_kernels()
    method = functools.partial(segment, options=options)
    results = []
    for sweep in tracked(sweeps, "sweeps"):
        steps = iterate_steps(sweep, range(seed, seed + count), method)
        results.append(SweepResult(sweep, tuple(steps)))
    title = "Where the segmentation breaks"
    write_stress_chart(out / CHART_FILE, results, title, count, seed)
    shown = [picture for picture in map(_picture, results) if picture is not None]
    files = [CHART_FILE, Path(CHART_FILE).with_suffix(".csv").name]
    if shown:
        write_sheet(out / SHEET_FILE, shown)
        files.append(SHEET_FILE)
    show(_table(results), json_wanted=json)
    say(f"{', '.join(files)} in {out}")
    faults = [fault for result in results for fault in result.faults]
    for fault in faults:
        say(f"broken bound: {fault}")
    if json:
        print_json(
            "stress_segmentation",
            seed,
            sweep_rows(results),
            seeds=count,
            quick=quick,
            broken_bounds=faults,
            points=point_rows(results),
            out=str(out),
        )
    return 1 if faults else 0


def _picture(result: SweepResult) -> ScoredFrame | None:
    """What a sweep's frame looks like where it breaks; None where there is nothing to see."""
    step = result.shown
    picture = step.worst.picture
    if picture is None or min(picture.labels.shape) < LEAST_SHOWN_PX:
        return None
    if max(picture.labels.max(), picture.truth.max()) > MOST_SHOWN:
        return None
    frame = picture.frame
    if picture.scene is not None:
        colour = render_staged(picture.scene, colour=True).colour
        frame = DepthFrame(frame.depth, frame.intrinsics, frame.T_world_camera, colour)
    name = f"{result.sweep.name}, {value_text(step.value, result.sweep.unit)}"
    score = score_segmentation(picture.labels, picture.truth, ignore=~frame.valid)
    return ScoredFrame(name, frame, picture.truth, picture.labels, score)


def _table(results: Sequence[SweepResult]) -> Table:
    table = Table(
        title="where the segmentation breaks (fewer than 90 % of trials right)",
        title_justify="left",
        box=box.SIMPLE_HEAD,
    )
    for column in ("sweep", "what gets harder", "holds to", "breaks at", "ms", "what is wrong"):
        table.add_column(column, justify="right" if column in ("breaks at", "ms") else "left")
    for result in results:
        sweep, broken = result.sweep, result.breaks_at
        seconds = result.steps[0].seconds
        table.add_row(
            sweep.name,
            sweep.axis,
            "" if sweep.holds_to is None else value_text(sweep.holds_to, sweep.unit),
            "never" if broken is None else value_text(broken, sweep.unit),
            "" if seconds is None else f"{1e3 * seconds:.0f}",
            result.shown.worst.note,
            style="bold red" if result.faults else None,
        )
    return table
