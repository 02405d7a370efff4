"""`eyehand stress touch`: make touching harder until the servo breaks, and chart where."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from cyclopts import Parameter

from eyehand.apps.output_files import make_folder

from ..bench.chart_style import GREY, VERMILION, draw_curve
from ..bench.shares import draw_bars, refused_pct, share_pct, worst
from ..bench.stress import run_sweeps, stress_seeds, tell_stress
from ..bench.sweep import select_sweeps
from ..bench.sweep_chart import ReportSpec
from .contact_sweeps import contact_sweeps
from .gain_sweeps import gain_sweeps
from .sensor_sweeps import sensor_sweeps
from .stress_trial import ContactFigures

if TYPE_CHECKING:
    from collections.abc import Sequence

    from matplotlib.axes import Axes

    from ..bench.sweep import Step, Sweep

SEEDS, QUICK_SEEDS = 8, 1
"""Trials a value when no number is asked for."""
DIGITS = 4
"""Significant digits of measured figures."""


def stress_touch(
    *,
    only: Annotated[list[str] | None, Parameter(consume_multiple=True, negative="")] = None,
    seeds: int | None = None,
    seed: int = 0,
    quick: bool = False,
    out: Path = Path("out/stress_touch"),
    json: bool = False,
) -> int:
    """Make touching harder step by step until the tactile servo breaks, and chart where.

    Gains past the limit, fast landings with and without anti-windup, contacts lost while rolling,
    round ones with yaw on, rods exactly across, contacts at the border, blobs that swap, objects
    that come at the pad, light ones, thresholds in the noise, dead and saturated tactels. Past its
    limit each should end in a named outcome with the pad backed off; force that grows, or a pad
    that still presses after that, breaks it. Ends with exit code 1 when a bound is broken, and says
    which. Writes stress.png with stress.csv.

    Parameters
    ----------
    only
        Sweeps to run; all when not given.
    seeds
        Trials at each value; default 8, or 1 with --quick.
    seed
        The first seed; electronics, noise and directions follow from it alone.
    quick
        Try each sweep at its easiest value, its bound and its hardest value only.
    out
        Output folder.
    json
        Print one JSON object on stdout; the table goes to stderr.
    """
    tried = stress_seeds(seeds, seed, QUICK_SEEDS if quick else SEEDS)
    sweeps = select_sweeps(touch_sweeps(), only or ())
    make_folder(out)
    results = run_sweeps(sweeps, tried, None, quick=quick)
    return tell_stress(results, touch_telling(), tried, out=out, json=json, quick=quick)


def touch_sweeps() -> tuple[Sweep[None], ...]:
    """All sweeps, in reading order."""
    return (*gain_sweeps(), *contact_sweeps(), *sensor_sweeps())


def touch_telling() -> ReportSpec:
    """How the sweeps are told: what was held, what ended with a name, the worst forces."""
    return ReportSpec(
        stage="touch",
        title="Where the tactile servo breaks",
        subtitle="Share of contacts that are held as they should",
        data="simulated 16 x 16 pad on a carrier with an arm's lag, default options",
        each="trial",
        figures=_figures,
        draw=_draw,
        keyed=True,
    )


def _figures(step: Step) -> dict[str, Any]:
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


def _unnamed_pct(step: Step) -> float:
    """Share of trials, %, that neither ended with a name nor held."""
    return share_pct(step, lambda trial: not (trial.refused or trial.passed))


def _draw(axes: Axes, places: Sequence[float], steps: Sequence[Step]) -> None:
    named = [refused_pct(step) for step in steps]
    unnamed = [_unnamed_pct(step) for step in steps]
    draw_bars(axes, places, named, "ended with a name, backed off", GREY, 0.45)
    draw_bars(axes, places, unnamed, "missed without a name", VERMILION, 0.6, named)
    draw_curve(axes, places, [100 * step.share for step in steps], "held")
