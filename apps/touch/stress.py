"""`eyehand stress touch`: find where the tactile servo breaks."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from eyehand.data_synth.pad import SENSORS

from ..bench.chart_style import GREY, VERMILION, draw_curve
from ..bench.shares import draw_bars, refused_pct, share_pct, worst
from ..bench.stress import OtherMethod, StressArguments, StressStage, run_stress
from ..bench.sweep import Sweep, SweepStep
from ..bench.sweep_chart import ReportSpec
from .contact_sweeps import CONTACT_SWEEPS
from .gain_sweeps import gain_sweeps
from .sensor_sweeps import SENSOR_SWEEPS
from .stress_trial import ContactFigures

if TYPE_CHECKING:
    from collections.abc import Sequence

    from matplotlib.axes import Axes

    from eyehand.data_synth.pad import SensorModel


DIGITS = 4
"""Significant digits of measured figures."""
FIRST = "good"
"""The sensor model that the bounds of the sweeps hold for."""
_SHARED = {
    "lost-rolling": 0.2, "wait": 8, "lag": 10, "gain-spread": 10, "hysteresis": 10, "creep": 5,
    "drift": 6, "shear": 100, "friction": 1.0, "dead-rows": 1.0, "dead": 5.0, "saturated": 5.0,
    "landing-ball": 50.0,
}  # fmt: skip
HOLDS_TO: dict[str, dict[str, float]] = {
    "real": {
        "gain-pen": 0.5, "gain-box": 0.5, "gain-ball": 0.5, "landing-pen": 20.0,
        "landing-box": 10.0, "round": 5.0, "right-angle": 5.0, "border": 30.0, "coming": 5.0,
        "light": 5.0, "threshold": 4.0, "backlash": 0.03, **_SHARED,
    },
    "harsh": {
        "gain-pen": 0.25, "gain-box": 0.25, "gain-ball": 0.25, "landing-pen": 10.0,
        "landing-box": 10.0, "round": 10.0, "border": 20.0, "coming": 2.0, "light": 10.0,
        "threshold": 6.0, "backlash": 0.01, **_SHARED,
    },
}  # fmt: skip
"""The other sensor models: sweep → value up to which contacts must hold."""


def stress_touch(arguments: StressArguments | None = None) -> int:
    """Make contacts harder step by step until the tactile servo breaks, and chart where.

    Runs 8 trials at each value, or 1 with --quick, with each of the sensor models good, real and
    harsh. One press before a trial shows the servo the delay and the lag. The sweeps cover gains
    past the limit, fast landings with and without anti-windup, contacts lost while rolling, round
    contacts with yaw control on, rods exactly across, contacts at the border, blobs that swap,
    objects that move towards the pad, light objects, thresholds within the noise, delay, lag,
    hysteresis, creep, drift, shear and friction, and dead and saturated tactels. Past its limit
    each trial must end in a named outcome with the pad backed off. A growing force violates that,
    and so does a pad that still presses afterwards. Exit code 1: a bound is violated. Writes
    stress.png and stress.csv.
    """
    return run_stress(touch_stage(), arguments or StressArguments())


def touch_sweeps() -> tuple[Sweep[SensorModel], ...]:
    """Return all sweeps, in reading order."""
    return (*gain_sweeps(), *CONTACT_SWEEPS, *SENSOR_SWEEPS)


def touch_stage() -> StressStage[SensorModel]:
    """Return the stress stage of tactile servoing."""
    return StressStage(
        name="touch",
        sweeps=touch_sweeps(),
        method=SENSORS[FIRST],
        method_name=FIRST,
        others=[OtherMethod(name, SENSORS[name], bounds) for name, bounds in HOLDS_TO.items()],
        report=ReportSpec(
            title="Where the tactile servo breaks",
            subtitle=f"Share of contacts held as required with three sensor models; bars: {FIRST}",
            data="simulated 16 x 16 pad on a carrier with an arm's lag, default options",
            case_name="trial",
            figures=_figures,
            draw=_draw,
            legend=True,
        ),
        seeds=8,
        quick_seeds=1,
    )


def _figures(step: SweepStep) -> dict[str, Any]:
    measured = [trial.picture for trial in step.trials if isinstance(trial.picture, ContactFigures)]
    names = sorted({figures.outcome for figures in measured if figures.outcome})
    return {
        "named_pct": round(refused_pct(step), 1),
        "unnamed_pct": round(_unnamed_pct(step), 1),
        "outcomes": " ".join(names),
        "peak_force_n": worst((figures.peak_force for figures in measured), DIGITS),
        "peak_pressure_pa": worst((figures.peak_pressure for figures in measured), DIGITS),
        "growth_after_end": worst((figures.growth for figures in measured), DIGITS),
        "unclean": sum(not trial.clean for trial in step.trials),
    }


def _unnamed_pct(step: SweepStep) -> float:
    """Return the percentage of trials that neither held nor ended in a named outcome."""
    return share_pct(step, lambda trial: not (trial.refused or trial.passed))


def _draw(axes: Axes, places: Sequence[float], steps: Sequence[SweepStep]) -> None:
    named = [refused_pct(step) for step in steps]
    unnamed = [_unnamed_pct(step) for step in steps]
    draw_bars(axes, places, named, "named outcome, backed off", GREY, 0.45)
    draw_bars(axes, places, unnamed, "missed without an outcome", VERMILION, 0.6, named)
    draw_curve(axes, places, [100 * step.pass_rate for step in steps], FIRST)
