"""`eyehand evaluate fit`: fitted solids against the solids that clouds were taken from."""

from __future__ import annotations

import time
from pathlib import Path
from typing import Any, get_args

import numpy as np
from rich.table import Table

from eyehand.errors import InputError
from eyehand.perception import FitOptions, fit_superquadric

from ..console import print_json, say, show, tracked
from ..description import ready_kernels
from ..description_files import make_folder
from .csv_table import write_csv
from .fit_cases import FitCase, Group, fit_case
from .fit_score import overlap

FAILED = 0.5
"""IoU below which a fit has failed, as the literature counts."""


def evaluate_fit(
    *,
    seed: int = 0,
    cases: int = 25,
    groups: list[Group] | None = None,
    out: Path = Path("out/evaluate_fit"),
    json: bool = False,
) -> int:
    """Fit clouds with known solids and print how much of them is met.

    Writes cases.csv, a row for every cloud.

    Parameters
    ----------
    seed
        First seed; case k of every group follows from seed + k alone.
    cases
        Clouds per group.
    groups
        Kinds of clouds; default: all.
    out
        Output folder.
    json
        Print one JSON object on stdout; the table goes to stderr.
    """
    if cases < 1:
        raise InputError(f"--cases must be >= 1, got {cases}")
    if seed < 0:
        raise InputError(f"--seed must be >= 0, got {seed}")
    chosen = groups or list(get_args(Group))
    make_folder(out)
    ready_kernels()
    wanted = [(group, seed + k) for group in chosen for k in range(cases)]
    rows = [_row(fit_case(*one)) for one in tracked(wanted, "fitting", len(wanted))]
    write_csv(out / "cases.csv", rows)
    summary = [_summary(group, [row for row in rows if row["group"] == group]) for group in chosen]
    show(_table(summary, seed, cases), json_wanted=json)
    say(f"every cloud: {out / 'cases.csv'}")
    if json:
        print_json("evaluate-fit", seed, summary, cases=cases, out=str(out))
    return 0


def _row(case: FitCase) -> dict[str, Any]:
    began = time.perf_counter()
    fit = fit_superquadric(
        case.points,
        view_origin=case.view_origin,
        support_plane=case.support_plane,
        options=FitOptions(),
    )
    seconds = time.perf_counter() - began
    solid = fit.superquadric
    met = overlap(case.truth, solid, case.seed) if fit and solid is not None else 0.0
    return {
        "group": case.group,
        "seed": case.seed,
        "iou": round(met, 4),
        "kind": solid.kind if solid is not None else "",
        "true_kind": case.true_kind or "",
        "fit_ms": round(1e3 * seconds, 2),
        "reason": fit.reason,
    }


def _summary(group: str, rows: list[dict[str, Any]]) -> dict[str, Any]:
    met = np.array([row["iou"] for row in rows])
    times = np.array([row["fit_ms"] for row in rows])
    return {
        "name": group,
        "cases": len(rows),
        "iou_median_pct": round(100 * float(np.median(met)), 1),
        "iou_p10_pct": round(100 * float(np.quantile(met, 0.1)), 1),
        "iou_worst_pct": round(100 * float(met.min()), 1),
        "failed_pct": round(100 * float(np.mean(met < FAILED)), 1),
        "fit_median_ms": round(float(np.median(times)), 1),
        "fit_p90_ms": round(float(np.quantile(times, 0.9)), 1),
    }


def _table(summary: list[dict[str, Any]], seed: int, cases: int) -> Table:
    table = Table(
        title=f"fits, {cases} clouds a group, seeds from {seed}",
        title_justify="left",
        caption="IoU with the true solid in %; failed: IoU below 50 %; ms: wall time",
        caption_justify="left",
    )
    table.add_column("clouds")
    for column in ("cases", "IoU", "p10", "worst", "failed", "ms", "p90"):
        table.add_column(column, justify="right")
    for row in summary:
        table.add_row(*(str(value) for value in row.values()))
    return table
