"""`eyehand evaluate fit --meshes`: fit views of household meshes and score them by class."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from rich.table import Table

from eyehand.errors import InputError
from eyehand.perception import FitOptions

from ...bench import machine_line, result_table, write_csv
from ...console import print_json, say, show, tracked
from ...perceived_frame import load_kernels
from ...run_folder import claim_folder
from .baselines import Fitter
from .comparison import OWN
from .household_meshes import HouseholdMesh, read_household
from .mesh_classes import CLASS_NAMES, MeshClass
from .mesh_options import MeshData
from .mesh_scenes import mesh_scenes
from .mesh_score import NOT_FOUND, MeshScore
from .mesh_trials import MeshTrial, scene_trials, view_trials
from .mesh_views import hide_in_turn, mesh_views
from .worst_fits import draw_worst

WORST = 12
"""Number of fits that are drawn."""


def evaluate_meshes(
    data: MeshData,
    methods: Mapping[str, FitOptions],
    baselines: Mapping[str, Fitter],
    *,
    seed: int,
    quick: bool,
    out: Path,
    json: bool,
) -> int:
    """Fit views of meshes, print a row per class and method, and draw the worst fits.

    Writes fits.csv with a row per fit, and worst.png with the fits of the last own method.
    """
    meshes = read_household(data.meshes, None if data.half == "all" else data.half)
    if not meshes:
        raise InputError(f"the folders have no mesh of the half {data.half}")
    views = data.directions()
    if quick:
        meshes, views = _one_per_class(meshes), views[:1]
    claim_folder(out)
    load_kernels()
    if data.neighbours:
        elevations = [view for view in views if isinstance(view, float)]
        images = mesh_scenes(meshes, elevations, data.noise, seed)
        run = scene_trials
    else:
        images = mesh_views(meshes, views, data.poses, data.noise, seed)
        if data.hidden:
            images = hide_in_turn(images, [share / 100 for share in data.hidden])
        run = view_trials
    trials: list[MeshTrial] = []
    # The first fit loads compiled kernels. It does not count.
    run(images[0], methods, {})
    for image in tracked(images, "fitting", len(images)):
        trials += run(image, methods, baselines)
    rows = _rows(trials, [*methods, *baselines])
    write_csv(out / "fits.csv", [fit_row(trial) for trial in trials])
    own = list(methods)[-1]
    drawn = [trial for trial in trials if trial.method == own]
    draw_worst(drawn, out / "worst.png", WORST)
    show(_table(rows, len(images), data), json_wanted=json)
    say(f"every fit: {out / 'fits.csv'}; worst fits of {own}: {out / 'worst.png'}")
    if json:
        print_json(
            "evaluate_fit",
            seed,
            rows,
            views=len(images),
            noise=data.noise,
            half=data.half,
            neighbours=data.neighbours,
            machine=machine_line(),
            out=str(out),
        )
    return 0


def _rows(trials: Sequence[MeshTrial], names: Sequence[str]) -> list[dict[str, Any]]:
    """Return the rows of all methods, class by class."""
    summaries = [
        mesh_summary([(t.placed.mesh.kind, t.score) for t in trials if t.method == name], name)
        for name in names
    ]
    return [row for rows in zip(*summaries, strict=True) for row in rows]


def fit_row(trial: MeshTrial) -> dict[str, Any]:
    """Return the figures of one fit."""
    score, mesh = trial.score, trial.placed.mesh
    return {
        "view": trial.view.name,
        "mesh": mesh.key,
        "class": mesh.kind,
        "half": mesh.half,
        "method": trial.method,
        "pixels": int((trial.view.object_pixels == trial.label).sum()),
        "iou_pct": round(100 * score.iou, 2),
        "solid_iou_pct": round(100 * score.solid_iou, 2),
        "hull_iou_pct": round(100 * score.hull_iou, 2),
        "chamfer_mm": round(1e3 * score.chamfer, 3) if score.parts else None,
        "true_width_mm": round(1e3 * score.true_width, 2),
        "width_error_mm": round(1e3 * score.width_error, 2) if score.parts else None,
        "usable": int(score.usable),
        "refused": int(score.refused),
        "flagged": int(score.flagged),
        "parts": score.parts,
        "fit_ms": round(1e3 * score.seconds, 2),
        "reason": score.reason,
    }


def _one_per_class(meshes: Sequence[HouseholdMesh]) -> tuple[HouseholdMesh, ...]:
    first = {mesh.kind: mesh for mesh in reversed(meshes)}
    return tuple(mesh for mesh in meshes if first[mesh.kind] is mesh)


def _table(rows: list[dict[str, Any]], views: int, data: MeshData) -> Table:
    how = "among neighbours" if data.neighbours else "alone"
    rows = [{**row, "short": row["method"].removeprefix(f"{OWN}, ")} for row in rows]
    return result_table(
        rows,
        [
            ("class", "{name}"),
            ("method", "{short}"),
            ("fits", "{fits}"),
            ("IoU", "{iou_median_pct:.1f}"),
            ("p10", "{iou_p10_pct:.1f}"),
            ("surf mm", "{chamfer_median_mm:.1f}"),
            ("width mm", "{width_error_median_mm:.1f}"),
            ("p90", "{width_error_p90_mm:.1f}"),
            ("usable", "{usable_pct:.0f}"),
            ("refused", "{refused_pct:.0f}"),
            ("flagged", "{flagged_pct:.0f}"),
            ("bad IoU", "{unsaid_iou_pct:.1f}"),
            ("bad use", "{unsaid_unusable_pct:.1f}"),
            ("1σ", "{sides_1_sigma_pct:.0f}"),
            ("2σ", "{sides_2_sigma_pct:.0f}"),
            ("1σ w", "{widths_1_sigma_pct:.0f}"),
            ("2σ w", "{widths_2_sigma_pct:.0f}"),
            ("ms", "{fit_median_ms:.0f}"),
            ("p90", "{fit_p90_ms:.0f}"),
        ],
        title=f"{views} views of meshes {how}, noise {data.noise}, half {data.half}",
        caption="IoU with the object (vessels: its hull), median and 10th percentile, %; surf: "
        "mean distance of the surfaces; width: error across the grasp, median and 90th percentile; "
        "usable: error ≤ 10 mm and an opening 20 mm wider clears the object; bad: IoU below 50 %, "
        "or not usable, and neither refused nor flagged; σ: true sides, and "
        "horizontal widths w, within the stated deviations; even: every class has the same weight",
        left=("method",),
    )


ALL, EVEN = "all", "even"
"""Names of the rows over all classes: every fit, or every class, has the same weight."""


def mesh_summary(
    scores: Sequence[tuple[MeshClass, MeshScore]], method: str
) -> list[dict[str, Any]]:
    """Return two rows over all scores and a row for each class that occurs.

    A refused fit has an IoU of 0 and infinite errors. Infinite figures are None. Shares are of all
    fits. The coverage is the share of the sides and widths within one and two stated standard
    deviations. `in_bounds` is the share within the stated bounds.
    """
    by_class = {kind: [score for name, score in scores if name == kind] for kind in CLASS_NAMES}
    known = {kind: own for kind, own in by_class.items() if own}
    weights = [1.0 / len(known[kind]) for kind, _ in scores]
    every = [score for _, score in scores]
    return [
        _row(ALL, method, every, [1.0] * len(every)),
        _row(EVEN, method, every, weights),
        *(_row(kind, method, own, [1.0] * len(own)) for kind, own in known.items()),
    ]


def _row(
    name: str, method: str, scores: Sequence[MeshScore], weights: Sequence[float]
) -> dict[str, Any]:
    def quantile(values: Sequence[float], share: float) -> float | None:
        return _quantile(np.array(values), np.array(weights), share)

    def share(values: Sequence[bool]) -> float:
        return round(100 * float(np.average(values, weights=weights)), 1)

    widths = [1e3 * abs(score.width_error) for score in scores]
    times = [1e3 * score.seconds for score in scores]

    def covered(name: str, sigmas: float) -> float | None:
        errors = [np.abs(getattr(score, name)) for score in scores]
        return _coverage([error <= sigmas for error in errors], weights)

    return {
        "name": name,
        "method": method,
        "fits": len(scores),
        "iou_median_pct": quantile([100 * score.iou for score in scores], 0.5),
        "iou_p10_pct": quantile([100 * score.iou for score in scores], 0.1),
        "solid_iou_median_pct": quantile([100 * score.solid_iou for score in scores], 0.5),
        "hull_iou_median_pct": quantile([100 * score.hull_iou for score in scores], 0.5),
        "chamfer_median_mm": quantile([1e3 * score.chamfer for score in scores], 0.5),
        "width_error_median_mm": quantile(widths, 0.5),
        "width_error_p90_mm": quantile(widths, 0.9),
        "usable_pct": share([score.usable for score in scores]),
        "refused_pct": share([score.refused for score in scores]),
        "not_found_pct": share([score.reason == NOT_FOUND for score in scores]),
        "flagged_pct": share([score.flagged for score in scores]),
        "unsaid_iou_pct": share([score.unsaid_iou for score in scores]),
        "unsaid_unusable_pct": share([score.unsaid_unusable for score in scores]),
        "in_parts_pct": share([score.parts > 1 for score in scores]),
        "sides_1_sigma_pct": covered("side_sigmas", 1.0),
        "sides_2_sigma_pct": covered("side_sigmas", 2.0),
        "widths_1_sigma_pct": covered("width_sigmas", 1.0),
        "widths_2_sigma_pct": covered("width_sigmas", 2.0),
        "in_bounds_pct": _coverage([score.in_bounds for score in scores], weights),
        "fit_median_ms": quantile(times, 0.5),
        "fit_p90_ms": quantile(times, 0.9),
    }


def _quantile(
    values: NDArray[np.float64], weights: NDArray[np.float64], share: float
) -> float | None:
    """Return the least value that at least a share of the weight does not exceed."""
    order = np.argsort(values)
    reached = np.cumsum(weights[order]) >= share * weights.sum() - 1e-9
    value = float(values[order][np.argmax(reached)])
    return round(value, 2) if np.isfinite(value) else None


def _coverage(covered: Sequence[NDArray[np.bool_]], weights: Sequence[float]) -> float | None:
    """Return the percentage of covered values, weighted by fit; None without values."""
    values = np.concatenate(covered)
    if not len(values):
        return None
    each = np.repeat(weights, [len(one) for one in covered])
    return round(100 * float(np.average(values, weights=each)), 1)
