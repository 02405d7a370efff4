"""Rows of figures over the fits of mesh views: all, and each class."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from .mesh_classes import CLASS_NAMES

if TYPE_CHECKING:
    from collections.abc import Sequence

    from .mesh_classes import MeshClass
    from .mesh_score import MeshScore

ALL = "all"
"""Name of the row over all classes."""


def mesh_summary(
    scores: Sequence[tuple[MeshClass, MeshScore]], method: str
) -> list[dict[str, Any]]:
    """Return a row over all scores and a row for each class that occurs.

    A refused fit has an IoU of 0 and infinite errors. Infinite figures are None. Shares are of all
    fits. The coverage is the share of the sides within one and two stated standard deviations.
    """
    rows = [_row(ALL, method, [score for _, score in scores])]
    for kind in CLASS_NAMES:
        own = [score for name, score in scores if name == kind]
        if own:
            rows.append(_row(kind, method, own))
    return rows


def _row(name: str, method: str, scores: Sequence[MeshScore]) -> dict[str, Any]:
    widths = np.abs([score.width_error for score in scores])
    times = 1e3 * np.array([score.seconds for score in scores])
    sides = np.abs(np.concatenate([score.side_sigmas for score in scores] or [np.zeros(0)]))
    return {
        "name": name,
        "method": method,
        "fits": len(scores),
        "iou_median_pct": _quantile([100 * score.iou for score in scores], 0.5),
        "iou_p10_pct": _quantile([100 * score.iou for score in scores], 0.1),
        "chamfer_median_mm": _quantile([1e3 * score.chamfer for score in scores], 0.5),
        "width_error_median_mm": _quantile(1e3 * widths, 0.5),
        "width_error_p90_mm": _quantile(1e3 * widths, 0.9),
        "usable_pct": _share([score.usable for score in scores]),
        "refused_pct": _share([score.refused for score in scores]),
        "flagged_pct": _share([score.flagged for score in scores]),
        "unsaid_iou_pct": _share([score.unsaid_iou for score in scores]),
        "unsaid_unusable_pct": _share([score.unsaid_unusable for score in scores]),
        "in_parts_pct": _share([score.parts > 1 for score in scores]),
        "sides_1_sigma_pct": _share(sides <= 1.0) if len(sides) else None,
        "sides_2_sigma_pct": _share(sides <= 2.0) if len(sides) else None,
        "fit_median_ms": _quantile(times, 0.5),
        "fit_p90_ms": _quantile(times, 0.9),
    }


def _quantile(values: Any, share: float) -> float | None:
    # Lower, so that a few infinite values do not make finite quantiles infinite.
    value = float(np.quantile(np.asarray(values, dtype=float), share, method="lower"))
    return round(value, 2) if np.isfinite(value) else None


def _share(values: Any) -> float:
    return round(100 * float(np.mean(values)), 1)
