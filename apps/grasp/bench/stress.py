"""`eyehand stress grasp`: make picks harder until they break, and chart where."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from cyclopts import Parameter

from eyehand.apps.grasp.ready import ready_grasping
from eyehand.apps.output_files import make_folder
from eyehand.grasping.pick_options import PickOptions

from ...bench.chart_style import GREY, VERMILION, draw_curve
from ...bench.shares import (
    draw_bars,
    draw_dotted,
    refused_pct,
    score_pct,
    unclean_pct,
    worst,
)
from ...bench.stress import run_sweeps, stress_seeds, tell_stress
from ...bench.sweep import select_sweeps
from ...bench.sweep_chart import ReportSpec, milliseconds
from .camera_sweeps import seeing_sweeps
from .event_sweeps import event_sweeps
from .fault_sweeps import fault_sweeps
from .shape_sweeps import load_sweeps, shape_sweeps
from .stress_trial import GraspFigures

if TYPE_CHECKING:
    from collections.abc import Collection, Sequence

    from matplotlib.axes import Axes

    from ...bench.sweep import Step, Sweep

SEEDS, QUICK_SEEDS = 2, 1
"""Trials a value when no number is asked for; what fails on purpose takes one."""
QUICK = ("width", "plate", "tall", "neighbour", "lost-depth", "only-table", "bad-physics")
"""Sweeps of a quick run that names none: one of each sort."""
DIGITS = 3
"""Significant digits of measured figures."""


def stress_grasp(
    *,
    only: Annotated[list[str] | None, Parameter(consume_multiple=True, negative="")] = None,
    seeds: int | None = None,
    seed: int = 0,
    quick: bool = False,
    out: Path = Path("out/stress_grasp"),
    json: bool = False,
) -> int:
    """Make picks harder step by step until they break, and chart where.

    Objects too wide, flat, slender, heavy, slippery or crowded; seen beside their place, out of
    reach, moved or gone after the look; held for minutes; cameras turned, misplaced or blind; hands
    and physics that fail. Each has a bound that must hold, and whatever is asked, the robot must
    end in a named outcome, touch nothing else before the grasp, fling nothing, and never say placed
    or clear where that is not so. Ends with exit code 1 when a bound is broken, and says which.
    Writes stress.png with stress.csv.

    Parameters
    ----------
    only
        Sweeps to run; all when not given.
    seeds
        Trials at each value; default 2, or 1 with --quick.
    seed
        The first seed; places, turns and noise follow from it alone.
    quick
        Try each sweep at its easiest value, its bound and its hardest value only; one sweep of
        each sort when none is named.
    out
        Output folder.
    json
        Print one JSON object on stdout; the table goes to stderr.
    """
    tried = stress_seeds(seeds, seed, QUICK_SEEDS if quick else SEEDS)
    sweeps = select_sweeps(grasp_sweeps(), only or (QUICK if quick else ()))
    make_folder(out)
    ready_grasping()
    results = run_sweeps(sweeps, tried, PickOptions(), quick=quick)
    telling = grasp_telling([sweep.name for sweep in sweeps])
    return tell_stress(results, telling, tried, out=out, json=json, quick=quick)


def grasp_sweeps() -> tuple[Sweep[PickOptions], ...]:
    """All sweeps, in reading order."""
    return (
        *shape_sweeps(),
        *load_sweeps(),
        *event_sweeps(),
        *seeing_sweeps(),
        *fault_sweeps(),
    )


def grasp_telling(names: Collection[str]) -> ReportSpec:
    """How sweeps of these names are told: what is right, put away, refused or unclean."""
    return ReportSpec(
        stage="grasp",
        title="Where picking breaks",
        subtitle="Share of trials that end as they should",
        data=f"simulated cell, {_seen_by(names)}",
        each="pick",
        figures=_figures,
        draw=_draw,
        keyed=True,
        time="cpu ms a trial",
    )


def _seen_by(names: Collection[str]) -> str:
    """Say which of the sweeps run see by the camera; the others know the true poses."""
    seeing = [sweep.name for sweep in seeing_sweeps() if sweep.name in names]
    if not seeing:
        return "true poses"
    if len(seeing) == len(names):
        return "one noisy depth view"
    where = f"in {seeing[0]}" if len(seeing) == 1 else f"from {seeing[0]} to {seeing[-1]}"
    return f"true poses, but one noisy depth view {where}"


def _figures(step: Step) -> dict[str, Any]:
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


def _draw(axes: Axes, places: Sequence[float], steps: Sequence[Step]) -> None:
    refused = [refused_pct(step) for step in steps]
    unclean = [unclean_pct(step) for step in steps]
    draw_bars(axes, places, refused, "not tried, and told why", GREY, 0.45)
    draw_bars(axes, places, unclean, "unclean: touched, flung or claimed wrongly", VERMILION, 0.75)
    draw_dotted(axes, places, [score_pct(step) for step in steps], "objects put away")
    draw_curve(axes, places, [100 * step.share for step in steps], "right")
