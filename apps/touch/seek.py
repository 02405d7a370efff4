"""`eyehand experiment seek`: find ridges, edges and corners of unknown objects by touch."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from pathlib import Path

from eyehand.errors import InputError

from ..bench import Experiment, ExperimentResult, TrialPlan, result_table, run_experiment
from ..console import tracked
from .arm_rig import SensorName
from .seek_picture import seek_picture
from .seek_run import run_seek, seek_row, spot_rows
from .seek_shapes import SHAPES
from .trial_arguments import measure_with

QUICK_SHAPES = ("box", "ridge", "prism")
"""Objects of a first look."""


def experiment_seek(
    *,
    only: list[str] | None = None,
    seed: int = 0,
    sensor: SensorName = "good",
    quick: bool = False,
    out: Path = Path("out/experiment_seek"),
    json: bool = False,
) -> int:
    """Find ridges, edges and corners of objects of unknown shape and pose.

    The pad lands on the object and moves until it feels an edge. It follows the edge, turns at the
    corners, and stops where it started. It follows a ridge to both ends. The servo controls only
    the pressure; the motion along the surface is computed from the tactile image. The chapter
    names this as future work. Writes seek.png, and seek.csv with every point that was found.

    Parameters
    ----------
    only
        Objects: box, ridge, prism, bend, disc. Default: all.
    seed
        Seed of places, orientations, first headings and noise.
    sensor
        Sensor model: ideal, good, real or harsh.
    quick
        Box, ridge and prism at twice the speed, for a first look.
    out
        Output folder.
    json
        Print one JSON object on stdout. The table then goes to stderr.
    """
    names = list(dict.fromkeys(only or (QUICK_SHAPES if quick else SHAPES)))
    unknown = [name for name in names if name not in SHAPES]
    if unknown:
        raise InputError(f"--only must name some of {', '.join(SHAPES)}, got {unknown[0]}")
    experiment = Experiment("seek", partial(measure_with, partial(_measure, names), sensor))
    return run_experiment(experiment, seed=seed, quick=quick, out=out, json=json)


def _measure(
    names: Sequence[str], plan: TrialPlan, sensor: SensorName = "good"
) -> ExperimentResult:
    objects = tracked(names, "objects", len(names))
    runs = [run_seek(name, plan.seed, quick=plan.quick, sensor=sensor) for name in objects]
    rows = [seek_row(run) for run in runs]
    table = result_table(
        rows,
        [
            ("", "{name}"),
            ("found", "{spots_found} of {spots_true}"),
            ("false", "{spots_wrong}"),
            ("error, median", "{place_median_mm:.2f} mm"),
            ("maximum", "{place_max_mm:.2f} mm"),
            ("edge error", "{line_max_mm:.2f} mm"),
            ("path", "{path_mm:.0f} mm"),
            ("time", "{time_s:.0f} s"),
            ("end", "{outcome}"),
        ],
        title="corners and ridge ends found by touch; the chapter names this as future work",
        caption="found: true corners or ridge ends with a detection within 5 mm; false: detections "
        "without a true one; edge error: of the first point on an edge; round: back at the start "
        "of the edge; done: both ends of a ridge found",
        left=("end",),
    )
    return ExperimentResult(rows, table, seek_picture(runs, plan.seed), spot_rows(runs))
