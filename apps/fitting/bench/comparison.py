"""Compare fitters on the same clouds: methods, scores, and rows of figures."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import numpy as np

from eyehand.errors import InputError
from eyehand.perception import FitOptions, Superquadric, SuperquadricFit, fit_superquadric

from ...bench import Method, MethodResult
from .baselines import Fitter
from .clouds import FitCase
from .fit_answer import FAILED, FitAnswer
from .score import FitScore, score_fit

OWN = "eyehand"
"""Name of our fit in rows and charts."""


@dataclass(frozen=True)
class GradedFit:
    """The answer of a fitter and its score."""

    answer: FitAnswer
    score: FitScore


def own_fitter(name: str, options: FitOptions) -> Method[FitCase, FitAnswer]:
    """Return our fit with these options."""
    return Method(OWN, name, partial(_own_answer, options))


def baseline_fitter(name: str, fitter: Fitter) -> Method[FitCase, FitAnswer]:
    """Return a baseline. If it raises an exception, its answer has no solid."""
    return Method(name, name, partial(_baseline_answer, name, fitter))


def grade(case: FitCase, answer: FitAnswer) -> GradedFit:
    """Score an answer. A fit that its own fitter rejects counts as no solid."""
    return GradedFit(answer, score_fit(case.truth, answer.usable_parts, case.seed))


def case_rows(
    cases: Sequence[FitCase], result: MethodResult[FitCase, FitAnswer, GradedFit]
) -> list[dict[str, Any]]:
    """Return one row of figures per cloud for one fitter."""
    return [
        {
            "group": case.group,
            "seed": case.seed,
            "solid": case.name,
            "method": result.method.name,
            "iou_pct": round(100 * graded.score.iou, 2),
            "mean_distance_mm": _millimetres(graded.score.mean_distance),
            "max_distance_mm": _millimetres(graded.score.max_distance),
            "extent_error_mm": _millimetres(graded.score.extent_error),
            "extent_error_pct": _figure(100 * graded.score.extent_share),
            "true_kind": case.true_kind or "",
            "kind": _kind(graded.answer.usable_parts),
            "fit_ms": round(float(milliseconds), 3),
            "reason": graded.answer.reason,
        }
        for case, graded, milliseconds in zip(cases, result.scores, result.wall_ms, strict=True)
    ]


def summary_rows(rows: Sequence[dict[str, Any]]) -> list[dict[str, Any]]:
    """Summarise the rows of clouds: one row per group and fitter.

    Medians are over all clouds. A cloud without a solid counts with infinite errors. An infinite
    median is None. The share of correct kinds is None if the true solids have no kind, or if the
    fitter calls every solid a superquadric.
    """
    grouped: dict[tuple[str, str], list[dict[str, Any]]] = {}
    for row in rows:
        grouped.setdefault((row["group"], row["method"]), []).append(row)
    with_kinds = {row["method"] for row in rows if row["kind"] not in ("", "superquadric")}
    return [_summary(own, method in with_kinds) for (_, method), own in grouped.items()]


def _own_answer(options: FitOptions, case: FitCase) -> FitAnswer:
    margin = options.silhouette_margin + case.margin
    fit = fit_superquadric(
        case.points,
        view_origin=case.view_origin,
        support_plane=case.support_plane,
        free_space=case.free_space,
        options=replace(options, silhouette_margin=margin),
    )
    return FitAnswer.of(fit)


def _baseline_answer(name: str, fitter: Fitter, case: FitCase) -> FitAnswer:
    try:
        found = fitter(case.points, case.view_origin, case.support_plane)
    except Exception as error:
        return FitAnswer((), f"{type(error).__name__}: {error}")
    if found is not None and not isinstance(found, Superquadric | SuperquadricFit):
        raise InputError(
            f"the baseline {name} must return a Superquadric, a SuperquadricFit or None, "
            f"got a {type(found).__name__}"
        )
    return FitAnswer.of(found)


def _kind(parts: tuple[Superquadric, ...]) -> str:
    """Return the kind of one solid, or the number of several."""
    if len(parts) == 1:
        return parts[0].kind
    return f"{len(parts)} parts" if parts else ""


def _summary(rows: list[dict[str, Any]], has_kinds: bool) -> dict[str, Any]:
    ious = np.array([row["iou_pct"] for row in rows])
    times = np.array([row["fit_ms"] for row in rows])
    right = [row["kind"] == row["true_kind"] for row in rows if row["true_kind"]]
    return {
        "name": rows[0]["group"],
        "method": rows[0]["method"],
        "cases": len(rows),
        "iou_median_pct": round(float(np.median(ious)), 2),
        "iou_p10_pct": round(float(np.quantile(ious, 0.1)), 2),
        "iou_worst_pct": round(float(ious.min()), 2),
        "failed_pct": round(100 * float(np.mean(ious < 100 * FAILED)), 2),
        "mean_distance_mm": _median(rows, "mean_distance_mm"),
        "max_distance_mm": _median(rows, "max_distance_mm"),
        "extent_error_mm": _median(rows, "extent_error_mm"),
        "extent_error_pct": _median(rows, "extent_error_pct"),
        "kind_right_pct": round(100 * float(np.mean(right)), 2) if right and has_kinds else None,
        "fit_median_ms": round(float(np.median(times)), 2),
        "fit_p90_ms": round(float(np.quantile(times, 0.9)), 2),
    }


def _millimetres(metres: float) -> float | None:
    return _figure(1e3 * metres)


def _figure(value: float) -> float | None:
    return round(value, 3) if np.isfinite(value) else None


def _median(rows: Sequence[dict[str, Any]], key: str) -> float | None:
    values = [np.inf if row[key] is None else row[key] for row in rows]
    return _figure(float(np.median(values)))
