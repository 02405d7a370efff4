"""`eyehand stress segmentation`: find where the segmentation breaks."""

from __future__ import annotations

import functools
from typing import TYPE_CHECKING, Annotated, Any

from cyclopts import Parameter

from eyehand.apps.perceived_frame import load_kernels
from eyehand.data_synth.render import render_staged
from eyehand.perception import DepthFrame, SegmentationOptions, segment

from ..bench import ReportSpec, StressArguments, StressStage, SweepStep, run_stress
from ..bench.chart_style import draw_curve
from ..bench.shares import milliseconds, percent
from ..bench.sweep import SweepResult, format_value
from .camera_sweeps import AGREEMENT_SWEEPS, CAMERA_SWEEPS
from .furnished_sweeps import FURNISHED_SWEEPS
from .input_sweeps import INPUT_SWEEPS
from .neighbour_sweeps import NEIGHBOUR_SWEEPS
from .pictures import ScoredFrame, write_sheet
from .score import score_segmentation
from .shape_sweeps import SHAPE_SWEEPS
from .stress_trial import SegmentCallable, TrialPicture

if TYPE_CHECKING:
    from collections.abc import Sequence
    from pathlib import Path

    from matplotlib.axes import Axes


MIN_SHOWN_PX = 64
"""Minimum image size for a picture. Sweeps of smaller images test error messages."""
MAX_SHOWN_OBJECTS = 50
"""Maximum number of objects in a picture. With more, only outlines are visible."""
SHEET_FILE = "breaking.png"


def stress_segmentation(
    arguments: StressArguments | None = None,
    *,
    options: Annotated[
        SegmentationOptions | None, Parameter(name="*", group="Segmentation options")
    ] = None,
) -> int:
    """Make generated scenes harder step by step until the segmentation breaks, and chart where.

    Tries 5 scenes at each value, or 2 with --quick. Each sweep has a bound that must hold. Past the
    bound an answer may be wrong, but it must still be valid. Exit code 1: a bound is violated.
    Writes stress.png, stress.csv, and breaking.png: the frame where each sweep breaks, with the
    true objects beside the answer.

    Parameters
    ----------
    options
        Options of the segmentation.
    """
    return run_stress(segmentation_stage(options), arguments or StressArguments())


def segmentation_stage(options: SegmentationOptions | None = None) -> StressStage[SegmentCallable]:
    """Return the stress stage of the segmentation."""
    return StressStage(
        name="segmentation",
        sweeps=SEGMENTATION_SWEEPS,
        method=functools.partial(segment, options=options),
        report=ReportSpec(
            title="Where the segmentation breaks",
            subtitle="share of trials that are right, in %",
            data="generated scenes, noise 1 mm at 1 m unless the sweep changes it",
            case_name="frame",
            figures=_figures,
            draw=_draw_shares,
        ),
        seeds=5,
        quick_seeds=2,
        prepare=load_kernels,
        write_files=_write_sheet,
    )


def _figures(step: SweepStep) -> dict[str, Any]:
    mean = sum(step.scores) / len(step.scores) if step.scores else None
    return {"overlap_f_pct": percent(mean, 2), "segment_ms": milliseconds(step)}


def _draw_shares(axes: Axes, places: Sequence[float], steps: Sequence[SweepStep]) -> None:
    draw_curve(axes, places, [100 * step.pass_rate for step in steps], "right")


def _write_sheet(out: Path, results: Sequence[SweepResult]) -> Sequence[str]:
    shown = [picture for picture in map(_picture, results) if picture is not None]
    if not shown:
        return ()
    write_sheet(out / SHEET_FILE, shown)
    return (SHEET_FILE,)


def _picture(result: SweepResult) -> ScoredFrame | None:
    """Return the frame at which a sweep breaks; None when a picture of it would show nothing."""
    step = result.shown
    picture = step.worst.picture
    if not isinstance(picture, TrialPicture) or min(picture.labels.shape) < MIN_SHOWN_PX:
        return None
    if max(picture.labels.max(), picture.truth.max()) > MAX_SHOWN_OBJECTS:
        return None
    frame = picture.frame
    if picture.scene is not None:
        colour = render_staged(picture.scene, colour=True).colour
        frame = DepthFrame(frame.depth, frame.intrinsics, frame.T_world_camera, colour)
    name = f"{result.sweep.name}, {format_value(step.value, result.sweep.unit)}"
    score = score_segmentation(picture.labels, picture.truth, ignore=~frame.valid)
    return ScoredFrame(name, frame, picture.truth, picture.labels, score)


SEGMENTATION_SWEEPS = (
    *CAMERA_SWEEPS,
    *NEIGHBOUR_SWEEPS,
    *SHAPE_SWEEPS,
    *FURNISHED_SWEEPS,
    *INPUT_SWEEPS,
    *AGREEMENT_SWEEPS,
)
"""All sweeps of the segmentation."""
