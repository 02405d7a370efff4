"""`eyehand control stress`: make motions harder until the control basis breaks, and chart where."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from cyclopts import Parameter

from eyehand.apps.console import show
from eyehand.apps.description_files import make_folder
from eyehand.apps.evaluation.chart_style import INK, PEER, VERMILION, draw_curve
from eyehand.apps.evaluation.stress_chart import Telling, write_stress_chart
from eyehand.apps.evaluation.stress_run import (
    CHART_FILE,
    CHART_FILES,
    run_sweeps,
    stress_seeds,
    tell_stress,
)
from eyehand.apps.evaluation.stress_sweep import chosen_sweeps
from eyehand.control.options import ControlOptions
from eyehand.errors import InputError

from .stress_contact_cases import contact_sweeps
from .stress_control_inputs import refusal_rows, refusal_table, refused, wrong_inputs
from .stress_gain_cases import gain_sweeps
from .stress_goal_cases import goal_sweeps
from .stress_limit_cases import limit_sweeps
from .stress_motion import MotionFigures

if TYPE_CHECKING:
    from collections.abc import Sequence

    from matplotlib.axes import Axes

    from eyehand.apps.evaluation.stress_sweep import Step, Sweep

    from .stress_motion import Method

SEEDS, QUICK_SEEDS = 10, 1
"""Trials a value when no number is asked for; long runs take fewer."""
INPUTS = "inputs"
"""Name of the wrong inputs among the sweeps."""
DIGITS = 4
"""Significant digits of measured figures."""


def control_stress(
    *,
    only: Annotated[list[str] | None, Parameter(consume_multiple=True, negative="")] = None,
    seeds: int | None = None,
    seed: int = 0,
    quick: bool = False,
    out: Path = Path("out/stress_control"),
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
    sweeps = _chosen(named) if named or not wanted else ()
    make_folder(out)
    results = run_sweeps(sweeps, tried, ControlOptions(), quick=quick)
    with_inputs = INPUTS in wanted or not wanted
    refusals = [refused(wrong) for wrong in (wrong_inputs() if with_inputs else ())]
    telling = control_telling()
    if results:
        write_stress_chart(out / CHART_FILE, results, telling, len(tried), seed)
    if refusals:
        show(refusal_table(refusals), json_wanted=json)
    return tell_stress(
        results,
        telling,
        tried,
        CHART_FILES if results else (),
        out=out,
        json=json,
        quick=quick,
        faults=[f"{one.wrong.name}: {one.happened}" for one in refusals if not one.kept],
        inputs=refusal_rows(refusals),
    )


def control_sweeps() -> tuple[Sweep[Method], ...]:
    """All sweeps, in reading order."""
    return (*goal_sweeps(), *limit_sweeps(), *gain_sweeps(), *contact_sweeps())


def control_telling() -> Telling:
    """How the sweeps are told: what is right, what is refused, and the worst that was measured."""
    return Telling(
        stage="control",
        title="Where the control basis breaks",
        subtitle="Share of motions that end as they should",
        data="7-joint arm at default options; a 4-joint arm and a palm of its own where so told",
        each="trial",
        figures=_figures,
        draw=_draw,
        keyed=True,
    )


def _chosen(names: Sequence[str]) -> tuple[Sweep[Method], ...]:
    try:
        return chosen_sweeps(control_sweeps(), names)
    except InputError as error:
        raise InputError(f"{error}, {INPUTS}") from None


def _figures(step: Step) -> dict[str, Any]:
    measured = [trial.picture for trial in step.trials if isinstance(trial.picture, MotionFigures)]

    def worst(name: str, pick: Any = max) -> float | None:
        values = [getattr(figures, name) for figures in measured]
        known = [value for value in values if value is not None]
        return float(f"{pick(known):.{DIGITS}g}") if known else None

    scores = step.scores
    return {
        "reached_pct": round(100 * sum(scores) / len(scores), 1) if scores else None,
        "refused_pct": round(100 * _refused(step), 1),
        "closest_mm": worst("closest_mm", min),
        "peak_speed_pct": worst("peak_speed_pct"),
        "end_step_rad": worst("end_step_rad"),
        "amplitude_mm": worst("amplitude_mm"),
        "peak_acceleration_rad_s2": worst("peak_acceleration"),
        "gradient_jump_pct": worst("jump_pct"),
        "unclean": sum(not trial.clean for trial in step.trials),
    }


def _refused(step: Step) -> float:
    return sum(trial.refused for trial in step.trials) / len(step.trials)


def _draw(axes: Axes, places: Sequence[float], steps: Sequence[Step]) -> None:
    look: dict[str, Any] = {"width": 0.82, "linewidth": 0, "zorder": 1.2}
    refused_shares = [100 * _refused(step) for step in steps]
    unclean = [100 * sum(not t.clean for t in step.trials) / len(step.trials) for step in steps]
    axes.bar(places, refused_shares, color=PEER, alpha=0.45, label="refused, or infeasible", **look)
    axes.bar(
        places, unclean, color=VERMILION, alpha=0.75, label="a limit or a margin broken", **look
    )
    known = [(x, step.scores) for x, step in zip(places, steps, strict=True) if step.scores]
    axes.plot(
        [x for x, _ in known],
        [100 * sum(scores) / len(scores) for _, scores in known],
        color=INK,
        linewidth=1.1,
        linestyle=(0, (1, 1.4)),
        label="goals reached",
        clip_on=False,
        zorder=3.2,
    )
    draw_curve(axes, places, [100 * step.share for step in steps], "right")
