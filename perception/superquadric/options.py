"""Every choice of the superquadric fit, with its unit and what it trades."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, get_args

from eyehand.errors import InputError

from .shape import MAX_EXPONENT, MIN_EXPONENT, Kind

OptimiserName = Literal["lm", "slsqp", "lbfgs", "mma", "bobyqa", "cobyla"]
"""``lm`` is the compiled Levenberg-Marquardt alone; the others are nlopt's, run after it, the
last two without derivatives."""
MOST_PARTS = 8
"""More solids than that are no description of one object."""


@dataclass(frozen=True)
class FitOptions:
    """Options of :func:`fit_superquadric`.

    Raises
    ------
    InputError
        If a value is out of its range; the message names the range or the choices.
    """

    kinds: tuple[Kind, ...] = (
        "sphere",
        "cylinder",
        "ellipsoid",
        "box",
        "superquadric",
        "tapered",
    )
    """Solids to choose from: fewer is faster."""
    points: int = 2000
    """Points used: more is more accurate and slower (time grows linearly)."""
    optimiser: OptimiserName = "slsqp"
    """Final refinement of the chosen solid: ``lm`` is fastest, nlopt's squeeze out the rest."""
    max_evaluations: int = 60
    """Budget of the final refinement."""
    starts: int = 6
    """Boxes from which the search for a general solid starts, besides what simpler kinds found:
    fewer is faster, more finds the basin of odd views."""
    start_iterations: int = 6
    """Levenberg-Marquardt steps per start: fewer is faster, more tells basins apart better."""
    finalists: int = 3
    """Distinct general solids that go on to all points: more settles near ties more safely."""
    ladder_iterations: int = 25
    """Levenberg-Marquardt steps per kind of solid from its best start."""
    prune: float = 30.0
    """Kinds whose criterion on few points trails the best by more are not finished: lower is
    faster, higher is safer."""
    noise: float = 0.0015
    """Expected noise of surface points, one σ, m: the Cauchy scale is twice this. Larger forgives
    rounder models, smaller trusts every point."""
    effective_points: float = 150.0
    """Most independent readings that the criterion believes in; fewer where residuals of
    neighbours agree. More buys richer solids on less evidence."""
    silhouette_rays: int = 32
    """Rays past the cloud's outline that the solid must not cross; 0 = off. Needs view_origin."""
    silhouette_margin: float = 0.0005
    """How far outside the outline the rays run, m, where the points come from an image: more
    forgives eroded segments."""
    silhouette_pitch: float = 0.5
    """... and by how many pixels more, where the points come from an image: a pixel at the
    outline may have seen the object or not."""
    silhouette_weight: float = 0.3
    """Weight of the rays against the mean squared point residual."""
    silhouette_pull: float = 0.1
    """Share of that weight with which the outline draws the solid outwards too, where the points
    come from an image, which shows an outline to a pixel. Costs a third of the time; 0 = off."""
    plane_weight: float = 0.1
    """Weight of contact with the support plane against the mean squared point residual."""
    plane_scale: float = 0.005
    """Gap to the support plane at which contact starts to let go, m."""
    exponent_range: tuple[float, float] = (0.1, 1.9)
    """Smallest and largest exponent tried: sharper edges need denser points."""
    edge_exponent: float = 0.1
    """Exponent that stands for a sharp edge in boxes and cylinders."""
    axis_range: tuple[float, float] = (0.002, 1.0)
    """Smallest and largest semi-axis, m."""
    axis_prior: float = 1.5
    """Standard deviation of log semi-axes about the cloud's radius: keeps unseen extents near
    seen ones, biases nothing that the view shows. Smaller holds faster."""
    unseen_growth: float = 0.07
    """Standard deviation of log semi-axes beyond the farthest point seen: larger lets hidden
    sides lie farther away."""
    exponent_prior: float = 0.7
    """Standard deviation of exponents about the middle between square and pinched."""
    taper_prior: float = 0.3
    """Standard deviation of the taper about none."""
    min_points: int = 50
    """Fewer points than this are refused by name."""
    max_parts: int = 1
    """Most solids that one object may become, 1 to 8: more follow mugs, tools and brackets, and
    cost several times the time where one solid explains too little; what one explains stays one."""
    seed: int = 0
    """Seed of the choice of points."""

    def __post_init__(self) -> None:
        kinds = get_args(Kind)
        if not self.kinds or any(kind not in kinds for kind in self.kinds):
            raise InputError(f"kinds must be some of {', '.join(kinds)}, got {self.kinds}")
        if self.optimiser not in get_args(OptimiserName):
            raise InputError(
                f"optimiser must be one of {', '.join(get_args(OptimiserName))}, "
                f"got {self.optimiser!r}"
            )
        for name, least in _LEAST.items():
            value = getattr(self, name)
            if not least <= value < float("inf"):
                raise InputError(f"fit option {name} must be finite and >= {least}, got {value}")
        if not 1 <= self.max_parts <= MOST_PARTS:
            raise InputError(f"max_parts must be 1 to {MOST_PARTS}, got {self.max_parts}")
        low, high = self.exponent_range
        if not MIN_EXPONENT <= low < high <= MAX_EXPONENT:
            raise InputError(
                f"exponent_range must lie in [{MIN_EXPONENT}, {MAX_EXPONENT}], got {(low, high)}"
            )
        if not MIN_EXPONENT <= self.edge_exponent <= 1.0:
            raise InputError(
                f"edge_exponent must lie in [{MIN_EXPONENT}, 1], got {self.edge_exponent}"
            )
        if not 0 < self.axis_range[0] < self.axis_range[1] < float("inf"):
            raise InputError(f"axis_range must rise from above 0 m, got {self.axis_range}")

    @classmethod
    def for_budget(cls, milliseconds: float, *, slower: float = 1.0) -> FitOptions:
        """Pick the most accurate settings for a time budget in ms: see `options_for_budget`."""
        from .budget import options_for_budget

        return options_for_budget(milliseconds, slower=slower)


_LEAST: dict[str, float] = {
    "points": 10,
    "min_points": 10,
    "max_evaluations": 1,
    "start_iterations": 1,
    "ladder_iterations": 1,
    "prune": 0.0,
    "noise": 1e-6,
    "effective_points": 2.0,
    "silhouette_rays": 0,
    "silhouette_margin": 0.0,
    "silhouette_pitch": 0.0,
    "silhouette_weight": 0.0,
    "silhouette_pull": 0.0,
    "plane_weight": 0.0,
    "plane_scale": 1e-6,
    "axis_prior": 1e-3,
    "unseen_growth": 1e-3,
    "exponent_prior": 1e-3,
    "taper_prior": 1e-3,
    "starts": 1,
    "finalists": 1,
    "seed": 0,
}
