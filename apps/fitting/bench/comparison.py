"""Fitters on the same clouds in turns: what each gives, and a row of figures for each answer."""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np

from eyehand.errors import InputError
from eyehand.perception import Superquadric, SuperquadricFit, fit_superquadric

from ...bench import Method
from .score import FitScore, score_fit

if TYPE_CHECKING:
    from collections.abc import Sequence

    from eyehand.perception import FitOptions

    from ...bench import MethodResult
    from .baselines import Fitter
    from .clouds import FitCase

OWN = "eyehand"
"""Whose fitter it is, for rows and charts."""
FAILED = 0.5
"""IoU below which a fit has failed, as the literature counts."""


@dataclass(frozen=True)
class FitAnswer:
    """What a fitter gave."""

    parts: tuple[Superquadric, ...]
    """The solids, largest first; none where it found none."""
    reason: str = ""
    """Why there is none."""

    @property
    def kind(self) -> str:
        """Kind of the solid, or how many there are."""
        if len(self.parts) == 1:
            return self.parts[0].kind
        return f"{len(self.parts)} parts" if self.parts else ""


@dataclass(frozen=True)
class GradedFit:
    """What a fitter gave, and what it is worth."""

    answer: FitAnswer
    score: FitScore


def own_fitter(name: str, options: FitOptions) -> Method[FitCase, FitAnswer]:
    """Ours, at some options."""
    return Method(OWN, name, partial(_own_answer, options))


def baseline_fitter(name: str, fitter: Fitter) -> Method[FitCase, FitAnswer]:
    """Another's. What it raises is an answer without a solid: failing on a cloud is a result."""
    return Method(name, name, partial(_baseline_answer, name, fitter))


def grade(case: FitCase, answer: FitAnswer) -> GradedFit:
    """Score an answer by every measure."""
    return GradedFit(answer, score_fit(case.truth, answer.parts, case.seed))


def case_rows(
    cases: Sequence[FitCase], result: MethodResult[FitCase, FitAnswer, GradedFit]
) -> list[dict[str, Any]]:
    """Give all figures of one fitter, a row a cloud."""
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
            "kind": graded.answer.kind,
            "fit_ms": round(float(milliseconds), 3),
            "reason": graded.answer.reason,
        }
        for case, graded, milliseconds in zip(cases, result.scores, result.wall_ms, strict=True)
    ]


def summary_rows(rows: Sequence[dict[str, Any]]) -> list[dict[str, Any]]:
    """Sum the rows of clouds up, one row for every group and fitter in it.

    Medians are over all clouds: where there is no solid, distances and errors are infinite, and
    a median that is infinite is None. The share of right kinds is None where the truth has none,
    and for a fitter that calls every solid a superquadric: it does not choose.
    """
    parted: dict[tuple[str, str], list[dict[str, Any]]] = {}
    for row in rows:
        parted.setdefault((row["group"], row["method"]), []).append(row)
    choosers = {row["method"] for row in rows if row["kind"] not in ("", "superquadric")}
    return [_summary(own, method in choosers) for (_, method), own in parted.items()]


def _own_answer(options: FitOptions, case: FitCase) -> FitAnswer:
    return _answer(
        fit_superquadric(
            case.points,
            view_origin=case.view_origin,
            support_plane=case.support_plane,
            options=options,
        )
    )


def _baseline_answer(name: str, fitter: Fitter, case: FitCase) -> FitAnswer:
    try:
        given = fitter(case.points, case.view_origin, case.support_plane)
    except Exception as error:
        return FitAnswer((), f"{type(error).__name__}: {error}")
    if given is not None and not isinstance(given, Superquadric | SuperquadricFit):
        raise InputError(
            f"the baseline {name} must give a Superquadric, a SuperquadricFit or None, "
            f"got a {type(given).__name__}"
        )
    return _answer(given)


def _answer(given: Superquadric | SuperquadricFit | None) -> FitAnswer:
    if given is None:
        return FitAnswer((), "no solid")
    if isinstance(given, Superquadric):
        return FitAnswer((given,))
    # A refusal counts as a failure: every cloud here shows enough.
    if not given or given.superquadric is None:
        return FitAnswer((), given.reason)
    return FitAnswer(getattr(given, "parts", ()) or (given.superquadric,))


def _summary(rows: list[dict[str, Any]], chooses: bool) -> dict[str, Any]:
    met = np.array([row["iou_pct"] for row in rows])
    times = np.array([row["fit_ms"] for row in rows])
    right = [row["kind"] == row["true_kind"] for row in rows if row["true_kind"]]
    return {
        "name": rows[0]["group"],
        "method": rows[0]["method"],
        "cases": len(rows),
        "iou_median_pct": round(float(np.median(met)), 2),
        "iou_p10_pct": round(float(np.quantile(met, 0.1)), 2),
        "iou_worst_pct": round(float(met.min()), 2),
        "failed_pct": round(100 * float(np.mean(met < 100 * FAILED)), 2),
        "mean_distance_mm": _median(rows, "mean_distance_mm"),
        "max_distance_mm": _median(rows, "max_distance_mm"),
        "extent_error_mm": _median(rows, "extent_error_mm"),
        "extent_error_pct": _median(rows, "extent_error_pct"),
        "kind_right_pct": round(100 * float(np.mean(right)), 2) if right and chooses else None,
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
