"""Settings of the fit for a time budget, from a stored Pareto front of time and accuracy."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

from ..stored_front import FrontFormat, StoredFront, affordable

STORED_FRONT = Path(__file__).parent / "front.json"
"""File that ``eyehand chart fit --store`` writes."""


@dataclass(frozen=True)
class FrontPoint:
    """A setting that no other setting beats in both time and accuracy."""

    name: str
    """Difference from the default, in words."""
    dials: dict[str, Any]
    """Options of this setting by field name. All other fields have their defaults."""
    median_ms: float
    """Median time of a fit on the machine of the stored front, ms."""
    iou_p10_pct: float
    """Tenth percentile of the overlap (IoU) with the true solids, per cent: nine fits of ten are
    better."""
    iou_median_pct: float
    """Median of the same, per cent."""
    failed_pct: float
    """Share of fits with an IoU below 0.5, per cent."""
    iou_mean_pct: float | None = None
    """Mean overlap over simple solids, solids of several parts and household meshes, per cent. A
    refused fit has 0. None in fronts that were measured on simple solids only."""
    mesh_iou_mean_pct: float | None = None
    """Mean overlap with household meshes, per cent."""
    mesh_iou_p25_pct: float | None = None
    """25th percentile of the same, per cent."""

    @property
    def accuracy_pct(self) -> float:
        """The figure that a budget maximises: the mean if it is known, else the percentile."""
        return self.iou_p10_pct if self.iou_mean_pct is None else self.iou_mean_pct

    @property
    def fields(self) -> dict[str, Any]:
        """Values of the fields of FitOptions. JSON has no tuples: lists become tuples."""
        return {k: tuple(v) if isinstance(v, list) else v for k, v in self.dials.items()}


FORMAT = FrontFormat("eyehand.fit_front/1", FrontPoint, "eyehand chart fit --store")
"""File format of the stored front."""


def dials_for_budget(
    milliseconds: float,
    *,
    slower: float = 1.0,
    front: StoredFront[FrontPoint] | None = None,
) -> dict[str, Any]:
    """Return the fields of the most accurate setting within a budget.

    See :meth:`~.options.FitOptions.for_budget` for the parameters.
    """
    front = FORMAT.read(STORED_FRONT) if front is None else front
    points = affordable(front.points, milliseconds, slower, "fit", _accuracy)
    return max(points, key=lambda point: point.accuracy_pct).fields


def _accuracy(point: FrontPoint) -> str:
    if point.iou_mean_pct is not None:
        return f"mean IoU {point.iou_mean_pct:.1f} %"
    return f"IoU {point.iou_p10_pct:.1f} % or better in nine of ten"
