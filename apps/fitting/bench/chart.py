"""`eyehand chart fit`: time against accuracy of the fit over its dials, beside other fitters."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import get_args

import numpy as np

from eyehand.apps.console import tracked
from eyehand.apps.perceived_frame import load_kernels
from eyehand.apps.run_folder import claim_folder
from eyehand.errors import InputError
from eyehand.perception import FitOptions
from eyehand.perception.superquadric import FRONT_FORMAT, STORED_FRONT, OptimiserName

from ...bench.chart_style import Provenance
from ...bench.comparison import Method, MethodResult, compare_methods
from ...bench.dial_chart import ChartWords, DialChart, FrontPlace, Measured, check_chart_arguments
from ...bench.dials import DialBoard
from .baselines import BASELINES, find_baseline
from .clouds import MESHES, FitCase, Group, fit_case
from .comparison import baseline_fitter, own_fitter
from .fit_answer import FAILED, FitAnswer
from .mesh_cases import case_iou, mesh_cases

SIMPLE: tuple[Group, ...] = ("view-1mm", "view-2mm", "table")
"""Groups of solids of one part: single views with noise, as a robot gets them."""
GROUPS: tuple[Group, ...] = (*SIMPLE, "compound")
"""Groups of clouds in the chart."""
MESH_SHARE = 2
"""Number of views of meshes, over the clouds per group: real objects weigh as two groups."""
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
    gain="iou_mean_pct",
    accuracy="IoU, mean",
    same_gain_pct=0.5,
    columns={"iou_mean_pct": "mean", "iou_p10_pct": "p10", "failed_pct": "failed"},
    caption="IoU: mean over all, and the 10th percentile of solids of one part; failed: IoU below "
    "50 % among these; all in %; a refused fit has an IoU of 0",
    min_shown_pct=0.0,
)
MESH_WORDS = replace(
    WORDS, columns={**WORDS.columns, "mesh_iou_mean_pct": "meshes", "mesh_iou_p25_pct": "p25"}
)
"""Words of the chart with household meshes: their mean and 25th percentile are shown too."""
PLACE = FrontPlace("fit", FRONT_FORMAT, STORED_FRONT, "FitOptions")


def chart_fit(
    *,
    seed: int = 0,
    cases: int | None = None,
    quick: bool = False,
    baselines: bool = True,
    baseline: list[str] | None = None,
    meshes: list[Path] | None = None,
    store: bool = False,
    out: Path = Path("out/chart_fit"),
    json: bool = False,
) -> int:
    """Chart time against accuracy of the superquadric fit over its dials, beside other fitters.

    Accuracy is the mean IoU with the true solid. The clouds are the groups view-1mm, view-2mm,
    table and compound of eyehand evaluate fit, equally many of each, with up to 4000 points, and
    twice as many views of household meshes. Time is processor time. Prints a table. Writes the
    chart fit.png and its figures fit.csv.

    Parameters
    ----------
    seed
        First seed of the clouds.
    cases
        Clouds of each of the four groups; default: 30.
    quick
        Use few settings and 2 clouds per group. Takes seconds instead of minutes.
    baselines
        Chart the known baseline fitters too.
    baseline
        A further baseline, as for eyehand evaluate fit. Can be given several times.
    meshes
        Folders of household meshes, as for eyehand evaluate fit.
    store
        Store the front for FitOptions.for_budget.
    out
        Output folder.
    json
        Print one JSON object on stdout; the table goes to stderr.
    """
    check_chart_arguments("--cases", cases, seed, store=store, quick=quick)
    if store and not meshes:
        raise InputError("--store needs real objects: name folders of them with --meshes")
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
    groups, clouds = _cases(each, meshes or (), seed)
    claim_folder(out)
    load_kernels()
    count = len(clouds)
    compared = compare_methods(
        methods,
        (draw() for draw in tracked(clouds, "fitting", count)),
        _graded,
        QUICK_ROUNDS if quick else ROUNDS,
    )
    results = [_measured(result) for result in compared]
    data = f"single objects ({', '.join(groups)}), up to {max(POINTS)} points"
    made = Provenance(data, seed, count, "cloud")
    words = MESH_WORDS if meshes else WORDS
    chart = DialChart(words, settings, results[: len(settings)], results[len(settings) :], made)
    chart.publish(out, PLACE, store=store, json=json, cases=count, groups=groups)
    return 0


def _cases(
    each: int, meshes: Sequence[Path], seed: int
) -> tuple[list[str], list[Callable[[], FitCase]]]:
    """Return the names of the groups, and a function per cloud that draws it."""
    drawers: list[Callable[[], FitCase]] = [
        partial(fit_case, group, seed + k, max(POINTS)) for k in range(each) for group in GROUPS
    ]
    if not meshes:
        return list(GROUPS), drawers
    views = mesh_cases(meshes, MESH_SHARE * each, max(POINTS), seed)
    return [*GROUPS, MESHES], [*drawers, *(partial(_same, view) for view in views)]


def _same(case: FitCase) -> FitCase:
    return case


def _graded(case: FitCase, answer: FitAnswer) -> tuple[str, float]:
    """Return the group of a cloud and the IoU of an answer."""
    return case.group, case_iou(case, answer)


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


def _measured(result: MethodResult[FitCase, FitAnswer, tuple[str, float]]) -> Measured:
    """Return the processor times and the figures of a method."""
    ious = 100 * np.array([iou for _, iou in result.scores])
    groups = np.array([group for group, _ in result.scores])
    simple = ious[np.isin(groups, SIMPLE)]
    figures = {
        "iou_mean_pct": ious.mean(),
        "iou_p10_pct": np.quantile(simple, 0.1),
        "iou_median_pct": np.median(simple),
        "failed_pct": 100 * np.mean(simple < 100 * FAILED),
    }
    meshes = ious[groups == MESHES]
    if len(meshes):
        figures |= {
            "mesh_iou_mean_pct": meshes.mean(),
            "mesh_iou_p25_pct": np.quantile(meshes, 0.25),
        }
    # A fit runs on one thread. Its processor time hardly depends on other load.
    result = replace(result, wall_ms=result.cpu_ms)
    return Measured.of(result, {key: round(float(v), 2) for key, v in figures.items()})


POINTS = (50, 100, 200, 300, 500, 1000, 2000, 4000)
"""Number of points that a fit uses. The clouds of the chart have the largest number."""
STARTS = (1, 2, 3, 6, 9)
MAX_MINIMA = (1, 2, 3, 5)
PARTS = (1, 2, 3, 4)
"""Maximum number of parts."""
ONE_OR_FOUR = (1, 4)
"""The same for small time budgets, in which the search for parts has no place."""
FAST_POINTS = (50, 100, 200, 300)
"""Number of points of fits without model selection, for small time budgets. The chart shows such
fits with more points as a separate curve, because they do not determine the kind."""
NO_TAPER = ("sphere", "cylinder", "ellipsoid", "box", "superquadric")
"""Kinds without tapered solids."""
SUPERQUADRIC_ONLY = ("superquadric",)
"""The only kind of a fit without model selection."""

_OPTIMISERS = get_args(OptimiserName)
_DEFAULT = FitOptions()

BOARD = DialBoard(
    default=_DEFAULT,
    dials={
        "points": POINTS,
        "optimiser": _OPTIMISERS,
        "starts": STARTS,
        "max_minima": MAX_MINIMA,
        "silhouette_rays": (_DEFAULT.silhouette_rays, 0),
        "plane_weight": (_DEFAULT.plane_weight, 0.0),
        "kinds": (_DEFAULT.kinds, NO_TAPER),
        "max_parts": PARTS,
    },
    # Points, starts and kinds determine most of the time. The other dials cost less, and matter
    # for fast and slow fits alike.
    crosses=(
        {"points": POINTS, "optimiser": ("lm",), "max_minima": (_DEFAULT.max_minima, 1)},
        {
            "points": POINTS,
            "optimiser": ("lm",),
            "kinds": (NO_TAPER,),
            "starts": (1, 3),
            "max_parts": ONE_OR_FOUR,
        },
        {
            "points": FAST_POINTS,
            "optimiser": ("lm",),
            "kinds": (SUPERQUADRIC_ONLY,),
            "starts": (1, 3),
            "max_parts": ONE_OR_FOUR,
        },
        {"points": (300, 1000), "max_parts": PARTS},
        {
            "points": (100, 300, 1000),
            "optimiser": ("lm",),
            "silhouette_rays": (_DEFAULT.silhouette_rays, 0),
            "plane_weight": (_DEFAULT.plane_weight, 0.0),
        },
    ),
    quick={
        "max_parts": ONE_OR_FOUR,
        "points": (100, 300),
        "optimiser": ("lm",),
        "kinds": (NO_TAPER,),
    },
    words={
        **{("points", points): f"{points} points" for points in POINTS},
        **{("optimiser", name): name for name in _OPTIMISERS},
        **{("starts", n): f"{n} start{'s' if n > 1 else ''}" for n in STARTS},
        **{("max_minima", n): f"{n} minim{'a' if n > 1 else 'um'}" for n in MAX_MINIMA},
        **{("max_parts", n): f"{n} part{'s' if n > 1 else ''}" for n in PARTS},
        ("silhouette_rays", 0): "no rays",
        ("plane_weight", 0.0): "no plane",
        ("kinds", NO_TAPER): "no taper",
        ("kinds", SUPERQUADRIC_ONLY): "superquadric only",
    },
)
"""All dials of the chart."""
