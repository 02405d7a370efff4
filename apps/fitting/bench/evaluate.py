"""`eyehand evaluate fit`: compare fitted solids with the true solids of clouds."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Annotated, Any, get_args

from cyclopts import Parameter
from rich.table import Table

from eyehand.errors import InputError
from eyehand.perception import FitOptions

from ...bench import Method, compare_methods, machine_line, result_table, write_csv
from ...console import counted, print_json, say, seed_span, show, tracked
from ...perceived_frame import load_kernels
from ...run_folder import claim_folder
from .baselines import find_baseline
from .clouds import FitCase, Group, fit_case
from .comparison import OWN, baseline_fitter, case_rows, grade, own_fitter, summary_rows
from .evaluate_meshes import evaluate_meshes
from .fit_answer import FitAnswer
from .mesh_options import MeshData

QUICK_CASES = 2
MESH_BASELINES = ("ems",)
"""Baselines on meshes, unless others are named."""
PARTS = FitOptions().max_parts
ONE_SOLID, IN_PARTS = f"{OWN}, 1 solid", f"{OWN}, {PARTS} parts"
"""Names of our fit with one solid, and with as many parts as by default."""


def evaluate_fit(
    *,
    seed: int = 0,
    cases: int = 25,
    groups: list[Group] | None = None,
    baseline: list[str] | None = None,
    meshes: Annotated[MeshData | None, Parameter(name="*", group="Household meshes")] = None,
    optimiser: str | None = None,
    points: int | None = None,
    max_parts: int | None = None,
    budget_ms: float | None = None,
    quick: bool = False,
    out: Path = Path("out/evaluate_fit"),
    json: bool = False,
) -> int:
    """Fit clouds of known solids and print the accuracy.

    Writes cases.csv with a row per cloud and fitter. Cloud k of a group depends on seed + k only.
    With --meshes the fit is evaluated on views of household objects instead, with a row per class,
    beside the baseline ems. That writes fits.csv, and worst.png with the worst fits.

    Parameters
    ----------
    seed
        First seed.
    cases
        Clouds per group.
    groups
        Kinds of clouds; default: all.
    baseline
        Another fitter for the same clouds: a known name, or module:function for a Python function
        f(points, view_origin, support_plane) that returns a Superquadric, a SuperquadricFit or
        None. Can be given several times.
    meshes
        Folders of meshes, their views and their noise.
    optimiser
        Optimiser of the final refinement. Default: that of the fit options.
    points
        Number of points of a cloud that the fit uses. Default: that of the fit options.
    max_parts
        Maximum number of parts of an object. Default: that of the fit options; for compounds and
        meshes also 1.
    budget_ms
        Use the stored settings for this time per fit, ms. Other given options override them.
    quick
        Use two clouds per group, or one mesh per class.
    out
        Output folder.
    json
        Print one JSON object on stdout; the table goes to stderr.
    """
    if cases < 1:
        raise InputError(f"--cases must be >= 1, got {cases}")
    if seed < 0:
        raise InputError(f"--seed must be >= 0, got {seed}")
    cases = min(cases, QUICK_CASES) if quick else cases
    base = FitOptions() if budget_ms is None else FitOptions.for_budget(budget_ms)
    dials = {"optimiser": optimiser, "points": points, "max_parts": max_parts}
    given = {name: value for name, value in dials.items() if value is not None}
    own = replace(base, **given)
    if meshes is not None and meshes.meshes:
        meshes.check()
        methods = {ONE_SOLID: replace(own, max_parts=1), IN_PARTS: replace(own, max_parts=PARTS)}
        if max_parts is not None:
            methods = {OWN: own}
        fitters = {name: find_baseline(name) for name in baseline or MESH_BASELINES}
        return evaluate_meshes(meshes, methods, fitters, seed=seed, quick=quick, out=out, json=json)
    baselines = [baseline_fitter(name, find_baseline(name)) for name in baseline or []]
    claim_folder(out)
    load_kernels()
    rows: list[dict[str, Any]] = []
    for group in dict.fromkeys(groups or get_args(Group)):
        fitters = [own_fitter(OWN, own)]
        if group == "compound" and max_parts is None:
            single = own_fitter(ONE_SOLID, replace(own, max_parts=1))
            fitters.append(replace(single, name=ONE_SOLID))
        rows += _fitted([*fitters, *baselines], group, range(seed, seed + cases))
    summary = summary_rows(rows)
    write_csv(out / "cases.csv", rows)
    show(_table(summary, seed, cases), json_wanted=json)
    say(f"every cloud: {out / 'cases.csv'}")
    if json:
        print_json("evaluate_fit", seed, summary, cases=cases, machine=machine_line(), out=str(out))
    return 0


def _fitted(
    methods: Sequence[Method[FitCase, FitAnswer]], group: Group, seeds: range
) -> list[dict[str, Any]]:
    """Return the rows of all methods over the clouds of a group."""
    clouds = [fit_case(group, seed) for seed in tracked(seeds, f"drawing {group}", len(seeds))]
    turns = tracked(clouds, f"fitting {group}", len(clouds))
    results = compare_methods(methods, turns, grade, rounds=1)
    return [row for result in results for row in case_rows(clouds, result)]


def _table(summary: list[dict[str, Any]], seed: int, cases: int) -> Table:
    rows = [{**row, "method": row["method"].rpartition(":")[2]} for row in summary]
    return result_table(
        rows,
        [
            ("clouds", "{name}"),
            ("method", "{method}"),
            ("IoU", "{iou_median_pct:.1f}"),
            ("p10", "{iou_p10_pct:.1f}"),
            ("worst", "{iou_worst_pct:.1f}"),
            ("failed", "{failed_pct:.1f}"),
            ("mean mm", "{mean_distance_mm:.2f}"),
            ("max mm", "{max_distance_mm:.1f}"),
            ("extent mm", "{extent_error_mm:.1f}"),
            ("extent %", "{extent_error_pct:.1f}"),
            ("kind", "{kind_right_pct:.1f}"),
            ("ms", "{fit_median_ms:.1f}"),
            ("p90", "{fit_p90_ms:.1f}"),
        ],
        title=f"fits of {counted(cases, 'cloud')} per group, {seed_span(seed, cases)}",
        caption="IoU with the true solid: median, 10th percentile and worst, %; failed: IoU below "
        "50 %; mm: distance of the surfaces, mean and maximum, and the largest error of a half "
        "extent; kind: correct kinds, %; ms: wall time, median and 90th percentile",
        left=("method",),
    )
