"""`eyehand stress fit`: find where the superquadric fit breaks."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from eyehand.apps.perceived_frame import load_kernels

from ...bench import ReportSpec, StressArguments, StressStage, Sweep, SweepStep, run_stress
from ...bench.chart_style import COLOURS, GREY, SKY, VERMILION, draw_curve
from ...bench.shares import draw_bars, draw_dotted, milliseconds, percent, refused_pct, share_pct
from .baselines import find_baseline
from .cloud_sweeps import cloud_sweeps
from .fit_answer import FAILED
from .rendered_sweeps import rendered_sweeps
from .solid_sweeps import solid_sweeps
from .stress_trial import RIGHT, FitCallable, baseline_method, fit_method

if TYPE_CHECKING:
    from collections.abc import Sequence

    from matplotlib.axes import Axes


MEDIAN, WORST = 0, COLOURS.index(SKY)
"""Places of the curves in COLOURS."""


def stress_fit(arguments: StressArguments | None = None, *, baseline: str | None = None) -> int:
    """Make clouds of known solids harder step by step until the fit breaks, and chart where.

    Tries 20 clouds at each value, or 3 with --quick. Each sweep has a bound that must hold. Past
    the bound an answer may be wrong, but it must still be valid. Exit code 1: a bound is violated.
    Writes stress.png and stress.csv.

    Parameters
    ----------
    baseline
        Test another fitter: the name of a baseline, or module:function. No bound applies to it.
    """
    return run_stress(fit_stage(baseline), arguments or StressArguments())


def fit_sweeps() -> tuple[Sweep[FitCallable], ...]:
    """Return all sweeps, in reading order."""
    return (*cloud_sweeps(), *solid_sweeps(), *rendered_sweeps())


def fit_stage(baseline: str | None = None) -> StressStage[FitCallable]:
    """Return the stress stage of the fit, or that of a baseline without bounds."""
    own = baseline is None
    sweeps = fit_sweeps()
    return StressStage(
        name="fit",
        sweeps=sweeps if own else [replace(sweep, holds_to=None) for sweep in sweeps],
        method=fit_method if own else baseline_method(find_baseline(baseline)),
        report=ReportSpec(
            title=f"Where {baseline or 'the fit'} breaks",
            subtitle=f"IoU with the true solid (right: {100 * RIGHT:.0f} % or more)",
            data="one view of a random solid, 1000 points, 1 mm noise unless the sweep changes it",
            case_name="cloud",
            figures=_figures,
            draw=_draw,
            legend=True,
        ),
        seeds=20,
        quick_seeds=3,
        prepare=load_kernels,
        members={"baseline": baseline},
        schema_version=2,
    )


def silent_pct(step: SweepStep) -> float:
    """Return the percentage of trials with a failed solid and no refusal."""
    return share_pct(step, lambda trial: trial.score is not None and trial.score < FAILED)


def _figures(step: SweepStep) -> dict[str, Any]:
    scores = step.scores
    return {
        "iou_median_pct": percent(float(np.median(scores)) if scores else None),
        "iou_worst_pct": percent(min(scores, default=None)),
        "refused_pct": round(refused_pct(step), 1),
        "silent_pct": round(silent_pct(step), 1),
        "raised": sum(not trial.clean for trial in step.trials),
        "fit_ms": milliseconds(step),
    }


def _draw(axes: Axes, places: Sequence[float], steps: Sequence[SweepStep]) -> None:
    silent = [silent_pct(step) for step in steps]
    refused = [refused_pct(step) for step in steps]
    draw_bars(axes, places, silent, "failed silently", VERMILION, 0.75)
    draw_bars(axes, places, refused, "refused", GREY, 0.45, silent)
    draw_dotted(axes, places, [100 * step.pass_rate for step in steps], "right")
    for label, number, pick in (("IoU, worst", WORST, min), ("IoU, median", MEDIAN, np.median)):
        known = [(x, step.scores) for x, step in zip(places, steps, strict=True) if step.scores]
        shares = [100 * float(pick(scores)) for _, scores in known]
        draw_curve(axes, [x for x, _ in known], shares, label, number)
