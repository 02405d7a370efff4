"""`eyehand stress grasp`: find where picking breaks."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from eyehand.errors import InputError
from eyehand.grasping import PickOptions

from ...bench.chart_style import GREY, VERMILION, draw_curve
from ...bench.shares import (
    draw_bars,
    draw_dotted,
    milliseconds,
    refused_pct,
    score_pct,
    unclean_pct,
    worst,
)
from ...bench.stress import StressArguments, StressStage, run_stress
from ...bench.sweep_chart import ReportSpec
from ..mesh_scenes import ObjectSource
from ..warm_up import warm_up_grasping
from .camera_sweeps import camera_sweeps
from .event_sweeps import event_sweeps
from .fault_sweeps import fault_sweeps
from .household_sweeps import household_sweeps
from .shape_sweeps import load_sweeps, shape_sweeps
from .stress_trial import GraspFigures
from .touch_fault_sweeps import touch_fault_sweeps

if TYPE_CHECKING:
    from collections.abc import Collection, Sequence

    from matplotlib.axes import Axes

    from ...bench.sweep import Sweep, SweepStep

QUICK = ["width", "plate", "tall", "neighbour", "lost-depth", "only-table", "bad-physics"]
"""Sweeps of a quick run that names none: one of each kind."""
DIGITS = 3
"""Significant digits of measured figures."""


def stress_grasp(
    arguments: StressArguments | None = None, *, hand: str = "", objects: Path | None = None
) -> int:
    """Make picks harder step by step until they break, and chart where.

    Runs 2 trials at each value, or 1 with --quick; sweeps of failing devices take one. The sweeps
    cover objects that are wide, flat, slender, heavy, slippery or crowded; objects beside their
    estimated place, out of reach, moved or removed after perception, or held for minutes; cameras
    that are turned, misplaced or blind; and failing hands and physics. Each sweep has a bound that
    must hold. At every value the robot must end in a named outcome, touch nothing else before the
    grasp, throw nothing, and never report "placed" or "clear" wrongly. With --quick and no names,
    one sweep of each kind runs. Exit code 1: a bound is violated. Writes stress.png and stress.csv.

    Parameters
    ----------
    arguments
        Sweeps, seeds and output.
    hand
        A gripper (panda, 2f85, a .json file): grasp with it in the clutter-removal protocol
        instead, over calibration error, noise, friction, mass, camera angle and density.
    objects
        Folder of meshes or URDFs. Without --hand, single objects of it are grasped with the demo's
        hand, over friction, balance, hidden parts and softness of the floor. With --hand, it may be
        the folder that holds packed/.
    """
    arguments = arguments or StressArguments()
    if hand:
        if objects is None:
            raise InputError("--hand needs --objects FOLDER")
        # The planner of parallel jaws loads kernels that other sweeps do not need.
        from .jaw_stress import stress_jaws

        return stress_jaws(hand, objects, arguments)
    if objects is not None:
        return run_stress(household_stage(str(objects)), arguments)
    if arguments.quick and not arguments.only:
        arguments = replace(arguments, only=QUICK)
    return run_stress(grasp_stage(arguments.only), arguments)


def grasp_sweeps() -> tuple[Sweep[PickOptions], ...]:
    """Return all sweeps, in reading order."""
    return (
        *shape_sweeps(),
        *load_sweeps(),
        *event_sweeps(),
        *camera_sweeps(),
        *fault_sweeps(),
        *touch_fault_sweeps(),
    )


def grasp_stage(only: Collection[str] | None = None) -> StressStage[PickOptions]:
    """Return the stress stage of picking; its footer describes the sweeps named in `only`."""
    sweeps = grasp_sweeps()
    names = only or [sweep.name for sweep in sweeps]
    return StressStage(
        name="grasp",
        sweeps=sweeps,
        method=PickOptions(),
        report=ReportSpec(
            title="Where picking breaks",
            subtitle="Share of trials that end as required",
            data=f"simulated cell, {_pose_source(names)}",
            case_name="pick",
            figures=_figures,
            draw=_draw,
            legend=True,
            time_column="cpu ms a trial",
        ),
        seeds=2,
        quick_seeds=1,
        prepare=warm_up_grasping,
    )


def household_stage(folder: str) -> StressStage[PickOptions]:
    """Return the stress stage of single objects of a folder.

    Raises
    ------
    InputError
        If the folder holds no objects.
    """
    ObjectSource(folder).read()
    stage = grasp_stage([])
    report = replace(
        stage.report,
        title="Where picking household objects breaks",
        data="simulated cell, one noisy depth view",
    )
    return replace(stage, sweeps=household_sweeps(folder), report=report, seeds=4)


def _pose_source(names: Collection[str]) -> str:
    """Describe which sweeps perceive with the camera; the others use the true poses."""
    seeing = [sweep.name for sweep in camera_sweeps() if sweep.name in names]
    if not seeing:
        return "true poses"
    if len(seeing) == len(names):
        return "one noisy depth view"
    where = f"in {seeing[0]}" if len(seeing) == 1 else f"from {seeing[0]} to {seeing[-1]}"
    return f"true poses, but one noisy depth view {where}"


def _figures(step: SweepStep) -> dict[str, Any]:
    known = [trial.picture for trial in step.trials if isinstance(trial.picture, GraspFigures)]
    placed = score_pct(step)
    return {
        "placed_pct": None if placed is None else round(placed, 1),
        "refused_pct": round(refused_pct(step), 1),
        "unclean": sum(not trial.clean for trial in step.trials),
        "picks": sum(figures.picks for figures in known),
        "touched_before": sum(figures.touched_before for figures in known),
        "peak_speed_m_s": worst((figures.peak_speed_m_s for figures in known), DIGITS),
        "creep_mm": worst((figures.creep_mm for figures in known), DIGITS),
        "cpu_ms": milliseconds(step),
    }


def _draw(axes: Axes, places: Sequence[float], steps: Sequence[SweepStep]) -> None:
    refused = [refused_pct(step) for step in steps]
    unclean = [unclean_pct(step) for step in steps]
    draw_bars(axes, places, refused, "refused with a reason", GREY, 0.45)
    draw_bars(
        axes, places, unclean, "invalid: touched, thrown or reported wrongly", VERMILION, 0.75
    )
    draw_dotted(axes, places, [score_pct(step) for step in steps], "objects put away")
    draw_curve(axes, places, [100 * step.pass_rate for step in steps], "right")
