"""The most accurate fit for a time budget, from a front that was measured once and stored."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from ..stored_front import FrontFormat, StoredFront, affordable
from .options import FitOptions

STORED_FRONT = Path(__file__).parent / "front.json"
"""What ``eyehand chart fit --store`` wrote last."""


@dataclass(frozen=True)
class FrontPoint:
    """One setting that no other beats in both time and accuracy."""

    name: str
    """How it differs from the default, in words."""
    dials: dict[str, Any]
    """Options that were turned, by field name, all of them; the others keep their defaults."""
    median_ms: float
    """Median time of a fit on the machine of the stored front, ms."""
    iou_p10_pct: float
    """Tenth percentile of the overlap (IoU) with the true solids of the stored front, per cent:
    nine fits of ten are better."""
    iou_median_pct: float
    """Median of the same."""
    failed_pct: float
    """Share of fits with an IoU below 0.5, per cent."""

    def options(self) -> FitOptions:
        """Turn the dials."""
        # JSON has no tuples.
        turned = {k: tuple(v) if isinstance(v, list) else v for k, v in self.dials.items()}
        return replace(FitOptions(), **turned)


FORMAT = FrontFormat("eyehand.fit_front/1", FrontPoint, "eyehand chart fit --store")
"""How the front is kept."""


def options_for_budget(
    milliseconds: float,
    *,
    slower: float = 1.0,
    front: StoredFront[FrontPoint] | None = None,
) -> FitOptions:
    """Pick the stored settings whose worst tenth of fits is best within a time budget.

    Parameters
    ----------
    milliseconds
        Longest median time of a fit on one thread, ms. Single clouds vary about the median, so
        leave room for them.
    slower
        How many times slower this machine is than that of the stored front; below 1 when it is
        faster. ``eyehand chart fit --quick`` measures and prints it.
    front
        Points to choose from; the stored ones by default.

    Returns
    -------
    FitOptions
        Settings whose stored time times `slower` is at most `milliseconds`.

    Raises
    ------
    InputError
        If a value is not positive or no point is that fast; the message tells what the fastest
        one costs.
    """
    front = FORMAT.read(STORED_FRONT) if front is None else front
    points = affordable(front.points, milliseconds, slower, "fit", _accuracy)
    return max(points, key=lambda point: point.iou_p10_pct).options()


def _accuracy(point: FrontPoint) -> str:
    return f"IoU {point.iou_p10_pct:.1f} % or better in nine of ten"
