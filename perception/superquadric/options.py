"""Options of the superquadric fit, with their units and trade-offs."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Literal, get_args

from eyehand.errors import InputError

from ..stored_front import FrontFormat, StoredFront, affordable
from .shape import Kind

OptimiserName = Literal["lm", "slsqp"]
"""``lm`` is the compiled Levenberg-Marquardt alone, without constraints. With ``slsqp``, SLSQP of
nlopt moves a solid out of space seen to be empty where that finds a conflict."""
MAX_PARTS = 8
"""Upper limit of `FitOptions.max_parts`: more solids do not describe one object."""


@dataclass(frozen=True)
class FitOptions:
    """Options of :func:`fit_superquadric`.

    Raises
    ------
    InputError
        If a value is out of its range. The message names the range or the choices.
    """

    kinds: tuple[Kind, ...] = ("sphere", "cylinder", "ellipsoid", "box", "superquadric", "tapered")
    """Kinds of solids to choose from. Fewer kinds are faster."""
    points: int = 2000
    """Maximum number of points used. More points are more accurate; the time grows linearly."""
    optimiser: OptimiserName = "slsqp"
    """Solver of the conflicts between a solid and a :class:`FreeSpace` that parts do not solve.
    Fits without a conflict take the same time with both; a conflict takes SLSQP 30 to 100 ms."""
    starts: int = 6
    """Boxes from which the search for a general superquadric starts, besides the solids of simpler
    kinds. Fewer starts are faster; more starts find the right minimum of unusual views."""
    max_minima: int = 3
    """Local minima of the general superquadric that are refined on all points. More minima make
    close decisions safer and take longer."""
    noise: float = 0.0015
    """Expected noise of the points, one standard deviation, m. The scale of the Cauchy loss is
    twice this. A larger value selects simpler kinds; a smaller value trusts every point."""
    silhouette_rays: int = 32
    """Rays just outside the outline of the cloud that the solid must not cross; 0 turns them off.
    They need `view_origin`. More rays follow the outline more closely and take longer."""
    silhouette_margin: float = 0.0005
    """Distance of these rays from the outline, m, if the points come from an image. A larger value
    tolerates eroded segments."""
    plane_weight: float = 0.1
    """Weight of the contact with the support plane against the mean squared point residual; 0
    turns the contact off."""
    plane_scale: float = 0.005
    """Gap to the support plane at which the contact loses its influence, m."""
    axis_range: tuple[float, float] = (0.002, 1.0)
    """Minimum and maximum semi-axis, m."""
    max_parts: int = 4
    """Maximum number of solids for one object, 1 to 8. Objects that one solid explains have one, in
    the same time. Mugs, tools and bottles have more, in two to five times the time."""
    seed: int = 0
    """Seed of the random choice of points."""

    def __post_init__(self) -> None:
        kinds = get_args(Kind)
        if not self.kinds or any(kind not in kinds for kind in self.kinds):
            raise InputError(f"kinds must be some of {', '.join(kinds)}, got {self.kinds}")
        if self.optimiser not in get_args(OptimiserName):
            raise InputError(
                f"optimiser must be one of {', '.join(get_args(OptimiserName))}, "
                f"got {self.optimiser!r}"
            )
        for name, minimum in _MINIMUM.items():
            value = getattr(self, name)
            if not minimum <= value < float("inf"):
                raise InputError(f"fit option {name} must be finite and >= {minimum}, got {value}")
        if not 1 <= self.max_parts <= MAX_PARTS:
            raise InputError(f"max_parts must be 1 to {MAX_PARTS}, got {self.max_parts}")
        if not 0 < self.axis_range[0] < self.axis_range[1] < float("inf"):
            raise InputError(
                f"axis_range must be two increasing lengths > 0 m, got {self.axis_range}"
            )

    @classmethod
    def for_budget(
        cls,
        milliseconds: float,
        *,
        slower: float = 1.0,
        front: StoredFront[FrontPoint] | None = None,
    ) -> FitOptions:
        """Return the most accurate stored settings for a time budget.

        Parameters
        ----------
        milliseconds
            Maximum median time of a fit on one thread, ms. Single clouds take longer or shorter.
        slower
            Time of this machine over that of the machine of the stored front.
            ``eyehand chart fit --quick`` measures and prints it.
        front
            Settings to choose from; by default the stored ones.

        Raises
        ------
        InputError
            If a value is not positive or no setting is that fast. The message names the time of
            the fastest one.
        """
        return replace(cls(), **dials_for_budget(milliseconds, slower=slower, front=front))


_MINIMUM: dict[str, float] = {
    "points": 10,
    "noise": 1e-6,
    "silhouette_rays": 0,
    "silhouette_margin": 0.0,
    "plane_weight": 0.0,
    "plane_scale": 1e-6,
    "starts": 1,
    "max_minima": 1,
    "seed": 0,
}


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
