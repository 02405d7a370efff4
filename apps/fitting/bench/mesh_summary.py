"""Rows of figures over the fits of mesh views: all, and each class."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .mesh_classes import CLASS_NAMES, MeshClass
from .mesh_score import NOT_FOUND, MeshScore

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
