"""`eyehand evaluate fit --meshes`: fit views of household meshes and score them by class."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from rich.table import Table

from eyehand.errors import InputError
from eyehand.perception import FitOptions

from ...bench import machine_line, result_table, write_csv
from ...console import print_json, say, show, tracked
from ...perceived_frame import load_kernels
from ...run_folder import claim_folder
from .baselines import Fitter
from .comparison import OWN
from .hidden_views import hide_in_turn
from .household_meshes import HouseholdMesh, read_household
from .mesh_options import MeshData
from .mesh_scenes import mesh_scenes
from .mesh_summary import mesh_summary
from .mesh_trials import MeshTrial, scene_trials, view_trials
from .mesh_views import mesh_views
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
