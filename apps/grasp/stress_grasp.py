"""`eyehand stress grasp`: make picks harder until they break, and chart where."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from cyclopts import Parameter

from eyehand.apps.description_files import make_folder
from eyehand.apps.evaluation.chart_style import INK, PEER, VERMILION, draw_curve
from eyehand.apps.evaluation.stress_chart import Telling, milliseconds, write_stress_chart
from eyehand.apps.evaluation.stress_run import (
    CHART_FILE,
    CHART_FILES,
    run_sweeps,
    stress_seeds,
    tell_stress,
)
from eyehand.apps.evaluation.stress_sweep import chosen_sweeps
from eyehand.apps.grasp.ready import ready_grasping
from eyehand.grasping.pick_options import PickOptions

from .stress_event_cases import event_sweeps
from .stress_fault_cases import fault_sweeps
from .stress_grasp_cases import load_sweeps, shape_sweeps
from .stress_grasp_trial import GraspFigures
from .stress_seeing_cases import seeing_sweeps

if TYPE_CHECKING:
    from collections.abc import Sequence

    from matplotlib.axes import Axes

    from eyehand.apps.evaluation.stress_sweep import Step, Sweep

    from .stress_grasp_trial import Method

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
    sweeps = chosen_sweeps(grasp_sweeps(), only or (QUICK if quick else ()))
    make_folder(out)
    ready_grasping()
    results = run_sweeps(sweeps, tried, PickOptions(), quick=quick)
    telling = grasp_telling()
    write_stress_chart(out / CHART_FILE, results, telling, len(tried), seed)
    return tell_stress(results, telling, tried, CHART_FILES, out=out, json=json, quick=quick)


def grasp_sweeps() -> tuple[Sweep[Method], ...]:
    """All sweeps, in reading order."""
    return (
        *shape_sweeps(),
        *load_sweeps(),
        *event_sweeps(),
        *seeing_sweeps(),
        *fault_sweeps(),
    )


def grasp_telling() -> Telling:
    """How the sweeps are told: what is right, what was put away, what was refused or unclean."""
    return Telling(
        stage="grasp",
        title="Where picking breaks",
        subtitle="Share of trials that end as they should",
        data="simulated cell; true poses, but one noisy depth view from camera-roll to only-table",
        each="pick",
        figures=_figures,
        draw=_draw,
        keyed=True,
    )


def _figures(step: Step) -> dict[str, Any]:
    known = [trial.picture for trial in step.trials if isinstance(trial.picture, GraspFigures)]
    creeps = [figures.creep_mm for figures in known if figures.creep_mm is not None]
    scores = step.scores
    return {
        "placed_pct": round(100 * sum(scores) / len(scores), 1) if scores else None,
        "refused_pct": round(100 * _refused(step), 1),
        "unclean": sum(not trial.clean for trial in step.trials),
        "picks": sum(figures.picks for figures in known),
        "touched_before": sum(figures.touched_before for figures in known),
        "peak_speed_m_s": _worst([figures.peak_speed_m_s for figures in known]),
        "creep_mm": _worst(creeps),
        "cpu_ms": milliseconds(step),
    }


def _worst(values: Sequence[float]) -> float | None:
    return float(f"{max(values):.{DIGITS}g}") if values else None


def _refused(step: Step) -> float:
    return sum(trial.refused for trial in step.trials) / len(step.trials)


def _draw(axes: Axes, places: Sequence[float], steps: Sequence[Step]) -> None:
    look: dict[str, Any] = {"width": 0.82, "linewidth": 0, "zorder": 1.2}
    refused = [100 * _refused(step) for step in steps]
    unclean = [100 * sum(not t.clean for t in step.trials) / len(step.trials) for step in steps]
    axes.bar(places, refused, color=PEER, alpha=0.45, label="not tried, and told why", **look)
    axes.bar(places, unclean, color=VERMILION, alpha=0.75, label="unclean", **look)
    known = [(x, step.scores) for x, step in zip(places, steps, strict=True) if step.scores]
    axes.plot(
        [x for x, _ in known],
        [100 * sum(scores) / len(scores) for _, scores in known],
        color=INK,
        linewidth=1.1,
        linestyle=(0, (1, 1.4)),
        label="objects put away",
        clip_on=False,
        zorder=3.2,
    )
    draw_curve(axes, places, [100 * step.share for step in steps], "right")
