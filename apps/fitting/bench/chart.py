"""`eyehand chart fit`: time against accuracy of the fit over its dials, beside other fitters."""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from eyehand.apps.console import tracked
from eyehand.apps.output_files import make_folder
from eyehand.apps.perceived_frame import load_kernels
from eyehand.perception import FitOptions
from eyehand.perception.superquadric import FRONT_FORMAT, STORED_FRONT

from ...bench import (
    ChartWords,
    DialChart,
    FrontPlace,
    Measured,
    Method,
    Provenance,
    check_chart_arguments,
    compare_methods,
)
from .baselines import BASELINES, find_baseline
from .clouds import Group, fit_case
from .comparison import baseline_fitter, own_fitter
from .dials import BOARD, POINTS, SUPERQUADRIC_ONLY
from .fit_answer import FAILED
from .score import overlap

if TYPE_CHECKING:
    from ...bench import MethodResult
    from .clouds import FitCase
    from .fit_answer import FitAnswer

GROUPS: tuple[Group, ...] = ("view-1mm", "view-2mm", "table")
"""Groups of clouds in the chart, pooled: single views with noise, as a robot gets them."""
CASES, QUICK_CASES = 30, 2
"""Default number of clouds per group."""
ROUNDS, QUICK_ROUNDS = 2, 1
"""Fits of each cloud at each setting. The fastest time counts."""
SUPERQUADRIC_POINTS = (300, 500, 1000, 2000, 4000)
"""Points of our fits without model selection."""
BASELINE_POINTS, QUICK_BASELINE_POINTS = (250, 1000), (1000,)
"""Points given to the baselines: the dial that all of them have."""
WORDS = ChartWords(
    title="Superquadric fit: time against accuracy",
    gain="iou_p10_pct",
    accuracy="IoU, 10th percentile",
    same_gain_pct=1.0,
    columns={"iou_p10_pct": "p10", "iou_median_pct": "IoU", "failed_pct": "failed"},
    caption="IoU with the true solid: 10th percentile and median over all clouds; failed: IoU "
    "below 50 %; all in %",
    min_shown_pct=0.0,
)
PLACE = FrontPlace("fit", FRONT_FORMAT, STORED_FRONT, "FitOptions")


def chart_fit(
    *,
    seed: int = 0,
    cases: int | None = None,
    quick: bool = False,
    baselines: bool = True,
    baseline: list[str] | None = None,
    store: bool = False,
    out: Path = Path("out/chart_fit"),
    json: bool = False,
) -> int:
    """Chart time against accuracy of the superquadric fit over its dials, beside other fitters.

    Accuracy is the 10th percentile of the IoU with the true solid. The clouds are the groups
    view-1mm, view-2mm and table of eyehand evaluate fit, equally many of each, with up to 4000
    points. Prints a table. Writes the chart fit.png and its figures fit.csv.

    Parameters
    ----------
    seed
        First seed of the clouds.
    cases
        Clouds of each of the three groups; default: 30.
    quick
        Use few settings and 2 clouds per group. Takes seconds instead of minutes.
    baselines
        Chart the known baseline fitters too.
    baseline
        A further baseline, as for eyehand evaluate fit. Can be given several times.
    store
        Store the front for FitOptions.for_budget.
    out
        Output folder.
    json
        Print one JSON object on stdout; the table goes to stderr.
    """
    check_chart_arguments("--cases", cases, seed, store=store, quick=quick)
    each = cases or (QUICK_CASES if quick else CASES)
    settings = BOARD.settings(quick=quick)
    names = [*(BASELINES if baselines else ()), *(baseline or [])]
    methods = [
        *(own_fitter(setting.name, setting.options) for setting in settings),
        *_superquadric_only(quick=quick),
        *(
            baseline
            for name in dict.fromkeys(names)
            for baseline in _baseline_methods(name, quick=quick)
        ),
    ]
    make_folder(out)
    load_kernels()
    wanted = [(group, seed + k) for k in range(each) for group in GROUPS]
    compared = compare_methods(
        methods,
        (
            fit_case(group, case_seed, max(POINTS))
            for group, case_seed in tracked(wanted, "fitting", len(wanted))
        ),
        _overlap,
        QUICK_ROUNDS if quick else ROUNDS,
    )
    results = [_measured(result) for result in compared]
    data = f"single objects ({', '.join(GROUPS)}), up to {max(POINTS)} points"
    made = Provenance(data, seed, len(wanted), "cloud")
    chart = DialChart(WORDS, settings, results[: len(settings)], results[len(settings) :], made)
    chart.publish(out, PLACE, store=store, json=json, cases=len(wanted), groups=GROUPS)
    return 0


def _superquadric_only(*, quick: bool) -> list[Method[FitCase, FitAnswer]]:
    """Return our fit without model selection. It is a separate curve: it returns no kind."""
    fitters = [
        own_fitter(f"{count} points", FitOptions(kinds=SUPERQUADRIC_ONLY, points=count))
        for count in (QUICK_BASELINE_POINTS if quick else SUPERQUADRIC_POINTS)
    ]
    return [replace(fitter, name="ours, superquadric only") for fitter in fitters]


def _baseline_methods(name: str, *, quick: bool) -> list[Method[FitCase, FitAnswer]]:
    baseline = baseline_fitter(name, find_baseline(name))
    return [
        Method(baseline.name, f"{count} points", partial(_run_on, baseline, count))
        for count in (QUICK_BASELINE_POINTS if quick else BASELINE_POINTS)
    ]


def _run_on(baseline: Method[FitCase, FitAnswer], count: int, case: FitCase) -> FitAnswer:
    # The points are in random order, so the first ones are a fair sample.
    return baseline.run(replace(case, points=case.points[:count]))


def _overlap(case: FitCase, answer: FitAnswer) -> float:
    return overlap(case.truth, answer.usable_parts, case.seed)


def _measured(result: MethodResult[FitCase, FitAnswer, float]) -> Measured:
    ious = 100 * np.array(result.scores)
    figures = {
        "iou_p10_pct": np.quantile(ious, 0.1),
        "iou_median_pct": np.median(ious),
        "failed_pct": 100 * np.mean(ious < 100 * FAILED),
    }
    return Measured.of(result, {key: round(float(v), 2) for key, v in figures.items()})
