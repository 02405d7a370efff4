"""`eyehand stress motion`: make motions harder until the control basis breaks, and chart where."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from cyclopts import Parameter

from eyehand.apps.console import show
from eyehand.apps.output_files import make_folder
from eyehand.control.options import ControlOptions

from ..bench.chart_style import GREY, VERMILION, draw_curve
from ..bench.shares import (
    draw_bars,
    draw_dotted,
    refused_pct,
    score_pct,
    unclean_pct,
    worst,
)
from ..bench.stress import run_sweeps, stress_seeds, tell_stress
from ..bench.sweep import select_sweeps
from ..bench.sweep_chart import ReportSpec
from .contact_sweeps import contact_sweeps
from .gain_sweeps import gain_sweeps
from .goal_sweeps import goal_sweeps
from .invalid_inputs import refusal_rows, refusal_table, refused, wrong_inputs
from .limit_sweeps import limit_sweeps
from .stress_trial import MotionFigures

if TYPE_CHECKING:
    from collections.abc import Sequence

    from matplotlib.axes import Axes

    from ..bench.sweep import Step, Sweep

SEEDS, QUICK_SEEDS = 10, 1
"""Trials a value when no number is asked for; long runs take fewer."""
INPUTS = "inputs"
"""Name of the wrong inputs among the sweeps."""
DIGITS = 4
"""Significant digits of measured figures."""


def stress_motion(
    *,
    only: Annotated[list[str] | None, Parameter(consume_multiple=True, negative="")] = None,
    seeds: int | None = None,
    seed: int = 0,
    quick: bool = False,
    out: Path = Path("out/stress_motion"),
    json: bool = False,
) -> int:
    """Make an arm's motions harder step by step until its control breaks, and chart where.

    Goals out of reach, inside obstacles, behind walls, at joint limits and against each other;
    gains and periods past what is stable; faces in parallel, starts in penetration, obstacles that
    come flying. Each value must end in a named status or a refusal: a joint past its speed, a
    distance below the margin or NaN break it, whatever is asked. Wrong input must be refused in
    words that name what is right. Ends with exit code 1 when a bound is broken, and says which.
    Writes stress.png with stress.csv.

    Parameters
    ----------
    only
        Sweeps to run, and "inputs" for the wrong inputs; all when not given.
    seeds
        Trials at each value; default 10, or 1 with --quick. Sweeps of long motions take fewer.
    seed
        The first seed; goals and places of obstacles follow from it alone.
    quick
        Try each sweep at its easiest value, its bound and its hardest value only.
    out
        Output folder.
    json
        Print one JSON object on stdout; the tables go to stderr.
    """
    tried = stress_seeds(seeds, seed, QUICK_SEEDS if quick else SEEDS)
    wanted = list(only or ())
    named = [name for name in wanted if name != INPUTS]
    sweeps = select_sweeps(control_sweeps(), named, [INPUTS]) if named or not wanted else ()
    make_folder(out)
    results = run_sweeps(sweeps, tried, ControlOptions(), quick=quick)
    with_inputs = INPUTS in wanted or not wanted
    refusals = [refused(wrong) for wrong in (wrong_inputs() if with_inputs else ())]
    if refusals:
        show(refusal_table(refusals), json_wanted=json)
    return tell_stress(
        results,
        control_telling(),
        tried,
        out=out,
        json=json,
        quick=quick,
        faults=[f"{one.wrong.name}: {one.happened}" for one in refusals if not one.kept],
        inputs=refusal_rows(refusals),
    )


def control_sweeps() -> tuple[Sweep[ControlOptions], ...]:
    """All sweeps, in reading order."""
    return (*goal_sweeps(), *limit_sweeps(), *gain_sweeps(), *contact_sweeps())


def control_telling() -> ReportSpec:
    """How the sweeps are told: what is right, what is refused, and the worst that was measured."""
    return ReportSpec(
        stage="motion",
        title="Where the control basis breaks",
        subtitle="Share of motions that end as they should",
        data="7-joint arm at default options; a 4-joint arm and a palm of its own where so told",
        each="trial",
        figures=_figures,
        draw=_draw,
        keyed=True,
    )


def _figures(step: Step) -> dict[str, Any]:
    measured = [trial.picture for trial in step.trials if isinstance(trial.picture, MotionFigures)]

    def worst_of(name: str, pick: Any = max) -> float | None:
        return worst((getattr(figures, name) for figures in measured), DIGITS, pick)

    reached = score_pct(step)
    return {
        "reached_pct": None if reached is None else round(reached, 1),
        "refused_pct": round(refused_pct(step), 1),
        "closest_mm": worst_of("closest_mm", min),
        "peak_speed_pct": worst_of("peak_speed_pct"),
        "end_step_rad": worst_of("end_step_rad"),
        "amplitude_mm": worst_of("amplitude_mm"),
        "peak_acceleration_rad_s2": worst_of("peak_acceleration"),
        "gradient_jump_pct": worst_of("jump_pct"),
        "unclean": sum(not trial.clean for trial in step.trials),
    }


def _draw(axes: Axes, places: Sequence[float], steps: Sequence[Step]) -> None:
    refusals = [refused_pct(step) for step in steps]
    unclean = [unclean_pct(step) for step in steps]
    draw_bars(axes, places, refusals, "refused, or infeasible", GREY, 0.45)
    draw_bars(axes, places, unclean, "a limit or a margin broken", VERMILION, 0.75)
    draw_dotted(axes, places, [score_pct(step) for step in steps], "goals reached")
    draw_curve(axes, places, [100 * step.share for step in steps], "right")
