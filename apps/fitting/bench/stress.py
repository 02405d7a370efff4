"""`eyehand stress fit`: make clouds harder until the fit breaks, and chart where."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import numpy as np
from cyclopts import Parameter

from eyehand.apps.console import show, tracked
from eyehand.apps.output_files import make_folder
from eyehand.apps.perceived_frame import load_kernels

from ...bench.chart_style import COLOURS, GREY, SKY, VERMILION, draw_curve
from ...bench.shares import draw_bars, draw_dotted, refused_pct, share_pct
from ...bench.stress import run_sweeps, stress_seeds, tell_stress
from ...bench.sweep import select_sweeps
from ...bench.sweep_chart import ReportSpec, milliseconds, percent
from .baselines import find_baseline
from .extreme_clouds import extremes
from .extremes import extreme_rows, extreme_table, run_extreme
from .stress_sweeps import fit_sweeps
from .stress_trial import FAILED, RIGHT, baseline_method, fit_method

if TYPE_CHECKING:
    from collections.abc import Sequence

    from matplotlib.axes import Axes

    from ...bench.sweep import Step

SEEDS, QUICK_SEEDS = 20, 3
"""Clouds a value when no number is asked for."""
EXTREME_SEEDS = 3
"""Most clouds an extreme is tried with: it is right at once or not at all."""
MEDIAN, WORST = 0, COLOURS.index(SKY)
"""Curves of the chart, by their colours' numbers."""
EXTREMES = "extremes"
"""Name of the extreme clouds among the sweeps."""


def stress_fit(
    *,
    only: Annotated[list[str] | None, Parameter(consume_multiple=True, negative="")] = None,
    seeds: int | None = None,
    seed: int = 0,
    quick: bool = False,
    baseline: str | None = None,
    out: Path = Path("out/stress_fit"),
    json: bool = False,
) -> int:
    """Make clouds with known solids harder step by step until the fit breaks, and chart where.

    Each sweep has a bound that must hold, and every answer, right or wrong, must be a clean one.
    Extreme clouds (nothing, NaN, a line, wrong units, 10 km away ...) must each be refused by
    name, be followed exactly, or degrade with a word. Ends with exit code 1 when a bound or an
    expectation is broken, and says which. Writes stress.png with stress.csv.

    Parameters
    ----------
    only
        Sweeps to run, and "extremes" for the extreme clouds; all when not given.
    seeds
        Clouds tried at each value; default 20, or 3 with --quick.
    seed
        The first seed; solids, views and noise follow from it alone.
    quick
        Try each sweep at its easiest value, its bound and its hardest value only.
    baseline
        Put another fitter under the same stress: a baseline's name, or module:function. It is held
        to no bound, and meets the extreme clouds only when they are asked for.
    out
        Output folder.
    json
        Print one JSON object on stdout; the tables go to stderr.
    """
    tried = stress_seeds(seeds, seed, QUICK_SEEDS if quick else SEEDS)
    wanted = list(only or ())
    with_extremes = EXTREMES in wanted or not (wanted or baseline)
    named = [name for name in wanted if name != EXTREMES]
    sweeps = select_sweeps(fit_sweeps(), named, [EXTREMES]) if named or not wanted else ()
    method = fit_method
    if baseline is not None:
        method = baseline_method(find_baseline(baseline))
        sweeps = [replace(sweep, holds_to=None) for sweep in sweeps]
    make_folder(out)
    load_kernels()
    results = run_sweeps(sweeps, tried, method, quick=quick)
    extreme_results = [
        run_extreme(extreme, tried[:EXTREME_SEEDS], method)
        for extreme in tracked(extremes() if with_extremes else (), EXTREMES)
    ]
    if extreme_results:
        show(extreme_table(extreme_results), json_wanted=json)
    return tell_stress(
        results,
        fit_telling(baseline),
        tried,
        out=out,
        json=json,
        quick=quick,
        faults=[result.fault for result in extreme_results if result.fault and not baseline],
        baseline=baseline,
        extremes=extreme_rows(extreme_results),
    )


def fit_telling(baseline: str | None = None) -> ReportSpec:
    """How the fit's sweeps are told: IoU with the true solid, refusals, silent failures."""
    return ReportSpec(
        stage="fit",
        title=f"Where {baseline or 'the fit'} breaks",
        subtitle=f"IoU with the true solid (right: {100 * RIGHT:.0f} % or more)",
        data="one view of a random solid, 1000 points, 1 mm noise where nothing else is said",
        each="cloud",
        figures=_figures,
        draw=_draw,
        keyed=True,
    )


def silent_pct(step: Step) -> float:
    """Share of trials, %, whose solid has failed without the fit saying so."""
    return share_pct(step, lambda trial: trial.score is not None and trial.score < FAILED)


def _figures(step: Step) -> dict[str, Any]:
    scores = step.scores
    return {
        "iou_median_pct": percent(float(np.median(scores)) if scores else None),
        "iou_worst_pct": percent(min(scores, default=None)),
        "refused_pct": round(refused_pct(step), 1),
        "silent_pct": round(silent_pct(step), 1),
        "raised": sum(not trial.clean for trial in step.trials),
        "fit_ms": milliseconds(step),
    }


def _draw(axes: Axes, places: Sequence[float], steps: Sequence[Step]) -> None:
    silent = [silent_pct(step) for step in steps]
    refused = [refused_pct(step) for step in steps]
    draw_bars(axes, places, silent, "failed silently", VERMILION, 0.75)
    draw_bars(axes, places, refused, "refused", GREY, 0.45, silent)
    draw_dotted(axes, places, [100 * step.share for step in steps], "right")
    for label, number, pick in (("IoU, worst", WORST, min), ("IoU, median", MEDIAN, np.median)):
        known = [(x, step.scores) for x, step in zip(places, steps, strict=True) if step.scores]
        shares = [100 * float(pick(scores)) for _, scores in known]
        draw_curve(axes, [x for x, _ in known], shares, label, number)
