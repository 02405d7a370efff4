"""`eyehand stress motion`: find where the control basis breaks."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from eyehand.control import ControlOptions

from ..bench import ReportSpec, StressArguments, StressStage, Sweep, SweepStep, run_stress
from ..bench.chart_style import GREY, VERMILION, draw_curve
from ..bench.shares import draw_bars, draw_dotted, refused_pct, score_pct, unclean_pct, worst
from .contact_sweeps import contact_sweeps
from .gain_sweeps import gain_sweeps
from .goal_sweeps import goal_sweeps
from .limit_sweeps import limit_sweeps
from .stress_trial import MotionFigures

if TYPE_CHECKING:
    from collections.abc import Sequence

    from matplotlib.axes import Axes


DIGITS = 4
"""Number of significant digits of measured values."""


def stress_motion(arguments: StressArguments | None = None) -> int:
    """Make an arm's motions harder step by step until its control breaks, and chart where.

    Runs 10 trials at each value, or 1 with --quick; sweeps of long motions take fewer. The sweeps
    cover goals out of reach, inside obstacles, behind walls, at joint limits and in conflict; gains
    and periods past stability; starts in penetration, and flying obstacles. Each
    trial must end in a named status or a refusal. A joint beyond its speed limit, a distance below
    the margin, or NaN is a violation at every value. Exit code 1: a bound is violated. Writes
    stress.png and stress.csv.
    """
    return run_stress(motion_stage(), arguments or StressArguments())


def control_sweeps() -> tuple[Sweep[ControlOptions], ...]:
    """Return all sweeps, in reading order."""
    return (*goal_sweeps(), *limit_sweeps(), *gain_sweeps(), *contact_sweeps())


def motion_stage() -> StressStage[ControlOptions]:
    """Return the stress stage of motion control."""
    return StressStage(
        name="motion",
        sweeps=control_sweeps(),
        method=ControlOptions(),
        report=ReportSpec(
            title="Where the motion of an arm breaks",
            subtitle="Share of motions that end as required",
            data="7-joint arm, default options; 4-joint arm or custom palm in some sweeps",
            case_name="trial",
            figures=_figures,
            draw=_draw,
            legend=True,
        ),
        seeds=10,
        quick_seeds=1,
        schema_version=2,
    )


def _figures(step: SweepStep) -> dict[str, Any]:
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
        "unclean": sum(not trial.clean for trial in step.trials),
    }


def _draw(axes: Axes, places: Sequence[float], steps: Sequence[SweepStep]) -> None:
    refusals = [refused_pct(step) for step in steps]
    unclean = [unclean_pct(step) for step in steps]
    draw_bars(axes, places, refusals, "rejected, or infeasible", GREY, 0.45)
    draw_bars(axes, places, unclean, "limit or margin violated", VERMILION, 0.75)
    draw_dotted(axes, places, [score_pct(step) for step in steps], "goals reached")
    draw_curve(axes, places, [100 * step.pass_rate for step in steps], "right")
