"""`eyehand stress segmentation`: make it harder until it breaks, and chart where."""

from __future__ import annotations

import functools
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from cyclopts import Parameter

from eyehand.apps.output_files import make_folder
from eyehand.apps.perceived_frame import load_kernels
from eyehand.data_synth.render import render_staged
from eyehand.perception import DepthFrame, SegmentationOptions, segment

from ..bench.chart_style import draw_curve
from ..bench.stress import run_sweeps, stress_seeds, tell_stress
from ..bench.sweep import format_value
from ..bench.sweep_chart import ReportSpec, milliseconds, percent
from .pictures import ScoredFrame, write_sheet
from .score import score_segmentation
from .stress_sweeps import segmentation_sweeps
from .stress_trial import TrialPicture

if TYPE_CHECKING:
    from collections.abc import Sequence

    from matplotlib.axes import Axes

    from ..bench.sweep import Step, SweepResult

SEEDS, QUICK_SEEDS = 5, 2
"""Scenes a value when no number is asked for."""
LEAST_SHOWN_PX = 64
"""Smaller images are not shown: they are about answers, not about pictures."""
MOST_SHOWN = 50
"""Objects past which a picture shows nothing but lines."""
SHEET_FILE = "breaking.png"


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
    tried = stress_seeds(seeds, seed, QUICK_SEEDS if quick else SEEDS)
    sweeps = segmentation_sweeps(only or ())
    make_folder(out)
    load_kernels()
    results = run_sweeps(sweeps, tried, functools.partial(segment, options=options), quick=quick)
    shown = [picture for picture in map(_picture, results) if picture is not None]
    if shown:
        write_sheet(out / SHEET_FILE, shown)
    return tell_stress(
        results,
        segmentation_telling(),
        tried,
        out=out,
        json=json,
        quick=quick,
        files=[SHEET_FILE] if shown else (),
    )


def segmentation_telling() -> ReportSpec:
    """How the segmentation's sweeps are told: the share that is right, and mean overlap F."""
    return ReportSpec(
        stage="segmentation",
        title="Where the segmentation breaks",
        subtitle="share of trials that are right, in %",
        data="staged scenes, noise 1 mm at 1 m where nothing else is said",
        each="frame",
        figures=_figures,
        draw=_draw_shares,
    )


def _figures(step: Step) -> dict[str, Any]:
    mean = sum(step.scores) / len(step.scores) if step.scores else None
    return {"overlap_f_pct": percent(mean, 2), "segment_ms": milliseconds(step)}


def _draw_shares(axes: Axes, places: Sequence[float], steps: Sequence[Step]) -> None:
    draw_curve(axes, places, [100 * step.share for step in steps], "right")


def _picture(result: SweepResult) -> ScoredFrame | None:
    """What a sweep's frame looks like where it breaks; None where there is nothing to see."""
    step = result.shown
    picture = step.worst.picture
    if not isinstance(picture, TrialPicture) or min(picture.labels.shape) < LEAST_SHOWN_PX:
        return None
    if max(picture.labels.max(), picture.truth.max()) > MOST_SHOWN:
        return None
    frame = picture.frame
    if picture.scene is not None:
        colour = render_staged(picture.scene, colour=True).colour
        frame = DepthFrame(frame.depth, frame.intrinsics, frame.T_world_camera, colour)
    name = f"{result.sweep.name}, {format_value(step.value, result.sweep.unit)}"
    score = score_segmentation(picture.labels, picture.truth, ignore=~frame.valid)
    return ScoredFrame(name, frame, picture.truth, picture.labels, score)
